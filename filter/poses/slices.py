"""Slices: sets of poses with a wide heading, each an arc of headings and the polygon of positions that goes with it.

A wide heading is coupled to the position: where it is 10 degrees, a landmark's bearing puts the robot here; where it is 30
degrees, over there; and from there it drives another way. So what is known of such a robot is taken along from step to step in
slices (the subpavings of interval analysis; Jaulin et al., Applied Interval Analysis, 2001).

All polygons have edges in the same directions and are given by their supports, how far they reach in each [m].
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array, Integers, Table
from filter.compiled import compiled, put, sum_of
from filter.geometry.angles import ANGLE_ROUNDING, AngularIntervals, narrowest
from filter.geometry.convex import EPSILON
from filter.geometry.polygon import Polygon
from filter.poses.cone import wrapped
from filter.records.frame import Frame
from filter.records.odometry import Odometry
from filter.records.record import field_names
from filter.sensing.motion import displacements_of
from filter.team import Team

COUNT = 24  # directions; 15 degrees between two cost 1 to 2 % of a polygon's area
QUARTER = COUNT // 4
ANGLES = 2 * np.pi * np.arange(COUNT) / COUNT
DIRECTIONS = np.stack([np.cos(ANGLES), np.sin(ANGLES)], axis=1)
DIRECTIONS[np.abs(DIRECTIONS) < EPSILON] = 0.0  # the four along the axes are exact
NARROW_HEADING = np.radians(4.0)  # a heading known as well as this has no slices [rad]
FINEST_SLICE = np.radians(2.0)  # slices are no finer than this [rad]
STRETCHED = 1.5  # slices that are so much wider than they should be, on average, are cut anew
SLACK = 16 * ANGLE_ROUNDING  # by which arcs are wider, each time they are put together [rad]
HAIR_OF_CELL = 1e-6  # of a cell of the grid on which they are
AGREED, EARLIER = -1, -2  # slices that do without no vote; that do without one that is over (see `filter.poses.votes`)

# The root that each of k leaves comes from, their arcs (k, 2), centre and bound [rad], and supports (k, COUNT) [m].
Leaves = tuple[Integers, Array, Array]


@dataclass(frozen=True, eq=False)
class Slices(Table):
    """Slices of the poses of some robots; the truth is in one of those of its robot.

    Attributes:
        robot: (s,) whose each is, sorted.
        centre: (s,) middle of its arc of headings [rad].
        bound: (s,) half-width of that [rad].
        reach: (s, COUNT) supports of the polygon around the positions [m].
        vote: (s,) the vote that each does without, where one can be wrong, or EARLIER; else AGREED.
    """

    robot: Integers
    centre: Array
    bound: Array
    reach: Array
    vote: Integers

    @classmethod
    def none(cls) -> Slices:
        """Return that there are none."""
        nobody = np.zeros(0, dtype=np.int64)
        return cls(nobody, np.zeros(0), np.zeros(0), np.zeros((0, COUNT)), nobody)

    @classmethod
    def of_table(cls, robots: Integers, table: Array, votes: Integers | int = AGREED) -> Slices:
        """Return slices (s, 2 + COUNT), centre and bound of an arc [rad] and supports [m], of robots (s,)."""
        vote = np.broadcast_to(votes, robots.shape).astype(np.int64)
        return cls(robots, table[:, 0].copy(), table[:, 1].copy(), table[:, 2:].copy(), vote)

    @classmethod
    def around(cls, robot: int, polygon: Polygon, headings: AngularIntervals) -> Slices:
        """Return one slice of all poses of a robot, in a polygon and with its own one of the headings (n)."""
        supports = polygon.support(DIRECTIONS)
        reach = supports + 4 * EPSILON * np.abs(supports)
        return cls(np.array([robot]), headings.centre[[robot]], headings.bound[[robot]], reach[None], np.array([AGREED]))

    @property
    def arcs(self) -> AngularIntervals:
        """(s) arcs of headings [rad]."""
        return AngularIntervals.of_found(self.centre, self.bound)

    def of(self, robot: int) -> Slices:
        """Return those of one robot."""
        return self.select(np.arange(*np.searchsorted(self.robot, [robot, robot + 1])))

    def without(self, robots: Integers) -> Slices:
        """Return those of all other robots than some (k,)."""
        return self.select(~np.isin(self.robot, robots)) if len(self) else self

    def contradicted(self) -> Integers:
        """Return the robots (k,) that have slices, all of which do without a vote: one of these votes is wrong."""
        agreed = self.robot[self.vote == AGREED]
        return np.setdiff1d(self.robot, agreed) if len(agreed) < len(self) else agreed[:0]

    def hulls(self, robots: Integers) -> tuple[AngularIntervals, Array]:
        """Return what is around the slices of robots (k,) that have some: arcs (k) [rad] and supports (k, COUNT) [m]."""
        first = np.searchsorted(self.robot, [robots, robots + 1])
        arcs = [narrowest((self.centre - self.bound)[a:b], (self.centre + self.bound)[a:b]) for a, b in first.T.tolist()]
        reach = [self.reach[a:b].max(axis=0) for a, b in first.T.tolist()]
        return AngularIntervals.of_found(*np.array(arcs).reshape(-1, 2).T.copy()), np.array(reach).reshape(-1, COUNT)

    def at_most(self, most: int) -> Slices:
        """Return those of robots that have no more than so many: what else is known holds without them, too."""
        robots, counts = np.unique(self.robot, return_counts=True)
        return self.without(robots[counts > most])

    def replaced(self, robots: Integers, others: Slices) -> Slices:
        """Return those of some robots (k,) replaced by others of theirs."""
        both = Slices.concatenate([self.without(robots), others])
        return both.select(np.argsort(both.robot, kind="stable"))

    def moved(self, odometry: Odometry | None, team: Team, duration: float) -> Slices:
        """Return the slices after a motion of so long a time [s]: each drives its own way, within its own arc."""
        if not len(self):
            return self
        told, turn, wider = self._driven(odometry), np.zeros(len(self)), (team.turn_rate_limit * duration)[self.robot]
        if told is not None:
            turn[told.robot], wider[told.robot] = told.turn, told.turn_bound
        sets, each = displacements_of(told, self.arcs, (team.speed_limit * duration)[self.robot]), np.arange(len(self))
        by = sets.support(np.repeat(each, COUNT), np.tile(DIRECTIONS, (len(self), 1))).reshape(-1, COUNT)
        arcs, size = self.arcs.turned_by(turn, wider), np.abs(self.reach) + np.abs(by)
        return replace(self, centre=arcs.centre, bound=arcs.bound, reach=self.reach + by + 4 * EPSILON * size)

    def through(self, start: float, frames: Sequence[Frame], team: Team) -> Slices:
        """Return the slices after the motions to frames, from a start on [s]."""
        slices, before = self, start
        for frame in frames if len(self) else ():
            slices, before = slices.moved(frame.odometry, team, frame.time - before), frame.time
        return slices

    def _driven(self, odometry: Odometry | None) -> Odometry | None:
        """Return odometry as if each slice were a robot, numbered as slices are."""
        if odometry is None:
            return None
        place = np.full(max(self.robot.max(), odometry.robot.max(initial=0)) + 1, -1)
        place[odometry.robot] = np.arange(len(odometry.robot))
        told = np.flatnonzero(place[self.robot] >= 0)
        columns = {name: getattr(odometry, name)[place[self.robot[told]]] for name in field_names(odometry)}
        return Odometry.of_checked(odometry.time, columns | {"robot": told}, start=odometry.start)


@compiled
def regrouped(heading: Array, leaves: Leaves, roots: int, budget: int) -> Array:
    """Return slices (g, 2 + COUNT) around the leaves of a tree: centre and bound of an arc [rad], and supports [m].

    All leaves are within a heading (2,). Those of one root stay one slice; but where roots are few, or slices have become wide
    for the heading, they are cut anew, into no more than a budget.
    """
    width = max(2 * heading[1] / budget, FINEST_SLICE)
    as_before = _by_root(leaves, roots)
    wide = 2 * sum_of(as_before[:, 1]) > STRETCHED * width * len(as_before)
    if roots > 1 and len(as_before) <= budget and not wide:
        return as_before
    return _on_a_grid(heading, leaves, max(1, int(np.ceil(2 * heading[1] / width - HAIR_OF_CELL))))


@compiled
def _by_root(leaves: Leaves, roots: int) -> Array:
    """Return the slices around the leaves of each root that has any."""
    root, arcs, reach = leaves
    slices, count = np.full((roots, 2 + COUNT), -np.inf), 0
    for r in range(roots):
        first, low, high = -1, np.inf, -np.inf
        for k in range(len(root)):
            if root[k] != r:
                continue
            first = k if first < 0 else first
            turn = wrapped(arcs[k, 0] - arcs[first, 0])
            low, high = min(low, turn - arcs[k, 1]), max(high, turn + arcs[k, 1])
            for m in range(COUNT):
                slices[count, 2 + m] = max(slices[count, 2 + m], reach[k, m])
        if first >= 0:
            slices[count, 0] = wrapped(arcs[first, 0] + (low + high) / 2)
            slices[count, 1] = min(np.pi, (high - low) / 2 + SLACK)
            count += 1
    return slices[:count].copy()


@compiled
def _on_a_grid(heading: Array, leaves: Leaves, cells: int) -> Array:
    """Return the slices around what is in each cell of a grid of headings."""
    (_, arcs, reach), half, width = leaves, heading[1] + SLACK, 2 * (heading[1] + SLACK) / cells
    ends, supports = np.empty((cells, 2)), np.full((cells, COUNT), -np.inf)
    ends[:, 0], ends[:, 1] = np.inf, -np.inf
    for k in range(len(arcs)):
        for turn in range(-1, 2):
            middle = wrapped(arcs[k, 0] - heading[0]) + 2 * np.pi * turn
            low, high = max(-half, middle - arcs[k, 1] - SLACK), min(half, middle + arcs[k, 1] + SLACK)
            if low > high:
                continue
            # What is a hair over an edge stays with its cell, or neighbours would be put together again and again.
            first = min(cells - 1, int(np.floor((low + half) / width + HAIR_OF_CELL)))
            last = min(cells - 1, max(first, int(np.ceil((high + half) / width - HAIR_OF_CELL)) - 1))
            for cell in range(first, last + 1):
                ends[cell, 0] = min(ends[cell, 0], low if cell == first else cell * width - half)
                ends[cell, 1] = max(ends[cell, 1], high if cell == last else (cell + 1) * width - half)
                for m in range(COUNT):
                    supports[cell, m] = max(supports[cell, m], reach[k, m])
    slices, count = np.empty((cells, 2 + COUNT)), 0
    for cell in range(cells):
        if ends[cell, 0] <= ends[cell, 1]:
            slices[count, 0] = wrapped(heading[0] + (ends[cell, 0] + ends[cell, 1]) / 2)
            slices[count, 1] = min(np.pi, (ends[cell, 1] - ends[cell, 0]) / 2 + SLACK)
            put(supports[cell], slices[count, 2:])
            count += 1
    return slices[:count].copy()
