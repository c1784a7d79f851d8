"""Projections of the team's polytope onto a plane, from inside and from outside (sections 5 and 6 of the paper).

A direction that was maximised gives a point of the projection and a line that supports it. The hull of the points is
inside, the intersection of the half-planes outside.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np

from filter.arrays import Array, Integers, function, number, read_only, settle, whole_number
from filter.errors import InvalidInput
from filter.geometry.convex import EPSILON
from filter.geometry.polygon import Polygon, clip
from filter.linear.program import LinearProgram

HalfPlanes = tuple[Array, Array]  # normals (k, 2) and offsets (k,)
NOTHING: HalfPlanes = (np.zeros((0, 2)), np.zeros(0))

Reason = Literal["performance ratio", "area gap", "searches", "time", "exact", "solver"]

# A polygon of less area than this share of its squared size is a segment, to rounding.
NO_AREA = 1e-12
# What is divided by is never smaller [m].
SMALLEST = 1e-100


@dataclass(frozen=True)
class Stop:
    """When a projection is good enough: at whichever comes first.

    A search ends there. An exact projection is simplified, outward, as far as that; it is never cut short by time.

    Attributes:
        performance_ratio: Inner area over outer area (eq. 7), in [0, 1].
        area_gap: Outer area less inner area (eq. 6) [m2], from 0 on.
        searches: Number of searches, or of edges, from 4 on.
        seconds: Time since the search began, from 0 on, or None for no limit [s]; it is looked at from the fourth search
            on. With a limit, results depend on the machine.
        clock: What tells the time, such as `time.perf_counter`, as there is no clock in here.

    Raises:
        InvalidInput: A number is not finite or out of its range, or there is a time limit without a clock.
    """

    performance_ratio: float = 0.999
    area_gap: float = 0.0
    searches: int = 32
    seconds: float | None = None
    clock: Callable[[], float] | None = None

    def __post_init__(self) -> None:
        settle(
            self,
            performance_ratio=number("performance ratio", self.performance_ratio, 0, 1),
            area_gap=number("area gap [m2]", self.area_gap, 0),
            searches=whole_number("searches", self.searches, 4),
        )
        if self.clock is not None:
            function("clock", self.clock)
        if self.seconds is not None:
            settle(self, seconds=number("time limit [s]", self.seconds, 0))
            if self.clock is None:
                raise InvalidInput("a clock to hold a time limit against", f"{self.seconds} s without one")

    def now(self) -> float:
        """Return the clock's time [s]; always 0 when there is no time limit."""
        return 0.0 if self.seconds is None or self.clock is None else number("time by the clock [s]", self.clock())

    def reason(self, inner_area: float, gap: float, searches: int, began: float = 0.0) -> Reason | None:
        """Return why to end a search that began at a time of `now` [s], or None to go on."""
        if inner_area >= self.performance_ratio * (inner_area + gap):
            return "performance ratio"
        if gap <= self.area_gap:
            return "area gap"
        if searches >= self.searches:
            return "searches"
        return "time" if self.seconds is not None and self.now() - began >= self.seconds else None


class Weights(NamedTuple):
    """Which rows of a program prove which directions: triples, all weights above 0.

    Attributes:
        direction: (m,) which of the directions.
        row: (m,) which row of the program.
        weight: (m,) the row's multiplier in the direction's proof.
    """

    direction: Integers
    row: Integers
    weight: Array

    @classmethod
    def of(cls, multipliers: Array) -> Weights:
        """Return what is not zero of (s, r) multipliers."""
        direction, row = np.nonzero(multipliers)
        return cls(direction, row, multipliers[direction, row])


