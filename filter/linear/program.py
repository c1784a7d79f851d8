"""Linear programs with bounds that are proved, whatever a solver says.

No solver is trusted: its answers are candidates. An upper bound counts only through `certified_bounds`, a point only
through `holds`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from filter.arrays import Array, Integers, Mask
from filter.compiled import compiled
from filter.geometry.convex import EPSILON

# What an interior-point solver leaves of a zero proves nothing: a multiplier is dropped where that costs less than this [m],
NEGLIGIBLE = 1e-9
# and less than this share of what the box allows anyway.
NEGLIGIBLE_SHARE = 1e-7
# Where products underflow, each is off by less than this; far below any length.
TINY = float(np.finfo(float).tiny)
# The entries of a sparse matrix, their columns, and where each row of them begins.
Entries = tuple[Array, Integers, Integers]
# A matrix of no more entries is better filled up than sparse.
SMALL = 20_000


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """The polytope {x : A x <= b, lower <= x <= upper}, every bound finite.

    Attributes:
        A: (r, v) rows.
        b: (r,) offsets [m].
        lower: (v,) [m].
        upper: (v,) [m].
    """

    A: sparse.csr_array
    b: Array
    lower: Array
    upper: Array

    @cached_property
    def centre(self) -> Array:
        """(v,) middle of the box; everything is computed relative to it, so that large coordinates lose little [m]."""
        return (self.lower + self.upper) / 2

    @cached_property
    def radius(self) -> Array:
        """(v,) the box is within centre +- radius; 0 for an anchored coordinate [m]."""
        radius = np.maximum(self.upper - self.centre, self.centre - self.lower)
        return np.where(radius > 0, np.nextafter(radius, np.inf), 0.0)

    @cached_property
    def slack(self) -> Array:
        """(r,) b - A centre, as if computed in twice the precision and then rounded [m]."""
        values, places = _rectangular(self.A)
        high, low = twice_precise_dot(
            np.column_stack([self.b, values]), np.column_stack([np.ones(len(self.b)), -self.centre[places]])
        )
        return np.asarray(high + low)

    @cached_property
    def _slack_rounding(self) -> Array:
        terms = 1 + np.diff(self.A.indptr)
        size = np.abs(self.b) + self._magnitudes @ np.abs(self.centre)
        return np.asarray(2 * EPSILON * np.abs(self.slack) + (terms * EPSILON) ** 2 * size + terms * TINY)

    @cached_property
    def _matrix(self) -> Array | sparse.csr_array:
        """A, filled up with zeros where that is small: products are faster then, and zeros are no rounding."""
        return self.A.toarray() if self.A.shape[0] * self.A.shape[1] <= SMALL else self.A

    @cached_property
    def _magnitudes(self) -> Array | sparse.csr_array:
        return abs(self._matrix)

    def certified_bounds(self, objectives: Array, multipliers: Array) -> Array:
        """Return (k,) upper bounds of c . x over the polytope that hold in exact arithmetic [m].

        Args:
            objectives: (k, v) directions c.
            multipliers: (k, r) dual candidates y; negative and non-finite entries are taken as 0.

        Algorithm:
            For any y >= 0 and x in the polytope, with centre x0 and radius w,
            c.x = c.x0 + (c - A'y).(x - x0) + y.(A x - A x0) <= c.x0 + |c - A'y|.w + y.(b - A x0)
            (Neumaier and Shcherbina, Safe bounds in linear and mixed-integer linear programming, 2004).
            Every rounding error of the evaluation is bounded by its terms' magnitudes and added; docs/soundness.md
            derives by how much.
        """
        with np.errstate(over="ignore", invalid="ignore"):  # multipliers that overflow bound nothing
            bounds = self._bounds(objectives, np.where(np.isfinite(multipliers), np.maximum(multipliers, 0), 0))
        return np.where(np.isnan(bounds), np.inf, bounds)

    def _bounds(self, objectives: Array, y: Array) -> Array:
        filled = int((objectives != 0).sum(axis=1).max(initial=0))
        places = np.argsort(objectives == 0, axis=1, kind="stable")[:, :filled]  # the non-zeros first
        values, middles = objectives[np.arange(len(objectives))[:, None], places], self.centre[places]
        high, low = twice_precise_dot(values, middles)
        few = ((8 + filled) * EPSILON) ** 2 * np.abs(values * middles).sum(axis=1)
        residual = objectives - (self._matrix.T @ y.T).T
        row, size, least = self._outward
        rest = low + np.abs(residual) @ self.radius + y @ row + (few + np.abs(objectives) @ size + least)
        return np.asarray(np.nextafter(high + rest, np.inf))

    @cached_property
    def _outward(self) -> tuple[Array, Array, float]:
        """What a bound takes for each multiplier (r,), each |c| (v,) and always: slacks and all allowances [m]."""
        operations = 8 + len(self.b) + len(self.centre)
        many = 2 * operations * EPSILON
        row = self.slack + (2 * self._slack_rounding + many * (np.abs(self.slack) + self._reach))
        return row, many * self.radius, operations * TINY * (1 + self.radius.sum())

    def essential(self, objectives: Array, multipliers: Array) -> Array:
        """Return (k, r) multipliers with the negligible and the non-finite ones set to 0: proofs that rest on few rows."""
        y = np.where(np.isfinite(multipliers), multipliers, 0)
        least = np.minimum(NEGLIGIBLE, NEGLIGIBLE_SHARE * (np.abs(objectives) @ self.radius))
        return np.where(y > least[:, None] / np.maximum(self._reach, TINY), y, 0)

    @cached_property
    def _reach(self) -> Array:
        """(r,) how far a row can vary within the box to either side [m]."""
        return np.asarray(self._magnitudes @ self.radius)

    def proves_empty(self, multipliers: Array) -> bool:
        """Return whether (r,) multipliers are a Farkas certificate: they bound 0 . x below 0."""
        zero = np.zeros((1, len(self.centre)))
        return bool(self.certified_bounds(zero, multipliers[None])[0] < 0)

    def holds(self, points: Array) -> Mask:
        """Return (k,) whether (k, v) points are in the polytope for sure, rounding counted against them."""
        inside = (self.lower <= points).all(axis=1) & (points <= self.upper).all(axis=1)
        slack, doubt = self._slack_at(points)
        return np.asarray(inside & (slack >= doubt).all(axis=1))

    def pulled(self, points: Array, interior: Array) -> Array:
        """Return (k, v) points moved towards an interior one (v,) until they are in the polytope, as far as rounding tells.

        Whether a point arrived is for `holds` to say: without an interior none can.
        """
        inside = np.clip(points, self.lower, self.upper)
        slack, doubt = self._slack_at(inside)
        room = self._slack_at(interior[None])[0][0]
        share = _shares((slack, doubt, room, self._exact), self._entries, np.abs(inside), np.abs(interior))
        moved = inside + share[:, None] * (interior - inside)
        return np.asarray(np.clip(moved, self.lower, self.upper))

    @cached_property
    def _exact(self) -> Mask:
        """(r,) rows +-x_k <= b on an anchored coordinate: the sign of their slack is right, however small it is."""
        row = np.repeat(np.arange(len(self.b)), np.diff(self.A.indptr))
        terms = np.bincount(row[self.A.data != 0], minlength=len(self.b))
        unit = (np.abs(self.A.data) == 1) & (self.radius[self.A.indices] == 0)
        return (terms == 1) & (np.bincount(row[unit], minlength=len(self.b)) == 1)

    @property
    def _entries(self) -> Entries:
        return self.A.data, self.A.indices, self.A.indptr

    def _slack_at(self, points: Array) -> tuple[Array, Array]:
        """Return b - A x at points (k, v) of the box, and the rounding in it, both (k, r)."""
        slack, doubt = _slacks((self.slack, self._slack_rounding, self._exact), self._entries, points - self.centre)
        return slack, doubt


@compiled
def _slacks(at_centre: tuple[Array, Array, Mask], entries: Entries, moved: Array) -> Array:
    """Return slacks and their rounding (2, k, r) at points (k, v) from the centre, given those at the centre (r,)."""
    (middle, rounding, exact), (data, column, first) = at_centre, entries
    both = np.empty((2, len(moved), len(middle)))
    for k in range(len(moved)):
        for row in range(len(middle)):
            total, size, terms = 0.0, 0.0, 8 + 2 * (first[row + 1] - first[row])
            for q in range(first[row], first[row + 1]):
                term = data[q] * moved[k, column[q]]
                total += term
                size += abs(term)
            both[0, k, row] = middle[row] - total
            both[1, k, row] = 0.0 if exact[row] else rounding[row] + EPSILON * terms * size + terms * TINY
    return both


@compiled
def _shares(known: tuple[Array, Array, Array, Mask], entries: Entries, size: Array, interior_size: Array) -> Array:
    """Return how far (k,) points have to go to an interior one, as shares of the way, for every row to hold for sure.

    Args:
        known: Slack and doubt (k, r) of the points, slack (r,) of the interior one, and which rows' signs are exact (r,).
        entries: Of the matrix.
        size: (k, v) absolute coordinates of the points, whose own rounding counts.
        interior_size: (v,) those of the interior one.
    """
    (slack, doubt, room, exact), (data, column, first) = known, entries
    shares = np.zeros(len(slack))
    for k in range(len(slack)):
        for row in range(len(room)):
            grid = 0.0
            for q in range(first[row], first[row + 1]) if not exact[row] else range(0):
                grid += abs(data[q]) * (size[k, column[q]] + interior_size[column[q]])
            lacking = 4 * doubt[k, row] + 2 * EPSILON * grid - slack[k, row]
            gain = room[row] - slack[k, row]
            if lacking > 0:
                shares[k] = max(shares[k], lacking / gain if gain > lacking else 1.0)
    return shares


def twice_precise_dot(a: Array, b: Array) -> tuple[Array, Array]:
    """Return (k,) high and low parts of the dot products of the rows of a and b, both (k, n), each entry below 1e140.

    The high part is the sum in floating point, the low part the errors made, themselves summed in floating point. Their
    sum is off by (n EPSILON)^2 / 2 of the sum of |a_j b_j| at most, underflow aside
    (Ogita, Rump and Oishi, Accurate sum and dot product, 2005, algorithm Dot2).
    """
    product = a * b
    (a_high, a_low), (b_high, b_low) = _split(a), _split(b)
    error = a_low * b_low - (((product - a_high * b_high) - a_low * b_high) - a_high * b_low)
    high, low = product[:, :1].sum(axis=1), error.sum(axis=1)
    for term in product.T[1:]:
        total = high + term
        part = total - high
        low += (high - (total - part)) + (term - part)
        high = total
    return high, low


def _split(a: Array) -> tuple[Array, Array]:
    """Return a as the sum of two numbers of half the digits (Veltkamp)."""
    scaled = (2.0**27 + 1) * a
    high = scaled - (scaled - a)
    return high, a - high


def _rectangular(matrix: sparse.csr_array) -> tuple[Array, Integers]:
    """Return the entries of each row and their columns, both (r, n), filled up with zeros in column 0."""
    counts = np.diff(matrix.indptr)
    if len(counts) and (counts == counts[0]).all():
        return matrix.data.reshape(len(counts), -1), matrix.indices.reshape(len(counts), -1)
    rows = np.repeat(np.arange(len(counts)), counts)
    places = np.arange(matrix.nnz) - np.repeat(matrix.indptr[:-1], counts)
    values, columns = np.zeros((len(counts), counts.max(initial=0))), np.zeros((len(counts), counts.max(initial=0)), np.int64)
    values[rows, places], columns[rows, places] = matrix.data, matrix.indices
    return values, columns
