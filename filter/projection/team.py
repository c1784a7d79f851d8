"""Robots and pairs projected in their windows, on many threads; what each finds does not depend on how many there are."""

from __future__ import annotations

import os
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.convex import side_of_box
from filter.geometry.polygons import Polygons, joined
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.solvers import Solver, name_of
from filter.projection.budget import IsOver, never
from filter.projection.claims import Contradiction, Outlined, Outlines, in_order
from filter.projection.polygons_of import Stop, position
from filter.projection.projector import EXACT, Failure, Projections, broken_row, project_all
from filter.projection.shadow import REASONS
from filter.projection.walk import PROVED, Task, Windowed, project_window
from filter.projection.window import Boxes, Links, Window, box_around, links, members_of, rows_in

# So many windows at most are projected between two looks at the clock, and so many at least by a thread, or it is not worth it.
TOGETHER, WORTH_A_THREAD = 64, 8


class Sheet(NamedTuple):
    """What was found in some windows, end to end: the columns of `Outlines`.

    Attributes:
        normals: (e, 2)
        offsets: (e,) [m].
        vertices: (e, 2) [m].
        margin: (k,) [m].
        first: (k + 1,) where the edges of each begin; one without edges was lost.
        behind: (e,)
        row: (m,) with room to spare at its end.
        multiplier: (m,)
        row_first: (e + 1,)
        searches: (k,)
        why: (k,) a place in `REASONS`.
    """

    normals: Array
    offsets: Array
    vertices: Array
    margin: Array
    first: Integers
    behind: Integers
    row: Integers
    multiplier: Array
    row_first: Integers
    searches: Integers
    why: Integers


@compiled
def project_some(i: Integers, j: Integers, task: Task) -> Sheet:
    """Project the windows of some pairs i, j, or of robots j where i is WORLD."""
    place = np.full(len(task.box[0]), -1)
    return laid_out([project_window(i[k], j[k], task, place) for k in range(len(j))], i, j, task.box)


@compiled
def laid_out(windows: list[Windowed], i: Integers, j: Integers, box: Boxes) -> Sheet:
    """Return what was found in some windows, end to end."""
    edges, claims = 0, 0
    for one in windows:
        edges += len(one.behind)
        claims += one.rows.size + len(one.own)
    sheet = Sheet(
        np.empty((edges, 2)),
        np.empty(edges),
        np.empty((edges, 2)),
        np.empty(len(windows)),
        np.zeros(len(windows) + 1, dtype=np.int64),
        np.empty(edges, dtype=np.int64),
        np.empty(claims, dtype=np.int64),
        np.empty(claims),
        np.zeros(edges + 1, dtype=np.int64),
        np.empty(len(windows), dtype=np.int64),
        np.empty(len(windows), dtype=np.int64),
    )
    for k in range(len(windows)):
        _lay(windows[k], sheet, k, box_around(i[k], j[k], box))
    return sheet


@compiled
def _lay(one: Windowed, sheet: Sheet, k: int, box: tuple[Array, Array]) -> None:
    """Add what was found in one window."""
    at, searches = sheet.first[k], len(one.rows)
    sheet.margin[k], sheet.searches[k], sheet.why[k] = one.margin, searches, one.why
    for vertex, line in zip(one.vertices, one.behind):  # noqa: B905, as it is compiled
        claim = sheet.row_first[at]
        sheet.vertices[at] = vertex
        if line < 0:
            sheet.behind[at] = line
            sheet.normals[at, 0], sheet.normals[at, 1], sheet.offsets[at] = side_of_box(line, box[0], box[1])
        else:
            sheet.normals[at], sheet.offsets[at] = one.lines[0][line], one.lines[1][line]
            sheet.behind[at] = PROVED if line < searches else one.own[line - searches]
        if line >= searches:
            sheet.row[claim], sheet.multiplier[claim] = one.own[line - searches], 1.0
            claim += 1
        elif line >= 0:
            for m in range(one.rows.shape[1]):
                if one.rows[line, m] >= 0:
                    sheet.row[claim], sheet.multiplier[claim] = one.rows[line, m], one.prices[line, m]
                    claim += 1
        at += 1
        sheet.row_first[at] = claim
    sheet.first[k + 1] = at


