"""The projection of the team's polytope onto a plane, from inside and from outside (sections 5 to 7 of the paper).

Each search maximises one direction: it gives a point of the projection and a line that supports it. The hull of the
points is inside, the intersection of the half-planes outside; between two neighbouring points the two differ by a
triangle, and the largest triangle is searched next.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise
from typing import Literal

import numpy as np

from filter.arrays import Array, Integers, number, read_only, whole
from filter.lp import LinearProgram
from filter.polygon import EPSILON, Polygon, clip
from filter.solvers import Workspace

HalfPlanes = tuple[Array, Array]  # normals (k, 2) and offsets (k,)
NOTHING: HalfPlanes = (np.zeros((0, 2)), np.zeros(0))

Reason = Literal["performance ratio", "area gap", "searches", "exact", "solver"]

# A triangle below this share of the polygon's squared size is rounding; a line between nearer points has no direction.
NEGLIGIBLE = 1e-12
# Across a set thinner than this share, the line between the first two points is rounding.
THIN = 1e-6
# What is divided by is never smaller [m].
SMALLEST = 1e-100


@dataclass(frozen=True)
class Stop:
    """When a search ends: at whichever comes first.

    Attributes:
        performance_ratio: Inner area over outer area (eq. 7), in [0, 1].
        area_gap: Outer area less inner area (eq. 6) [m2], from 0 on.
        searches: Number of searches, from 4 on.

    Raises:
        InvalidInput: A number is not finite or out of its range.
    """

    performance_ratio: float = 0.95
    area_gap: float = 0.0
    searches: int = 16

    def __post_init__(self) -> None:
        number("performance ratio", self.performance_ratio, 0, 1)
        number("area gap [m2]", self.area_gap, 0)
        whole("searches", self.searches, low=4)

    def reason(self, inner_area: float, gap: float, searches: int) -> Reason | None:
        """Return why to end here, or None to go on."""
        if inner_area >= self.performance_ratio * (inner_area + gap):
            return "performance ratio"
        if gap <= self.area_gap:
            return "area gap"
        return "searches" if searches >= self.searches else None


@dataclass(frozen=True, eq=False)
class Projection:
    """What is known of a projection after some searches.

    Attributes:
        outer: Contains the projection: proved.
        edges: (e,) the search behind each edge of the outer polygon; from s on the known half-planes; negative for an
            edge of the program's box.
        inner: Lies in the projection: its vertices are proved feasible. None when no point could be.
        directions: (s, 2) searched directions, of length 1.
        multipliers: (s, r) the proof of each outer edge, a weight for each row of the program.
        inner_areas: (s,) area inside after each search, as the solver has it [m2].
        outer_areas: (s,) area outside after each search, as the solver has it, infinite before the fourth [m2].
        reason: Why the search ended; it went by the areas as the solver has them.
        looseness: The most that what is proved in a direction differs from the point found for it, as a share of the
            box's extent; infinite when the solver gave up. A guess of the answers' quality, no proof of anything.
    """

    outer: Polygon
    edges: Integers
    inner: Polygon | None
    directions: Array
    multipliers: Array
    inner_areas: Array
    outer_areas: Array
    reason: Reason
    looseness: float = 0.0

    def __post_init__(self) -> None:
        for name in ("edges", "directions", "multipliers", "inner_areas", "outer_areas"):
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
    return min(1.0, inner.area / outer.area) if outer.area > 0 else 1.0


def position(robot: int, robots: int) -> Array:
    """Return D (2, 2 robots) of the projection onto a robot's position (eq. 2)."""
    D = np.zeros((2, 2 * robots))
    D[:, 2 * robot : 2 * robot + 2] = np.eye(2)
    return D


def relative_position(i: int, j: int, robots: int) -> Array:
    """Return D (2, 2 robots) of the projection onto x_i - x_j (eq. 3)."""
    return position(i, robots) - position(j, robots)


