"""What ranges and bearings of wide directions leave of each robot's poses: the hulls of cells, with its mates as sets."""

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Frozen, Integers, Mask, read_only
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON
from filter.geometry.many import Polygons
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope, prune
from filter.sensing.branch import Tree, branch
from filter.sensing.cell import Said
from filter.sensing.readings import Readings
from filter.sensing.rows import world_arcs

EDGES, MATES_EDGES = 24, 8  # so many rows on a robot are what its poses are cut from, and on a mate make it a set


@dataclass(frozen=True, eq=False)
class Told(Frozen):
    """Readings as whoever they concern is told of them: those of mates twice, once as the other one's.

    Attributes:
        robot: (m,) who is told; sorted, and the rest by the target, bearings before ranges.
        target: (m,) of what.
        sector: (m, 4) see `cell`.
        own: (m,) whether the bearing is from the robot's own heading.
        landmarks: (l, 2) [m].
        spacing: Greatest angle between two tangents of a range's far side [rad].
    """

    robot: Integers
    target: Integers
    sector: Array
    own: Mask
    landmarks: Array
    spacing: float

    @classmethod
    def of(cls, readings: Readings, headings: AngularIntervals, landmarks: Array, spacing: float) -> "Told":
        """Return what readings say, given the (n) headings [rad]."""
        _, bearings, ranges = readings
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
        is_range = np.arange(len(robot)) >= 2 * count
        order = np.lexsort((is_range, target, robot))
        order = order[robot[order] < robots]
        return cls(robot[order], target[order], sector[order], own[order], landmarks, spacing)

    def said(self, robot: int, bodies: Polygons) -> Said:
        """Return what was said of one robot, where its mates are sets (n) [m]."""
        begin, end = np.searchsorted(self.robot, [robot, robot + 1])
        targets, first = np.unique(self.target[begin:end], return_index=True)
        hulls = [
            bodies.vertices[bodies.first[t] : bodies.first[t + 1]] if t < len(bodies) else self.landmarks[t - len(bodies)][None]
            for t in targets.tolist()
        ]
        point_first = np.cumsum([0, *map(len, hulls)])
        points = np.concatenate(hulls)
        return Said(
            self.sector[begin:end], self.own[begin:end], np.append(first, end - begin), points, point_first, self.spacing
        )


@dataclass(frozen=True, eq=False)
class ByCases(Frozen):
    """A proof that a robot is behind some half-planes, case by case: in none of the pieces of a tree is it anywhere else.

    Attributes:
        known: The polytope whose rows on single robots the pieces are cut from, and their mates are.
        headings: (n) before [rad].
        robot: Whose poses they are.
        tree: How they were split.
        rows: (k, 3) normals and offsets [m].
        heading: (2,) centre and bound of what is left of its heading [rad].
    """

    known: Polytope
    headings: AngularIntervals
    robot: int
    tree: Tree
    rows: Array
    heading: Array

    def constraints(self, source: int) -> Constraints:
        """Return the half-planes as rows, from a number in the belief's table of sources."""
        count = len(self.rows)
        who = np.full(count, WORLD), np.full(count, self.robot)
        return Constraints(*who, self.rows[:, :2].copy(), self.rows[:, 2].copy(), np.full(count, source))


def by_cases(known: Polytope, headings: AngularIntervals, told: Told, robot: int, cells: int) -> ByCases | None:
    """Return what so many cells leave of one robot's poses, from its own rows and those of its mates; None if nothing."""
    bodies, start = as_sets(known, MATES_EDGES), as_sets(known, EDGES).select(np.array([robot]))
    said = told.said(robot, bodies)
    origin = (known.lower[robot] + known.upper[robot]) / 2
    far = np.abs(origin).max() + max(np.abs(start.vertices).max(), np.abs(said.points).max())
    margin = max(start.margin.max(), bodies.margin.max()) + 8 * EPSILON * far
    heading, tree = np.array([headings.centre[robot], headings.bound[robot]]), Tree.blank(cells)
    moved = said._replace(points=said.points - origin)
    rows = branch(start.vertices - origin, heading, moved, margin, tree)
    if not len(rows):
        return None
    rows[:, 2] += rows[:, :2] @ origin + 8 * EPSILON * far
    return ByCases(known, headings, robot, Tree(*map(read_only, tree)), rows, heading)


def as_sets(known: Polytope, edges: int) -> Polygons:
    """Return (n) polygons around the robots, from no more than so many rows on each of them alone."""
    rows = known.constraints
    alone = known.with_constraints(rows.select(rows.i == WORLD))
    few = known.with_constraints(prune(alone, edges, edges))
    return few.of_robots(np.arange(len(known.lower))).polygons


def _sectors(value: Array, bound: Array) -> Array:
    return np.stack([value, bound, np.zeros(len(value)), np.full(len(value), np.inf)], axis=1)
