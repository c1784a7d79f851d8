"""Robots and pairs projected in their windows, on many threads; what each finds does not depend on how many there are."""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array, Integers
from filter.geometry.many import Polygons
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.linear.solvers import Solver, name_of
from filter.projection.claims import Hulls, Outlines, Weights, in_order
from filter.projection.fallback import Failure, broken_row, interior, project_all
from filter.projection.proved import Projection, position
from filter.projection.sheet import Sheet, Task, blank
from filter.projection.stop import REASONS, IsOver, Stop, never
from filter.projection.walk import project_some
from filter.projection.window import Links, Window, links, members_of_robot, rows_in
from filter.workers import spread

# Windows with so many robots, all told, are projected between two looks at the clock; for fewer a thread would not be worth it.
TOGETHER = 512
WALK = "walk"  # what has failed, in a failure
NO_NUMBERS = np.zeros(0, dtype=np.int64)
NO_OUTLINES = Outlines(Polygons.of([]), Weights.of(np.zeros((0, 0))), Hulls.none(0), NO_NUMBERS, ())


@dataclass(frozen=True, eq=False)
class Outlined:
    """What a projection of every robot, or of some pairs, gave.

    Attributes:
        outlines: (n) of all of them.
        failures: Where walks and solvers failed.
        contradiction: (r,) multipliers of the polytope's rows that prove that it is empty, or None. There are no outlines then.
    """

    outlines: Outlines
    failures: tuple[Failure, ...] = ()
    contradiction: Array | None = None


