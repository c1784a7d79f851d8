"""The linear-programming solvers: PIQP and the simplex of HiGHS, kept across directions, or any that qpsolvers knows.

Their answers are candidates that `LinearProgram` judges. The only module that imports piqp, highspy and qpsolvers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import highspy
import numpy as np
import piqp
import qpsolvers
from scipy import sparse

from filter.arrays import Array, Integers
from filter.errors import InvalidInput
from filter.lp import LinearProgram
from filter.polygon import EPSILON

# A coordinate narrower than this share of itself is anchored, to rounding: it is held at its middle.
NARROW = 64 * EPSILON
# A row that the box implies with this much to spare, relative to the box, cannot hold a point back.
CLEARLY = 1e-3
# PIQP needs 8 to 15 iterations; where it needs many more the polytope is all but flat, and more of them gain nothing.
MAX_ITERATIONS = 60
# The simplex method goes on from the vertex of the direction before; a point of its own is as exact as HiGHS can make it.
SIMPLEX = "highs-simplex"
SIMPLEX_OPTIONS: dict[str, str | int | float] = {
    "solver": "simplex",
    "simplex_strategy": 4,  # primal: the last vertex stays feasible when the direction changes
    "presolve": "off",
    "primal_feasibility_tolerance": 1e-10,
    "dual_feasibility_tolerance": 1e-10,
}


@dataclass(frozen=True, eq=False)
class Candidate:
    """What a solver says: a point (v,) near the optimum [m], and multipliers (r,) of the rows. Neither is trusted."""

    point: Array
    multipliers: Array


class Workspace(Protocol):
    """One program, many directions."""

    def maximize(self, objective: Array) -> Candidate | None:
        """Return a candidate for the greatest c . x in direction c (v,), or None when the solver gives up."""


def workspace(program: LinearProgram, solver: str) -> Workspace:
    """Return a workspace of the named solver for the program.

    Raises:
        InvalidInput: No such solver is installed.
    """
    check_solver(solver)
    if solver == SIMPLEX:
        return _Simplex(program)
    return _Piqp(program) if solver == "piqp" else _Qpsolvers(program, solver)


def check_solver(solver: str) -> None:
    """Raise `InvalidInput`, with the list of those installed, unless there is such a solver."""
    known = sorted([*qpsolvers.available_solvers, SIMPLEX])
    if solver not in known:
        raise InvalidInput(f"a solver among {', '.join(known)}", repr(solver))


def deepest_point(program: LinearProgram, solver: str) -> Candidate | None:
    """Return a candidate for the point that keeps farthest from every row: the most t with A x + t <= b.

    With a negative t the multipliers are a candidate for the proof that the polytope is empty.
    """
    size = abs(program.A) @ program.radius
    # A row on anchored coordinates alone keeps no point at a distance; it matters where it cannot be satisfied.
    live = np.flatnonzero((program.slack < (1 + CLEARLY) * size) & ((size > 0) | (program.slack < 0)))
    depth = float(np.abs(program.slack).max(initial=0) + 4 * program.radius.max(initial=0))
    deepened = LinearProgram(
        sparse.csr_array(sparse.hstack([program.A[live], np.ones((len(live), 1))])),
        program.b[live],
        np.append(program.lower, -depth),
        np.append(program.upper, depth),
    )
    found = workspace(deepened, solver).maximize(np.append(np.zeros(len(program.lower)), 1.0))
    if found is None:
        return None
    multipliers = np.zeros(len(program.b))
    multipliers[live] = found.multipliers
    return Candidate(found.point[:-1], multipliers)


@dataclass(frozen=True, eq=False)
class _Scaled:
    """The program as solvers like it: maximise c . z over G z <= h, |z| <= 1.

    Every coordinate is moved to the middle of its box and measured in its radius; anchored coordinates and rows that
    the box implies are left out; the coefficients of each row that is left add up to 1. So a solver's tolerance is
    relative to what is known already, however small that is.
    """

    program: LinearProgram
    free: Integers
    live: Integers
    size: Array
    G: sparse.csc_matrix
    h: Array

    @classmethod
    def of(cls, program: LinearProgram) -> _Scaled:
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

    def objective(self, objective: Array) -> tuple[Array, float]:
        """Return c with its greatest entry at 1, and what it was divided by."""
        c = objective[self.free] * self.program.radius[self.free]
        scale = float(np.abs(c).max(initial=0)) or 1.0
        return c / scale, scale

    def candidate(self, z: Array, multipliers: Array, scale: float) -> Candidate | None:
        """Return the solver's answer in the program's own units, or None when it is no number."""
        if not np.isfinite(z).all():
            return None
        point, rows = self.program.centre.copy(), np.zeros(len(self.program.b))
        point[self.free] += self.program.radius[self.free] * z
        rows[self.live] = np.maximum(multipliers, 0) * scale / self.size
        return Candidate(point, rows)


class _Piqp:
    """PIQP, set up once; a new direction only changes the cost."""

    def __init__(self, program: LinearProgram) -> None:
        self._scaled = scaled = _Scaled.of(program)
        self._solver = piqp.SparseSolver()
        self._solver.settings.max_iter = MAX_ITERATIONS
        count = len(scaled.free)
        if count:
            nothing, ones = sparse.csc_matrix((count, count)), np.ones(count)
            self._solver.setup(nothing, ones, None, None, scaled.G, None, scaled.h, -ones, ones)

    def maximize(self, objective: Array) -> Candidate | None:
        scaled = self._scaled
        c, scale = scaled.objective(objective)
        if not len(c):
            return scaled.candidate(c, np.zeros(len(scaled.h)), scale)
        self._solver.update(c=-c)
        if self._solver.solve() not in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED):
            return None
        return scaled.candidate(self._solver.result.x, self._solver.result.z_u, scale)


class _Simplex:
    """HiGHS's primal simplex method, begun at the last direction's vertex; it returns vertices of the polytope."""

    def __init__(self, program: LinearProgram) -> None:
        self._scaled = scaled = _Scaled.of(program)
        self._solver = highspy.Highs()  # type: ignore[no-untyped-call]
        self._solver.silent()
        for name, value in SIMPLEX_OPTIONS.items():
            self._solver.setOptionValue(name, value)
        rows, columns = scaled.G.shape
        model = highspy.HighsLp()
        model.num_col_, model.num_row_ = columns, rows
        model.col_cost_, model.col_lower_, model.col_upper_ = np.zeros(columns), -np.ones(columns), np.ones(columns)
        model.row_lower_, model.row_upper_ = np.full(rows, -np.inf), scaled.h
        model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
        model.a_matrix_.start_, model.a_matrix_.index_ = scaled.G.indptr, scaled.G.indices
        model.a_matrix_.value_ = scaled.G.data
        model.sense_ = highspy.ObjSense.kMaximize
        self._solver.passModel(model)

    def maximize(self, objective: Array) -> Candidate | None:
        scaled = self._scaled
        c, scale = scaled.objective(objective)
        if not len(c):
            return scaled.candidate(c, np.zeros(len(scaled.h)), scale)
        self._solver.changeColsCost(len(c), np.arange(len(c), dtype=np.int32), c)
        self._solver.run()
        if self._solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return None
        solution = self._solver.getSolution()
        return scaled.candidate(np.array(solution.col_value), np.array(solution.row_dual), scale)


class _Qpsolvers:
    """Any solver that qpsolvers knows; a new one each time."""

    def __init__(self, program: LinearProgram, solver: str) -> None:
        self._scaled = _Scaled.of(program)
        self._solver = solver

    def maximize(self, objective: Array) -> Candidate | None:
        scaled = self._scaled
        c, scale = scaled.objective(objective)
        if not len(c):
            return scaled.candidate(c, np.zeros(len(scaled.h)), scale)
        nothing, ones = sparse.csc_matrix((len(c), len(c))), np.ones(len(c))
        problem = qpsolvers.Problem(nothing, -c, scaled.G, scaled.h, lb=-ones, ub=ones)
        try:
            solution = qpsolvers.solve_problem(problem, solver=self._solver)
        except Exception:  # each solver has exceptions of its own; all mean that it gives up
            return None
        if not solution.found or solution.x is None or solution.z is None:
            return None
        return scaled.candidate(solution.x, np.asarray(solution.z, dtype=float), scale)
