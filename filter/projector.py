"""Several projections of one program, by the way the caller chose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from filter.arrays import Array
from filter.exact import Walker, project_exactly
from filter.lp import LinearProgram
from filter.projection import HalfPlanes, Projection, Stop
from filter.search import project
from filter.solvers import deepest_point, workspace

EXACT = "exact"  # no solver: a walk over the vertices
# The solver of the search that stands in for a walk that is lost.
STAND_IN = "piqp"


@dataclass(frozen=True, eq=False)
class Projections:
    """What was found of a program.

    Attributes:
        found: One for each plane; none when the program is empty.
        contradiction: (r,) multipliers that prove that the program is empty, or None.
    """

    found: tuple[Projection, ...]
    contradiction: Array | None = None


def project_all(
    program: LinearProgram, planes: Sequence[Array], known: Sequence[HalfPlanes], solver: str, stop: Stop
) -> Projections:
    """Project a program onto several planes.

    Args:
        program: The polytope.
        planes: D (2, v) for each.
        known: For each, half-planes that contain the projection anyway.
        solver: "exact" for walks over the vertices, or the name of a solver for searches.
        stop: When a search ends.
    """
    broken = _broken_row(program)
    if broken is not None:
        return Projections((), broken)
    return _walked(program, planes, known, stop) if solver == EXACT else _searched(program, planes, known, solver, stop)


def _broken_row(program: LinearProgram) -> Array | None:
    """Return the multipliers of a row that no point of the box satisfies, or None: it is no row for a solver."""
    room = program.slack + abs(program.A) @ program.radius
    multipliers = np.zeros(len(room))
    if not len(room) or room.min() >= 0:
        return None
    multipliers[np.argmin(room)] = 1.0
    return multipliers if program.proves_empty(multipliers) else None


def _searched(
    program: LinearProgram, planes: Sequence[Array], known: Sequence[HalfPlanes], solver: str, stop: Stop
) -> Projections:
    deepest = deepest_point(program, solver)
    if deepest is not None and program.proves_empty(deepest.multipliers):
        return Projections((), deepest.multipliers)
    interior = program.centre if deepest is None else deepest.point
    one = workspace(program, solver)
    pairs = zip(planes, known, strict=True)
    return Projections(tuple(project(program, one, D, interior, stop=stop, known=lines) for D, lines in pairs))


def _walked(program: LinearProgram, planes: Sequence[Array], known: Sequence[HalfPlanes], stop: Stop) -> Projections:
    walker = Walker(program)
    if walker.contradiction is not None and program.proves_empty(walker.contradiction):
        return Projections((), walker.contradiction)
    shadows = [walker.shadow(D, stop) for D in planes]
    interior = _interior(program, [shadow.points for shadow in shadows if shadow])
    found = [
        shadow and project_exactly(program, shadow, D, interior, lines)
        for shadow, D, lines in zip(shadows, planes, known, strict=True)
    ]
    lost = [k for k, each in enumerate(found) if each is None]
    if lost:
        instead = _searched(program, [planes[k] for k in lost], [known[k] for k in lost], STAND_IN, stop)
        if instead.contradiction is not None:
            return instead
        found = [each or instead.found[lost.index(k)] for k, each in enumerate(found)]
    return Projections(tuple(each for each in found if each))


def _interior(program: LinearProgram, points: Sequence[Array]) -> Array | None:
    """Return the middle of the vertices (p, v) that were seen, if it is inside for sure; else the deepest point, or None."""
    if points:
        middle = np.asarray(np.concatenate(points).mean(axis=0))
        if program.holds(middle[None])[0]:
            return middle
    deepest = deepest_point(program, STAND_IN)
    return None if deepest is None else deepest.point
