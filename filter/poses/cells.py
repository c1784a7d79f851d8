"""What ranges and bearings of wide directions leave of each robot's poses: the hulls of cells, with its mates as sets."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import overload

import numpy as np

from filter.arrays import Array, Frozen, Integers, Mask, chosen
from filter.geometry.angles import AngularIntervals
from filter.geometry.many import Polygons
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope, prune
from filter.linear.sources import Sources
from filter.poses.branch import FEW_EDGES, Tree
from filter.poses.slices import Slices
from filter.poses.turns import CORNERS_FOR_OTHERS, Heard, Outcome, Sets, Starts, in_turn
from filter.sensing.arms import Arms
from filter.sensing.readings import Readings
from filter.sensing.rows import world_arcs

FINEST_TANGENTS = np.pi / 12  # apart; so cells, which have few corners, have room for what matters [rad]
AT_A_TIME = 16  # so many robots are found before there is another look at the time
START_EDGES = 24  # so many rows on a robot are what its poses are cut from, at most


@dataclass(frozen=True, eq=False)
class Told(Frozen):
    """Readings as whoever they concern is told of them: those of mates twice, once as the other one's.

    Attributes:
        robot: (m,) who is told; sorted, and the rest by the target and between which sensors, bearings before ranges.
        target: (m,) of what.
        reading: (m,) by which one, bearings before ranges.
        begins: (m,) whether it is the first one of its target and sensors.
        sector: (m, 4) see `cell`.
        own: (m,) whether the bearing is from the robot's own heading.
        headings: (n) before [rad].
        spacing: Greatest angle between two tangents of a range's far side [rad].
        arms: Of the readings; None if all are taken at the centres of robots.
    """

    robot: Integers
    target: Integers
    reading: Integers
    begins: Mask
    sector: Array
    own: Mask
    headings: AngularIntervals
    spacing: float
    arms: Arms | None = None

    @classmethod
    def of(cls, readings: Readings, headings: AngularIntervals, spacing: float, arms: Arms | None = None) -> "Told":
        """Return what readings say, given the (n) headings [rad], and the ways from the places of sensors to the centres."""
        bearings, ranges = readings.bearings, readings.ranges
        count, robots = len(bearings.robot), len(headings)
        ways = world_arcs(bearings, headings[bearings.robot]).turned(np.pi)
        of_bearings, back = (
            _sectors(value, bound) for value, bound in ((bearings.bearing, bearings.bound), (ways.centre, ways.bound))
        )
        of_ranges = _sectors(np.zeros(len(ranges.robot)), np.full(len(ranges.robot), np.pi))
        of_ranges[:, 2], of_ranges[:, 3] = ranges.interval()
        robot = np.concatenate([bearings.robot, bearings.target, ranges.robot, ranges.target])
        target = np.concatenate([bearings.target, bearings.robot, ranges.target, ranges.robot])
        own = np.arange(len(robot)) < count
        sector = np.concatenate([of_bearings, back, of_ranges, of_ranges])
        told = bearings, bearings, ranges, ranges
        reading = np.concatenate(
            [begin + np.arange(len(each.robot)) for each, begin in zip(told, (0, 0, count, count), strict=True)]
        )
        spots = np.concatenate([np.broadcast_to(readings.spots(each)[0], len(each.robot)) for each in told])
        order = np.lexsort((reading >= count, spots, target, robot))
        order = order[robot[order] < robots]
        begins = (np.diff(np.stack([robot, target, spots])[:, order], prepend=-1) != 0).any(axis=0)
        which = robot[order], target[order], reading[order], begins, sector[order], own[order]
        return cls(*which, headings, max(spacing, FINEST_TANGENTS), arms)

    def select(self, index: Integers) -> "Told":
        """Return some of what is told, whole targets of theirs."""
        names = "robot", "target", "reading", "begins", "sector", "own"
        return replace(self, **{name: getattr(self, name)[index] for name in names})

    def apart(self, robots: Integers) -> tuple[Array, Integers]:
        """Return corners (p, 2) of by how much ways to targets are others than measured, and where (m + 1,) each one's begin.

        They are those of some robots (k,), and none if all readings are taken at the centres of robots.
        """
        counts, corners = np.zeros(len(self.robot), dtype=np.int64), [np.zeros((0, 2))]
        if self.arms is not None:
            for place in np.flatnonzero(self.begins & np.isin(self.robot, robots)).tolist():
                reading = int(self.reading[place])
                corners.append(self.arms.seen(reading, bool(self.arms.robot[reading] != self.robot[place])))
                counts[place] = len(corners[-1])
        return np.concatenate(corners), np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])

    def heard(self, robots: Integers) -> Heard:
        """Return the same for a compiled function, of some robots (k,)."""
        headings = self.headings.centre, self.headings.bound
        return Heard(self.target, self.begins, self.sector, self.own, *self.apart(robots), headings, self.spacing)


@dataclass(frozen=True, eq=False)
class ByCases(Frozen):
    """A proof that a robot is behind some half-planes, case by case: in none of the pieces of a tree is it anywhere else.

    Attributes:
        known: The polytope whose rows on single robots, and those of the cases before, tell where robots can be.
        sources: What produced the rows.
        headings: (n) before [rad].
        robot: Whose poses they are.
        spacing: Greatest angle between two tangents of a range's far side [rad].
        tree: How they were split.
        rows: (k, 4) normals and offsets [m], and whether they are among the few that are enough for others.
        heading: (2,) centre and bound of what is left of its heading [rad].
        roots: Its slices before, from which the tree begins; none where it begins from all that is known.
        slices: (g, 2 + COUNT) what its slices are then (see `regrouped`); none where it is to have none.
    """

    known: Polytope
    sources: Sources
    headings: AngularIntervals
    robot: int
    spacing: float
    tree: Tree
    rows: Array
    heading: Array
    roots: Slices
    slices: Array

    @property
    def few(self) -> Array:
        """The (k, 3) rows that are enough for others."""
        return self.rows[self.rows[:, 3] > 0, :3]

    def constraints(self, source: int) -> Constraints:
        """Return the half-planes as rows, from a number in the belief's table of sources."""
        count = len(self.rows)
        who = np.full(count, WORLD), np.full(count, self.robot)
        return Constraints(*who, self.rows[:, :2].copy(), self.rows[:, 2].copy(), np.full(count, source))


