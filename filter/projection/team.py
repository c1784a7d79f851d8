"""Robots and pairs projected in their windows, on many threads; what each finds does not depend on how many there are."""

import os
from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array, Integers
from filter.geometry.many import Polygons
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.linear.solvers import Solver
from filter.projection.claims import Hulls, Outlines, Weights, in_order
from filter.projection.fallback import Fallback, broken_row, interior, project_all
from filter.projection.proved import Projection, position
from filter.projection.sheet import Sheet, Task, blank
from filter.projection.stop import REASONS, IsOver, Reason, Stop, never
from filter.projection.walk import project_some
from filter.projection.window import Links, Window, links, members_of, rows_in
from filter.workers import spread

# Windows with so many robots, all told, are projected between two looks at the clock; for fewer a thread would not be worth it.
TOGETHER = 512
CORES = os.cpu_count() or 1
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

    outlines: Outlines = NO_OUTLINES
    failures: tuple[Fallback, ...] = ()
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
        Who comes first in the order, (n,) all robots once, has time first; those on whom it runs out keep what is known of
        them at a glance.
        """
        robots = len(polytope.lower)
        broken = broken_row(polytope.program()) if polytope.may_have_a_broken_row() else None
        if broken is not None:
            return Outlined(contradiction=broken)
        who, left = links(polytope.constraints, robots), np.arange(robots) if order is None else order
        pieces, failures, late = list[tuple[Integers, Outlines]](), list[Fallback](), list[int]()
        if self.exact:
            done, walks = self._walked(polytope, np.full(robots, WORLD), left, who, is_over)
            if walks.contradiction is not None:
                return walks
            pieces.append((left[done], walks.outlines))
            left = np.delete(left, done[walks.outlines.outer.counts > 0])
        for robot in left.tolist():
            alone = Outlined() if is_over() else self._searched(polytope, who, robot, is_over)
            if alone.contradiction is not None:
                return alone
            pieces.append((np.full(len(alone.outlines.outer), robot), alone.outlines))
            failures += alone.failures
            if not len(alone.outlines.outer):
                late.append(robot)
        if late:
            unrefined = np.array(late)
            pieces.append((unrefined, Outlines.at_a_glance(polytope.of_robots(unrefined), len(polytope.constraints), "time")))
        return self._with_the_inside(polytope, who, in_order(pieces), tuple(failures))

    def pairs(self, polytope: Polytope, pairs: tuple[Integers, Integers], *, is_over: IsOver = never) -> Outlined:
        """Project onto x_j - x_i of pairs i < j (g), each in the window of the two; those lost or late keep what rows say."""
        i, j = pairs
        done, walks = self._walked(polytope, i, j, links(polytope.constraints, len(polytope.lower)), is_over)
        lost, late = done[walks.outlines.outer.counts == 0], np.delete(np.arange(len(j)), done)
        pieces, why = [(done, walks.outlines)], dict[Reason | None, Integers]({None: lost, "time": late})
        for reason, some in why.items():
            if len(some):
                glance = Outlines.at_a_glance(polytope.of(i[some], j[some]), len(polytope.constraints), reason)
                pieces.append((some, glance))
        failures = tuple(Fallback(int(j[k]), (WALK,), None, int(i[k])) for k in lost)
        return Outlined(in_order(pieces), failures)

    def _walked(self, polytope: Polytope, i: Integers, j: Integers, who: Links, is_over: IsOver) -> tuple[Integers, Outlined]:
        """Walk the windows of pairs i, j (g), or of robots j where i is WORLD.

        Return whose time came, and what was found of these: there are no edges where a walk was lost.
        """
        window, rows = self.window, polytope.constraints
        inside = window.leaves_nobody_out and bool((i == WORLD).all())
        task = Task(window.hops, window.robots, inside, self.stop.goal, who, rows.rows, (polytope.lower, polytope.upper))
        (begin, end), (lower, upper) = rows.groups(i, j), polytope.around(i, j)
        size = max(1, TOGETHER // min(window.robots, len(polytope.lower)))
        chunks = [np.arange(k, min(k + size, len(j))) for k in range(0, len(j), size)]

        def walked(chunk: Integers) -> tuple[Sheet, int] | None:
            if is_over():
                return None
            sheet = blank((end - begin)[chunk], task)
            own, around = (begin[chunk], end[chunk]), (lower[chunk], upper[chunk])
            return sheet, project_some((i[chunk], j[chunk]), own, around, task, sheet)

        workers = self.threads or CORES
        alone = workers == 1 or len(chunks) <= 1
        results = [walked(chunk) for chunk in chunks] if alone else spread(walked, chunks, workers)
        done, found = [NO_NUMBERS], [NO_OUTLINES]
        for chunk, (sheet, proof) in ((chunk, one) for chunk, one in zip(chunks, results, strict=True) if one):
            if proof:
                contradiction = np.zeros(len(rows))
                contradiction[sheet.row[:proof]] = sheet.weight[:proof]
                return NO_NUMBERS, Outlined(contradiction=contradiction)
            done.append(chunk)
            found.append(_of_sheet(sheet))
        return np.concatenate(done), Outlined(Outlines.concatenate(found))

    def _searched(self, polytope: Polytope, who: Links, robot: int, is_over: IsOver) -> Outlined:
        """Search one robot's window by the solvers; there are no outlines where time ran out before."""
        rows, place = polytope.constraints, np.full(len(polytope.lower), -1)
        members = self._members(who, robot)
        place[members] = np.arange(len(members))
        number = np.sort(rows_in(members, place, who))
        few = rows.select(number)
        few = replace(few, i=np.where(few.i == WORLD, WORLD, place[few.i]), j=place[few.j])
        program = Polytope(few, polytope.lower[members], polytope.upper[members]).program()
        own = rows.rows_of(WORLD, robot)
        plane, known = position(int(place[robot]), len(members)), (rows.normal[own], rows.offset[own])
        before = [WALK] if self.exact else []
        found = project_all(program, [plane], [known], self.solvers, self.stop, before=before, is_over=is_over)
        if found.contradiction is not None:
            multipliers = np.zeros(len(rows))
            multipliers[number] = found.contradiction
            return Outlined(contradiction=multipliers)
        if not found.complete:
            return Outlined()
        failures = dict.fromkeys(replace(each, robot=robot) for each in found.failures)
        return Outlined(_outline(found.complete[0], own, number), tuple(failures))

    def _members(self, who: Links, robot: int) -> Integers:
        """Return whom a robot's window has, in the order of their numbers."""
        place = np.full(len(who.own_first) - 1, -1)
        return np.sort(members_of(WORLD, robot, self.window.hops, self.window.robots, who, place))

    def _with_the_inside(self, polytope: Polytope, who: Links, outlines: Outlines, failures: tuple[Fallback, ...]) -> Outlined:
        """Return what was found, with inner polygons only if the whole team is known to have a point inside.

        A part of the team that has to do with nobody else can be empty on its own, by less than a walk can see: then no
        robot of it has an inner point, and solvers are asked for the proof.
        """
        nothing, known = replace(outlines, inner=Hulls.none(len(outlines.outer))), outlines.inner.known
        if not self.window.leaves_nobody_out or "time" in outlines.reasons:
            return Outlined(nothing, failures)
        apart = (self._members(who, robot) for robot in np.flatnonzero(~known).tolist())
        if all(known[members].any() for members in apart):
            return Outlined(outlines, failures)
        inside = interior(polytope.program(), self.solvers)
        if inside.contradiction is not None:
            return Outlined(contradiction=inside.contradiction)
        return Outlined(nothing, (*failures, *inside.failures))


