"""Every robot projected in its window: compiled from the rows of the team to certified edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit

from filter.arrays import Array, Integers
from filter.constraints import WORLD, Constraints
from filter.plane import EPSILON, cut_box
from filter.polygon import SIDES, Polygon
from filter.polytope import Polytope
from filter.projection import Projection, Stop, Weights, position
from filter.projector import EXACT, Failure, Projections, broken_row, project_all
from filter.shadow import BEYOND, LONGEST, LONGEST_EACH, REASONS, SMALLEST, WORTHLESS, Trace, no_trace, simplified, turn
from filter.simplex import FOUND, become_feasible, corner, spread
from filter.solvers import Solver, name_of
from filter.window import Boxes, Links, Program, TeamRows, Window, links, members_of, program_of, rows_in

# What underflow can take from some hundred products.
TINY = 1e-300


class Windowed(NamedTuple):
    """What was found in one window.

    Attributes:
        vertices: (e, 2) of the outer polygon; none when the walk was lost or the window is empty [m].
        edges: (e,) the shadow's edge behind each, from `normals` on the robot's own rows, negative the sides of its box.
        margin: The polygon's [m].
        normals: (s, 2) of the shadow's edges that were kept.
        offsets: (s,) certified [m].
        rows: (s, v) the rows that prove each, -1 for none.
        prices: (s, v) their multipliers.
        why: What decided which edges were kept, a place in `REASONS`.
    """

    vertices: Array
    edges: Integers
    margin: float
    normals: Array
    offsets: Array
    rows: Integers
    prices: Array
    why: int


@njit(cache=True, nogil=True)
def certified(normal: Array, prices: Array, number: Integers, members: tuple[Integers, Array, Array], team: TeamRows) -> float:
    """Return an offset that holds in exact arithmetic for a direction of the first member's position [m].

    The same bound as `LinearProgram.certified_bounds`, for prices >= 0 of a few rows.

    Args:
        normal: (2,).
        prices: (v,) of the rows.
        number: (v,) which constraints; -1 for none.
        members: The place of each robot (n,), and centre and radius (v,) of the members' coordinates.
        team: i, j, normal and offset of all constraints.
    """
    (place, centre, radius), (i, j, normals, offsets) = members, team
    residual, size = np.zeros(len(centre)), np.zeros(len(centre))
    total, doubt, operations = 0.0, 0.0, 2 * (len(number) + len(centre) + 8) * EPSILON
    for m in range(2):
        residual[m], size[m] = normal[m], abs(normal[m])
    for k in range(len(number)):
        row, price = number[k], prices[k]
        if row < 0 or not 0 < price < np.inf:
            continue
        slack, magnitude = offsets[row], abs(offsets[row])
        for side in range(2):
            robot = j[row] if side == 0 else i[row]
            if robot >= 0:
                for m in range(2):
                    coefficient = normals[row, m] if side == 0 else -normals[row, m]
                    at = 2 * place[robot] + m
                    slack -= coefficient * centre[at]
                    magnitude += abs(coefficient * centre[at])
                    residual[at] -= price * coefficient
                    size[at] += abs(price * coefficient)
        total += price * slack
        doubt += 16 * EPSILON * price * magnitude + operations * price * abs(slack)
    for at in range(len(centre)):
        total += abs(residual[at]) * radius[at]
        doubt += operations * size[at] * radius[at]
    along = normal[0] * centre[0] + normal[1] * centre[1]
    doubt += 16 * EPSILON * (abs(normal[0] * centre[0]) + abs(normal[1] * centre[1]) + abs(total))
    return (along + total) + doubt * (1 + 1e-9) + TINY * (1 + radius.sum())


class Task(NamedTuple):
    """What all windows of a team have in common.

    Attributes:
        hops: How far a window reaches.
        most: How many robots it may have.
        who: Who has rows with whom.
        team: i, j, normal and offset of all constraints.
        box: Lower and upper corners (n, 2) of all robots.
        goal: As in `Stop`: performance ratio, area gap and greatest number of edges.
    """

    hops: int
    most: int
    who: Links
    team: TeamRows
    box: Boxes
    goal: tuple[float, float, int]


@njit(cache=True, nogil=True)
def walked(program: Program) -> tuple[bool, Trace]:
    """Return whether a walk around the first robot's shadow came through, and what it saw; in units of the robot's box."""
    variables = len(program.centre)
    first, second, start, prices = np.zeros(variables), np.zeros(variables), np.empty(variables), np.empty(variables)
    first[0], second[1] = min(1.0, program.radius[0] * 1e300), min(1.0, program.radius[1] * 1e300)
    for k in range(variables):
        prices[k] = 0.5 + 0.5 * spread(k + 1)
        start[k] = prices[k] if k % 2 else -prices[k]
    basis, nothing, trace = corner(program.rows, start), no_trace(0, variables), no_trace(LONGEST, variables)
    limit = LONGEST + LONGEST_EACH * variables
    how, _ = become_feasible(program.rows, basis, prices, limit)
    found = (
        how == FOUND
        and turn(program.rows, basis, start, first, np.pi / 2, nothing, limit) == FOUND
        and turn(program.rows, basis, first, second, 2 * np.pi, trace, limit) == FOUND
        and trace.filled[0] < LONGEST
    )
    return found, trace


@njit(cache=True, nogil=True)
def edge_of(program: Program, trace: Trace, k: int, rows: Integers, prices: Array) -> tuple[float, float]:
    """Return the normal of one of a walk's edges, and write which constraints prove it, with which multipliers."""
    x = trace.normal[k, 0] / (program.radius[0] if program.radius[0] > 0 else 1.0)
    y = trace.normal[k, 1] / (program.radius[1] if program.radius[1] > 0 else 1.0)
    length = np.hypot(x, y)
    for m in range(len(rows)):
        basic = trace.basic[k, m]
        if basic < len(program.number) and trace.prices[k, m] > WORTHLESS:
            rows[m] = program.number[basic]
            prices[m] = trace.prices[k, m] / (length * program.size[basic])
    return x / length, y / length