def project(
    program: LinearProgram, solver: Workspace, D: Array, interior: Array, *, stop: Stop, known: HalfPlanes = NOTHING
) -> Projection:
    """Project the program's polytope by any D (2, v), onto {D x}.

    Args:
        program: The polytope.
        solver: A workspace on the same program.
        D: (2, v).
        interior: (v,) a point of the polytope, as far inside as possible, to pull the inner points to [m].
        stop: When to end; it looks at what the searches found, not at what was known.
        known: Half-planes that contain the projection anyway; they cut the outer polygon.

    Algorithm:
        Section 7 of the paper: two opposite searches, two normal to the line between their points, then always
        normal to the inner edge of the largest triangle. The bounds on areas hold for any points of the optimal
        faces; at most 2 |V| searches only for vertices, which an interior-point solver need not return.
    """
    search = _Search(solver, D, stop)
    search.run()
    directions = np.array([(direction.real, direction.imag) for direction in search.directions]).reshape(-1, 2)
    points = np.array(search.points).reshape(-1, D.shape[1])
    multipliers = np.array(search.multipliers).reshape(len(directions), len(program.b))
    multipliers = program.essential(directions @ D, multipliers)
    certified = certified_offsets(program, D, directions, multipliers)
    return Projection(
        *_outer(program, D, (np.concatenate([directions, known[0]]), np.concatenate([certified, known[1]]))),
        _inner(program, D, points, interior),
        directions,
        multipliers,
        np.array(search.inner_areas),
        np.array(search.outer_areas),
        search.reason,
        np.inf if search.reason == "solver" else _looseness(program, D, directions, points, certified),
    )


def certified_offsets(program: LinearProgram, D: Array, directions: Array, multipliers: Array) -> Array:
    """Return (s,) offsets of proved edges: direction . D x is nowhere greater in the program's polytope [m].

    Args:
        program: The polytope.
        D: (2, v) the projection.
        directions: (s, 2) normals of the edges.
        multipliers: (s, r) candidates for the proofs, from wherever; bad ones give large offsets, none a wrong one.
    """
    return program.certified_bounds(directions @ D, multipliers) + _rounding_of_objectives(program, D, directions)


def _looseness(program: LinearProgram, D: Array, directions: Array, points: Array, certified: Array) -> float:
    """Return the greatest gap between an edge and its point, relative to the box's extent in the edge's direction."""
    if not np.isfinite(certified).all():
        return np.inf
    extent = np.abs(directions @ D) @ program.radius
    gap = np.abs(certified - ((points @ D.T) * directions).sum(axis=1))
    rounding = 16 * EPSILON * np.abs(certified)
    return float(np.max(np.where(gap > rounding, gap, 0) / np.maximum(extent + rounding, SMALLEST), initial=0))


def _outer(program: LinearProgram, D: Array, edges: HalfPlanes) -> tuple[Polygon, Integers]:
    middle, reach = D @ program.centre, np.abs(D) @ program.radius
    terms = 4 + np.count_nonzero(D, axis=1)
    reach = reach + terms * EPSILON * (np.abs(D) @ (np.abs(program.centre) + program.radius))
    kept = clip(*edges, middle - reach, middle + reach)
    # None: proved to be empty, though the caller's interior says otherwise; the box contains the empty set, too.
    return kept or (Polygon.box(middle - reach, middle + reach), np.arange(-4, 0))


def _rounding_of_objectives(program: LinearProgram, D: Array, directions: Array) -> Array:
    """Return (s,) what the rounding of direction . D can be worth [m]; nothing for positions and their differences."""
    exact = (np.count_nonzero(D, axis=0) <= 1) & (np.abs(D).max(axis=0) == np.ceil(np.abs(D).max(axis=0).clip(0, 1)))
    rough = np.where(exact, 0.0, np.abs(D))
    return 4 * EPSILON * (np.abs(directions) @ rough @ (np.abs(program.centre) + program.radius))


