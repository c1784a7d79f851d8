"""Several projections of one program, by the ways the caller chose: where one fails, by the next."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import takewhile

import numpy as np

from filter.arrays import Array
from filter.linear.program import LinearProgram
from filter.linear.solvers import Candidate, Chain, Solver, deepest_point, name_of
from filter.projection.budget import IsOver, never
from filter.projection.exact import Walker, project_exactly
from filter.projection.polygons_of import HalfPlanes, Projection, Stop
from filter.projection.search import project
from filter.projection.simplex import MOST

EXACT = "exact"  # no solver: a walk over the vertices
# Where what is proved differs from what a solver found by more than this share of the box, another solver is asked.
LOOSE = 1e-3
# The inverse that a walk takes along is dense. Beyond so many coordinates a search in the sparse program is cheaper.
LARGEST = 100


@dataclass(frozen=True)
class Failure:
    """Answers that were no good.

    Attributes:
        plane: Of which projection, or None for the deepest point.
        failed: Whose, in the order they were asked.
        used: Whose answers were good, or None.
    """

    plane: int | None
    failed: tuple[str, ...]
    used: str | None


@dataclass(frozen=True, eq=False)
class Projections:
    """What was found of a program.

    Attributes:
        found: One for each plane, or None for those that time ran out on; none when the program is empty.
        failures: Where solvers failed.
        contradiction: (r,) multipliers that prove that the program is empty, or None.
    """

    found: tuple[Projection | None, ...] = ()
    failures: tuple[Failure, ...] = ()
    contradiction: Array | None = None

    @property
    def complete(self) -> tuple[Projection, ...]:
        """Those that time did not run out on."""
        return tuple(each for each in self.found if each is not None)


def project_all(
    program: LinearProgram,
    planes: Sequence[Array],
    known: Sequence[HalfPlanes],
    solvers: Sequence[Solver],
    stop: Stop,
    *,
    is_over: IsOver = never,
) -> Projections:
    """Project a program onto several planes.

    The solvers are asked in turn, the next one where an answer is no good. If none is good, the best of what they prove
    is taken; with what is known anyway it is always a region, only a larger one.

    Args:
        program: The polytope.
        planes: D (2, v) for each.
        known: For each, half-planes that contain the projection anyway.
        solvers: What searches; the first may be "exact", for walks over the vertices.
        stop: When a projection is good enough.
        is_over: Whether time is up, and the planes that are left have to do without.
    """
    broken = broken_row(program)
    if broken is not None:
        return Projections(contradiction=broken)
    if EXACT not in solvers[:1]:
        return _searched(program, planes, known, solvers, stop, is_over=is_over)
    if not _is_walkable(program) and solvers[1:]:
        return _searched(program, planes, known, solvers[1:], stop, is_over=is_over)
    walker = Walker(program)
    if walker.contradiction is not None and program.proves_empty(walker.contradiction):
        return Projections(contradiction=walker.contradiction)
    return _walked(walker, planes, known, solvers, stop, is_over=is_over)


def _is_walkable(program: LinearProgram) -> bool:
    """Return whether a walk can be made, and is cheaper than a search."""
    return len(program.lower) <= LARGEST and int(np.diff(program.A.indptr).max(initial=0)) <= MOST


def broken_row(program: LinearProgram) -> Array | None:
    """Return the multipliers of a row that no point of the box satisfies, or None: it is no row for a solver."""
    room = program.slack + abs(program.A) @ program.radius
    multipliers = np.zeros(len(room))
    if not len(room) or room.min() >= 0:
        return None
    multipliers[np.argmin(room)] = 1.0
    return multipliers if program.proves_empty(multipliers) else None


def _walked(
    walker: Walker,
    planes: Sequence[Array],
    known: Sequence[HalfPlanes],
    solvers: Sequence[Solver],
    stop: Stop,
    *,
    is_over: IsOver,
) -> Projections:
    program = walker.program
    shadows = [walker.shadow(D, stop) for D in takewhile(lambda _: not is_over(), planes)]
    planes, late = planes[: len(shadows)], (None,) * (len(planes) - len(shadows))
    middle = _middle(program, [shadow.points for shadow in shadows if shadow])
    inside = _Interior(middle) if middle is not None else _interior(program, solvers[1:])
    if inside.contradiction is not None:  # a set that is empty by less than a walk can see
        return Projections(contradiction=inside.contradiction)
    trios = zip(shadows, planes, known, strict=False)
    found = [project_exactly(program, shadow, D, inside.point, lines) if shadow else None for shadow, D, lines in trios]
    lost = [k for k, each in enumerate(found) if each is None]
    if not lost:
        return Projections((*found, *late), inside.failures)
    instead = _searched(program, [planes[k] for k in lost], [known[k] for k in lost], solvers[1:], stop, inside=inside)
    used = {failure.plane: failure for failure in instead.failures if failure.plane is not None}
    failures = list(inside.failures)
    for place, k in enumerate(lost):
        failed = used.get(place, Failure(place, (), name_of(solvers[1]) if solvers[1:] else None))
        failures.append(Failure(k, (EXACT, *failed.failed), failed.used))
        found[k] = instead.found[place]
    return Projections((*found, *late), tuple(failures))


def _middle(program: LinearProgram, points: Sequence[Array]) -> Array | None:
    """Return the middle of the vertices (p, v) that were seen, if it is inside for sure."""
    middle = np.concatenate(points).mean(axis=0) if points else program.centre
    return middle if program.holds(middle[None])[0] else None


@dataclass(frozen=True, eq=False)
class _Interior:
    point: Array
    contradiction: Array | None = None
    failures: tuple[Failure, ...] = ()


def _interior(program: LinearProgram, solvers: Sequence[Solver]) -> _Interior:
    """Return the first point that is proved to be inside, or at least some point, or a proof that there is none."""
    points = [program.centre]
    failed: list[str] = []
    for solver in solvers:
        found = deepest_point(program, solver)
        if found is not None and program.proves_empty(found.multipliers):
            return _Interior(found.point, found.multipliers)
        if found is not None and program.holds(found.point[None])[0]:
            return _Interior(found.point, None, (Failure(None, tuple(failed), name_of(solver)),) if failed else ())
        points += [found.point] if found is not None else []
        failed.append(name_of(solver))
    return _Interior(points[-1], None, (Failure(None, tuple(failed), None),) if failed else ())


def _searched(
    program: LinearProgram,
    planes: Sequence[Array],
    known: Sequence[HalfPlanes],
    solvers: Sequence[Solver],
    stop: Stop,
    *,
    inside: _Interior | None = None,
    is_over: IsOver = never,
) -> Projections:
    inside = inside or _interior(program, solvers)
    if inside.contradiction is not None:
        return Projections(contradiction=inside.contradiction)
    chain = Chain(program, solvers)
    found, failures = list[Projection | None](), list(inside.failures)
    for k, (D, lines) in enumerate(zip(planes, known, strict=True)):
        if is_over():
            found.append(None)
            continue
        one, failed, used = _projected(chain, D, lines, inside.point, stop)
        found.append(one)
        failures += [Failure(k, failed, used)] if failed else []
    return Projections(tuple(found), tuple(failures))


def _projected(
    chain: Chain, D: Array, known: HalfPlanes, interior: Array, stop: Stop
) -> tuple[Projection, tuple[str, ...], str | None]:
    """Return a projection by the first solver whose answers are good, or the least one of all; who failed; who did not."""
    tried: list[Projection] = []
    failed: list[str] = []
    for name, solver in chain:
        found = project(chain.program, solver, D, interior, stop=stop, known=known)
        if found.looseness <= LOOSE:
            return found, tuple(failed), name
        tried.append(found)
        failed.append(name)
    tried = tried or [project(chain.program, _Nobody(), D, interior, stop=stop, known=known)]
    return min(tried, key=lambda one: one.outer.area), tuple(failed), None


class _Nobody:
    """Stands where there is no solver."""

    def maximize(self, objective: Array) -> Candidate | None:  # noqa: ARG002
        return None