def project_windows(
    polytope: Polytope,
    window: Window,
    solvers: Sequence[Solver],
    stop: Stop,
    *,
    order: Integers | None = None,
    is_over: IsOver = never,
    threads: int | None = None,
) -> Outlined | Contradiction:
    """Project every robot of the team in its own window; what is proved there holds in the whole team.

    Nothing is known from inside: a point that the window allows may be impossible in the team.

    Args:
        polytope: The team's.
        window: How far a window reaches.
        solvers: What searches; the first may be "exact", for walks over the vertices.
        stop: When a projection is good enough.
        order: (n,) who comes first; all robots once. None for the order of their numbers.
        is_over: Whether time is up; the robots that are left keep what is known of them at a glance.
        threads: How many windows at a time; None for as many as there are cores.
    """
    robots = len(polytope.lower)
    broken = broken_row(polytope.program()) if polytope.may_have_a_broken_row() else None
    if broken is not None:
        return Contradiction(broken)
    who, order = links(polytope.constraints, robots), np.arange(robots) if order is None else order
    pieces, left, failures = list[tuple[Integers, Outlines]](), order, list[Failure]()
    if solvers[0] == EXACT:
        walks = _Walks(np.full(robots, WORLD), order, _task(polytope, window, who, stop), is_over, threads)
        pieces, left = [(order[walks.done], walks.outlines)], order[walks.left]
    late = []
    for robot in left.tolist():
        if is_over():
            late.append(robot)
            continue
        alone = _searched(polytope, who, robot, window, solvers, stop=stop)
        if alone.contradiction is not None:
            return Contradiction(alone.contradiction)
        pieces.append((np.array([robot]), Outlines.of(polytope, np.array([robot]), alone.complete)))
        failures += alone.failures
    unrefined = np.array(late, dtype=np.int64)
    pieces.append((unrefined, Outlines.at_a_glance(polytope.of_robots(unrefined), "time")))
    return Outlined(in_order(pieces), tuple(failures))


def project_pairs(
    polytope: Polytope,
    pairs: tuple[Integers, Integers],
    window: Window,
    stop: Stop,
    *,
    is_over: IsOver = never,
    threads: int | None = None,
) -> Outlined:
    """Project pairs, x_j - x_i, each in the window of the two; those that are lost or too late keep what their rows say.

    Args:
        polytope: The team's.
        pairs: i and j (g) of each, i < j.
        window: How far a window reaches.
        stop: When a projection is good enough.
        is_over: Whether time is up.
        threads: How many windows at a time; None for as many as there are cores.
    """
    i, j = pairs
    task = _task(polytope, window, links(polytope.constraints, len(polytope.lower)), stop)
    walks = _Walks(i, j, task, is_over, threads)
    glance = Outlines.at_a_glance(polytope.of(i[walks.left], j[walks.left]), "time")
    outlines = in_order([(walks.done, walks.outlines), (walks.left, glance)])
    return Outlined(outlines, tuple(Failure(int(k), (EXACT,), None) for k in walks.lost))


def _task(polytope: Polytope, window: Window, who: Links, stop: Stop) -> Task:
    goal = float(stop.performance_ratio), float(stop.area_gap), int(stop.searches)
    return Task(window.hops, window.robots, who, polytope.constraints.columns, (polytope.lower, polytope.upper), goal)


