"""Projections by solvers, for those who chose them and where a walk is lost: where one fails, by the next."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from filter.arrays import Array
from filter.linear.program import LinearProgram
from filter.linear.solvers import Solver, Workspace, deepest_point, name_of, workspace
from filter.projection.proved import HalfPlanes, Projection
from filter.projection.search import project
from filter.projection.stop import IsOver, Stop, never
from filter.records.names import InWords

# Where what is proved differs from what a solver found by more than this share of the box, another solver is asked.
LOOSE = 1e-3


@dataclass(frozen=True)
class Fallback(InWords):
    """A walk was lost, or a solver's answers were no good, and others were asked for.

    Attributes:
        robot: Whose region was searched, or None for the deepest point of the whole team.
        failed: The "walk" and the solvers whose answers were no good, in the order they were asked.
        used: The solver whose answers were good, or None: what is proved anyway, and what was propagated, has to do.
        seen_from: The other robot of a pair, if it was the region of one seen from the other.
    """

    robot: int | None
    failed: tuple[str, ...]
    used: str | None
    seen_from: int | None = None

    def _in_words(self, words: Callable[[Any], str]) -> str:
        what = "the deepest point" if self.robot is None else f"the region of {words(self.robot)}"
        what += "" if self.seen_from is None else f" seen from {words(self.seen_from)}"
        return f"{what}: no good answer of {', '.join(self.failed)}, {self.used or 'nobody'} took over"


@dataclass(frozen=True, eq=False)
class Found:
    """What solvers found of a program.

    Attributes:
        point: (v,) proved to be inside, or else at least some point [m].
        contradiction: (r,) multipliers that prove that the program is empty, or None.
        failures: Where solvers failed; whose region it was is the place of the projection.
        complete: The projections that time did not run out on, in the order they were asked for; none of an empty program.
    """

    point: Array
    contradiction: Array | None = None
    failures: tuple[Fallback, ...] = ()
    complete: tuple[Projection, ...] = ()


def project_all(
    program: LinearProgram,
    planes: Sequence[Array],
    known: Sequence[HalfPlanes],
    solvers: Sequence[Solver],
    stop: Stop,
    *,
    before: Sequence[str] = (),
    is_over: IsOver = never,
) -> Found:
    """Search several projections of a program, each by some D (2, v).

    Known are half-planes that contain each projection anyway: without any good answer it is a region, too. The solvers are
    asked in turn, the next one where an answer is no good; if none is, the least region counts. What has failed `before` is
    told with each projection. When time is over, those that are left have to do without.
    """
    broken = broken_row(program)
    inside = interior(program, solvers) if broken is None else Found(program.centre, broken)
    if inside.contradiction is not None:
        return inside
    workspaces: list[Workspace | None] = [workspace(program, solver) for solver in solvers] or [None]
    complete, failures = list[Projection](), inside.failures
    for D, lines in zip(planes, known, strict=True):
        if is_over():
            break
        tried = list[Projection]()
        for work in workspaces:
            tried.append(project(program, work, D, inside.point, stop=stop, known=lines, is_over=is_over))
            if tried[-1].looseness <= LOOSE:
                break
        is_good, failed = tried[-1].looseness <= LOOSE, [*before, *map(name_of, solvers[: len(tried)])]
        used = failed.pop() if is_good else None
        failures += _told(len(complete), failed, used)
        complete.append(tried[-1] if is_good else min(tried, key=lambda one: one.outer.area))
    return replace(inside, failures=failures, complete=tuple(complete))


def broken_row(program: LinearProgram) -> Array | None:
    """Return the multipliers of a row that no point of the box satisfies, or None: it is no row for a solver."""
    room, multipliers = program.slack + abs(program.A) @ program.radius, np.zeros(len(program.b))
    multipliers[np.argsort(room, kind="stable")[:1]] = 1.0
    return multipliers if program.proves_empty(multipliers) else None


def interior(program: LinearProgram, solvers: Sequence[Solver]) -> Found:
    """Return the first point that is proved to be inside, or at least some point, or a proof that there is none."""
    point, failed = program.centre, list[str]()
    for solver in solvers:
        found = deepest_point(program, solver)
        if found is not None:
            point = found.point
            if program.proves_empty(found.multipliers):
                return Found(point, found.multipliers)
            if program.holds(point[None])[0]:
                return Found(point, None, _told(None, failed, name_of(solver)))
        failed.append(name_of(solver))
    return Found(point, None, _told(None, failed, None))


def _told(which: int | None, failed: Sequence[str], used: str | None) -> tuple[Fallback, ...]:
    return (Fallback(which, tuple(failed), used),) if failed else ()