@njit(cache=True, nogil=True)
def is_tight(program: Program, trace: Trace, k: int, normal: Array, offset: float) -> bool:
    """Return whether a proved edge is no farther out than its vertex, but for rounding."""
    reached = 0.0
    for m in range(2):
        reached += normal[m] * (program.centre[m] + program.radius[m] * trace.point[k, m])
    rounding = 64 * EPSILON * (abs(program.centre[0]) + abs(program.centre[1])) + SMALLEST
    return offset - reached <= BEYOND * max(program.radius[0], program.radius[1]) + rounding


@njit(cache=True, nogil=True)
def project_window(robot: int, task: Task, place: Integers) -> Windowed:
    """Project a robot's window onto the robot's position.

    Args:
        robot: Which.
        task: The team.
        place: (n,) scratch, all -1, and so again afterwards.
    """
    members = members_of(robot, task.hops, task.most, task.who.near, task.who.near_first, place)
    program = program_of(members, place, rows_in(members, place, task.who), task.team, task.box)
    found, trace = walked(program)
    kept, why = np.empty(0, dtype=np.int64), 0
    if found:
        count, unit = trace.filled[0], program.radius[0] * program.radius[1]
        kept, why = simplified(trace.normal[:count], trace.point[:count, :2], unit, task.goal)
    normals, offsets = np.empty((len(kept), 2)), np.empty(len(kept))
    rows, prices = np.full((len(kept), len(program.centre)), -1), np.zeros((len(kept), len(program.centre)))
    for at in range(len(kept)):
        normals[at] = edge_of(program, trace, kept[at], rows[at], prices[at])
        offsets[at] = certified(normals[at], prices[at], rows[at], (place, program.centre, program.radius), task.team)
        found = found and is_tight(program, trace, kept[at], normals[at], offsets[at])
    for member in members:
        place[member] = -1
    vertices, edges, margin = np.empty((0, 2)), np.empty(0, dtype=np.int64), 0.0
    if found:
        own = task.who.own[task.who.own_first[robot] : task.who.own_first[robot + 1]]
        lines = np.concatenate((normals, task.team[2][own])), np.concatenate((offsets, task.team[3][own]))
        vertices, edges, margin = cut_box(lines[0], lines[1], task.box[0][robot], task.box[1][robot])
    return Windowed(vertices, edges, margin, normals, offsets, rows, prices, why)


