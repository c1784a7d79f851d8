"""A program as solvers like it: every coordinate in the radius of its own box, every row of size 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy import sparse

from filter.arrays import Array, Integers
from filter.geometry.convex import EPSILON
from filter.linear.program import LinearProgram

# A coordinate narrower than this share of itself is anchored, to rounding: it is held at its middle.
NARROW = 64 * EPSILON


@dataclass(frozen=True, eq=False)
class ScaledProgram:
    """The program as maximise c . z over G z <= h, |z| <= 1.

    Every coordinate is moved to the middle of its box and measured in its radius; anchored coordinates and rows that
    the box implies are left out; the coefficients of each row that is left add up to 1. So a solver's tolerance is
    relative to what is known already, however small that is.

    Attributes:
        program: What is scaled.
        free: (f,) its coordinates that are not anchored.
        live: (l,) its rows that the box does not imply.
        size: (l,) what each of these was divided by.
        G: (l, f).
        h: (l,).
    """

    program: LinearProgram
    free: Integers
    live: Integers
    size: Array
    G: sparse.csc_matrix
    h: Array

    @classmethod
    def of(cls, program: LinearProgram) -> ScaledProgram:
        """Scale a program."""
        A, radius = program.A, program.radius
        row = np.repeat(np.arange(len(program.b)), np.diff(A.indptr))
        value = A.data * radius[A.indices]
        size = np.bincount(row, np.abs(value), minlength=len(program.b)).astype(float)
        is_free, is_live = radius > NARROW * np.abs(program.centre), (program.slack < size) & (size > 0)
        free, live = np.flatnonzero(is_free), np.flatnonzero(is_live)
        kept = is_free[A.indices] & is_live[row]
        place = np.searchsorted(live, row[kept]), np.searchsorted(free, A.indices[kept])
        G = sparse.csc_matrix((value[kept] / size[row[kept]], place), shape=(len(live), len(free)))
        return cls(program, free, live, size[live], G, program.slack[live] / size[live])

    @property
    def radius(self) -> Array:
        """(f,) what each free coordinate was divided by [m]."""
        return self.program.radius[self.free]

    def objective(self, objective: Array) -> tuple[Array, float]:
        """Return c with its greatest entry at 1, and what it was divided by."""
        c = objective[self.free] * self.radius
        scale = float(np.abs(c).max(initial=0)) or 1.0
        return c / scale, scale

    def points(self, z: Array) -> Array:
        """Return (k, f) scaled points as (k, v) points of the program."""
        points = np.tile(self.program.centre, (len(z), 1))
        points[:, self.free] += self.radius * z
        return points

    def multipliers(self, scaled: Array, scale: Array) -> Array:
        """Return (k, l) multipliers of scaled rows, for objectives divided by (k,) scales, as (k, r) of the program's."""
        rows = np.zeros((len(scaled), len(self.program.b)))
        rows[:, self.live] = np.maximum(scaled, 0) * scale[:, None] / self.size
        return rows
