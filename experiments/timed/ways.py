"""Ways to project a window onto one robot, to be timed side by side; each answers with an area."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from importlib import import_module
from importlib.util import find_spec
from typing import Any

import numpy as np

from filter.arrays import Array
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.linear.program import LinearProgram
from filter.linear.solvers import SIMPLEX, Workspace, workspace
from filter.projection.proved import position
from filter.projection.search import project
from filter.projection.sheet import Sheet, Task, blank
from filter.projection.stop import Stop
from filter.projection.walk import project_some
from filter.projection.window import Window, links

SEARCH = Stop()  # the filter's own
EXACT = Stop(performance_ratio=1.0, searches=400)
POLYTOPE = "polytope"
TURN = 2.4  # [rad]


@dataclass(frozen=True, eq=False)
class Problem:
    """A window, and the robot in it that is projected onto.

    Attributes:
        polytope: What the window knows.
        robot: Whose region is wanted.
    """

    polytope: Polytope
    robot: int

    @cached_property
    def program(self) -> LinearProgram:
        """The window's linear program."""
        return self.polytope.program()

    @cached_property
    def plane(self) -> Array:
        """(2, v) the projection."""
        return position(self.robot, len(self.polytope.lower))

    def solver(self, name: str) -> Workspace:
        """Return a solver on the program after its first solve."""
        made = workspace(self.program, name)
        made.maximize(self.plane[0])
        return made

    def task(self, stop: Stop, *, inside: bool = False) -> Task:
        """Return the window as the compiled code takes it, for outer polygons, or inner ones, too."""
        rows, box = self.polytope.constraints, (self.polytope.lower, self.polytope.upper)
        who, window = links(rows, len(self.polytope.lower)), Window.everybody()
        return Task(window.hops, window.robots, inside, stop.goal, who, rows.rows, box)


def by_kernel(problem: Problem, task: Task) -> Sheet:
    """Walk around the shadow in compiled code, certify, simplify and cut: all that the filter does for a window."""
    i, j = np.array([WORLD]), np.array([problem.robot])
    begin, end = problem.polytope.constraints.groups(i, j)
    sheet = blank(end - begin, task)
    project_some((i, j), (begin, end), problem.polytope.around(i, j), task, sheet)
    return sheet


def by_search(problem: Problem, solver: Workspace) -> None:
    """Search, on a solver that is set up."""
    project(problem.program, solver, problem.plane, problem.program.centre, stop=SEARCH)


class Solves:
    """One solve after the other, each for a direction a good turn from the last: what a search asks for."""

    def __init__(self, solver: Workspace, plane: Array) -> None:
        self._solver, self._plane, self._angle = solver, plane, 0.0

    def __call__(self) -> None:
        """Solve for the next direction."""
        self._angle += TURN
        self._solver.maximize(np.cos(self._angle) * self._plane[0] + np.sin(self._angle) * self._plane[1])


def by_polytope(problem: Problem) -> None:
    """Project by the package `polytope`, by its iterative hull, which starts its solver anew for each direction."""
    package = import_module(POLYTOPE)
    program, count = problem.program, len(problem.program.lower)
    A = np.vstack([program.A.toarray(), np.eye(count), -np.eye(count)])
    b = np.concatenate([program.b, program.upper, -program.lower])
    axes = [2 * problem.robot + 1, 2 * problem.robot + 2]  # it counts from 1
    package.projection(package.Polytope(A, b), axes, solver="iterhull")


def ways(problem: Problem) -> dict[str, Callable[[], Any]]:
    """Return the ways by name, ready to be timed; what does not depend on the direction is set up, where there is such."""
    task, piqp, simplex = problem.task(SEARCH), problem.solver("piqp"), problem.solver(SIMPLEX)
    inside = problem.task(SEARCH, inside=True)
    found: dict[str, Callable[[], Any]] = {
        "piqp_solve": Solves(piqp, problem.plane),
        "highs_warm_solve": Solves(simplex, problem.plane),
        "kernel": lambda: by_kernel(problem, task),
        "kernel_inside": lambda: by_kernel(problem, inside),
        "piqp_search": lambda: by_search(problem, piqp),
        "highs_warm_search": lambda: by_search(problem, simplex),
    }
    return found | ({POLYTOPE: lambda: by_polytope(problem)} if find_spec(POLYTOPE) else {})