@dataclass(frozen=True, eq=False)
class Projection:
    """What is known of a projection after some searches.

    Attributes:
        outer: Contains the projection: proved.
        edges: (e,) the search behind each edge of the outer polygon; from s on the known half-planes; negative for an
            edge of the program's box.
        inner: Lies in the projection: its vertices are proved feasible. None when no point could be.
        directions: (s, 2) searched directions, or normals of the exact edges that were kept, of length 1.
        weights: The proof of each direction's edge.
        inner_areas: (s,) area inside after each search, as the solver has it [m2]; (0,) where nothing was searched.
        outer_areas: (s,) area outside after each search, as the solver has it, infinite before the fourth [m2]; or (0,).
        reason: Why the search ended, by the areas as the solver has them; or what decided how many edges of an exact
            projection were kept, "exact" when all were that matter.
        looseness: The most that what is proved in a direction differs from the point found for it, as a share of the
            box's extent; infinite when the solver gave up. A guess of the answers' quality, no proof of anything.
    """

    outer: Polygon
    edges: Integers
    inner: Polygon | None
    directions: Array
    weights: Weights
    inner_areas: Array
    outer_areas: Array
    reason: Reason
    looseness: float = 0.0

    def __post_init__(self) -> None:
        for name in ("edges", "directions", "inner_areas", "outer_areas"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @property
    def searches(self) -> int:
        """Number of searches."""
        return len(self.directions)

    @property
    def performance_ratio(self) -> float:
        """Area inside over area outside (eq. 7), in [0, 1]; 0 without an inner polygon."""
        return performance_ratio(self.inner, self.outer)


def performance_ratio(inner: Polygon | None, outer: Polygon) -> float:
    """Return area inside over area outside (eq. 7), in [0, 1]; 1 for two polygons without area, 0 without an inner one."""
    if inner is None:
        return 0.0
    lower, upper = outer.bounds
    without = outer.area <= NO_AREA * float(((upper - lower) ** 2).sum())
    return 1.0 if without else min(1.0, inner.area / outer.area)


def position(robot: int, robots: int) -> Array:
    """Return D (2, 2 robots) of the projection onto a robot's position (eq. 2)."""
    D = np.zeros((2, 2 * robots))
    D[:, 2 * robot : 2 * robot + 2] = np.eye(2)
    return D


def relative_position(i: int, j: int, robots: int) -> Array:
    """Return D (2, 2 robots) of the projection onto x_i - x_j (eq. 3)."""
    return position(i, robots) - position(j, robots)


def certified_offsets(program: LinearProgram, D: Array, directions: Array, multipliers: Array) -> Array:
    """Return (s,) offsets of proved edges: direction . D x is nowhere greater in the program's polytope [m].

    Args:
        program: The polytope.
        D: (2, v) the projection.
        directions: (s, 2) normals of the edges.
        multipliers: (s, r) candidates for the proofs, from wherever; bad ones give large offsets, none a wrong one.
    """
    return program.certified_bounds(directions @ D, multipliers) + _rounding_of_objectives(program, D, directions)


def looseness(program: LinearProgram, D: Array, directions: Array, points: Array, certified: Array) -> float:
    """Return the greatest gap between (s,) edges and their (s, v) points, as a share of the extent of the box there."""
    if not np.isfinite(certified).all():
        return np.inf
    extent = np.abs(directions @ D) @ program.radius
    gap = np.abs(certified - ((points @ D.T) * directions).sum(axis=1))
    rounding = 16 * EPSILON * np.abs(certified)
    return float(np.max(np.where(gap > rounding, gap, 0) / np.maximum(extent + rounding, SMALLEST), initial=0))


def outer_polygon(program: LinearProgram, D: Array, edges: HalfPlanes, known: HalfPlanes) -> tuple[Polygon, Integers]:
    """Return a polygon around the projection {D x}, and what is behind each of its edges.

    That is one of the s proved edges, from s on one of the half-planes that are known to contain the projection anyway,
    or, negative, a side of the program's box.
    """
    middle, reach = D @ program.centre, np.abs(D) @ program.radius
    terms = 4 + np.count_nonzero(D, axis=1)
    reach = reach + terms * EPSILON * (np.abs(D) @ (np.abs(program.centre) + program.radius))
    normals, offsets = np.concatenate([edges[0], known[0]]), np.concatenate([edges[1], known[1]])
    kept = clip(normals, offsets, middle - reach, middle + reach)
    if kept is None:  # the set is empty, which nobody has proved with names; what was known and the box contain it, too
        kept = clip(known[0], known[1], middle - reach, middle + reach)
        kept = kept and (kept[0], np.where(kept[1] >= 0, kept[1] + len(edges[0]), kept[1]))
    return kept or (Polygon.box(middle - reach, middle + reach), np.arange(-4, 0))


def _rounding_of_objectives(program: LinearProgram, D: Array, directions: Array) -> Array:
    """Return (s,) what the rounding of direction . D can be worth [m]; nothing for positions and their differences."""
    exact = (np.count_nonzero(D, axis=0) <= 1) & (np.abs(D).max(axis=0) == np.ceil(np.abs(D).max(axis=0).clip(0, 1)))
    rough = np.where(exact, 0.0, np.abs(D))
    return 4 * EPSILON * (np.abs(directions) @ rough @ (np.abs(program.centre) + program.radius))


def inner_polygon(program: LinearProgram, D: Array, points: Array, interior: Array) -> Polygon | None:
    """Return a polygon inside the projection {D x}: the hull of those of the (k, v) points that are proved feasible.

    They are first pulled to an interior point (v,), as far as they need it; None when none can be proved feasible.
    """
    pulled = program.pulled(points, interior)
    feasible = pulled[program.holds(pulled)]
    return Polygon.hull(feasible @ D.T) if len(feasible) else None
