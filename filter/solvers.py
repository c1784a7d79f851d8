"""The linear-programming solvers: PIQP with a workspace kept across directions, or any that qpsolvers knows.

Their answers are candidates that `LinearProgram` judges. The only module that imports piqp and qpsolvers.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import piqp
import qpsolvers
from scipy import sparse

from filter.arrays import Array
from filter.errors import InvalidInput
from filter.lp import LinearProgram
from filter.scaling import ScaledProgram

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


def workspace(program: LinearProgram, solver: str) -> Workspace:
    """Return a workspace of the named solver for the program.

    Raises:
        InvalidInput: No such solver is installed.
    """
    check_solver(solver)
    return _Piqp(program) if solver == "piqp" else _Qpsolvers(program, solver)


def check_solver(solver: str, others: Sequence[str] = ()) -> None:
    """Raise `InvalidInput`, with the list of those there are, unless the solver is installed or among the others."""
    known = [*others, *sorted(qpsolvers.available_solvers)]
    if solver not in known:
        raise InvalidInput(f"a solver among {', '.join(known)}", repr(solver))


def deepest_point(program: LinearProgram, solver: str) -> Candidate | None:
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


def _candidate(scaled: ScaledProgram, z: Array, multipliers: Array, scale: float) -> Candidate | None:
    """Return the solver's answer in the program's own units, or None when it is no number."""
    if not np.isfinite(z).all():
        return None
    return Candidate(scaled.points(z[None])[0], scaled.multipliers(multipliers[None], np.array([scale]))[0])


class _Piqp:
    """PIQP, set up once; a new direction only changes the cost."""

    def __init__(self, program: LinearProgram) -> None:
        self._scaled = scaled = ScaledProgram.of(program)
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
        if self._solver.solve() not in (piqp.PIQP_SOLVED, piqp.PIQP_MAX_ITER_REACHED):
            return None
        return _candidate(scaled, self._solver.result.x, self._solver.result.z_u, scale)


class _Qpsolvers:
    """Any solver that qpsolvers knows; a new one each time."""

    def __init__(self, program: LinearProgram, solver: str) -> None:
        self._scaled = ScaledProgram.of(program)
        self._solver = solver

    def maximize(self, objective: Array) -> Candidate | None:
        scaled = self._scaled
        c, scale = scaled.objective(objective)
        if not len(c):
            return _candidate(scaled, c, np.zeros(len(scaled.h)), scale)
        nothing, ones = sparse.csc_matrix((len(c), len(c))), np.ones(len(c))
        problem = qpsolvers.Problem(nothing, -c, scaled.G, scaled.h, lb=-ones, ub=ones)
        try:
            solution = qpsolvers.solve_problem(problem, solver=self._solver)
        except Exception:  # each solver has exceptions of its own; all mean that it gives up
            return None
        if not solution.found or solution.x is None or solution.z is None:
            return None
        return _candidate(scaled, solution.x, np.asarray(solution.z, dtype=float), scale)