def _of_sheet(sheet: Sheet) -> Outlines:
    """Return what is on a sheet; the rest of its columns is room to spare."""
    edges = sheet.first[-1]
    claims, corners = sheet.row_first[edges], sheet.corner_first[-1]
    normals, offsets, vertices = (column[:edges].copy() for column in (sheet.normals, sheet.offsets, sheet.vertices))
    weights = Weights(sheet.row[:claims].copy(), sheet.weight[:claims].copy(), sheet.row_first[: edges + 1].copy())
    inner = Hulls(sheet.corners[:corners].copy(), sheet.corner_first)
    reasons = tuple(REASONS[why] for why in sheet.why.tolist())
    return Outlines(Polygons(normals, offsets, vertices, sheet.margin, sheet.first), weights, inner, sheet.searches, reasons)


def _outline(found: Projection, own: Integers, number: Integers) -> Outlines:
    """Return a projection, cut by a robot's own rows, as an outline; a window's rows are those by number of the team's."""
    proofs = replace(found.weights, row=number[found.weights.row])
    itself = Weights(own, np.ones(len(own)), np.arange(len(own) + 1))
    sides = Weights(own[:0], np.zeros(0), np.zeros(5, dtype=np.int64))
    weights = Weights.concatenate([proofs, itself, sides]).select(found.edges)
    searches = np.array([found.searches])
    return Outlines(Polygons.of([found.outer]), weights, Hulls.of([found.inner]), searches, (found.reason,))
