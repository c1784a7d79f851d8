"""Measurements of several instants, merged at the last one: how robots have moved and turned since each of the instants.

A row on positions of an earlier time is one on those of now, moved outward by what the robots can have driven since. So several
instants cost one prediction and one projection.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from filter.arrays import Array, Frozen, Integers
from filter.compiled import compiled
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import WORLD, Constraints
from filter.records.frame import Frame
from filter.records.odometry import Odometry
from filter.records.record import field_names
from filter.sensing.motion import Displacements, displacements_of, support_of
from filter.team import Team


@dataclass(frozen=True, eq=False)
class Since(Frozen):
    """How n robots have moved from one of s instants to the next; the last one is now, the first began with a belief.

    Attributes:
        stamps: (s,) when the instants were, in order of time [s].
        headings: (n) in the beginning [rad].
        turns: (s, n, 2) turn on the way to each instant, and its largest error [rad].
        odometry: The motion on the way to each of them, of robots numbered k n + robot for the k-th; None where nobody knows.
        reach: (s n,) how far those without odometry can have gone [m].
    """

    stamps: Array
    headings: AngularIntervals
    turns: Array
    odometry: Odometry | None
    reach: Array

    @classmethod
    def of(cls, team: Team, headings: AngularIntervals, start: float, frames: Sequence[Frame]) -> "Since":
        """Return what frames, each with the motion since the one before, say of the time from a start [s]."""
        stamps = np.array([frame.time for frame in frames])
        length, count = np.diff(stamps, prepend=start)[:, None], len(frames)
        turns = np.stack([np.zeros((count, team.robots)), length * team.turn_rate_limit], axis=2)
        told = [(k, frame.odometry) for k, frame in enumerate(frames) if frame.odometry is not None]
        stacked = None
        if told:
            columns = {name: np.concatenate([getattr(record, name) for _, record in told]) for name in field_names(told[0][1])}
            columns["robot"] = np.concatenate([record.robot + k * team.robots for k, record in told])
            stacked = Odometry.of_checked(float(stamps[-1]), columns, start=start)
            turns.reshape(-1, 2)[stacked.robot] = np.stack([stacked.turn, stacked.turn_bound], axis=1)
        return cls(stamps, headings, turns, stacked, (length * team.speed_limit).ravel())

    def moves(self, looks: AngularIntervals) -> "Moves":
        """Return where robots have gone, that looked so in the beginning and at each instant, (s n + n) [rad]."""
        robots = len(self.headings)
        return Moves(displacements_of(self.odometry, looks[:-robots], self.reach), robots)


@dataclass(frozen=True, eq=False)
class Moves(Frozen):
    """Where n robots have gone from one instant to the next, of s: sets of displacements that add up.

    Attributes:
        sets: (s n) displacements on the way to each instant.
        robots: n
    """

    sets: Displacements
    robots: int

    def support(self, robot: Integers, direction: Array, at: Integers | None = None) -> Array:
        """Return (r,) upper bounds of direction . u, (r, 2), over displacements since instants, or the beginning [m]."""
        first = np.zeros(len(robot), dtype=np.int64) if at is None else at + 1
        sets = self.sets
        return _support(sets.vertices, sets.reach, sets.slip, first * self.robots + robot, self.robots, direction)

    def moved(self, rows: Constraints, at: Integers | None = None) -> Constraints:
        """Return rows (r) on positions at instants (r,), or in the beginning, as rows on those of now."""
        pair = np.flatnonzero(rows.i != WORLD)
        own = self.support(rows.j, rows.normal, at)
        own[pair] += self.support(rows.i[pair], -rows.normal[pair], None if at is None else at[pair])
        return rows.shifted(own)

    @property
    def normals(self) -> Array:
        """(n, CORNERS, 2) outward normals of edges of what was last added up for each robot; NaN where there are fewer."""
        return self.sets.normals[-self.robots :]

    @cached_property
    def discs(self) -> tuple[Array, Array]:
        """Centres (s n + n, 2) and radii (s n + n,) of discs around displacements since the beginning and each instant [m]."""
        middle, radius, size = self.sets.discs
        centre, reach = np.zeros((len(radius) + self.robots, 2)), np.zeros(len(radius) + self.robots)
        _add_up(centre, reach, middle, radius, size)
        return centre, reach

    def between(self, robot: Integers, target: Integers, at: Integers) -> tuple[Array, Array]:
        """Return by what (k, 2) the way from robots to targets, and up to what (k,), is another now than at instants [m]."""
        centre, radius = self.discs
        moving, first = target < self.robots, (at + 1) * self.robots
        place, mate = first + robot, np.where(moving, first + target, 0)
        by = np.where(moving[:, None], centre[mate], 0.0) - centre[place]
        return by, np.where(moving, radius[mate], 0.0) + radius[place]


@compiled
def _add_up(centre: Array, reach: Array, middle: Array, radius: Array, size: Array) -> None:
    """Write centres and radii of the discs since each instant, from those on the way to each; none since the last one."""
    robots, rounding = len(reach) - len(radius), np.zeros(len(reach))
    for k in range(len(radius) - 1, -1, -1):
        centre[k, 0], centre[k, 1] = centre[k + robots, 0] + middle[k, 0], centre[k + robots, 1] + middle[k, 1]
        reach[k], rounding[k] = reach[k + robots] + radius[k], rounding[k + robots] + size[k]
    for k in range(len(radius)):
        reach[k] += 1e-12 * rounding[k]


@compiled
def _support(vertices: Array, reach: Array, slip: Array, place: Integers, robots: int, direction: Array) -> Array:
    support = np.zeros(len(place))
    for k in range(len(place)):
        for part in range(place[k], len(slip), robots):
            support[k] += support_of(vertices[part], reach[part], slip[part], direction[k, 0], direction[k, 1])
    return support
