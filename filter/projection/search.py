"""The search for a projection (section 7 of the paper): always where inside and outside differ most.

Between two neighbouring points the inner and the outer polygon differ by a triangle; the largest triangle is searched next.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from filter.arrays import Array
from filter.linear.program import LinearProgram
from filter.linear.solvers import Workspace
from filter.projection.claims import Weights
from filter.projection.proved import (
    NOTHING,
    HalfPlanes,
    Projection,
    certified_offsets,
    inner_polygon,
    looseness,
    outer_polygon,
)
from filter.projection.stop import IsOver, Reason, Stop, never

# A triangle below this share of the polygon's squared size is rounding; a line between nearer points has no direction.
NO_TRIANGLE = 1e-12
# Across a set thinner than this share, the line between the first two points is rounding.
THIN = 1e-6


def project(
    program: LinearProgram,
    solver: Workspace,
    D: Array,
    interior: Array,
    *,
    stop: Stop,
    known: HalfPlanes = NOTHING,
    is_over: IsOver = never,
) -> Projection:
    """Project the program's polytope by any D (2, v), onto {D x}.

    Args:
        program: The polytope.
        solver: A workspace on the same program.
        D: (2, v).
        interior: (v,) a point of the polytope, as far inside as possible, to pull the inner points to [m].
        stop: When to end; it looks at what the searches found, not at what was known.
        known: Half-planes that contain the projection anyway; they cut the outer polygon.
        is_over: Whether time is up; it is asked from the fourth search on.

    Algorithm:
        Section 7 of the paper: two opposite searches, two normal to the line between their points, then always
        normal to the inner edge of the largest triangle. The bounds on areas hold for any points of the optimal
        faces; at most 2 |V| searches only for vertices, which an interior-point solver need not return.
    """
    search = _Search(solver, D, stop, is_over)
    search.run()
    directions = np.array([(direction.real, direction.imag) for direction in search.directions]).reshape(-1, 2)
    points = np.array(search.points).reshape(-1, D.shape[1])
    multipliers = np.array(search.multipliers).reshape(len(directions), len(program.b))
    multipliers = program.essential(directions @ D, multipliers)
    certified = certified_offsets(program, D, directions, multipliers)
    return Projection(
        *outer_polygon(program, D, (directions, certified), known),
        inner_polygon(program, D, points, interior),
        directions,
        Weights.of(multipliers),
        np.array(search.inner_areas),
        np.array(search.outer_areas),
        search.reason,
        np.inf if search.reason == "solver" else looseness(program, D, directions, points, certified),
    )


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
    is_over: IsOver
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
            reason = reason or ("time" if self.is_over() else None)
            k = max(range(len(supports)), key=lambda k: supports[k].triangle)
            if reason or supports[k].triangle <= NO_TRIANGLE * (inner_area + gap):
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
    if turn <= NO_TRIANGLE:
        return 0.0
    edge = after.point - here.point
    # The supporting lines meet where the first one, from its point on, has come as far along the second direction.
    apex = here.direction * 1j * (after.direction.conjugate() * edge).real / turn
    return max(0.0, _cross(apex, edge) / 2)
