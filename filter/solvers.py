"""The linear-programming solvers: PIQP with a workspace kept across directions, or any that qpsolvers knows.

Their answers are candidates that `LinearProgram` judges. The only module that imports piqp and qpsolvers.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol

import numpy as np
import piqp
import qpsolvers
from scipy import sparse

from filter.arrays import Array, Mask
from filter.errors import InvalidInput
from filter.lp import LinearProgram

# A coordinate narrower than this share of the widest one has no interior that a solver could find: it is held at its middle.
NARROW = 1e-9


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


def check_solver(solver: str) -> None:
    """Raise `InvalidInput`, with the list of those installed, unless there is such a solver."""
    if solver not in qpsolvers.available_solvers:
        raise InvalidInput(f"a solver among {', '.join(sorted(qpsolvers.available_solvers))}", repr(solver))


def deepest_point(program: LinearProgram, solver: str) -> Candidate | None:
    """Return a candidate for the point that keeps farthest from every row: the most t with A x + t <= b.

    With a negative t the multipliers are a candidate for the proof that the polytope is empty.
    """
    depth = float(np.abs(program.slack).max(initial=0) + 4 * program.radius.max(initial=0))
    ones = np.ones((len(program.b), 1))
    deepened = LinearProgram(
        sparse.csr_array(sparse.hstack([program.A, ones])),
        program.b,
        np.append(program.lower, -depth),
        np.append(program.upper, depth),
    )
    found = workspace(deepened, solver).maximize(np.append(np.zeros(len(program.lower)), 1.0))
    return Candidate(found.point[:-1], found.multipliers) if found else None


@dataclass(frozen=True, eq=False)
class _Scaled:
    """The program in units of its widest coordinate, moved to its centre, anchored coordinates left out."""

    program: LinearProgram
    scale: float
    free: Mask
    G: sparse.csc_array
    h: Array
    bound: Array

    @classmethod
    def of(cls, program: LinearProgram) -> _Scaled:
        scale = float(program.radius.max(initial=0)) or 1.0
        free = program.radius > NARROW * scale
        G = sparse.csc_array(program.A[:, np.flatnonzero(free)])
        return cls(program, scale, free, G, program.slack / scale, program.radius[free] / scale)

    def candidate(self, z: Array, multipliers: Array) -> Candidate | None:
        if not np.isfinite(z).all():
            return None
        point = self.program.centre.copy()
        point[self.free] += self.scale * z
        return Candidate(point, multipliers)


class _Piqp:
    """PIQP, set up once; a new direction only changes the cost."""

    def __init__(self, program: LinearProgram) -> None:
        self._scaled = scaled = _Scaled.of(program)
        self._solver = piqp.SparseSolver()
        self._solver.settings.verbose = False
        size = int(scaled.free.sum())
        if size:
            nothing = sparse.csc_matrix((size, size))
            self._solver.setup(
                nothing, np.zeros(size), None, None, sparse.csc_matrix(scaled.G), None, scaled.h, -scaled.bound, scaled.bound
            )

    def maximize(self, objective: Array) -> Candidate | None:
        scaled = self._scaled
        if not scaled.free.any():
            return Candidate(scaled.program.centre, np.zeros(len(scaled.h)))
        self._solver.update(c=-objective[scaled.free])
        status = self._solver.solve()
        if status != piqp.PIQP_SOLVED:
            return None
        return scaled.candidate(self._solver.result.x, self._solver.result.z_u.copy())


class _Qpsolvers:
    """Any solver that qpsolvers knows; a new one each time."""

    def __init__(self, program: LinearProgram, solver: str) -> None:
        self._scaled = _Scaled.of(program)
        self._solver = solver

    def maximize(self, objective: Array) -> Candidate | None:
        scaled = self._scaled
        size = int(scaled.free.sum())
        if not size:
            return Candidate(scaled.program.centre, np.zeros(len(scaled.h)))
        problem = qpsolvers.Problem(
            sparse.csc_matrix((size, size)),
            -objective[scaled.free],
            sparse.csc_matrix(scaled.G),
            scaled.h,
            lb=-scaled.bound,
            ub=scaled.bound,
        )
        try:
            solution = qpsolvers.solve_problem(problem, solver=self._solver)
        except Exception:  # each solver has exceptions of its own; all mean that it gives up
            return None
        if not solution.found or solution.x is None or solution.z is None:
            return None
        return scaled.candidate(solution.x, np.asarray(solution.z, dtype=float))
