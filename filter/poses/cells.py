"""What ranges and bearings of wide directions leave of each robot's poses: the hulls of cells, with its mates as sets."""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Frozen, Integers, Mask, read_only
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON, hull_of
from filter.geometry.many import Polygons, clip_boxes
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope, prune
from filter.linear.sources import Sources
from filter.poses.branch import FEW_EDGES, Roots, Tree, branch
from filter.poses.cell import Said
from filter.poses.slices import COUNT, DIRECTIONS, Slices, regrouped
from filter.sensing.arms import Arms
from filter.sensing.readings import Readings
from filter.sensing.rows import world_arcs

FINEST_TANGENTS = np.pi / 12  # apart; so cells, which have few corners, have room for what matters [rad]
NO_SLICES = np.zeros((0, 2 + COUNT))
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

    def said(self, robot: int, bodies: Mapping[int, Array]) -> Said:
        """Return what was said of one robot, where bodies are sets, hulls of points (p, 2) [m]."""
        begin, end = np.searchsorted(self.robot, [robot, robot + 1])
        first = np.flatnonzero(self.begins[begin:end])
        points = [self._points(place, bodies) for place in (begin + first).tolist()]
        each, first = np.cumsum([0, *map(len, points)]), np.append(first, end - begin)
        return Said(self.sector[begin:end], self.own[begin:end], first, np.concatenate(points), each, self.spacing)

    def _points(self, place: int, bodies: Mapping[int, Array]) -> Array:
        """Return where the target would be, seen from the centre of the robot that is told, as its sensor sees it."""
        points, reading = bodies[int(self.target[place])], int(self.reading[place])
        if self.arms is None:
            return points
        apart = self.arms.seen(reading, bool(self.arms.robot[reading] != self.robot[place]))
        return hull_of((points[:, None] + apart).reshape(-1, 2))


class Places:
    """Where bodies can be, as sets with few edges; those of robots found in cells become smaller one after the other.

    Attributes:
        known: From which this is known.
        told: What robots are told of them.
        starts: What the poses of each robot are cut from, polygons by robots [m].
        bodies: Corners (p, 2) of the sets that robots and landmarks are for others, by bodies [m].
        margin: How far sets can reach beyond the hulls of their corners [m].
    """

    def __init__(self, known: Polytope, told: Told, robots: Integers, landmarks: Array) -> None:
        """Begin with what is known of some robots (k,), and of those of which they are told."""
        self.known, self.told, targets = known, told, np.unique(told.target[np.isin(told.robot, robots)])
        mates = targets[targets < len(known.lower)]
        starts, others = as_sets(known, robots, START_EDGES), as_sets(known, mates, FEW_EDGES)
        self.starts = dict(zip(robots.tolist(), starts, strict=True))
        self.bodies = dict(zip(mates.tolist(), others.corners(), strict=True))
        self.bodies |= dict(enumerate(landmarks[:, None], len(known.lower)))
        self.margin = float(max(starts.margin.max(initial=0), others.margin.max(initial=0)))

    def roots(self, robot: int, heading: AngularIntervals, slices: Slices) -> Roots:
        """Return the sets of poses of a robot with an arc of headings (1): its polygon, cut by its slices if it has any."""
        start, count = self.starts[robot], len(slices)
        if not count:
            return Roots(start.vertices, np.array([0, len(start.vertices)]), np.stack([heading.centre, heading.bound], axis=1))
        lines, each = len(start.offsets) + COUNT, np.zeros(count, dtype=np.int64)
        normals = np.tile(np.concatenate([start.normals, DIRECTIONS]), (count, 1))
        offsets = np.concatenate([np.tile(start.offsets, (count, 1)), slices.reach], axis=1).ravel()
        ends, whose = lines * np.arange(1, count + 1), each + robot
        box = self.known.lower[whose], self.known.upper[whose]
        clipped, arcs = clip_boxes(read_only(normals), read_only(offsets), (ends - lines, ends), *box), slices.arcs
        arcs, found = arcs.intersection(heading[each]), clipped.polygons
        some, self.margin = ~(clipped.empty | arcs.empty), max(self.margin, float(found.margin.max()))
        corners, first = found.vertices[some[found.owner]], np.cumsum([0, *np.where(some, found.counts, 0)])
        return Roots(corners, first, np.stack([arcs.centre, arcs.bound], axis=1))

    def take(self, case: "ByCases") -> None:
        """Take over where a robot was found to be."""
        rows, box = case.few, (self.known.lower[[case.robot]], self.known.upper[[case.robot]])
        group = np.zeros(1, dtype=np.int64), np.full(1, len(rows))
        lines = read_only(rows[:, :2].copy()), read_only(rows[:, 2].copy())  # as all others: no other type is compiled for
        found = clip_boxes(*lines, group, *box).polygons
        self.bodies[case.robot], self.margin = found.vertices, max(self.margin, float(found.margin[0]))


@dataclass(frozen=True, eq=False)
class ByCases(Frozen):
    """A proof that a robot is behind some half-planes, case by case: in none of the pieces of a tree is it anywhere else.

    Attributes:
        known: The polytope whose rows on single robots, and those of the cases before, tell where robots can be (see `Places`).
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


def by_cases(places: Places, sources: Sources, robot: int, slices: Slices, most: Most) -> ByCases | None:
    """Return what is left of one robot's poses, from its slices before, and where bodies can be; None if that is nothing."""
    told = places.told
    looks = told.headings[np.array([robot])]
    roots, said = places.roots(robot, looks, slices), told.said(robot, places.bodies)
    if not len(roots.corners):
        return None
    west, east = roots.corners.min(axis=0), roots.corners.max(axis=0)
    origin = (west + east) / 2
    far = np.abs(origin).max() + max(np.abs(west).max(), np.abs(east).max(), np.abs(said.points).max())
    heading, tree, slack = np.stack([looks.centre, looks.bound])[:, 0], Tree.blank(most.cells), 8 * EPSILON * far
    moved = said._replace(points=said.points - origin)
    rows = branch(roots._replace(corners=roots.corners - origin), heading, moved, places.margin + slack, tree)
    if not len(rows):
        return None
    rows[:, 2] += rows[:, :2] @ origin + slack
    tree.line[:, 2] += tree.line[:, :2] @ origin
    tree.reach[:] += DIRECTIONS @ origin + slack
    budget = most.taken_along
    kept = regrouped(heading, tree.leaves, len(roots.heading), budget) if budget else NO_SLICES
    of_it = tuple(map(read_only, tree))
    return ByCases(places.known, sources, told.headings, robot, told.spacing, Tree(*of_it), rows, heading, slices, kept)


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
