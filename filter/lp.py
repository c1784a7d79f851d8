"""Linear programs with bounds that are proved, whatever a solver says.

No solver is trusted: its answers are candidates. An upper bound counts only through `certified_bounds`, a point only
through `holds`.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from scipy import sparse

from filter.arrays import Array, Mask
from filter.plane import EPSILON

# Rounding of a few operations on entries of at most four non-zeros; each operation is off by EPSILON / 2 at most.
FEW = 16 * EPSILON


@dataclass(frozen=True, eq=False)
class LinearProgram:
    """The polytope {x : A x <= b, lower <= x <= upper}, every bound finite.

    Attributes:
        A: (r, v) rows with at most four non-zeros.
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
        """(r,) b - A centre, to rounding [m]."""
        return np.asarray(self.b - self.A @ self.centre)

    @cached_property
    def _slack_rounding(self) -> Array:
        return np.asarray(FEW * (np.abs(self.b) + self._magnitudes @ np.abs(self.centre)))

    @cached_property
    def _magnitudes(self) -> sparse.csr_array:
        return abs(self.A)

    @cached_property
    def _transposed(self) -> tuple[sparse.csr_array, sparse.csr_array]:
        return sparse.csr_array(self.A.T), sparse.csr_array(self._magnitudes.T)

    def certified_bounds(self, objectives: Array, multipliers: Array) -> Array:
        """Return (k,) upper bounds of c . x over the polytope that hold in exact arithmetic [m].

        Args:
            objectives: (k, v) directions c.
            multipliers: (k, r) dual candidates y; negative and non-finite entries are taken as 0.

        Algorithm:
            For any y >= 0 and x in the polytope, with centre x0 and radius w,
            c.x = c.x0 + (c - A'y).(x - x0) + y.(A x - A x0) <= c.x0 + |c - A'y|.w + y.(b - A x0)
            (Neumaier and Shcherbina, Safe bounds in linear and mixed-integer linear programming, 2004).
            Every rounding error of the evaluation is bounded by its terms' magnitudes and added.
        """
        y = np.where(np.isfinite(multipliers), np.maximum(multipliers, 0), 0)
        transposed, magnitudes = self._transposed
        residual = objectives - (transposed @ y.T).T
        size = np.abs(objectives) + (magnitudes @ y.T).T
        bound = objectives @ self.centre + np.abs(residual) @ self.radius + y @ self.slack
        entries = 8 + np.count_nonzero(objectives, axis=1)
        few = 2 * EPSILON * entries * (np.abs(objectives) @ np.abs(self.centre)) + 2 * (y @ self._slack_rounding)
        many = 2 * (len(self.b) + len(self.centre)) * EPSILON * (size @ self.radius + y @ np.abs(self.slack))
        return np.asarray(np.nextafter(bound + few + many, np.inf))

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
        room = self._slack_at(interior[None])[0]
        lacking = 4 * doubt - slack
        with np.errstate(divide="ignore", invalid="ignore"):
            share = np.where(lacking > 0, lacking / (room - slack), 0).max(axis=1, initial=0)[:, None]
        moved = inside + np.clip(share, 0, 1) * (interior - inside)
        return np.asarray(np.clip(moved, self.lower, self.upper))

    @cached_property
    def _exact(self) -> Mask:
        """(r,) rows +-x_k <= b on an anchored coordinate: the sign of their slack is right, however small it is."""
        row = np.repeat(np.arange(len(self.b)), np.diff(self.A.indptr))
        terms = np.bincount(row[self.A.data != 0], minlength=len(self.b))
        unit = (np.abs(self.A.data) == 1) & (self.radius[self.A.indices] == 0)
        return (terms == 1) & (np.bincount(row[unit], minlength=len(self.b)) == 1)

    def _slack_at(self, points: Array) -> tuple[Array, Array]:
        """Return b - A x at points (k, v) of the box, and the rounding in it, both (k, r)."""
        moved = points - self.centre
        slack = self.slack - (self.A @ moved.T).T
        doubt = self._slack_rounding + FEW * (self._magnitudes @ (np.abs(moved) + EPSILON * np.abs(points)).T).T
        return np.asarray(slack), np.where(self._exact, 0.0, doubt)
