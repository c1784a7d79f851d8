"""Whether a camera is turned or late: a robot then drives, or turns, otherwise than the bearings of the landmarks say.

All sightings of a turned camera agree on another heading; only the direction in which its robot drives does not, and of that a
few metres tell too little for a proof. A camera whose clock is late sees landmarks aside whenever its robot turns. Here is an
estimate beside the sets: an extended Kalman filter of each robot's pose and its camera's offset and delay, with deviations from
the declared bounds. **It is evidence, no proof, and nothing of it enters a region**; it only says what not to believe.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array, Frozen, Mask, positive, settle
from filter.compiled import compiled
from filter.geometry.angles import wrap
from filter.poses.slices import QUARTER
from filter.robust.hypotheses import Hypotheses
from filter.robust.slices import Sighting

UNKNOWN = 0.8  # with a heading that is known no better than this, nothing is estimated [rad]
FAR_OUT = 2.0  # with a position neither [m]
JUMPED = 2  # so many landmarks in turn to the same side: the robot was bumped, or its camera
LATELY = 0.25  # over such a time the turn rate is averaged that a late camera shows [s]
RECENT = 0.05  # the last sighting's part in the share of those that an estimate does not explain, ...
WRONG = 0.7  # ... which shows that it is wrong
SINGULAR = 1e-12  # a covariance of a sighting whose determinant is no more than so large a share of the variances' product


@dataclass(frozen=True)
class Alignment:
    """When a camera is suspected to be turned, or late. Raises InvalidInput if a value is out of its range.

    Attributes:
        share: The offset of a good camera is at most this share of a bearing's bound, as other errors come on top; in (0, 1].
        deviations: One whose estimate is beyond that by so many of its deviations is suspected, ...
        patience: ... after it has been for so long [s].
        tolerated_delay: So much later than commands, or earlier, a good camera's pictures may be stamped than is declared [s].
        bearing: Deviation of a bearing over its bound.
        range: Deviation of a range over its bound; errors repeat themselves, so it is large.
        lasting: Errors of motion are as large as their bounds, and last so long [s].
        gate: A sighting farther off than so many deviations has the less weight.
        prior: Deviation of an offset of which nothing is known [rad].
        wander: How much an offset may change in a second, by its deviation [rad].
        clock: Deviation of a camera's delay of which nothing is known [s].
        drift: How much a delay may change in a second, by its deviation [s].
        hidden: So long after it is turned or late a camera can still look good [s].
    """

    share: float = 0.6
    deviations: float = 2.0
    patience: float = 5.0
    tolerated_delay: float = 0.2
    bearing: float = 0.4
    range: float = 1.5
    lasting: float = 1.0
    gate: float = 3.0
    prior: float = 0.17
    wander: float = 0.0067
    clock: float = 0.2
    drift: float = 0.003
    hidden: float = 60.0

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            settle(self, **{name: positive(name, value, 1 if name == "share" else np.inf)})


@dataclass(frozen=True, eq=False)
class Offsets(Frozen):
    """What motion says of n cameras.

    Attributes:
        mean: (n, 5) position [m], heading, the camera's offset [rad], and its delay [s]; positive as in `Turned` and `Late`.
        covariance: (n, 5, 5) of it.
        rate: (n,) how fast the robot turned lately [rad/s].
        running: (n,) whether there is an estimate.
        misfit: (n,) the share of the last sightings, some twenty, that are beyond the gate.
        astray: (n, 2) how many landmarks in turn are beyond the gate to one side, negative to the right, and the last.
        allowed: (n,) the bound of the robot's last bearing [rad].
        good_until: (n, 2) until when the camera looked good [s], less the time for which it can hide that it is turned or late.
        bad_since: (n, 2) since when the estimate is that of a turned or late camera [s]; infinite where it is not.
        suspected: (n, 2) cameras that are suspected to be turned: their bearings are not to tell a heading; or late: they are
            not to be believed at all.
    """

    mean: Array
    covariance: Array
    rate: Array
    running: Mask
    misfit: Array
    astray: Array
    allowed: Array
    good_until: Array
    bad_since: Array
    suspected: Mask

    @classmethod
    def none(cls, robots: int, time: float) -> Offsets:
        """Return that nothing is known, at a time [s]."""
        nobody, never, zeros = np.zeros((robots, 2), dtype=bool), np.full((robots, 2), np.inf), np.zeros((robots, 5, 5))
        estimate = zeros[:, 0], zeros, zeros[:, 0, 0], nobody[:, 0], zeros[:, 0, 0], zeros[:, 0, :2]
        return cls(*estimate, never[:, 0], np.full((robots, 2), time), never, nobody)

    @property
    def turned(self) -> Mask:
        """(n,) cameras that are suspected to be turned."""
        return self.suspected[:, 0]

    @property
    def late(self) -> Mask:
        """(n,) cameras that are suspected to be late."""
        return self.suspected[:, 1]

    @property
    def on_trial(self) -> Mask:
        """(n,) late cameras without an estimate: they are listened to, with no guarantee, until there is one again."""
        return self.late & ~self.running

    @property
    def deviations(self) -> Array:
        """(n, 2) deviations of offset [rad] and delay [s]."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2)[:, 3:])

    def moved(self, distance: Array, turn: Array, aside: Array, duration: float, rules: Alignment) -> Offsets:
        """Return the estimates after moves.

        They are least and greatest path and turn, (n, 2) each, and bounds of direction and slip and what is aside, (n, 3).
        """
        mean, covariance, (direction, slip, way) = self.mean.copy(), self.covariance.copy(), aside.T
        whole, lately = max(duration, 1e-9), duration / (duration + LATELY)
        path, turned, twist = distance.mean(axis=1), turn.mean(axis=1), np.ptp(turn, axis=1) / 2
        across = slip + np.abs(distance).max(axis=1) * np.minimum(1.0, direction)
        lasting, wander = max(rules.lasting, duration) / whole, np.square([rules.wander, rules.drift]) * duration
        noise = lasting * np.square([np.ptp(distance, axis=1) / 2 + slip, across, twist])
        chord = path * np.sinc(turned / 2 / np.pi)
        for robot in np.flatnonzero(self.running):
            move = np.array([chord[robot], turned[robot], way[robot]])
            _drive(mean[robot], covariance[robot], move, np.append(noise[:, robot], wander))
        rate = np.where(self.running, self.rate + lately * (turned / whole - self.rate), self.rate)
        return replace(self, mean=mean, covariance=covariance, rate=rate)

    def seen(self, sightings: Sequence[Sighting], landmarks: Array, excluded: Mask, rules: Alignment) -> Offsets:
        """Return them after sightings of landmarks (l, 2) [m] but those whose identity is put aside, of (b,) bodies."""
        mean, covariance, misfit = self.mean.copy(), self.covariance.copy(), self.misfit.copy()
        astray, allowed, robots = self.astray.copy(), self.allowed.copy(), len(self.rate)
        for robot, target, sector in sightings:
            if target < robots or excluded[target] or sector[1] >= np.pi:  # team mates say nothing here
                continue
            allowed[robot] = sector[1]
            if self.running[robot]:
                seen = np.array([sector[0], (sector[2] + sector[3]) / 2])
                deviations = np.array([rules.bearing * sector[1], rules.range * (sector[3] - sector[2]) / 2])
                mine = mean[robot], covariance[robot], self.rate[robot]
                far, aside = _see(*mine, landmarks[target - robots], seen, deviations, rules.gate)
                misfit[robot] += RECENT * (far - misfit[robot])
                (count, last), side = astray[robot], np.sign(aside) if abs(aside) > rules.gate else 0.0
                count = side if side * count <= 0 else count + side * (last != target)
                astray[robot] = (count, target) if abs(count) < JUMPED else 0.0
                if abs(count) >= JUMPED:  # heading and offset are open, their difference is not
                    covariance[robot, 2:4, 2:4] += rules.prior**2 * np.eye(2)
        return replace(self, mean=mean, covariance=covariance, misfit=misfit, astray=astray, allowed=allowed)

    def checked(self, sets: Sequence[Hypotheses], rules: Alignment) -> Offsets:
        """Return them without those that are wrong or have become too wide, and begun where the sets are small enough."""
        mean, covariance, misfit = self.mean.copy(), self.covariance.copy(), self.misfit.copy()
        variance = np.diagonal(covariance, axis1=1, axis2=2)
        narrow = (variance[:, :2].max(axis=1) <= FAR_OUT**2) & (variance[:, 2] <= UNKNOWN**2) & (variance >= 0).all(axis=1)
        finite = np.isfinite(mean).all(axis=1) & np.isfinite(covariance).all(axis=(1, 2))
        running = self.running & narrow & finite & (misfit < WRONG)
        for robot in np.flatnonzero(~running).tolist():
            mean[robot], covariance[robot], hull = 0.0, 0.0, sets[robot].hull().reshape(4, QUARTER)[:, 0]
            half, (heading, bound) = (hull[:2] + hull[2:]) / 2, sets[robot].heading()
            if bound <= UNKNOWN and half.max() <= FAR_OUT:
                mean[robot] = [*((hull[:2] - hull[2:]) / 2), heading, 0.0, 0.0]
                covariance[robot] = np.diag(np.square([*half, bound, 0.0, rules.clock]))
                covariance[robot, 2:4, 2:4] += rules.prior**2  # what is known of the heading, the camera may have said
                running[robot], misfit[robot] = True, 0.0
        return replace(self, mean=mean, covariance=covariance, running=running, misfit=misfit)

    def judged(self, time: float, rules: Alignment) -> Offsets:
        """Return them with cameras suspected whose offset or delay is beyond a bound for sure; no longer those that agree."""
        mean, deviation, running = self.mean.copy(), self.deviations, self.running[:, None]
        mean[:, 3] = wrap(mean[:, 3])  # a full turn is none
        off, bound = np.abs(mean[:, 3:]), np.column_stack([self.allowed, np.full(len(mean), rules.tolerated_delay)])
        known = running & (deviation < np.array([rules.prior, rules.clock]) / 2)
        beyond = running & (off - rules.deviations * deviation > bound * [rules.share, 1.0])
        beyond[:, 0] &= ~self.late  # whatever a late camera shows, it may be late by more
        bad_since = np.where(beyond, np.minimum(self.bad_since, time), np.inf)
        agrees, looks_good = known & (off + deviation <= bound), known & (off <= deviation / 2)
        suspected = (time - bad_since >= rules.patience) | (self.suspected & ~agrees)
        good_until = np.where(looks_good, np.maximum(self.good_until, time - rules.hidden), self.good_until)
        return replace(self, mean=mean, good_until=good_until, bad_since=bad_since, suspected=suspected)


