"""Exact projections of a program, certified: the shadows that a walk over its vertices sees, as polygons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Integers
from filter.lp import LinearProgram
from filter.plane import EPSILON, area_of, worthy
from filter.projection import NOTHING, HalfPlanes, Projection, Stop, certified_offsets, inner_polygon, outer_polygon
from filter.scaling import ScaledProgram
from filter.shadow import no_trace, turn
from filter.simplex import EMPTY, FOUND, OUTWARD, Basis, Rows, become_feasible, corner

# A shadow with more edges than this is left to the search, and so is a walk of so many exchanges for each variable.
LONGEST, LONGEST_EACH = 400, 50
# An edge that is certified this much farther out than it was found, relative to the box, shows that the walk went wrong.
LOOSE = 1e-7
ROUNDING = 64 * EPSILON  # of a point far from the origin
SMALLEST = 1e-100  # keeps a quotient finite
# A vertex that violates a row by more than this share of the box shows the same.
STRAYED = 1e-8
# Edges whose normals turn by less are one.
SAME = 1e-13


@dataclass(frozen=True, eq=False)
class Shadow:
    """What a walk has seen of a projection; candidates all.

    Attributes:
        directions: (t, 2) outward normals of the edges that matter, of length 1, counter-clockwise.
        multipliers: (t, r) for each of them, a weight for each row of the program.
        points: (p, v) a point of the polytope behind each vertex [m].
        reached: (t,) how far the vertices reach in the directions [m].
    """

    directions: Array
    multipliers: Array
    points: Array
    reached: Array


class Walker:
    """A walk over the vertices of one program, from shadow to shadow; what it finds depends on where it has been."""

    def __init__(self, program: LinearProgram) -> None:
        """Walk to the first vertex.

        Args:
            program: With at most four non-zeros in a row.
        """
        self.program = program
        self._scaled = ScaledProgram.of(program)
        self._rows = _rows(self._scaled)
        self._limit = LONGEST + LONGEST_EACH * len(self._scaled.free)
        self.contradiction: Array | None = None  # (r,) candidate multipliers for a proof that the program is empty
        self._objective = np.zeros(0)
        self._basis: Basis | None = None
        self._begin()

    def shadow(self, D: Array, stop: Stop) -> Shadow | None:
        """Return the projection onto {D x}, or None when the walk is lost.

        Args:
            D: (2, v) the plane.
            stop: How many edges to keep of the exact polygon, and how much area may be added by leaving out the others.
        """
        if self._basis is None:
            self._begin()
        if self._basis is None:
            return None
        plane = D[:, self._scaled.free] * self._scaled.radius
        size = np.abs(plane).max(axis=1, initial=0)
        plane /= np.where(size > 0, size, 1.0)[:, None]
        first, second = plane[0].copy(), plane[1].copy()
        trace = no_trace(LONGEST, len(first))
        arrived = turn(self._rows, self._basis, self._objective, first, np.pi / 2, no_trace(0, len(first)), self._limit)
        if arrived != FOUND or turn(self._rows, self._basis, first, second, 2 * np.pi, trace, self._limit) != FOUND:
            self._basis = None
            return None
        self._objective = first
        count = int(trace.filled[0])
        if count == LONGEST or not self._holds(trace.point[:count]):
            self._basis = None
            return None
        points = self._scaled.points(trace.point[:count])
        unit = float(np.prod(size))  # what an area in the scaled plane stands for [m2]
        kept = _simplified(trace.normal[:count], trace.point[:count] @ np.stack([first, second], axis=1), unit, stop)
        normals = trace.normal[kept] / np.where(size > 0, size, 1.0)
        length = np.hypot(normals[:, 0], normals[:, 1])
        directions = normals / length[:, None]
        multipliers = self._scaled.multipliers(
            _dense(trace.basic[kept], trace.prices[kept], len(self._scaled.live)), 1 / length
        )
        return Shadow(directions, multipliers, points, ((points[kept] @ D.T) * directions).sum(axis=1))

    def _holds(self, points: Array) -> bool:
        """Return whether the walk has kept to the polytope: a point beyond it makes a bound that is right but far off."""
        return bool(((self._scaled.G @ points.T).T - self._scaled.h <= STRAYED).all() and (np.abs(points) <= 1 + STRAYED).all())

    def _begin(self) -> None:
        variables = len(self._scaled.free)
        spread = np.modf(np.arange(1, variables + 1) * 0.6180339887498949)[0]  # any direction in which nothing is parallel
        prices = 0.5 + 0.5 * spread
        self._objective = prices * np.where(np.arange(variables) % 2, 1.0, -1.0)
        basis = corner(self._rows, self._objective)
        how, contradicted = become_feasible(self._rows, basis, prices, self._limit)
        self._basis = basis if how == FOUND else None
        if how == EMPTY:
            self.contradiction = self._farkas(basis, contradicted)

    def _farkas(self, basis: Basis, contradicted: int) -> Array:
        """Return weights of rows that say: the contradicted row and the basic ones exclude one another."""
        row = np.zeros(len(self._scaled.free))
        np.add.at(row, self._rows.column[contradicted], self._rows.value[contradicted])
        weights = np.append(-(row @ basis.inverse), 1.0)
        rows = np.append(basis.basic, contradicted)
        return self._scaled.multipliers(_dense(rows[None], weights[None], len(self._scaled.live)), np.ones(1))[0]


def project_exactly(
    program: LinearProgram, shadow: Shadow, D: Array, interior: Array | None, known: HalfPlanes = NOTHING
) -> Projection | None:
    """Return a shadow as certified polygons, or None when the walk is found to have gone wrong.

    Args:
        program: What the shadow is of.
        shadow: Candidates.
        D: (2, v) the plane it was projected onto.
        interior: (v,) a point of the polytope, to pull the inner points to [m]; None for no inner polygon.
        known: Half-planes that contain the projection anyway; they cut the outer polygon.
    """
    certified = certified_offsets(program, D, shadow.directions, shadow.multipliers)
    allowed = LOOSE * (np.abs(D) @ program.radius).max() + ROUNDING * (np.abs(D) @ np.abs(program.centre)).max()
    if not (certified - shadow.reached <= allowed).all():
        return None
    inner = None if interior is None else inner_polygon(program, D, shadow.points, interior)
    nothing, edges = np.zeros(0), (shadow.directions, certified)
    return Projection(
        *outer_polygon(program, D, edges, known), inner, shadow.directions, shadow.multipliers, nothing, nothing, "exact"
    )


def _rows(scaled: ScaledProgram) -> Rows:
    """Return the program as the walk likes it; each row moved outward by another amount."""
    rows, variables = scaled.G.shape
    G = scaled.G.tocsr()
    row = np.repeat(np.arange(rows), np.diff(G.indptr))
    place = np.arange(len(row)) - G.indptr[row]
    column, value = np.zeros((rows + 2 * variables, 4), dtype=np.int64), np.zeros((rows + 2 * variables, 4))
    column[row, place], value[row, place] = G.indices, G.data
    column[rows:, 0] = np.tile(np.arange(variables), 2)
    value[rows:, 0] = np.repeat([1.0, -1.0], variables)
    spread = np.modf(np.arange(rows + 2 * variables) * 0.6180339887498949)[0]
    return Rows(column, value, np.append(scaled.h, np.ones(2 * variables)) + OUTWARD * (1 + spread))


def _dense(basic: Integers, prices: Array, rows: int) -> Array:
    """Return (t, rows) multipliers; those of the variables' bounds are left out, since a certificate needs none."""
    dense = np.zeros((len(basic), rows))
    at, k = np.nonzero(basic < rows)
    dense[at, basic[at, k]] = np.maximum(prices[at, k], 0.0)
    return dense


def _simplified(normals: Array, vertices: Array, unit: float, stop: Stop) -> Integers:
    """Return the (k,) edges to keep of a polygon with (t, 2) normals; each edge ends at its vertex."""
    following = np.roll(normals, -1, axis=0)
    distinct = np.flatnonzero(
        (np.abs(normals[:, 0] * following[:, 1] - normals[:, 1] * following[:, 0]) > SAME)
        | ((normals * following).sum(axis=1) < 0)
    )
    middle = vertices.mean(axis=0)
    offsets = ((vertices - middle) * normals).sum(axis=1)
    allowance = max(area_of(vertices) * (1 / max(stop.performance_ratio, SMALLEST) - 1), stop.area_gap / max(unit, SMALLEST))
    everything = np.ones(len(distinct), dtype=bool)
    return distinct[worthy(normals[distinct], offsets[distinct], everything, stop.searches, allowance)]