@dataclass(frozen=True)
class Projector:
    """Projects a team's polytope onto its robots, and onto pairs of them.

    Attributes:
        window: From how much of the team a region is found.
        stop: When a projection is good enough.
        exact: Whether to walk over the vertices; otherwise solvers search.
        solvers: They are asked in turn where a walk is lost, or from the first on.
        threads: How many windows at a time; None for as many as there are cores.
    """

    window: Window
    stop: Stop
    exact: bool = True
    solvers: tuple[Solver, ...] = ()
    threads: int | None = None

    def robots(self, polytope: Polytope, *, order: Integers | None = None, is_over: IsOver = never) -> Outlined:
        """Project onto every robot, in its own window; what is proved there holds in the whole team.

        Only in the window of everybody is anything known from inside: a point that another window allows may be impossible.

        Args:
            polytope: The team's.
            order: (n,) who comes first; all robots once. None for the order of their numbers.
            is_over: Whether time is up; the robots that are left keep what is known of them at a glance.
        """
        robots = len(polytope.lower)
        broken = broken_row(polytope.program()) if polytope.may_have_a_broken_row() else None
        if broken is not None:
            return _empty(broken)
        who, left = links(polytope.constraints, robots), np.arange(robots) if order is None else order
        pieces, failures = list[tuple[Integers, Outlines]](), list[Failure]()
        if self.exact:
            walks = self._walked(polytope, np.full(robots, WORLD), left, who, is_over)
            if walks.contradiction is not None:
                return _empty(walks.contradiction)
            pieces, left = [(left[walks.done], walks.outlines)], left[walks.left]
        late = np.zeros(robots, dtype=bool)
        for robot in left.tolist():
            late[robot] = is_over()
            if not late[robot]:
                alone = self._searched(polytope, who, robot, is_over)
                if alone.contradiction is not None:
                    return alone
                late[robot] = not len(alone.outlines.outer)
                pieces.append((np.full(len(alone.outlines.outer), robot), alone.outlines))
                failures += alone.failures
        unrefined = np.flatnonzero(late)
        pieces.append((unrefined, Outlines.at_a_glance(polytope.of_robots(unrefined), len(polytope.constraints), "time")))
        return self._with_the_inside(polytope, who, in_order(pieces), tuple(failures))

    def pairs(self, polytope: Polytope, pairs: tuple[Integers, Integers], *, is_over: IsOver = never) -> Outlined:
        """Project onto pairs, x_j - x_i, each in the window of the two; those lost or too late keep what their rows say.

        Args:
            polytope: The team's.
            pairs: i and j (g) of each, i < j.
            is_over: Whether time is up.
        """
        i, j = pairs
        walks = self._walked(polytope, i, j, links(polytope.constraints, len(polytope.lower)), is_over)
        glance = Outlines.at_a_glance(polytope.of(i[walks.left], j[walks.left]), len(polytope.constraints), "time")
        outlines = in_order([(walks.done, walks.outlines), (walks.left, glance)])
        return Outlined(outlines, tuple(Failure(int(k), (WALK,), None) for k in walks.lost))

    def _walked(self, polytope: Polytope, i: Integers, j: Integers, who: Links, is_over: IsOver) -> _Walks:
        """Walk the windows of pairs i, j (g), or of robots j where i is WORLD."""
        window, rows = self.window, polytope.constraints
        inside = window.leaves_nobody_out and bool((i == WORLD).all())
        box = polytope.lower, polytope.upper
        task = Task(window.hops, window.robots, inside, self.stop.goal, who, rows.rows, box)
        begin, end = rows.groups(i, j)
        size = max(1, TOGETHER // min(window.robots, len(polytope.lower)))
        chunks = [np.arange(k, min(k + size, len(j))) for k in range(0, len(j), size)]

        def walked(chunk: Integers) -> tuple[Sheet, int] | None:
            if is_over():
                return None
            sheet = blank((end - begin)[chunk], task)
            return sheet, project_some(i[chunk], j[chunk], task, sheet)

        workers = self.threads or os.cpu_count() or 1
        alone = workers == 1 or len(chunks) <= 1
        results = [walked(chunk) for chunk in chunks] if alone else spread(walked, chunks, workers)
        return _walks(chunks, results, len(rows))

    def _searched(self, polytope: Polytope, who: Links, robot: int, is_over: IsOver) -> Outlined:
        """Search one robot's window by the solvers; there are no outlines where time ran out before."""
        rows, place = polytope.constraints, np.full(len(polytope.lower), -1)
        members = self._members(who, robot)
        place[members] = np.arange(len(members))
        number = rows_in(members, place, who)
        few = rows.select(np.sort(number))
        few = replace(few, i=np.where(few.i == WORLD, WORLD, place[few.i]), j=place[few.j])
        program = Polytope(few, polytope.lower[members], polytope.upper[members]).program()
        own = rows.rows_of(WORLD, robot)
        known = rows.normal[own], rows.offset[own]
        found = project_all(
            program, [position(int(place[robot]), len(members))], [known], self.solvers, self.stop, is_over=is_over
        )
        if found.contradiction is not None:
            multipliers = np.zeros(len(rows))
            multipliers[np.sort(number)] = found.contradiction
            return _empty(multipliers)
        if not found.complete:
            return Outlined(NO_OUTLINES)
        return Outlined(_outline(found.complete[0], own, np.sort(number)), self._named(robot, found.failures))

    def _members(self, who: Links, robot: int) -> Integers:
        """Return whom a robot's window has, in the order of their numbers."""
        place = np.full(len(who.own_first) - 1, -1)
        return np.sort(members_of_robot(robot, self.window.hops, self.window.robots, who, place))

    def _named(self, robot: int, failures: Sequence[Failure]) -> tuple[Failure, ...]:
        """Return the failures in one robot's window, with that of the walk before."""
        lost = (WALK,) if self.exact else ()
        first = name_of(self.solvers[0]) if self.solvers else None
        of_robot = next((each for each in failures if each.which is not None), Failure(0, (), first))
        of_robot = Failure(robot, (*lost, *of_robot.failed), of_robot.used)
        deepest = tuple(replace(each, which=robot) for each in failures if each.which is None)
        return tuple(dict.fromkeys((*deepest, of_robot) if of_robot.failed else deepest))

    def _with_the_inside(self, polytope: Polytope, who: Links, outlines: Outlines, failures: tuple[Failure, ...]) -> Outlined:
        """Return what was found, with inner polygons only if the whole team is known to have a point inside.

        A part of the team that has to do with nobody else can be empty on its own, by less than a walk can see: then no
        robot of it has an inner point, and solvers are asked for the proof.
        """
        nothing = replace(outlines, inner=Hulls.none(len(outlines.outer)))
        if not self.window.leaves_nobody_out or "time" in outlines.reasons:
            return Outlined(nothing, failures)
        if outlines.inner.known.all():
            return Outlined(outlines, failures)
        apart = (self._members(who, robot) for robot in np.flatnonzero(~outlines.inner.known).tolist())
        if all(outlines.inner.known[members].any() for members in apart):
            return Outlined(outlines, failures)
        inside = interior(polytope.program(), self.solvers)
        if inside.contradiction is not None:
            return _empty(inside.contradiction)
        return Outlined(nothing, (*failures, *inside.failures))


@dataclass(frozen=True, eq=False)
class _Walks:
    """Walks around robots or pairs: whose time came, and their outlines, without edges where a walk was lost.

    `left` are those that time ran out on, then those that were `lost`; a `contradiction`, (r,) multipliers, proves that the
    polytope is empty.
    """

    done: Integers
    outlines: Outlines
    lost: Integers
    left: Integers
    contradiction: Array | None


def _walks(chunks: Sequence[Integers], results: Sequence[tuple[Sheet, int] | None], rows: int) -> _Walks:
    """Return the results of chunks of walks, of a polytope of so many rows; None where time had run out."""
    done = np.concatenate([NO_NUMBERS, *(chunk for chunk, one in zip(chunks, results, strict=True) if one)])
    late = np.concatenate([NO_NUMBERS, *(chunk for chunk, one in zip(chunks, results, strict=True) if not one)])
    for sheet, proof in filter(None, results):
        if proof:
            contradiction = np.zeros(rows)
            contradiction[sheet.row[:proof]] = sheet.weight[:proof]
            return _Walks(done, NO_OUTLINES, NO_NUMBERS, late, contradiction)
    outlines = Outlines.concatenate([NO_OUTLINES, *(_of_sheet(sheet) for sheet, _ in filter(None, results))])
    lost = done[outlines.outer.counts == 0]
    return _Walks(done, outlines, lost, np.concatenate([late, lost]), None)


def _of_sheet(sheet: Sheet) -> Outlines:
    """Return what is on a sheet; the rest of its columns is room to spare."""
    edges = sheet.first[-1]
    claims, corners = sheet.row_first[edges], sheet.corner_first[-1]
    normals, offsets, vertices = (column[:edges].copy() for column in (sheet.normals, sheet.offsets, sheet.vertices))
    weights = Weights(sheet.row[:claims].copy(), sheet.weight[:claims].copy(), sheet.row_first[: edges + 1].copy())
    inner = Hulls(sheet.corners[:corners].copy(), sheet.corner_first)
    reasons = tuple(REASONS[why] for why in sheet.why.tolist())
    return Outlines(Polygons(normals, offsets, vertices, sheet.margin, sheet.first), weights, inner, sheet.searches, reasons)


def _empty(multipliers: Array) -> Outlined:
    return Outlined(NO_OUTLINES, (), multipliers)


def _outline(found: Projection, own: Integers, number: Integers) -> Outlines:
    """Return one robot's projection as an outline.

    Args:
        found: Of its window's program.
        own: The rows on the robot alone, which have cut it.
        number: (r,) which row of the team's polytope each row of the window's program is.
    """
    proofs = replace(found.weights, row=number[found.weights.row])
    itself = Weights(own, np.ones(len(own)), np.arange(len(own) + 1))
    sides = Weights(own[:0], np.zeros(0), np.zeros(5, dtype=np.int64))
    weights = Weights.concatenate([proofs, itself, sides]).select(found.edges)
    searches = np.array([found.searches])
    return Outlines(Polygons.of([found.outer]), weights, Hulls.of([found.inner]), searches, (found.reason,))
