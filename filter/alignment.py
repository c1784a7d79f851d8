"""Whether a camera is turned: a robot then drives in another direction than the bearings of the landmarks say.

A camera that is turned by some degrees shows another heading, and all its sightings agree on it. Only the direction in which
the robot drives does not, and of that a few metres tell too little for a proof from bounds. So here is an estimate beside the
sets: an extended Kalman filter for each robot, with pose and offset of the camera, from odometry and landmarks. Its deviations
are taken from the declared bounds. **It is evidence, no proof, and nothing of it enters a region**; it only says which
camera's heading is not to be taken for its robot's.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from filter.angles import wrap
from filter.arrays import Array, Mask, number, read_only
from filter.compiled import compiled
from filter.errors import InvalidInput
from filter.hypotheses import Hypotheses
from filter.sightings import Sightings
from filter.slices import QUARTER

UNKNOWN = 0.8  # with a heading that is known no better than this, nothing is estimated [rad]
FAR_OUT = 2.0  # with a position neither [m]
JUMPED = 2  # so many landmarks in turn to the same side: the robot was bumped, or its camera
RECENT = 0.05  # the last sighting's part in the share of those that an estimate does not explain, ...
WRONG = 0.7  # ... which shows that it is wrong


@dataclass(frozen=True)
class Alignment:
    """When a camera is suspected to be turned.

    Attributes:
        share: The offset of a good camera is at most this share of a bearing's bound, as other errors come on top; in (0, 1].
        deviations: One whose estimate is beyond that by so many of its deviations is suspected, ...
        patience: ... after it has been for so long [s].
        bearing: Deviation of a bearing over its bound.
        range: Deviation of a range over its bound; errors repeat themselves, so it is large.
        lasting: Errors of motion are as large as their bounds, and last so long [s].
        gate: A sighting farther off than so many deviations has the less weight.
        prior: Deviation of an offset of which nothing is known [rad].
        wander: How much an offset may change in a second, by its deviation [rad].
        delay: So long after it is turned a camera can still look good [s].

    Raises:
        InvalidInput: A value is out of its range.
    """

    share: float = 0.6
    deviations: float = 2.0
    patience: float = 5.0
    bearing: float = 0.4
    range: float = 1.5
    lasting: float = 1.0
    gate: float = 3.0
    prior: float = 0.17
    wander: float = 0.0067
    delay: float = 60.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            if number(name, value, 0, 1 if name == "share" else np.inf) == 0:
                raise InvalidInput(f"{name}: above 0", 0)


@dataclass(frozen=True, eq=False)
class Offsets:
    """What the directions of motion say of n cameras.

    Attributes:
        mean: (n, 4) position [m], heading, and offset of the camera, positive where bearings are too large [rad].
        covariance: (n, 4, 4) of it.
        running: (n,) whether there is an estimate.
        misfit: (n,) the share of the last sightings, some twenty, that are beyond the gate.
        astray: (n, 2) how many landmarks in turn are beyond the gate to one side, negative to the right, and the last.
        allowed: (n,) the bound of the robot's last bearing [rad].
        good_until: (n,) until when the camera looked good [s], less the delay with which it shows that it is not.
        bad_since: (n,) since when the estimate is that of a turned camera [s]; infinite where it is not.
        suspected: (n,) cameras whose bearings are not to tell a heading.
    """

    mean: Array
    covariance: Array
    running: Mask
    misfit: Array
    astray: Array
    allowed: Array
    good_until: Array
    bad_since: Array
    suspected: Mask

    def __post_init__(self) -> None:
        for column in fields(self):
            object.__setattr__(self, column.name, read_only(getattr(self, column.name)))

    @classmethod
    def none(cls, robots: int, time: float) -> Offsets:
        """Return that nothing is known, at a time [s]."""
        nobody, zeros = np.zeros(robots, dtype=bool), np.zeros((robots, 4, 4))
        never = np.full(robots, np.inf)
        fits = np.zeros(robots), np.zeros((robots, 2))
        return cls(zeros[:, 0], zeros, nobody, *fits, never, np.full(robots, time), never.copy(), nobody.copy())

    @property
    def offset(self) -> Array:
        """(n,) estimated offsets of the cameras, positive where bearings are too large [rad]."""
        return self.mean[:, 3]

    @property
    def deviation(self) -> Array:
        """(n,) their deviations [rad]."""
        return np.sqrt(self.covariance[:, 3, 3])


class Estimating:
    """The work of one step on the offsets; it works on copies, `offsets` is the result."""

    def __init__(self, before: Offsets, rules: Alignment) -> None:
        """Begin with what was known before."""
        self._rules = rules
        columns = (getattr(before, column.name).copy() for column in fields(Offsets))
        self._mean, self._covariance, self._running, self._misfit, self._astray, self._allowed, *self._judgement = columns

    @property
    def offsets(self) -> Offsets:
        """What is known now."""
        columns = (self._mean, self._covariance, self._running, self._misfit, self._astray, self._allowed, *self._judgement)
        return Offsets(*(column.copy() for column in columns))

    def move(self, moves: Sequence[tuple[Array, Array, Array]], duration: float) -> None:
        """Move the estimates: least and greatest path and turn of each robot, the bound of its direction and its slip."""
        lasting, wander = max(self._rules.lasting, duration) / max(duration, 1e-9), self._rules.wander**2 * duration
        for robot in np.flatnonzero(self._running).tolist():
            distance, turn, aside = moves[robot]
            path, twist = (distance[1] - distance[0]) / 2, (turn[1] - turn[0]) / 2
            across = aside[1] + np.abs(distance).max() * min(1.0, aside[0])
            noise = np.array([*(lasting * np.square([path + aside[1], across, twist])), wander])
            _drive(self._mean[robot], self._covariance[robot], distance.mean(), turn.mean(), noise)

    def see(self, sightings: Sightings, robots: int, landmarks: Array, excluded: Mask) -> None:
        """Merge sightings of landmarks (l, 2) [m] but those whose identity is put aside, (b,); team mates say nothing here."""
        rules = self._rules
        for robot, target, sector in zip(sightings.robot.tolist(), sightings.target.tolist(), sightings.sector, strict=True):
            if target < robots or excluded[target] or sector[1] >= np.pi:
                continue
            self._allowed[robot] = sector[1]
            if self._running[robot]:
                seen = np.array([sector[0], (sector[2] + sector[3]) / 2])
                deviations = np.array([rules.bearing * sector[1], rules.range * (sector[3] - sector[2]) / 2])
                mine = self._mean[robot], self._covariance[robot]
                far, aside = _see(*mine, landmarks[target - robots], seen, deviations, rules.gate)
                self._misfit[robot] += RECENT * (far - self._misfit[robot])
                self._jump(robot, target, float(np.sign(aside)) if abs(aside) > rules.gate else 0.0)

    def _jump(self, robot: int, target: int, side: float) -> None:
        """Count landmarks that are astray to one side; if several are, heading and offset are open, their difference is not."""
        count, last = self._astray[robot]
        if side * count <= 0:  # none, or to the other side
            self._astray[robot] = side, target
        elif last != target:
            self._astray[robot] = count + side, target
        if abs(self._astray[robot, 0]) >= JUMPED:
            self._astray[robot] = 0.0
            self._covariance[robot, 2:, 2:] += self._rules.prior**2 * np.eye(2)

    def check(self, sets: Sequence[Hypotheses]) -> None:
        """Stop estimates that are wrong or have become too wide; begin where the sets are small enough."""
        variance = np.diagonal(self._covariance, axis1=1, axis2=2)
        wide = (variance[:, :2].max(axis=1) > FAR_OUT**2) | (variance[:, 2] > UNKNOWN**2)
        self._running &= ~wide & (self._misfit < WRONG)
        for robot in np.flatnonzero(~self._running).tolist():
            self._begin(robot, sets[robot].hull(), *sets[robot].heading())

    def _begin(self, robot: int, hull: Array, heading: float, bound: float) -> None:
        half = (hull[[0, QUARTER]] + hull[[2 * QUARTER, 3 * QUARTER]]) / 2
        if bound > UNKNOWN or half.max() > FAR_OUT:
            return
        middle = (hull[[0, QUARTER]] - hull[[2 * QUARTER, 3 * QUARTER]]) / 2
        self._mean[robot] = [*middle, heading, 0.0]
        self._covariance[robot] = np.diag(np.square([*half, bound, 0.0]))
        self._covariance[robot, 2:, 2:] += self._rules.prior**2  # what is known of the heading, the camera may have said
        self._running[robot], self._misfit[robot] = True, 0.0

    def judge(self, time: float) -> None:
        """Suspect cameras whose offset is beyond the bound for sure, and those no longer that agree again, at a time [s]."""
        rules, (good_until, bad_since, suspected) = self._rules, self._judgement
        self._mean[:, 3] = wrap(self._mean[:, 3])  # a full turn is none
        off, deviation = np.abs(self._mean[:, 3]), np.sqrt(self._covariance[:, 3, 3])
        looks_good = ~self._running | (off <= deviation / 2)
        good_until = np.where(looks_good, np.maximum(good_until, time - rules.delay), good_until)
        turned = self._running & (off - rules.deviations * deviation > rules.share * self._allowed)
        bad_since = np.where(turned, np.minimum(bad_since, time), np.inf)
        agrees = self._running & (off + deviation <= self._allowed)
        self._judgement = [good_until, bad_since, (time - bad_since >= rules.patience) | (suspected & ~agrees)]


@compiled
def _drive(mean: Array, covariance: Array, distance: float, turn: float, noise: Array) -> None:
    """Move one estimate in place; the noise (4,) is the variance along the way, across it, of the turn and of the offset."""
    way = mean[2] + turn / 2
    x, y = np.cos(way), np.sin(way)
    mean[0] += distance * x
    mean[1] += distance * y
    mean[2] += turn
    F = np.eye(4)
    F[0, 2], F[1, 2] = -distance * y, distance * x
    covariance[:] = F @ covariance @ F.T
    covariance[0, 0] += x * x * noise[0] + y * y * noise[1]
    covariance[1, 1] += y * y * noise[0] + x * x * noise[1]
    covariance[0, 1] += x * y * (noise[0] - noise[1])
    covariance[1, 0] += x * y * (noise[0] - noise[1])
    covariance[2, 2] += noise[2]
    covariance[3, 3] += noise[3]


@compiled
def _see(mean: Array, covariance: Array, place: Array, seen: Array, deviations: Array, gate: float) -> tuple[bool, float]:
    """Merge a bearing and a range (2,) of a place (2,) into one estimate, in place.

    Returns:
        Whether it is beyond the gate, and how many deviations the bearing alone is aside.
    """
    dx, dy = place[0] - mean[0], place[1] - mean[1]
    distance = max(np.hypot(dx, dy), 1e-6)
    H = np.zeros((2, 4))
    H[0, 0], H[0, 1], H[0, 2], H[0, 3] = dy / distance**2, -dx / distance**2, -1.0, 1.0
    H[1, 0], H[1, 1] = -dx / distance, -dy / distance
    off = seen[0] - (np.arctan2(dy, dx) - mean[2] + mean[3])
    apart = np.array([off - 2 * np.pi * np.round(off / (2 * np.pi)), seen[1] - distance])
    R = np.diag(deviations**2)
    S = H @ covariance @ H.T + R
    aside = apart[0] / np.sqrt(S[0, 0])
    far = float(apart @ np.linalg.solve(S, apart)) / gate**2
    if far > 1:
        S += (far - 1) * R
    K = np.linalg.solve(S, H @ covariance).T
    mean += K @ apart
    covariance[:] = covariance - K @ S @ K.T
    return far > 1, aside