@compiled
def _drive(mean: Array, covariance: Array, move: Array, noise: Array) -> None:
    """Move one estimate in place by chord, turn and what is aside (3,); (5,) variances along, across, of turn, offset, lag."""
    chord, turn, aside = move
    way = mean[2] + turn / 2 + aside
    x, y = np.cos(way), np.sin(way)
    mean[0] += chord * x
    mean[1] += chord * y
    mean[2] += turn
    F, Q = np.eye(5), np.diag(noise)
    F[0, 2], F[1, 2] = -chord * y, chord * x
    Q[0, 0], Q[1, 1] = x * x * noise[0] + y * y * noise[1], y * y * noise[0] + x * x * noise[1]
    Q[0, 1] = Q[1, 0] = x * y * (noise[0] - noise[1])
    covariance[:] = F @ covariance @ F.T + Q


@compiled
def _see(
    mean: Array, covariance: Array, rate: float, place: Array, seen: Array, deviations: Array, gate: float
) -> tuple[bool, float]:
    """Merge a bearing and a range (2,) of a place (2,) into one estimate, in place; the robot turns at a rate [rad/s].

    Returns:
        Whether it is beyond the gate, and how many deviations the bearing alone is aside; what cannot be weighed is beyond it.
    """
    dx, dy = place[0] - mean[0], place[1] - mean[1]
    distance = max(np.hypot(dx, dy), 1e-6)
    H = np.zeros((2, 5))
    H[0] = dy / distance**2, -dx / distance**2, -1.0, 1.0, rate
    H[1, 0], H[1, 1] = -dx / distance, -dy / distance
    off = seen[0] - (np.arctan2(dy, dx) - mean[2] + mean[3] + rate * mean[4])
    apart = np.array([off - 2 * np.pi * np.round(off / (2 * np.pi)), seen[1] - distance])
    R = np.diag(deviations**2)
    S = H @ covariance @ H.T + R
    if not S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0] > SINGULAR * S[0, 0] * S[1, 1]:
        return True, 0.0
    aside = apart[0] / np.sqrt(S[0, 0])
    far = float(apart @ np.linalg.solve(S, apart)) / gate**2
    if far > 1:
        S += (far - 1) * R
        R *= far
    K = np.linalg.solve(S, H @ covariance).T
    mean += K @ apart
    kept = np.eye(5) - K @ H
    joseph = kept @ covariance @ kept.T + K @ R @ K.T
    covariance[:] = (joseph + joseph.T) / 2
    return far > 1, aside
