"""Exact projections of a program, certified: the shadows that a walk over its vertices sees, as polygons."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Integers
from filter.geometry.convex import EPSILON, area_of, worthy_vertices
from filter.linear.program import LinearProgram
from filter.linear.scaled import ScaledProgram
from filter.projection.polygons_of import (
    NOTHING,
    HalfPlanes,
    Projection,
    Reason,
    Stop,
    Weights,
    certified_offsets,
    inner_polygon,
    outer_polygon,
)
from filter.projection.shadow import BEYOND, LONGEST, LONGEST_EACH, REASONS, SMALLEST, Trace, no_trace, simplified, turn
from filter.projection.simplex import EMPTY, FOUND, OUTWARD, Basis, Rows, become_feasible, corner, spread

ROUNDING = 64 * EPSILON  # of a point far from the origin
# Vertices are spared for as much area as edges are, yet never for more than this leaves.
LEAST_RATIO = 0.999


@dataclass(frozen=True, eq=False)
class Shadow:
    """What a walk has seen of a projection; candidates all.

    Attributes:
        directions: (t, 2) outward normals of the edges that matter, of length 1, counter-clockwise.
        multipliers: (t, r) for each of them, a weight for each row of the program.
        points: (p, v) points of the polytope behind the vertices that matter [m].
        reached: (t,) how far the vertices reach in the directions [m].
        reason: What decided which edges matter.
    """

    directions: Array
    multipliers: Array
    points: Array
    reached: Array
    reason: Reason


class Walker:
    """A walk over the vertices of one program, from shadow to shadow; what it finds depends on where it has been."""

    def __init__(self, program: LinearProgram) -> None:
        """Walk to the first vertex.

        Args:
            program: With at most `MOST` non-zeros in a row.
        """
        self.program = program
        self._scaled = ScaledProgram.of(program)
        self._rows = _rows(self._scaled)
        self._limit = LONGEST + LONGEST_EACH * len(self._scaled.free)
        self.contradiction: Array | None = None  # (r,) candidate multipliers for a proof that the program is empty
        self._objective = np.zeros(0)
        self._basis: Basis | None = None
        self._hopeless = False  # to begin again would end the same way
        self._begin()

    def shadow(self, D: Array, stop: Stop) -> Shadow | None:
        """Return the projection onto {D x}, or None when the walk is lost.

        Args:
            D: (2, v) the plane.
            stop: How many edges to keep of the exact polygon, and how much area may be added by leaving out the others.
        """
        if self._basis is None and not self._hopeless:
            self._begin()
        if self._basis is None:
            return None
        plane = D[:, self._scaled.free] * self._scaled.radius
        size = np.abs(plane).max(axis=1, initial=0)
        size = np.where(size > 0, size, 1.0)
        first, second = plane[0] / size[0], plane[1] / size[1]
        trace = self._walked(self._basis, first, second)
        if trace is None:
            self._basis = None
            return None
        self._objective = first
        return self._judged(D, trace, trace.point @ np.stack([first, second], axis=1), size, stop)

    def _walked(self, basis: Basis, first: Array, second: Array) -> Trace | None:
        """Return what a full turn in the plane of two objectives sees, or None when it is lost."""
        nothing, trace = no_trace(0, len(first)), no_trace(LONGEST, len(first))
        if turn(self._rows, basis, self._objective, first, np.pi / 2, nothing, self._limit) != FOUND:
            return None
        if turn(self._rows, basis, first, second, 2 * np.pi, trace, self._limit) != FOUND or trace.filled[0] == LONGEST:
            return None
        count = int(trace.filled[0])
        return Trace(trace.normal[:count], trace.prices[:count], trace.basic[:count], trace.point[:count], trace.filled)

    def _judged(self, D: Array, trace: Trace, vertices: Array, size: Array, stop: Stop) -> Shadow:
        """Return the edges that matter, and their proofs, in the program's own units; (2,) is the size of the plane's."""
        goal = (float(stop.performance_ratio), float(stop.area_gap), int(stop.searches))
        kept, why = simplified(trace.normal, vertices, float(np.prod(size)), goal)
        normals = trace.normal[kept] / size
        length = np.hypot(normals[:, 0], normals[:, 1])
        directions, proofs = normals / length[:, None], _dense(trace.basic[kept], trace.prices[kept], len(self._scaled.live))
        multipliers = self.program.essential(directions @ D, self._scaled.multipliers(proofs, 1 / length))
        reached = ((self._scaled.points(trace.point[kept]) @ D.T) * directions).sum(axis=1)
        corners = worthy_vertices(vertices, (1 - max(goal[0], LEAST_RATIO)) * area_of(vertices))
        return Shadow(directions, multipliers, self._scaled.points(trace.point[corners]), reached, REASONS[why])

    def _begin(self) -> None:
        variables = len(self._scaled.free)
        prices = 0.5 + 0.5 * spread(np.arange(1, variables + 1))  # towards any corner, as long as nothing is parallel
        self._objective = prices * np.where(np.arange(variables) % 2, 1.0, -1.0)
        basis = corner(self._rows, self._objective)
        how, contradicted = become_feasible(self._rows, basis, prices, self._limit)
        self._basis, self._hopeless = (basis, False) if how == FOUND else (None, True)
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
    allowed = BEYOND * (np.abs(D) @ program.radius).max() + ROUNDING * (np.abs(D) @ np.abs(program.centre)).max() + SMALLEST
    if not (certified - shadow.reached <= allowed).all():
        return None
    extent = np.abs(shadow.directions @ D) @ program.radius
    gap = float(np.max(np.abs(certified - shadow.reached) / np.maximum(extent, SMALLEST), initial=0.0))
    inner = None if interior is None else inner_polygon(program, D, shadow.points, interior)
    nothing, edges = np.zeros(0), (shadow.directions, certified)
    outer, proofs = outer_polygon(program, D, edges, known), Weights.of(shadow.multipliers)
    return Projection(*outer, inner, shadow.directions, proofs, nothing, nothing, shadow.reason, gap)


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
    moved = OUTWARD * (1 + spread(np.arange(rows + 2 * variables)))
    return Rows(column, value, np.append(scaled.h, np.ones(2 * variables)) + moved)


def _dense(basic: Integers, prices: Array, rows: int) -> Array:
    """Return (t, rows) multipliers; those of the variables' bounds are left out, since a certificate needs none."""
    dense = np.zeros((len(basic), rows))
    at, k = np.nonzero(basic < rows)
    dense[at, basic[at, k]] = np.maximum(prices[at, k], 0.0)
    return dense