@dataclass(frozen=True)
class Most:
    """Into how many parts the poses of one robot are cut at most.

    Attributes:
        cells: In an update.
        slices: That are taken along.
    """

    cells: int
    slices: int

    @property
    def taken_along(self) -> int:
        """How many slices there are at most: they are cells, and have to leave room for others."""
        return min(self.slices, self.cells // 2)


@dataclass(frozen=True, eq=False)
class Cases(Frozen, Sequence[ByCases]):
    """What was found case by case of k robots, one after the other.

    Attributes:
        known: The polytope whose rows on single robots, and those of the cases before, tell where robots can be.
        sources: What produced the rows.
        told: What robots are told.
        robot: (k,) whose poses they are.
        found: What was found.
        before: Their slices before, from which trees begin.
    """

    known: Polytope
    sources: Sources
    told: Told
    robot: Integers
    found: Outcome
    before: Slices

    def __len__(self) -> int:
        return len(self.robot)

    @overload
    def __getitem__(self, index: int) -> ByCases: ...

    @overload
    def __getitem__(self, index: slice) -> list[ByCases]: ...

    def __getitem__(self, index: int | slice) -> ByCases | list[ByCases]:
        k = chosen("a case", index, len(self))
        if isinstance(k, range):
            return [self[each] for each in k]
        found, robot, told = self.found, int(self.robot[k]), self.told
        tree = Tree(*(column[k] for column in found.trees))
        slices = found.slices[k, : found.kept[k]]
        rows, heading = found.rows[k, : found.edges[k]], found.heading[k]
        before = self.before.of(robot)
        return ByCases(self.known, self.sources, told.headings, robot, told.spacing, tree, rows, heading, before, slices)

    @property
    def headings(self) -> AngularIntervals:
        """(k) what is left of headings [rad]."""
        return AngularIntervals.of_found(self.found.heading[:, 0], self.found.heading[:, 1])

    @property
    def slices(self) -> Slices:
        """Slices of what is left."""
        found = self.found
        some = np.arange(found.slices.shape[1]) < found.kept[:, None]
        return Slices.of_table(np.repeat(self.robot, found.kept), found.slices[some])

    def constraints(self, sources: Integers) -> Constraints:
        """Return the half-planes as rows, from numbers (k,) in the belief's table of sources."""
        found = self.found
        rows = found.rows[np.arange(found.rows.shape[1]) < found.edges[:, None]]
        whose = np.repeat(np.arange(len(self)), found.edges)
        world = np.full(len(rows), WORLD)
        return Constraints(world, self.robot[whose], rows[:, :2].copy(), rows[:, 2].copy(), sources[whose])


@dataclass(frozen=True, eq=False)
class Scene(Frozen):
    """Where robots and landmarks can be before something is found in cells, and what is told of them.

    Attributes:
        known: Where robots can be.
        sources: What produced its rows.
        told: What robots are told.
        landmarks: (l, 2) [m].
        slices: Of robots' poses.
    """

    known: Polytope
    sources: Sources
    told: Told
    landmarks: Array
    slices: Slices

    def in_cells(self, robots: Integers, most: Most, is_over: Callable[[], bool] = lambda: False) -> tuple[Cases, int]:
        """Return what cells leave of robots' poses (k,), in order, until time is over; and of whom nothing, -1 for nobody."""
        mine = self.slices.select(np.isin(self.slices.robot, robots)).at_most(most.cells)
        starts, sets = self._starts(robots, mine)
        found, heard, done = Outcome.blank(len(robots), most.cells, most.taken_along), self.told.heard(robots), 0
        nowhere = -1
        while done < len(robots) and nowhere < 0 and not is_over():
            end = min(done + AT_A_TIME, len(robots))
            nowhere = in_turn((done, end), starts, heard, sets, found)
            done = end if nowhere < 0 else nowhere + 1
        cases = Cases(self.known, self.sources, self.told, robots[:done], found.first(done), mine)
        return cases, -1 if nowhere < 0 else int(robots[nowhere])

    def _starts(self, robots: Integers, slices: Slices) -> tuple[Starts, Sets]:
        """Return what the poses of robots (k,) are cut from, and where those can be of whom they are told."""
        whose, count, polygons = self.told.robot, len(self.known.lower), as_sets(self.known, robots, START_EDGES)
        sets = sets_of(self.known, self.landmarks, self.told.target[np.isin(whose, robots)], polygons.margin)
        said = np.stack([np.searchsorted(whose, robots), np.searchsorted(whose, robots + 1)], axis=1)
        lines = polygons.normals, polygons.offsets
        of_slices = (slices.centre, slices.bound, slices.reach), np.searchsorted(slices.robot, np.append(robots, count))
        return Starts(robots, said, lines, polygons.vertices, polygons.first, *of_slices), sets


def sets_of(known: Polytope, landmarks: Array, targets: Integers, margins: Array) -> Sets:
    """Return where landmarks (l, 2) are, and robots that are among targets (t,), beside polygons of some margins [m]."""
    count, bodies = len(known.lower), len(known.lower) + len(landmarks)
    mates = np.unique(targets[targets < count])
    others, corners = as_sets(known, mates, FEW_EDGES), np.zeros((bodies, CORNERS_FOR_OTHERS, 2))
    size = np.ones(bodies, dtype=np.int64)
    corners[count:, 0], size[mates] = landmarks, others.counts
    corners[mates[others.owner], np.arange(len(others.owner)) - others.first[others.owner]] = others.vertices
    margin = np.array([max(margins.max(initial=0), others.margin.max(initial=0))])
    return Sets(corners, size, margin, (known.lower, known.upper))


def few_rows(known: Polytope, robots: Integers, edges: int) -> Constraints:
    """Return no more than so many rows on each of some robots (k,) alone."""
    begin, end = known.constraints.groups(np.full(len(robots), WORLD), robots)
    rows = [np.arange(*ends) for ends in zip(begin.tolist(), end.tolist(), strict=True)]
    alone = known.constraints.select(np.concatenate([np.zeros(0, dtype=np.int64), *rows]))
    return prune(known.with_constraints(alone), edges, edges)


def as_sets(known: Polytope, robots: Integers, edges: int) -> Polygons:
    """Return polygons around some robots (k,), from no more than so many rows on each of them alone."""
    return known.with_constraints(few_rows(known, robots, edges)).of_robots(robots).polygons


def _sectors(value: Array, bound: Array) -> Array:
    return np.stack([value, bound, np.zeros(len(value)), np.full(len(value), np.inf)], axis=1)