def _inner(program: LinearProgram, D: Array, points: Array, interior: Array) -> Polygon | None:
    pulled = program.pulled(points, interior)
    feasible = pulled[program.holds(pulled)]
    return Polygon.hull(feasible @ D.T) if len(feasible) else None


@dataclass
class _Support:
    """One search: its direction, the point reached, and the triangle up to the next. The plane's vectors are x + y j."""

    direction: complex
    point: complex
    triangle: float = 0.0


@dataclass
class _Search:
    """The searches of one projection, and its supports in counter-clockwise order."""

    solver: Workspace
    D: Array
    stop: Stop
    supports: list[_Support] = field(default_factory=list)
    directions: list[complex] = field(default_factory=list)
    points: list[Array] = field(default_factory=list)
    multipliers: list[Array] = field(default_factory=list)
    inner_areas: list[float] = field(default_factory=list)
    outer_areas: list[float] = field(default_factory=list)
    reason: Reason = "solver"

    def run(self) -> None:
        if not self._begin():
            return
        while True:
            supports = self.supports
            inner_area, gap = self._inner_area(), sum(support.triangle for support in supports)
            self._record(inner_area, inner_area + gap)
            reason = self.stop.reason(inner_area, gap, len(self.directions))
            k = max(range(len(supports)), key=lambda k: supports[k].triangle)
            if reason or supports[k].triangle <= NEGLIGIBLE * (inner_area + gap):
                self.reason = reason or "exact"
                return
            edge = supports[(k + 1) % len(supports)].point - supports[k].point
            if not self._look(k + 1, edge * -1j):
                return

    def _begin(self) -> bool:
        """Make the first four searches (section 7.1); False when the solver gives up."""
        for place, direction in enumerate((1 + 0j, -1 + 0j)):
            if not self._look(place, direction):
                return False
            self._record(0.0, np.inf)
        right, left = (support.point for support in self.supports)
        along = right - left
        across = along * 1j if along.real > THIN * abs(along) else 1j
        if not self._look(1, across):
            return False
        self._record(self._inner_area(), np.inf)
        return self._look(3, -across)

    def _look(self, place: int, towards: complex) -> bool:
        """Search one direction and put its support in its place; False when the solver gives up."""
        direction = towards / abs(towards)
        found = self.solver.maximize(direction.real * self.D[0] + direction.imag * self.D[1])
        if found is None or not np.isfinite(found.point).all():
            return False
        self.supports.insert(place, _Support(direction, complex(*(self.D @ found.point))))
        self.directions.append(direction)
        self.points.append(found.point)
        self.multipliers.append(found.multipliers)
        changed = range(4) if len(self.supports) == 4 else (place - 1, place)
        for k in changed if len(self.supports) >= 4 else ():
            self.supports[k].triangle = _triangle(self.supports[k], self.supports[(k + 1) % len(self.supports)])
        return True

    def _inner_area(self) -> float:
        first = self.supports[0].point
        edges = [support.point - first for support in self.supports[1:]]
        return max(0.0, sum(_cross(here, after) for here, after in pairwise(edges)) / 2)

    def _record(self, inner_area: float, outer_area: float) -> None:
        self.inner_areas.append(inner_area)
        self.outer_areas.append(outer_area)


def _cross(a: complex, b: complex) -> float:
    return (a.conjugate() * b).imag


def _triangle(here: _Support, after: _Support) -> float:
    """Return the area between the line from one point to the next and their two supporting lines [m2]."""
    turn = _cross(here.direction, after.direction)
    if turn <= NEGLIGIBLE:
        return 0.0
    edge = after.point - here.point
    # The supporting lines meet where the first one, from its point on, has come as far along the second direction.
    apex = here.direction * 1j * (after.direction.conjugate() * edge).real / turn
    return max(0.0, _cross(apex, edge) / 2)
