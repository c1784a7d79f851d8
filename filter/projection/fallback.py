"""Projections by solvers, for those who chose them and where a walk is lost: where one fails, by the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from filter.arrays import Array
from filter.linear.program import LinearProgram
from filter.linear.solvers import Candidate, Solver, Workspaces, deepest_point, name_of
from filter.projection.proved import HalfPlanes, Projection
from filter.projection.search import project
from filter.projection.stop import IsOver, Stop, never

# Where what is proved differs from what a solver found by more than this share of the box, another solver is asked.
LOOSE = 1e-3


@dataclass(frozen=True)
class Failure:
    """Answers that were no good.

    Attributes:
        which: Of which projection, or None for the deepest point.
        failed: Whose, in the order they were asked.
        used: Whose answers were good, or None.
    """

    which: int | None
    failed: tuple[str, ...]
    used: str | None


@dataclass(frozen=True, eq=False)
class Found:
    """What was found of a program.

    Attributes:
        projections: One for each that was asked for, or None for those that time ran out on; none when the program is empty.
        failures: Where solvers failed.
        contradiction: (r,) multipliers that prove that the program is empty, or None.
    """

    projections: tuple[Projection | None, ...] = ()
    failures: tuple[Failure, ...] = ()
    contradiction: Array | None = None

    @property
    def complete(self) -> tuple[Projection, ...]:
        """Those that time did not run out on."""
        return tuple(each for each in self.projections if each is not None)


def project_all(
    program: LinearProgram,
    planes: Sequence[Array],
    known: Sequence[HalfPlanes],
    solvers: Sequence[Solver],
    stop: Stop,
    *,
    is_over: IsOver = never,
) -> Found:
    """Search several projections of a program.

    The solvers are asked in turn, the next one where an answer is no good. If none is good, the best of what they prove
    is taken; with what is known anyway it is always a region, only a larger one.

    Args:
        program: The polytope.
        planes: D (2, v) for each.
        known: For each, half-planes that contain the projection anyway.
        solvers: What searches.
        stop: When a projection is good enough.
        is_over: Whether time is up, and the projections that are left have to do without.
    """
    broken = broken_row(program)
    inside = Interior(program.centre, broken) if broken is not None else interior(program, solvers)
    if inside.contradiction is not None:
        return Found(contradiction=inside.contradiction)
    workspaces, failures = Workspaces(program, solvers), list(inside.failures)
    found = list[Projection | None]()
    for k, (D, lines) in enumerate(zip(planes, known, strict=True)):
        if is_over():
            found.append(None)
            continue
        one, failed, used = _projected(workspaces, D, lines, inside.point, stop=stop, is_over=is_over)
        found.append(one)
        failures += [Failure(k, failed, used)] if failed else []
    return Found(tuple(found), tuple(failures))


def broken_row(program: LinearProgram) -> Array | None:
    """Return the multipliers of a row that no point of the box satisfies, or None: it is no row for a solver."""
    room = program.slack + abs(program.A) @ program.radius
    multipliers = np.zeros(len(room))
    if not len(room) or room.min() >= 0:
        return None
    multipliers[np.argmin(room)] = 1.0
    return multipliers if program.proves_empty(multipliers) else None


@dataclass(frozen=True, eq=False)
class Interior:
    """What solvers say of a program's inside.

    Attributes:
        point: (v,) proved to be inside, or else at least some point [m].
        contradiction: (r,) multipliers that prove that there is none, or None.
        failures: Where solvers failed.
    """

    point: Array
    contradiction: Array | None = None
    failures: tuple[Failure, ...] = ()


def interior(program: LinearProgram, solvers: Sequence[Solver]) -> Interior:
    """Return the first point that is proved to be inside, or at least some point, or a proof that there is none."""
    points = [program.centre]
    failed: list[str] = []
    for solver in solvers:
        found = deepest_point(program, solver)
        if found is not None and program.proves_empty(found.multipliers):
            return Interior(found.point, found.multipliers)
        if found is not None and program.holds(found.point[None])[0]:
            return Interior(found.point, None, (Failure(None, tuple(failed), name_of(solver)),) if failed else ())
        points += [found.point] if found is not None else []
        failed.append(name_of(solver))
    return Interior(points[-1], None, (Failure(None, tuple(failed), None),) if failed else ())


def _projected(
    workspaces: Workspaces, D: Array, known: HalfPlanes, inside: Array, *, stop: Stop, is_over: IsOver
) -> tuple[Projection, tuple[str, ...], str | None]:
    """Return a projection by the first solver whose answers are good, or the least one of all; who failed; who did not."""
    tried: list[Projection] = []
    failed: list[str] = []
    for name, solver in workspaces:
        found = project(workspaces.program, solver, D, inside, stop=stop, known=known, is_over=is_over)
        if found.looseness <= LOOSE:
            return found, tuple(failed), name
        tried.append(found)
        failed.append(name)
    tried = tried or [project(workspaces.program, _Nobody(), D, inside, stop=stop, known=known)]
    return min(tried, key=lambda one: one.outer.area), tuple(failed), None


class _Nobody:
    """Stands where there is no solver."""

    def maximize(self, objective: Array) -> Candidate | None:  # noqa: ARG002
        return None
