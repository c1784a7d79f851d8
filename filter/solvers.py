"""The linear-programming solvers: PIQP with a workspace kept across directions, or any that qpsolvers knows.

Their answers are candidates that `LinearProgram` judges; whatever else they do, raising included, is no answer. The only
module that imports piqp and qpsolvers.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

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


@dataclass(frozen=True, eq=False)
class Candidate:
    """What a solver says: a point (v,) near the optimum [m], and multipliers (r,) of the rows. Neither is trusted."""

    point: Array
    multipliers: Array


class Workspace(Protocol):
    """One program, many directions."""

    def maximize(self, objective: Array) -> Candidate | None:
        """Return a candidate for the greatest c . x in direction c (v,), or None when the solver gives up."""


Solver = str | Callable[[LinearProgram], Workspace]
"""The name of a solver that is installed, or whatever makes a workspace."""


def workspace(program: LinearProgram, solver: Solver) -> Workspace:
    """Return a workspace of the solver for the program; no exception of the solver's leaves it.

    Raises:
        InvalidInput: No such solver is installed.
    """
    check_solver(solver)
    return _Guarded(program, solver)


def check_solver(solver: Solver) -> None:
    """Raise `InvalidInput`, with the list of those installed, unless there is such a solver."""
    if not callable(solver) and solver not in qpsolvers.available_solvers:
        raise InvalidInput(f"a solver among {', '.join(sorted(qpsolvers.available_solvers))}", repr(solver))


def name_of(solver: Solver) -> str:
    """Return what to call a solver."""
    return solver if isinstance(solver, str) else getattr(solver, "__name__", type(solver).__name__)


class Chain:
    """Workspaces of several solvers for one program, each made when it is first asked for.

    Attributes:
        program: The program.
    """

    def __init__(self, program: LinearProgram, solvers: Sequence[Solver]) -> None:
        self.program, self._solvers = program, solvers
        self._made: list[Workspace] = []

    def __iter__(self) -> Iterator[tuple[str, Workspace]]:
        """Yield the solvers' names and workspaces, in turn."""
        for k, solver in enumerate(self._solvers):
            if k == len(self._made):
                self._made.append(workspace(self.program, solver))
            yield name_of(solver), self._made[k]


def deepest_point(program: LinearProgram, solver: Solver) -> Candidate | None:
    """Return a candidate for the point that keeps farthest from every row: the most t with A x + t <= b.

    With a negative t the multipliers are a candidate for the proof that the polytope is empty.
    """
    live = np.flatnonzero(program.slack < (1 + CLEARLY) * (abs(program.A) @ program.radius))
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


class _Guarded:
    """A solver's workspace; an exception, or an answer of another shape than the program's, is no answer."""

    def __init__(self, program: LinearProgram, solver: Solver) -> None:
        self._program = program
        self._work: Workspace | None = None
        try:
            self._work = _made(program, solver)
        except Exception:  # each solver has exceptions of its own; all mean that it gives up
            return

    def maximize(self, objective: Array) -> Candidate | None:
        try:
            found = self._work.maximize(objective) if self._work is not None else None
            if found is None:
                return None
            point, multipliers = np.asarray(found.point, dtype=float), np.asarray(found.multipliers, dtype=float)
        except Exception:  # as above
            return None
        fits = point.shape == self._program.lower.shape and multipliers.shape == self._program.b.shape
        return Candidate(point, multipliers) if fits and np.isfinite(point).all() else None


def _made(program: LinearProgram, solver: Solver) -> Workspace:
    if callable(solver):
        return solver(program)
    return _Piqp(program) if solver == "piqp" else _Qpsolvers(program, solver)


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
        solution = qpsolvers.solve_problem(problem, solver=self._solver)
        if not solution.found or solution.x is None or solution.z is None:
            return None
        return scaled.candidate(solution.x, np.asarray(solution.z, dtype=float), scale)
