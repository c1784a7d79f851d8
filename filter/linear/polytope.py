"""The team's polytope: constraints within a box, what it says of one robot or one pair at a glance, and which rows matter."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from filter.arrays import Array, Frozen, Integers, Mask
from filter.compiled import compiled, put
from filter.geometry.convex import centroid_of
from filter.geometry.many import Clipped, clip_boxes
from filter.geometry.simplify import edges_worth_keeping
from filter.linear.constraints import WORLD, Constraints
from filter.linear.program import LinearProgram

TWINS = 1e-6  # rows that turn by less lead a walk astray, and say the same [rad]
APART = 1e-6  # and so do those that are not even this share of the size of what they bound apart


@dataclass(frozen=True, eq=False)
class Polytope(Frozen):
    """The set of configurations {x : constraints, lower <= x <= upper}.

    Attributes:
        constraints: Rows on the bodies.
        lower: (n, 2) least coordinates, finite [m].
        upper: (n, 2) greatest coordinates, finite; equal to the lower ones where anchored [m].
        origin: (n,) what each robot's box comes from, numbers in the belief's table of sources; (0,) when nobody asks.
    """

    constraints: Constraints
    lower: Array
    upper: Array
    origin: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def with_constraints(self, constraints: Constraints) -> Polytope:
        """Return the same box with other rows."""
        return Polytope(constraints, self.lower, self.upper, self.origin)

    def program(self) -> LinearProgram:
        """Return the polytope as a linear program in (x_0, y_0, x_1, y_1, ...)."""
        A = self.constraints.matrix(len(self.lower))
        return LinearProgram(A, self.constraints.offset, self.lower.ravel(), self.upper.ravel())

    def may_have_a_broken_row(self) -> bool:
        """Return whether some row seems to hold nowhere in the box; a look that is cheap, and no proof."""
        rows, (lower, upper) = self.constraints, self.around(self.constraints.i, self.constraints.j)
        least = (rows.normal * np.where(rows.normal > 0, lower, upper)).sum(axis=1)
        return bool((least > rows.offset).any())

    def of_robots(self, robots: Integers) -> Clipped:
        """Return polygons around (g) robots, each from its own rows and the box alone, and the row behind each edge."""
        return self.of(np.full(len(robots), WORLD), robots)

    def of(self, i: Integers, j: Integers) -> Clipped:
        """Return the same around x_j - x_i for (g) pairs i < j, or around x_j where i is WORLD."""
        rows = self.constraints
        return clip_boxes(rows.normal, rows.offset, rows.groups(i, j), *self.around(i, j))

    def around(self, i: Integers, j: Integers) -> tuple[Array, Array]:
        """Return the corners of boxes around x_j - x_i, or x_j where i is WORLD, both (g, 2); they err outward [m]."""
        lower, upper = np.empty((len(j), 2)), np.empty((len(j), 2))
        _around((lower, upper), i, j, (self.lower, self.upper))
        return lower, upper

    def loosened(self, share: float = APART) -> Polytope:
        """Return the same with rows and box outward by a share of the boxes' extents.

        Where rows were proved from one another, more of them meet in a vertex than a walk can tell apart.
        """
        rows, by = self.constraints, share * (self.upper - self.lower).sum(axis=1, keepdims=True)
        lower, upper = self.around(rows.i, rows.j)
        return Polytope(rows.shifted(share * (upper - lower).sum(axis=1)), self.lower - by, self.upper + by, self.origin)

    def within(self, other: Polytope) -> Polytope:
        """Return what is in both, boxes too."""
        rows = Constraints.concatenate([self.constraints, other.constraints])
        return Polytope(rows, np.maximum(self.lower, other.lower), np.minimum(self.upper, other.upper), self.origin)


def prune(polytope: Polytope, rows_per_robot: int, rows_per_pair: int) -> Constraints:
    """Return the polytope's rows with at most so many left on each robot and on each pair: dropping rows is always sound.

    Of twins, almost the same row twice, one goes. Where there are more, those that the others imply within the group go first,
    then again and again the edge whose removal adds the least area.
    """
    polytope = polytope.with_constraints(_without_twins(polytope))
    rows = polytope.constraints
    i, j, first = rows.grouped()
    size, budget = first[1:] - first[:-1], np.where(i == WORLD, rows_per_robot, rows_per_pair)
    crowded = np.flatnonzero(size > budget)
    if not len(crowded):
        return rows
    clipped = polytope.of(i[crowded], j[crowded])
    stays = size <= budget
    stays[crowded[clipped.empty]] = True  # rows that exclude one another all stay, for the next update to name their causes
    keep = np.repeat(stays, size)
    outlines, is_row = clipped.polygons, clipped.behind < len(rows)  # sides of the box stay, and count nothing
    lines = outlines.normals, outlines.offsets
    worthy = _worthy(lines, outlines.vertices, outlines.first, is_row, budget[crowded])
    keep[clipped.behind[worthy & is_row]] = True
    return rows.select(keep)


def _without_twins(polytope: Polytope) -> Constraints:
    """Return the rows without those that another one on the same robot or pair is almost parallel to, and cuts off more."""
    rows = polytope.constraints
    i, j, first = rows.grouped()
    lower, upper = polytope.around(i, j)
    keep = _single(rows.normal, rows.offset, first, (lower + upper) / 2)
    return rows if keep.all() else rows.select(keep)


@compiled
def _around(around: tuple[Array, Array], i: Integers, j: Integers, box: tuple[Array, Array]) -> None:
    (lower, upper), (least, greatest) = around, box
    for k in range(len(j)):
        for axis in range(2):
            lower[k, axis], upper[k, axis] = least[j[k], axis], greatest[j[k], axis]
            if i[k] != WORLD:
                lower[k, axis] = np.nextafter(lower[k, axis] - greatest[i[k], axis], -np.inf)
                upper[k, axis] = np.nextafter(upper[k, axis] - least[i[k], axis], np.inf)


@compiled
def _single(normals: Array, offsets: Array, first: Integers, middle: Array) -> Mask:
    keep = np.ones(len(offsets), dtype=np.bool_)
    for g in range(len(first) - 1):
        for one in range(first[g], first[g + 1]):
            for other in range(first[g], one):
                x, y = normals[one, 0] - normals[other, 0], normals[one, 1] - normals[other, 1]
                if keep[other] and abs(x) + abs(y) < TWINS:
                    nearer = offsets[one] - offsets[other] < x * middle[g, 0] + y * middle[g, 1]
                    keep[other if nearer else one] = False
                    if not nearer:
                        break
    return keep


@compiled
def _worthy(lines: tuple[Array, Array], vertices: Array, first: Integers, removable: Mask, budget: Integers) -> Mask:
    normals, offsets = lines
    keep = np.ones(len(offsets), dtype=np.bool_)
    for k in range(len(budget)):
        begin, end = first[k], first[k + 1]
        x, y = centroid_of(vertices[begin:end])
        level = offsets[begin:end] - (normals[begin:end, 0] * x + normals[begin:end, 1] * y)
        worth, _ = edges_worth_keeping(normals[begin:end].copy(), level, removable[begin:end], budget[k], -1.0)
        put(worth, keep[begin:end])
    return keep
