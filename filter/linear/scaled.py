"""A program as solvers like it: every coordinate in the radius of its own box, every row of size 1."""

from collections.abc import Callable

import numpy as np
import scipy

from filter.arrays import Array
from filter.geometry.convex import EPSILON
from filter.linear.program import Candidate, LinearProgram

# A coordinate narrower than this share of itself is anchored, to rounding: it is held at its middle.
NARROW = 64 * EPSILON

Answer = tuple[Array, Array]  # z (f,) and multipliers (l,) of a scaled program
Solve = Callable[[Array], Answer | None]  # for an objective (f,)


class ScaledProgram:
    """The program as maximise c . z over G z <= h, |z| <= 1.

    Every coordinate is moved to the middle of its box and measured in its radius; anchored coordinates and rows that the box
    implies are left out; the coefficients of each row that is left add up to 1. So a solver's tolerance is relative to what is
    known already, however small that is.

    Attributes:
        free: (f,) the program's coordinates that are not anchored.
        live: (l,) its rows that the box does not imply.
        size: (l,) what each of these was divided by.
        G: (l, f).
        h: (l,).
    """

    def __init__(self, program: LinearProgram) -> None:
        A, radius = program.A, program.radius
        row = np.repeat(np.arange(len(program.b)), np.diff(A.indptr))
        value = A.data * radius[A.indices]
        size = np.bincount(row, np.abs(value), minlength=len(program.b)).astype(float)
        is_free, is_live = radius > NARROW * np.abs(program.centre), (program.slack < size) & (size > 0)
        kept = is_free[A.indices] & is_live[row]
        self._program, self.free, self.live = program, np.flatnonzero(is_free), np.flatnonzero(is_live)
        self.size, self.h = size[self.live], program.slack[self.live] / size[self.live]
        place = np.searchsorted(self.live, row[kept]), np.searchsorted(self.free, A.indices[kept])
        self.G = scipy.sparse.csc_matrix((value[kept] / size[row[kept]], place), shape=(len(self.live), len(self.free)))

    def maximize(self, objective: Array, solve: Solve) -> Candidate | None:
        """Return what is solved for an objective (v,), its greatest coefficient made 1, in the program's own units."""
        radius = self._program.radius[self.free]
        c = objective[self.free] * radius
        scale = float(np.abs(c).max(initial=0)) or 1.0
        found = solve(c / scale)
        if found is None:
            return None
        point, multipliers = self._program.centre.copy(), np.zeros(len(self._program.b))
        point[self.free] += radius * found[0]
        multipliers[self.live] = np.maximum(found[1], 0) * scale / self.size
        return Candidate(point, multipliers)
