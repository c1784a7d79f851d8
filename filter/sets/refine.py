"""Each robot's region: the projection of the team's polytope, cut with what is known of that robot alone.

The outer polygon's edges become rows themselves: that is how the team's knowledge survives pruning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from filter.arrays import Array, Integers
from filter.errors import Inconsistent
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.solvers import Solver
from filter.projection.budget import IsOver, never
from filter.projection.claims import Contradiction, Outlined, Outlines, in_order
from filter.projection.polygons_of import Stop, position
from filter.projection.projector import project_all
from filter.projection.team import project_windows
from filter.projection.walk import PROVED
from filter.projection.window import Window
from filter.sets.belief import Event, Fallback, Proof, Sources
from filter.sets.boxes import proved_boxes
from filter.sets.regions import Regions

Scope = Literal["team"] | Window

# A conflict is named by the multipliers above one of these shares of the greatest: the first that leaves a proof.
SHARES = (1e-2, 1e-4, 1e-6, 0.0)


def regions_at_a_glance(polytope: Polytope) -> Regions:
    """Return each robot's region from its own rows alone, without a search: larger, sound, nothing known from inside."""
    return _regions(polytope, Outlines.at_a_glance(polytope.of_robots(np.arange(len(polytope.lower)))))


def _regions(polytope: Polytope, outlines: Outlines) -> Regions:
    """Return outlines as regions, each edge with its causes."""
    edges, boxes = np.repeat(np.arange(len(outlines.behind)), np.diff(outlines.row_first)), np.zeros(0, dtype=np.int64)
    if len(polytope.origin):
        boxes = np.flatnonzero((outlines.behind < 0) & (outlines.behind != PROVED))
    cause = np.concatenate([polytope.constraints.source[outlines.row], polytope.origin[outlines.outer.owner[boxes]]])
    edge = np.concatenate([edges, boxes])
    first = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(np.bincount(edge, minlength=len(outlines.behind)))])
    order = np.argsort(edge, kind="stable")
    return Regions(outlines.outer, outlines.inner, outlines.searches, outlines.reasons, cause[order], first)


@dataclass(frozen=True, eq=False)
class Searched:
    """What a search of every robot's region gave.

    Attributes:
        polytope: With the regions' edges as the only rows on single robots and with the regions' boxes.
        regions: (n) where each robot is.
        sources: The table, with the regions entered.
        events: Where solvers failed.
        proofs: Of every edge, then of every side of the boxes.
    """

    polytope: Polytope
    regions: Regions
    sources: Sources
    events: tuple[Event, ...]
    proofs: tuple[Proof, ...]


def searched(
    time: float,
    polytope: Polytope,
    sources: Sources,
    solvers: Sequence[Solver],
    *,
    stop: Stop,
    scope: Scope = "team",
    is_over: IsOver = never,
    threads: int | None = None,
) -> Searched:
    """Search every robot's region in the whole team's polytope, or in the robot's window of it.

    The solvers are asked in turn, the next one where an answer is no good. If none is good, the best of what they prove
    is taken; with what was propagated it is always a region, only a larger one. Those whose regions were refined longest
    ago come first: when time is up, the others' regions are what is known of them at a glance.

    Raises:
        Inconsistent: The polytope is proved to be empty.
    """
    robots = np.arange(len(polytope.lower))
    order = np.argsort(sources.time[polytope.origin], kind="stable") if len(polytope.origin) else robots
    if isinstance(scope, Window):
        found = project_windows(polytope, scope, solvers, stop, order=order, is_over=is_over, threads=threads)
    else:
        found = _in_the_team(polytope, order, solvers, stop, is_over)
    if isinstance(found, Contradiction):
        conflict = _conflict(polytope, found.multipliers)
        conflict = conflict[np.argsort(sources.time[conflict], kind="stable")]
        raise Inconsistent(f"at {time} s", [sources[number] for number in conflict.tolist()])
    table, numbers = sources.extended("region", time, robots)
    outlines = found.outlines
    refined = np.array([reason != "time" or not len(polytope.origin) for reason in outlines.reasons], dtype=bool)
    alone = np.full(len(robots), WORLD)
    own, row = edges_as_rows(polytope, outlines, (alone, robots), numbers)
    lower, upper, boxes = proved_boxes(polytope, table, outlines.outer, (own, row), np.flatnonzero(refined))
    pairs = polytope.constraints.select(polytope.constraints.i != WORLD)
    origin = np.where(refined, numbers, polytope.origin if len(polytope.origin) else numbers)
    smaller = Polytope(Constraints.concatenate([pairs, own]), lower, upper, origin)
    events = tuple(Fallback(each.plane, each.failed, each.used) for each in found.failures)
    edges = proof_of(polytope, sources, outlines, (alone, robots))
    return Searched(smaller, _regions(polytope, outlines), table, events, (edges, boxes))