@njit(cache=True, nogil=True)
def project_some(robots: Integers, task: Task) -> list[Windowed]:
    """Project the windows of some robots."""
    place = np.full(len(task.box[0]), -1)
    return [project_window(robot, task, place) for robot in robots]


def project_windows(polytope: Polytope, window: Window, solvers: Sequence[Solver], stop: Stop) -> Projections:
    """Project every robot of the team in its own window; what is proved there holds in the whole team.

    Nothing is known from inside: a point that the window allows may be impossible in the team.

    Args:
        polytope: The team's.
        window: How far a window reaches.
        solvers: What searches; the first may be "exact", for walks over the vertices.
        stop: When a projection is good enough.
    """
    rows, robots = polytope.constraints, len(polytope.lower)
    broken = broken_row(polytope.program())
    if broken is not None:
        return Projections(contradiction=broken)
    who = links(rows, robots)
    found: list[Projection | None] = [None] * robots
    if solvers[0] == EXACT:
        team, box = (rows.i, rows.j, rows.normal, rows.offset), (polytope.lower, polytope.upper)
        goal = (float(stop.performance_ratio), float(stop.area_gap), int(stop.searches))
        windows = project_some(np.arange(robots), Task(window.hops, window.robots, who, team, box, goal))
        found = [_projection(polytope, who, robot, each) for robot, each in enumerate(windows)]
    failures: list[Failure] = []
    for robot in (robot for robot, each in enumerate(found) if each is None):
        alone = _searched(polytope, who, robot, window, solvers, stop=stop)
        if alone.contradiction is not None:
            return alone
        found[robot] = alone.found[0]
        failures += alone.failures
    return Projections(tuple(each for each in found if each), tuple(failures))


def _projection(polytope: Polytope, who: Links, robot: int, found: Windowed) -> Projection | None:
    """Return what a walk has found and certified, or None when it was lost."""
    if not len(found.vertices):
        return None
    own = who.own[who.own_first[robot] : who.own_first[robot + 1]]
    normals = np.concatenate([found.normals, polytope.constraints.normal[own], SIDES])
    box = np.append(polytope.upper[robot], -polytope.lower[robot])
    offsets = np.concatenate([found.offsets, polytope.constraints.offset[own], box])
    behind = np.where(found.edges < 0, found.edges + len(offsets), found.edges)
    outer = Polygon(normals[behind], offsets[behind], found.vertices, found.margin)
    direction, at = np.nonzero(found.rows >= 0)
    weights, nothing = Weights(direction, found.rows[direction, at], found.prices[direction, at]), np.zeros(0)
    return Projection(outer, found.edges, None, found.normals, weights, nothing, nothing, REASONS[found.why])


def _searched(
    polytope: Polytope, who: Links, robot: int, window: Window, solvers: Sequence[Solver], *, stop: Stop
) -> Projections:
    """Project one robot's window by the solvers that are left when a walk is lost."""
    rows, place = polytope.constraints, np.full(len(polytope.lower), -1)
    members = np.sort(members_of(robot, window.hops, window.robots, who.near, who.near_first, place))
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
    one = alone.found[0]
    one = replace(one, inner=None, weights=one.weights._replace(row=number[one.weights.row]))
    deepest = tuple(replace(each, plane=robot) for each in alone.failures if each.plane is None)
    return Projections((one,), (*deepest, failure) if failure.failed else deepest)


def _first(solvers: Sequence[Solver]) -> str | None:
    return name_of(solvers[0]) if solvers else None