class _Walks:
    """The walks around (g) pairs i, j, or robots j where i is WORLD.

    Attributes:
        done: Whose time came.
        outlines: What was found of them; without edges where a walk was lost.
        lost: Whose walk was lost.
        left: Those that time ran out on, then those that were lost.
    """

    def __init__(self, i: Integers, j: Integers, task: Task, is_over: IsOver, threads: int | None) -> None:
        workers = threads or os.cpu_count() or 1
        size = min(TOGETHER, max(WORTH_A_THREAD, -(-len(j) // workers)))
        chunks = [np.arange(k, min(k + size, len(j))) for k in range(0, len(j), size)]

        def projected(chunk: Integers) -> Sheet | None:
            return None if is_over() else project_some(i[chunk], j[chunk], task)

        if workers == 1 or len(chunks) <= 1:
            sheets = [projected(chunk) for chunk in chunks]
        else:
            with ThreadPoolExecutor(workers) as pool:
                sheets = list(pool.map(projected, chunks))
        nobody = np.zeros(0, dtype=np.int64)
        done = [(chunk, sheet) for chunk, sheet in zip(chunks, sheets, strict=True) if sheet]
        late = [chunk for chunk, sheet in zip(chunks, sheets, strict=True) if not sheet]
        self.done = np.concatenate([nobody, *(chunk for chunk, _ in done)])
        self.outlines = _outlines([project_some(nobody, nobody, task), *(sheet for _, sheet in done)])
        self.lost = self.done[np.diff(self.outlines.outer.first) == 0]
        self.left = np.concatenate([*late, self.lost])


def _outlines(sheets: Sequence[Sheet]) -> Outlines:
    every = Sheet(*(np.concatenate(column) for column in zip(*sheets, strict=True)))
    used = [sheet.row_first[-1] for sheet in sheets]  # the rest of row and multiplier is room to spare
    row = np.concatenate([sheet.row[:count] for sheet, count in zip(sheets, used, strict=True)])
    multiplier = np.concatenate([sheet.multiplier[:count] for sheet, count in zip(sheets, used, strict=True)])
    first = joined([sheet.first for sheet in sheets])
    row_first = joined([sheet.row_first for sheet in sheets])
    outer = Polygons(every.normals, every.offsets, every.vertices, every.margin, first)
    reasons, nothing = tuple(REASONS[why] for why in every.why.tolist()), (None,) * len(every.why)
    return Outlines(outer, every.behind, row, multiplier, row_first, nothing, every.searches, reasons)


def _searched(
    polytope: Polytope, who: Links, robot: int, window: Window, solvers: Sequence[Solver], *, stop: Stop
) -> Projections:
    """Project one robot's window by the solvers that are left when a walk is lost."""
    rows, place = polytope.constraints, np.full(len(polytope.lower), -1)
    members = np.sort(members_of(WORLD, robot, window.hops, window.robots, who.near, who.near_first, place))
    place[members] = np.arange(len(members))
    number = rows_in(members, place, who)
    i = np.where(rows.i[number] == WORLD, WORLD, place[rows.i[number]])
    few = Constraints(i, place[rows.j[number]], rows.normal[number], rows.offset[number], rows.source[number])
    own = who.own[who.own_first[robot] : who.own_first[robot + 1]]
    program = Polytope(few, polytope.lower[members], polytope.upper[members]).program()
    plane, known = position(int(place[robot]), len(members)), (rows.normal[own], rows.offset[own])
    left = solvers[1:] if solvers[0] == EXACT else solvers
    alone = project_all(program, [plane], [known], left, stop)
    lost = (EXACT,) if solvers[0] == EXACT else ()
    failed = next((each for each in alone.failures if each.plane == 0), None)
    failure = Failure(robot, (*lost, *(failed.failed if failed else ())), failed.used if failed else _first(left))
    if alone.contradiction is not None:
        contradiction = np.zeros(len(rows))
        contradiction[number] = alone.contradiction
        return Projections(contradiction=contradiction)
    one = alone.complete[0]
    one = replace(one, inner=None, weights=one.weights._replace(row=number[one.weights.row]))
    deepest = tuple(replace(each, plane=robot) for each in alone.failures if each.plane is None)
    return Projections((one,), (*deepest, failure) if failure.failed else deepest)


def _first(solvers: Sequence[Solver]) -> str | None:
    return name_of(solvers[0]) if solvers else None
