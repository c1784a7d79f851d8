"""The search for a projection (section 7 of the paper): always where inside and outside differ most, by a triangle."""

from __future__ import annotations

from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np

from filter.arrays import Array
from filter.linear.program import Candidate, LinearProgram
from filter.linear.solvers import Workspace
from filter.projection.claims import Weights
from filter.projection.proved import NOTHING, HalfPlanes, Projection, certified_offsets, inner_polygon, looseness, outer_polygon
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
        Two opposite searches, two normal to the line between their points, then always normal to the inner edge of the
        largest triangle by which the inner and the outer polygon differ. The bounds on areas hold for any points of the
        optimal faces; at most 2 |V| searches only for vertices, which an interior-point solver need not return.
    """
    search = _Search(solver, D, stop, is_over)
    reason = search.run()
    directions = np.array([(made.direction.real, made.direction.imag) for made in search.made]).reshape(-1, 2)
    points = np.array([made.found.point for made in search.made]).reshape(-1, D.shape[1])
    multipliers = np.array([made.found.multipliers for made in search.made]).reshape(len(directions), len(program.b))
    multipliers = program.essential(directions @ D, multipliers)
    inner_areas, outer_areas = np.array(search.areas).reshape(-1, 2).T
    certified = certified_offsets(program, D, directions, multipliers)
    return Projection(
        *outer_polygon(program, D, (directions, certified), known),
        inner_polygon(program, D, points, interior),
        directions,
        Weights.of(multipliers),
        inner_areas,
        outer_areas,
        reason,
        np.inf if reason == "solver" else looseness(program, D, directions, points, certified),
    )


@dataclass
class _Support:
    """One search: its direction, what was found, the point reached, and the triangle up to the next.

    The plane's vectors are x + y j.
    """

    direction: complex
    found: Candidate
    point: complex
    triangle: float = 0.0


@dataclass
class _Search:
    """The searches of one projection, in the order they were made, and counter-clockwise, and the areas after each."""

    solver: Workspace
    D: Array
    stop: Stop
    is_over: IsOver
    made: list[_Support] = field(default_factory=list)
    around: list[_Support] = field(default_factory=list)
    areas: list[tuple[float, float]] = field(default_factory=list)

    def run(self) -> Reason:
        """Search, and return why that ended."""
        if not self._begin():
            return "solver"
        while True:
            inner_area, gap = self._inner_area(), sum(support.triangle for support in self.around)
            self.areas.append((inner_area, inner_area + gap))
            reason = self.stop.reason(inner_area, gap, len(self.made)) or ("time" if self.is_over() else None)
            k = max(range(len(self.around)), key=lambda k: self.around[k].triangle)
            if reason or self.around[k].triangle <= NO_TRIANGLE * (inner_area + gap):
                return reason or "exact"
            if not self._look(k + 1, (self._after(k).point - self.around[k].point) * -1j):
                return "solver"

    def _begin(self) -> bool:
        """Make the first four searches (section 7.1); False when the solver gives up."""
        for place, direction in enumerate((1 + 0j, -1 + 0j)):
            if not self._look(place, direction):
                return False
            self.areas.append((0.0, np.inf))
        along = self.around[0].point - self.around[1].point
        across = along * 1j if along.real > THIN * abs(along) else 1j
        if not self._look(1, across):
            return False
        self.areas.append((self._inner_area(), np.inf))
        return self._look(3, -across)

    def _look(self, place: int, towards: complex) -> bool:
        """Search one direction and put its support in its place; False when the solver gives up."""
        direction = towards / abs(towards)
        found = self.solver.maximize(direction.real * self.D[0] + direction.imag * self.D[1])
        if found is None or not np.isfinite(found.point).all():
            return False
        self.made.append(_Support(direction, found, complex(*(self.D @ found.point))))
        self.around.insert(place, self.made[-1])
        for k in (place - 1, place):
            self.around[k].triangle = _triangle(self.around[k], self._after(k))
        return True

    def _after(self, k: int) -> _Support:
        return self.around[(k + 1) % len(self.around)]

    def _inner_area(self) -> float:
        edges = [support.point - self.around[0].point for support in self.around[1:]]
        return max(0.0, sum(_cross(here, after) for here, after in pairwise(edges)) / 2)


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
