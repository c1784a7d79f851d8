"""The linear-programming solvers: PIQP and the simplex of HiGHS, kept across directions, or any that qpsolvers knows.

Their answers are candidates that `LinearProgram` judges; whatever else they do, raising included, is no answer. The only
module that imports piqp, highspy and qpsolvers, and not before they are asked: exact projections need none.
"""

from collections.abc import Callable, Iterable
from functools import cache, cached_property, partial
from importlib.util import find_spec
from typing import Protocol

import numpy as np
import scipy

from filter.arrays import Array, several, shown
from filter.errors import InvalidInput
from filter.geometry.convex import EPSILON
from filter.linear.program import Candidate, LinearProgram

# A row that the box implies with this much to spare, relative to the box, cannot hold a point back.
CLEARLY = 1e-3
# A coordinate narrower than this share of itself is anchored, to rounding: it is held at its middle.
NARROW = 64 * EPSILON
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


Answer = tuple[Array, Array]  # z (f,) and multipliers (l,) of a scaled program
Solve = Callable[[Array], Answer | None]  # for an objective (f,)


class Workspace(Protocol):
    """One program, many directions."""

    def maximize(self, objective: Array) -> Candidate | None:
        """Return a candidate for the greatest c . x in direction c (v,), or None when the solver gives up."""


Solver = str | Callable[[LinearProgram], Workspace]
"""The name of a solver that is installed, or whatever makes a workspace."""


def workspace(program: LinearProgram, solver: Solver) -> Workspace:
    """Return the solver's workspace for the program; raise `InvalidInput` if none is installed, and nothing of the solver's."""
    check_solver(solver)
    return _Guarded(program, solver)


def check_solver(solver: Solver) -> None:
    """Raise `InvalidInput`, with the list of those there are, unless the solver is installed."""
    ours = isinstance(solver, str) and solver in PACKAGES and all(map(_is_there, PACKAGES[solver]))
    if callable(solver) or ours:  # nothing is loaded for these
        return
    import qpsolvers  # noqa: PLC0415 - see above

    known = sorted([*qpsolvers.available_solvers, SIMPLEX])
    if not isinstance(solver, str) or solver not in known:
        raise InvalidInput(f"a solver among {', '.join(known)}", shown(solver))


@cache
def _is_there(package: str) -> bool:
    """Return whether a package can be imported; asked once, as an interrupt in here would leave the lock of imports locked."""
    return find_spec(package) is not None


def checked_solvers(solvers: Iterable[Solver]) -> tuple[Solver, ...]:
    """Return solvers that are all installed; raise `InvalidInput` if one is not, or if they come as one text."""
    expected = 'a tuple of solvers, such as ("piqp", "highs")'
    if isinstance(solvers, str):
        raise InvalidInput(expected, shown(solvers))
    every = several(expected, solvers, object)
    for solver in every:
        check_solver(solver)
    return every


def name_of(solver: Solver) -> str:
    """Return what to call a solver."""
    return solver if isinstance(solver, str) else getattr(solver, "__name__", type(solver).__name__)


def deepest_point(program: LinearProgram, solver: Solver) -> Candidate | None:
    """Return a candidate for the point that keeps farthest from every row: the most t with A x + t <= b.

    With a negative t the multipliers are a candidate for the proof that the polytope is empty.
    """
    size = abs(program.A) @ program.radius
    # A row on anchored coordinates alone keeps no point at a distance; it matters where it cannot be satisfied.
    live = np.flatnonzero((program.slack < (1 + CLEARLY) * size) & ((size > 0) | (program.slack < 0)))
    depth = float(np.abs(program.slack).max(initial=0) + 4 * program.radius.max(initial=0))
    A = scipy.sparse.csr_array(scipy.sparse.hstack([program.A[live], np.ones((len(live), 1))]))
    deepened = LinearProgram(A, program.b[live], np.append(program.lower, -depth), np.append(program.upper, depth))
    found = workspace(deepened, solver).maximize(np.append(np.zeros(len(program.lower)), 1.0))
    if found is None:
        return None
    multipliers = np.zeros(len(program.b))
    multipliers[live] = found.multipliers
    return Candidate(found.point[:-1], multipliers)