def _in_the_team(
    polytope: Polytope, order: Integers, solvers: Sequence[Solver], stop: Stop, is_over: IsOver
) -> Outlined | Contradiction:
    robots, rows = len(polytope.lower), polytope.constraints
    own = [rows.rows_of(WORLD, robot) for robot in order.tolist()]
    known, planes = [(rows.normal[each], rows.offset[each]) for each in own], [position(robot, robots) for robot in order]
    found = project_all(polytope.program(), planes, known, solvers, stop, is_over=is_over)
    if found.contradiction is not None:
        return Contradiction(found.contradiction)
    reached = np.array([each is not None for each in found.found], dtype=bool)
    pieces = [
        (order[reached], Outlines.of(polytope, order[reached], found.complete)),
        (order[~reached], Outlines.at_a_glance(polytope.of_robots(order[~reached]), "time")),
    ]
    failures = (replace(each, plane=None if each.plane is None else int(order[each.plane])) for each in found.failures)
    return Outlined(in_order(pieces), tuple(failures))


def edges_as_rows(
    polytope: Polytope, outlines: Outlines, whose: tuple[Integers, Integers], numbers: Integers
) -> tuple[Constraints, Integers]:
    """Return the outlines' edges as rows, and which row (e,) each edge is; -1 for the sides of boxes.

    Args:
        polytope: What the outlines are of.
        outlines: (n) of robots or pairs.
        whose: i and j (n) of each.
        numbers: (n,) the sources of edges that were proved anew; rows that were known keep theirs.
    """
    is_row = (outlines.behind >= 0) | (outlines.behind == PROVED)
    owner, behind = outlines.outer.owner[is_row], outlines.behind[is_row]
    source = numbers[owner]
    source[behind >= 0] = polytope.constraints.source[behind[behind >= 0]]
    normals, offsets = outlines.outer.normals[is_row], outlines.outer.offsets[is_row]
    rows = Constraints(whose[0][owner], whose[1][owner], normals, offsets, source)
    return rows, np.where(is_row, np.cumsum(is_row) - 1, -1)


def proof_of(polytope: Polytope, sources: Sources, outlines: Outlines, whose: tuple[Integers, Integers]) -> Proof:
    """Return why every edge holds, of outlines of robots or pairs i, j."""
    outer, claim = outlines.outer, np.repeat(np.arange(len(outlines.behind)), np.diff(outlines.row_first))
    i, j = (each[outer.owner] for each in whose)
    return Proof(polytope, sources, i, j, outer.normals, outer.offsets, claim, outlines.row, outlines.multiplier)


def _conflict(polytope: Polytope, multipliers: Array) -> Integers:
    """Return the numbers of the sources of a Farkas certificate (r,), of as few rows as still prove it."""
    program = polytope.program()
    kept = (np.where(multipliers > share * multipliers.max(), multipliers, 0) for share in SHARES)
    proof = next((weights for weights in kept if program.proves_empty(weights)), multipliers)
    return np.unique(polytope.constraints.source[proof > 0])
