"""The search for a projection (section 7 of the paper): always where inside and outside differ most, by a triangle."""

from collections.abc import Sequence
from dataclasses import dataclass
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
    solver: Workspace | None,
    D: Array,
    interior: Array,
    *,
    stop: Stop,
    known: HalfPlanes = NOTHING,
    is_over: IsOver = never,
) -> Projection:
    """Project the program's polytope by any D (2, v), onto {D x}.

    Inner points are pulled to an interior one (v,), as far inside as possible [m]. Half-planes that are known to contain the
    projection anyway cut the outer polygon; when to stop depends on what the searches find alone. Whether time is over is
    asked from the fourth search on. Without a solver nobody searches.

    Algorithm:
        Two opposite searches, two normal to the line between their points, then always normal to the inner edge of the
        largest triangle by which the inner and the outer polygon differ. The bounds on areas hold for any points of the
        optimal faces; at most 2 |V| searches only for vertices, which an interior-point solver need not return.
    """
    made, areas, reason = _searched(solver, D, stop, is_over)
    directions = np.array([(each.direction.real, each.direction.imag) for each in made]).reshape(-1, 2)
    points = np.array([each.found.point for each in made]).reshape(-1, D.shape[1])
    multipliers = np.array([each.found.multipliers for each in made]).reshape(len(directions), len(program.b))
    multipliers = program.essential(directions @ D, multipliers)
    inner_areas, outer_areas = np.array(areas).reshape(-1, 2).T
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
    """One search: its direction, x + y j, what was found, the point reached, and the triangle up to the next support."""

    direction: complex
    found: Candidate
    point: complex
    triangle: float = 0.0


def _searched(
    solver: Workspace | None, D: Array, stop: Stop, is_over: IsOver
) -> tuple[list[_Support], list[tuple[float, float]], Reason]:
    """Return the searches, the areas inside and outside after each, and why they ended."""
    made, around, areas = list[_Support](), list[_Support](), list[tuple[float, float]]()
    while True:
        place, towards = _next(made, around)
        direction = towards / abs(towards)
        found = solver.maximize(direction.real * D[0] + direction.imag * D[1]) if solver else None
        if found is None or not np.isfinite(found.point).all():
            return made, areas, "solver"
        made.append(_Support(direction, found, complex(*(D @ found.point))))
        around.insert(place, made[-1])
        for k in (place - 1, place):
            around[k].triangle = _triangle(around[k], around[(k + 1) % len(around)])
        edges = [support.point - around[0].point for support in around[1:]]
        inner_area = max(0.0, sum(_cross(here, after) for here, after in pairwise(edges)) / 2)
        gap = sum(support.triangle for support in around) if len(made) >= 4 else np.inf
        areas.append((inner_area, inner_area + gap))
        if len(made) >= 4:
            reason = stop.reason(inner_area, gap, len(made)) or ("time" if is_over() else None)
            if reason or max(support.triangle for support in around) <= NO_TRIANGLE * (inner_area + gap):
                return made, areas, reason or "exact"


def _next(made: Sequence[_Support], around: Sequence[_Support]) -> tuple[int, complex]:
    """Return the next search's place among those around, counter-clockwise, and its direction."""
    if len(made) < 2:
        return len(made), (1 + 0j, -1 + 0j)[len(made)]
    if len(made) < 4:
        along = made[0].point - made[1].point
        across = along * 1j if along.real > THIN * abs(along) else 1j
        return (1, across) if len(made) == 2 else (3, -across)
    k = max(range(len(around)), key=lambda k: around[k].triangle)
    return k + 1, (around[(k + 1) % len(around)].point - around[k].point) * -1j


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