class _Guarded:
    """A solver's workspace, made when first asked; an exception, or an answer of another shape than the program's, is none."""

    def __init__(self, program: LinearProgram, solver: Solver) -> None:
        self._program, self._solver = program, solver

    @cached_property
    def _maximize(self) -> Callable[[Array], Candidate | None]:
        if callable(self._solver):
            return self._solver(self._program).maximize
        scaled = ScaledProgram(self._program)
        set_up = SET_UP.get(self._solver, partial(_of_qpsolvers, self._solver))
        return partial(scaled.maximize, solve=set_up(scaled) if len(scaled.free) else lambda c: (c, 0 * scaled.h))

    def maximize(self, objective: Array) -> Candidate | None:
        try:
            found = self._maximize(objective)
            if found is None:
                return None
            point, multipliers = np.asarray(found.point, dtype=float), np.asarray(found.multipliers, dtype=float)
        except Exception:  # each solver has exceptions of its own; all mean that it gives up
            return None
        fits = point.shape == self._program.lower.shape and multipliers.shape == self._program.b.shape
        return Candidate(point, multipliers) if fits and np.isfinite(point).all() else None


class ScaledProgram:
    """The program as solvers like it: maximise c . z over G z <= h, |z| <= 1.

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
        size = abs(program.A) @ program.radius
        self._program = program
        self.free = np.flatnonzero(program.radius > NARROW * np.abs(program.centre))
        self.live = np.flatnonzero((program.slack < size) & (size > 0))
        self.size, self.h = size[self.live], program.slack[self.live] / size[self.live]
        self.G = scipy.sparse.csc_matrix(program.A[self.live][:, self.free])
        widths = np.repeat(program.radius[self.free], np.diff(self.G.indptr))
        self.G.data = self.G.data * widths / self.size[self.G.indices]

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


def _piqp(scaled: ScaledProgram) -> Solve:
    """Set up PIQP once; a new direction only changes the cost."""
    import piqp  # noqa: PLC0415 - see above

    solver, good = piqp.SparseSolver(), (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED)
    solver.settings.max_iter = MAX_ITERATIONS
    nothing, ones = scipy.sparse.csc_matrix((len(scaled.free), len(scaled.free))), np.ones(len(scaled.free))
    solver.setup(nothing, ones, None, None, scaled.G, None, scaled.h, -ones, ones)

    def solve(c: Array) -> Answer | None:
        solver.update(c=-c)
        return (solver.result.x, solver.result.z_u) if solver.solve() in good else None

    return solve


def _simplex(scaled: ScaledProgram) -> Solve:
    """Set up HiGHS's primal simplex method, which begins at the last direction's vertex, and returns vertices."""
    import highspy  # noqa: PLC0415 - see above

    solver = highspy.Highs()  # type: ignore[no-untyped-call]
    solver.silent()
    for name, value in SIMPLEX_OPTIONS.items():
        solver.setOptionValue(name, value)
    ones = np.ones(len(scaled.free))
    model = highspy.HighsLp()
    model.num_row_, model.num_col_ = scaled.G.shape
    model.col_cost_, model.col_lower_, model.col_upper_ = 0 * ones, -ones, ones
    model.row_lower_, model.row_upper_ = np.full(len(scaled.h), -np.inf), scaled.h
    model.a_matrix_.format_ = highspy.MatrixFormat.kColwise
    model.a_matrix_.start_, model.a_matrix_.index_ = scaled.G.indptr, scaled.G.indices
    model.a_matrix_.value_ = scaled.G.data
    model.sense_ = highspy.ObjSense.kMaximize
    solver.passModel(model)

    def solve(c: Array) -> Answer | None:
        solver.changeColsCost(len(c), np.arange(len(c), dtype=np.int32), c)
        solver.run()
        if solver.getModelStatus() != highspy.HighsModelStatus.kOptimal:
            return None
        found = solver.getSolution()
        return np.array(found.col_value), np.array(found.row_dual)

    return solve


def _of_qpsolvers(solver: str, scaled: ScaledProgram) -> Solve:
    """Return any solver that qpsolvers knows; a new one each time."""
    import qpsolvers  # noqa: PLC0415 - see above

    nothing, ones = scipy.sparse.csc_matrix((len(scaled.free), len(scaled.free))), np.ones(len(scaled.free))

    def solve(c: Array) -> Answer | None:
        found = qpsolvers.solve_problem(qpsolvers.Problem(nothing, -c, scaled.G, scaled.h, lb=-ones, ub=ones), solver=solver)
        return (found.x, found.z) if found.found and found.x is not None and found.z is not None else None

    return solve


SET_UP = {"piqp": _piqp, SIMPLEX: _simplex}
