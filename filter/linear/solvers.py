"""The linear-programming solvers: PIQP and the simplex of HiGHS, kept across directions, or any that qpsolvers knows.

Their answers are candidates that `LinearProgram` judges; whatever else they do, raising included, is no answer. The only
module that imports piqp, highspy and qpsolvers, and not before they are asked: exact projections need none.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from importlib.util import find_spec
from typing import Protocol

import numpy as np
from scipy import sparse

from filter.arrays import Array, several, shown
from filter.errors import InvalidInput
from filter.linear.program import LinearProgram
from filter.linear.scaled import ScaledProgram

# A row that the box implies with this much to spare, relative to the box, cannot hold a point back.
CLEARLY = 1e-3
# PIQP needs 8 to 15 iterations; where it needs many more the polytope is all but flat, and more of them gain nothing.
MAX_ITERATIONS = 60
# The simplex method goes on from the vertex of the direction before; a point of its own is as exact as HiGHS can make it.
SIMPLEX = "highs-simplex"
# What the solvers need that are asked by default, or that have a workspace here.
PACKAGES = {"piqp": ("piqp",), SIMPLEX: ("highspy",), "highs": ("qpsolvers", "highspy")}
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


Solver = str | Callable[[LinearProgram], Workspace]
"""The name of a solver that is installed, or whatever makes a workspace."""


def workspace(program: LinearProgram, solver: Solver) -> Workspace:
    """Return a workspace of the solver for the program; no exception of the solver's leaves it.

    Raises:
        InvalidInput: No such solver is installed.
    """
    check_solver(solver)
    return _Guarded(program, solver)


def check_solver(solver: Solver, others: Sequence[str] = ()) -> None:
    """Raise `InvalidInput`, with the list of those there are, unless the solver is installed or among the others."""
    if callable(solver) or (isinstance(solver, str) and (solver in others or _is_installed(solver))):
        return
    import qpsolvers  # noqa: PLC0415 - see above

    known = [*others, *sorted([*qpsolvers.available_solvers, SIMPLEX])]
    if not callable(solver) and not (isinstance(solver, str) and solver in known):
        raise InvalidInput(f"a solver among {', '.join(known)}", shown(solver))


def checked_solvers(solvers: Iterable[Solver]) -> tuple[Solver, ...]:
    """Return solvers that are all installed.

    Raises:
        InvalidInput: One is not, or they come as one text.
    """
    expected = 'a tuple of solvers, such as ("piqp", "highs")'
    if isinstance(solvers, str):
        raise InvalidInput(expected, shown(solvers))
    every = several(expected, solvers, object)
    for solver in every:
        check_solver(solver)
    return every


def _is_installed(solver: str) -> bool:
    """Return whether one of our own solvers is there, without loading it."""
    return solver in PACKAGES and all(find_spec(package) is not None for package in PACKAGES[solver])


def name_of(solver: Solver) -> str:
    """Return what to call a solver."""
    return solver if isinstance(solver, str) else getattr(solver, "__name__", type(solver).__name__)


class Workspaces:
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
    if solver == SIMPLEX:
        return _Simplex(program)
    return _Piqp(program) if solver == "piqp" else _Qpsolvers(program, solver)


def _candidate(scaled: ScaledProgram, z: Array, multipliers: Array, scale: float) -> Candidate | None:
    """Return the solver's answer in the program's own units, or None when it is no number."""
    if not np.isfinite(z).all():
        return None
    return Candidate(scaled.points(z[None])[0], scaled.multipliers(multipliers[None], np.array([scale]))[0])


class _Piqp:
    """PIQP, set up once; a new direction only changes the cost."""

    def __init__(self, program: LinearProgram) -> None:
        import piqp  # noqa: PLC0415 - see above

        self._scaled = scaled = ScaledProgram.of(program)
        self._good = piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED
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
            return _candidate(scaled, c, np.zeros(len(scaled.h)), scale)
        self._solver.update(c=-c)
        if self._solver.solve() not in self._good:
            return None
        return _candidate(scaled, self._solver.result.x, self._solver.result.z_u, scale)


class _Simplex:
    """HiGHS's primal simplex method, begun at the last direction's vertex; it returns vertices of the polytope."""

    def __init__(self, program: LinearProgram) -> None:
        import highspy  # noqa: PLC0415 - see above

        self._scaled = scaled = ScaledProgram.of(program)
        self._good = highspy.HighsModelStatus.kOptimal
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
            return _candidate(scaled, c, np.zeros(len(scaled.h)), scale)
        self._solver.changeColsCost(len(c), np.arange(len(c), dtype=np.int32), c)
        self._solver.run()
        if self._solver.getModelStatus() != self._good:
            return None
        solution = self._solver.getSolution()
        return _candidate(scaled, np.array(solution.col_value), np.array(solution.row_dual), scale)


class _Qpsolvers:
    """Any solver that qpsolvers knows; a new one each time."""

    def __init__(self, program: LinearProgram, solver: str) -> None:
        self._scaled = ScaledProgram.of(program)
        self._solver = solver

    def maximize(self, objective: Array) -> Candidate | None:
        import qpsolvers  # noqa: PLC0415 - see above

        scaled = self._scaled
        c, scale = scaled.objective(objective)
        if not len(c):
            return _candidate(scaled, c, np.zeros(len(scaled.h)), scale)
        nothing, ones = sparse.csc_matrix((len(c), len(c))), np.ones(len(c))
        problem = qpsolvers.Problem(nothing, -c, scaled.G, scaled.h, lb=-ones, ub=ones)
        solution = qpsolvers.solve_problem(problem, solver=self._solver)
        if not solution.found or solution.x is None or solution.z is None:
            return None
        return _candidate(scaled, solution.x, np.asarray(solution.z, dtype=float), scale)
