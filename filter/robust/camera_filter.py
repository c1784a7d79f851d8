"""Whether a camera is turned or late: a robot then drives, or turns, otherwise than the bearings of the landmarks say.

A camera that is turned by some degrees shows another heading, and all its sightings agree on it. Only the direction in which
the robot drives does not, and of that a few metres tell too little for a proof from bounds. A camera whose clock is late sees
landmarks aside whenever its robot turns. So here is an estimate beside the sets: an extended Kalman filter for each robot, with
pose, and offset and delay of the camera, from odometry and landmarks. Its deviations are taken from the declared bounds. **It
is evidence, no proof, and nothing of it enters a region**; it only says which camera, or which one's heading, not to believe.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields

import numpy as np

from filter.arrays import Array, Mask
from filter.compiled import compiled
from filter.geometry.angles import wrap
from filter.robust.cameras import Alignment, Offsets
from filter.robust.hypotheses import Hypotheses
from filter.robust.sightings import Sightings
from filter.robust.slices import QUARTER

UNKNOWN = 0.8  # with a heading that is known no better than this, nothing is estimated [rad]
FAR_OUT = 2.0  # with a position neither [m]
JUMPED = 2  # so many landmarks in turn to the same side: the robot was bumped, or its camera
LATELY = 0.25  # over such a time the turn rate is averaged that a late camera shows [s]
RECENT = 0.05  # the last sighting's part in the share of those that an estimate does not explain, ...
WRONG = 0.7  # ... which shows that it is wrong
SINGULAR = 1e-12  # a covariance of a sighting whose determinant is no more than so large a share of the variances' product


class Estimating:
    """The work of one step on the offsets; it works on copies, `offsets` is the result."""

    def __init__(self, before: Offsets, rules: Alignment) -> None:
        """Begin with what was known before."""
        self._rules = rules
        columns = (getattr(before, column.name).copy() for column in fields(Offsets))
        self._mean, self._covariance, self._rate, self._running, self._misfit, self._astray, self._allowed, *judgement = columns
        self._judgement = judgement

    @property
    def offsets(self) -> Offsets:
        """What is known now."""
        estimate = (self._mean, self._covariance, self._rate, self._running, self._misfit, self._astray)
        return Offsets(*(column.copy() for column in (*estimate, self._allowed, *self._judgement)))

    def move(self, moves: Sequence[tuple[Array, Array, Array]], duration: float) -> None:
        """Move the estimates: least and greatest path and turn of each robot, the bound of its direction and its slip."""
        rules, lately = self._rules, duration / (duration + LATELY)
        lasting, wander = max(rules.lasting, duration) / max(duration, 1e-9), np.square([rules.wander, rules.drift]) * duration
        for robot in np.flatnonzero(self._running).tolist():
            distance, turn, aside = moves[robot]
            path, twist = (distance[1] - distance[0]) / 2, (turn[1] - turn[0]) / 2
            across = aside[1] + np.abs(distance).max() * min(1.0, aside[0])
            noise = np.array([*(lasting * np.square([path + aside[1], across, twist])), *wander])
            self._rate[robot] += lately * (turn.mean() / max(duration, 1e-9) - self._rate[robot])
            chord = distance.mean() * np.sinc(turn.mean() / 2 / np.pi)
            _drive(self._mean[robot], self._covariance[robot], chord, turn.mean(), noise)

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
                mine = self._mean[robot], self._covariance[robot], self._rate[robot]
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
            self._covariance[robot, 2:4, 2:4] += self._rules.prior**2 * np.eye(2)

    def check(self, sets: Sequence[Hypotheses]) -> None:
        """Stop estimates that are wrong or have become too wide; begin where the sets are small enough."""
        variance = np.diagonal(self._covariance, axis1=1, axis2=2)
        narrow = (variance[:, :2].max(axis=1) <= FAR_OUT**2) & (variance[:, 2] <= UNKNOWN**2)
        possible = (
            np.isfinite(self._mean).all(axis=1) & np.isfinite(self._covariance).all(axis=(1, 2)) & (variance >= 0).all(axis=1)
        )
        self._running &= narrow & possible & (self._misfit < WRONG)
        for robot in np.flatnonzero(~self._running).tolist():
            self._mean[robot], self._covariance[robot] = 0.0, 0.0
            self._begin(robot, sets[robot].hull(), *sets[robot].heading())

    def _begin(self, robot: int, hull: Array, heading: float, bound: float) -> None:
        half = (hull[[0, QUARTER]] + hull[[2 * QUARTER, 3 * QUARTER]]) / 2
        if bound > UNKNOWN or half.max() > FAR_OUT:
            return
        middle = (hull[[0, QUARTER]] - hull[[2 * QUARTER, 3 * QUARTER]]) / 2
        self._mean[robot] = [*middle, heading, 0.0, 0.0]
        self._covariance[robot] = np.diag(np.square([*half, bound, 0.0, self._rules.clock]))
        self._covariance[robot, 2:4, 2:4] += self._rules.prior**2  # what is known of the heading, the camera may have said
        self._running[robot], self._misfit[robot] = True, 0.0

    def judge(self, time: float) -> None:
        """Suspect cameras whose offset or delay is beyond a bound for sure, and those no longer that agree again."""
        rules, (good_until, bad_since, suspected) = self._rules, self._judgement
        self._mean[:, 3] = wrap(self._mean[:, 3])  # a full turn is none
        running, off = self._running[:, None], np.abs(self._mean[:, 3:])
        deviation = np.sqrt(np.diagonal(self._covariance, axis1=1, axis2=2)[:, 3:])
        bound = np.column_stack([self._allowed, np.full(len(off), rules.tolerated_delay)])
        known = running & (deviation < np.array([rules.prior, rules.clock]) / 2)
        looks_good = known & (off <= deviation / 2)
        beyond = running & (off - rules.deviations * deviation > bound * [rules.share, 1.0])
        beyond[:, 0] &= ~suspected[:, 1]  # whatever a late camera shows, it may be late by more
        bad_since = np.where(beyond, np.minimum(bad_since, time), np.inf)
        agrees = known & (off + deviation <= bound)
        suspected = (time - bad_since >= rules.patience) | (suspected & ~agrees)
        good_until = np.where(looks_good, np.maximum(good_until, time - rules.hidden), good_until)
        self._judgement = [good_until, bad_since, suspected]


@compiled
def _drive(mean: Array, covariance: Array, chord: float, turn: float, noise: Array) -> None:
    """Move one estimate in place by a chord; the noise (5,) is the variance along it, across it, of turn, offset and delay."""
    way = mean[2] + turn / 2
    x, y = np.cos(way), np.sin(way)
    mean[0] += chord * x
    mean[1] += chord * y
    mean[2] += turn
    F = np.eye(5)
    F[0, 2], F[1, 2] = -chord * y, chord * x
    covariance[:] = F @ covariance @ F.T
    covariance[0, 0] += x * x * noise[0] + y * y * noise[1]
    covariance[1, 1] += y * y * noise[0] + x * x * noise[1]
    covariance[0, 1] += x * y * (noise[0] - noise[1])
    covariance[1, 0] += x * y * (noise[0] - noise[1])
    covariance[2, 2] += noise[2]
    covariance[3, 3] += noise[3]
    covariance[4, 4] += noise[4]


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
    H[0, 0], H[0, 1], H[0, 2], H[0, 3], H[0, 4] = dy / distance**2, -dx / distance**2, -1.0, 1.0, rate
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
