"""Linear programs with bounds that are proved, whatever a solver says.

No solver is trusted: its answers are candidates. A bound counts only through `certified_bounds`, a point through `holds`.
"""

from __future__ import annotations  # so that scipy loads its matrices when one is made

from dataclasses import dataclass
from functools import cached_property

import numpy as np
import scipy

from filter.arrays import Array, Mask
from filter.geometry.convex import EPSILON

# What an interior-point solver leaves of a zero proves nothing: a multiplier is dropped where that costs less than this [m],
NEGLIGIBLE = 1e-9
# and less than this share of what the box allows anyway.
NEGLIGIBLE_SHARE = 1e-7
# Where products underflow, each is off by less than this; far below any length.
TINY = float(np.finfo(float).tiny)
# A matrix of no more entries is better filled up than sparse.
SMALL = 20_000


@dataclass(frozen=True, eq=False)
class Candidate:
    """What a solver says: a point (v,) near the optimum [m], and multipliers (r,) of the rows. Neither is trusted."""

    point: Array
    multipliers: Array


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """The polytope {x : A x <= b, lower <= x <= upper}, every bound finite.

    Attributes:
        A: (r, v) rows.
        b: (r,) offsets [m].
        lower: (v,) [m].
        upper: (v,) [m].
    """

    A: scipy.sparse.csr_array
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
        counts = np.diff(self.A.indptr)
        filled = np.arange(counts.max(initial=0)) < counts[:, None]
        values, middles = np.zeros(filled.shape), np.zeros(filled.shape)
        values[filled], middles[filled] = self.A.data, -self.centre[self.A.indices]
        high, low = twice_precise_dot(np.column_stack([self.b, values]), np.column_stack([np.ones(len(self.b)), middles]))
        return np.asarray(high + low)

    @cached_property
    def _slack_rounding(self) -> Array:
        terms = 1 + np.diff(self.A.indptr)
        size = np.abs(self.b) + abs(self._matrix) @ np.abs(self.centre)
        return np.asarray(2 * EPSILON * np.abs(self.slack) + (terms * EPSILON) ** 2 * size + terms * TINY)

    @cached_property
    def _matrix(self) -> Array | scipy.sparse.csr_array:
        """A, filled up with zeros where that is small: products are faster then, and zeros are no rounding."""
        return self.A.toarray() if self.A.shape[0] * self.A.shape[1] <= SMALL else self.A

    def certified_bounds(self, objectives: Array, multipliers: Array) -> Array:
        """Return (k,) upper bounds of c . x over the polytope, for objectives c (k, v), that hold in exact arithmetic [m].

        The multipliers y (k, r) are dual candidates; negative and non-finite entries are taken as 0.

        Algorithm:
            For any y >= 0 and x in the polytope, with centre x0 and radius w,
            c.x = c.x0 + (c - A'y).(x - x0) + y.(A x - A x0) <= c.x0 + |c - A'y|.w + y.(b - A x0)
            (Neumaier and Shcherbina, Safe bounds in linear and mixed-integer linear programming, 2004). Every rounding error of
            the evaluation is bounded by its terms' magnitudes and added; docs/soundness.md derives by how much.
        """
        y = np.where(np.isfinite(multipliers), np.maximum(multipliers, 0), 0)
        filled = int((objectives != 0).sum(axis=1).max(initial=0))
        places = np.argsort(objectives == 0, axis=1, kind="stable")[:, :filled]  # the non-zeros first
        values, middles = objectives[np.arange(len(objectives))[:, None], places], self.centre[places]
        high, low = twice_precise_dot(values, middles)
        few = ((8 + filled) * EPSILON) ** 2 * np.abs(values * middles).sum(axis=1)
        row, size, least = self._outward
        with np.errstate(over="ignore", invalid="ignore"):  # multipliers that overflow bound nothing
            residual = objectives - (self._matrix.T @ y.T).T
            rest = low + np.abs(residual) @ self.radius + y @ row + (few + np.abs(objectives) @ size + least)
            bounds = np.nextafter(high + rest, np.inf)
        return np.where(np.isnan(bounds), np.inf, bounds)

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
        return np.asarray(abs(self._matrix) @ self.radius)

    def proves_empty(self, multipliers: Array) -> bool:
        """Return whether (r,) multipliers are a Farkas certificate: they bound 0 . x below 0."""
        return bool(self.certified_bounds(np.zeros((1, len(self.centre))), multipliers[None])[0] < 0)

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
        gain = self._slack_at(interior[None])[0] - slack
        own = np.where(self._exact, 0.0, (abs(self.A) @ (np.abs(inside) + np.abs(interior)).T).T)  # a point's own rounding
        lacking = 4 * doubt + 2 * EPSILON * own - slack
        share = np.divide(lacking, gain, out=np.ones_like(gain), where=gain > np.maximum(lacking, 0))
        share = np.where(lacking > 0, share, 0).max(axis=1, initial=0)
        return np.asarray(np.clip(inside + share[:, None] * (interior - inside), self.lower, self.upper))

    def _slack_at(self, points: Array) -> tuple[Array, Array]:
        """Return b - A x at points (k, v), and the rounding in it, both (k, r)."""
        moved, terms = (points - self.centre).T, 8 + 2 * np.diff(self.A.indptr)
        doubt = self._slack_rounding + EPSILON * terms * (abs(self.A) @ np.abs(moved)).T + terms * TINY
        return self.slack - (self.A @ moved).T, np.where(self._exact, 0.0, doubt)

    @cached_property
    def _exact(self) -> Mask:
        """(r,) rows +-x_k <= b on an anchored coordinate: the sign of their slack is right, however small it is."""
        unit = (np.abs(self.A.data) == 1) & (self.radius[self.A.indices] == 0)
        row = np.repeat(np.arange(len(self.b)), np.diff(self.A.indptr))
        terms, units = (np.bincount(row[which], minlength=len(self.b)) for which in (self.A.data != 0, unit))
        return (terms == 1) & (units == 1)


def twice_precise_dot(a: Array, b: Array) -> tuple[Array, Array]:
    """Return (k,) high and low parts of the dot products of the rows of a and b, both (k, n), each entry below 1e140.

    The high part is the sum in floating point, the low part the errors made, summed likewise. Their sum is off by
    (n EPSILON)^2 / 2 of the sum of |a_j b_j| at most, underflow aside (Ogita, Rump and Oishi, Accurate sum and dot product,
    2005, algorithm Dot2).
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
