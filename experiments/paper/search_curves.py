"""What a search amounts to after 4, 5, ... searches: adaptive, by uniform directions, and with a solver of vertices.

The exact polygon is found by searching until nothing is left, with the simplex method, which returns vertices. All the rest is
measured against it.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from experiments.paper.formations import Formation, Searcher
from filter.arrays import Array, Integers
from filter.geometry.convex import area_of
from filter.geometry.polygon import Polygon
from filter.linear.program import Candidate, LinearProgram
from filter.linear.solvers import SIMPLEX
from filter.projection.proved import Projection, position
from filter.projection.search import project
from filter.projection.stop import Stop

FIRST, LAST = 4, 30
SEARCHES = np.arange(FIRST, LAST + 1)
TRACED = Stop(performance_ratio=1.0, searches=LAST)
# Vertices come back from the simplex method with some 1e-10 of a region's size of rounding. So a polygon is exact when it lacks
# no more than this share of its area, and a corner that is flatter than this share of its size is none.
ROUNDING = 1e-9
TO_THE_END = Stop(performance_ratio=1 - ROUNDING, searches=2000)


@dataclass(frozen=True, eq=False)
class Curves:
    """One robot's projection, searched in three ways.

    Attributes:
        formation: The number of its formation.
        robots: How many robots that has.
        robot: Whose position is projected.
        adaptive: (27, 2) inner and outer area after 4, ..., 30 searches of the largest triangles [m2].
        uniform: (27, 2) the same of as many uniform directions [m2].
        area: Of the exact projection [m2].
        vertices: How many the exact projection has.
        searches_to_the_end: How many it takes to find them all, with a solver of vertices; None if that gave up.
        performance_ratio: After 30 searches, of the polygons that are proved.
        escaped: Whether the robot was outside the proved outer polygon: a broken guarantee.
    """

    formation: int
    robots: int
    robot: int
    adaptive: Array
    uniform: Array
    area: float
    vertices: int
    searches_to_the_end: int | None
    performance_ratio: float
    escaped: bool

    @property
    def variables(self) -> int:
        """How many coordinates of the formation are free, with a reference and a scale."""
        return 2 * self.robots - 3


def curves_of(formation: Formation, number: int = 0) -> list[Curves]:
    """Return the curves of every robot of which no coordinate is anchored, with robot 0 as the reference."""
    anchors = formation.anchors([0])
    polytope = formation.polytope(anchors)
    searcher, exact = Searcher(polytope), Searcher(polytope, SIMPLEX)
    found = []
    for robot in np.flatnonzero(np.isnan(anchors).all(axis=1)).tolist():
        D = position(robot, len(formation))
        traced, whole = searcher.project(D, TRACED), exact.project(D, TO_THE_END)
        finished = whole.reason != "solver"
        corners = corners_of(whole if finished else traced)
        found.append(
            Curves(
                number,
                len(formation),
                robot,
                trace(traced),
                np.array([uniform_areas(corners, count) for count in range(FIRST, LAST + 1)]),
                area_of(corners),
                len(corners),
                whole.searches if finished else None,
                traced.performance_ratio,
                not traced.outer.contains(formation.positions[robot]),
            )
        )
    return found


def trace(found: Projection) -> Array:
    """Return (27, 2) inner and outer area after 4, ..., 30 searches; a search that ended before stays as it is [m2]."""
    after = np.minimum(SEARCHES, found.searches) - 1
    return np.column_stack([found.inner_areas[after], found.outer_areas[after]])


def corners_of(found: Projection) -> Array:
    """Return (k, 2) vertices of the inner polygon, counter-clockwise; none that lies on a line between its neighbours [m]."""
    vertices = (found.inner or found.outer).vertices
    flat = ROUNDING * float(np.ptp(vertices, axis=0).max())
    while len(vertices) > 3:
        ends = np.roll(vertices, -1, axis=0) - np.roll(vertices, 1, axis=0)
        before = vertices - np.roll(vertices, 1, axis=0)
        heights = np.abs(before[:, 0] * ends[:, 1] - before[:, 1] * ends[:, 0]) / np.maximum(np.hypot(*ends.T), flat)
        if heights.min() > flat:
            break
        vertices = np.delete(vertices, int(heights.argmin()), axis=0)
    return vertices


def uniform_areas(corners: Array, count: int) -> tuple[float, float]:
    """Return inner and outer area after `count` searches in uniform directions, the first along +x [m2].

    Args:
        corners: (k, 2) of the exact projection, counter-clockwise [m].
        count: From 3 on.
    """
    turn = 2 * np.pi * np.arange(count) / count
    directions = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    values = directions @ corners.T
    inner = corners[distinct(values.argmax(axis=1))]
    offsets = values.max(axis=1)
    # Neighbouring lines meet at offset . direction + along . (the direction turned left).
    step = 2 * np.pi / count
    along = (np.roll(offsets, -1) - offsets * np.cos(step)) / np.sin(step)
    left = np.stack([-directions[:, 1], directions[:, 0]], axis=1)
    return area_of(inner), area_of(offsets[:, None] * directions + along[:, None] * left)


def distinct(places: Integers) -> Integers:
    """Return cyclic places with repetitions left out."""
    return places[places != np.roll(places, 1)] if len(np.unique(places)) > 1 else places[:1]


def regular_polygon(vertices: int) -> Polygon:
    """Return a regular polygon of radius 1 m: with many vertices, all but a circle."""
    turn = 2 * np.pi * (np.arange(vertices) + 0.5) / vertices
    return Polygon.hull(np.stack([np.cos(turn), np.sin(turn)], axis=1))


class _Corners:
    """A solver that knows the vertices (k, 2) of a polygon."""

    def __init__(self, vertices: Array) -> None:
        self._vertices = vertices

    def maximize(self, objective: Array) -> Candidate:
        return Candidate(self._vertices[int((self._vertices @ objective).argmax())], np.zeros(0))


def trace_of_polygon(polygon: Polygon, stop: Stop = TRACED) -> Projection:
    """Return the searches of a polygon of which every vertex is known; its outer polygon is only the box."""
    lower, upper = polygon.bounds
    box = LinearProgram(sparse.csr_array((0, 2)), np.zeros(0), lower, upper)
    return project(box, _Corners(polygon.vertices), np.eye(2), box.centre, stop=stop)
