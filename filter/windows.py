"""Every robot projected in its window: compiled from the rows of the team to certified edges."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from numba import njit
from scipy import sparse

from filter.arrays import Array, Integers
from filter.constraints import WORLD, Constraints
from filter.plane import EPSILON, cut_box
from filter.polygon import SIDES, Polygon
from filter.polytope import Polytope
from filter.projection import Projection, Stop, position
from filter.projector import EXACT, Failure, Projections, broken_row, project_all
from filter.shadow import LONGEST, LONGEST_EACH, REASONS, SMALLEST, WORTHLESS, no_trace, simplified, turn
from filter.simplex import FOUND, become_feasible, corner, spread
from filter.solvers import Solver, name_of
from filter.window import Boxes, Links, TeamRows, Window, links, members_of, program_of, rows_in

# An edge that is certified this much farther out than it was found, relative to the box, shows that the walk went wrong.
LOOSE = 1e-7
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


@njit(cache=True, nogil=True)
def project_window(
    robot: int,
    hops: int,
    most: int,
    who: Links,
    team: TeamRows,
    box: Boxes,
    goal: tuple[float, float, int],
    place: Integers,
) -> Windowed:
    """Project a robot's window onto the robot's position.

    Args:
        robot: Which.
        hops: How far the window reaches.
        most: How many robots it may have.
        who: Who has rows with whom.
        team: i, j, normal and offset of all constraints.
        box: Lower and upper corners (n, 2) of all robots.
        goal: As in `Stop`: performance ratio, area gap and greatest number of edges.
        place: (n,) scratch, all -1, and so again afterwards.
    """
    members = members_of(robot, hops, most, who.near, who.near_first, place)
    number = rows_in(members, place, who)
    program = program_of(members, place, number, team, box)
    variables = len(program.centre)
    first, second, start, prices = np.zeros(variables), np.zeros(variables), np.empty(variables), np.empty(variables)
    first[0], second[1] = min(1.0, program.radius[0] * 1e300), min(1.0, program.radius[1] * 1e300)
    for k in range(variables):
        prices[k] = 0.5 + 0.5 * spread(k + 1)
        start[k] = prices[k] if k % 2 else -prices[k]
    basis = corner(program.rows, start)
    limit = LONGEST + LONGEST_EACH * variables
    trace = no_trace(LONGEST, variables)
    how, _ = become_feasible(program.rows, basis, prices, limit)
    lost = (
        how != FOUND
        or turn(program.rows, basis, start, first, np.pi / 2, no_trace(0, variables), limit) != FOUND
        or turn(program.rows, basis, first, second, 2 * np.pi, trace, limit) != FOUND
        or trace.filled[0] == LONGEST
    )
    count, kept, why = trace.filled[0], np.empty(0, dtype=np.int64), 0
    if not lost:
        unit = program.radius[0] * program.radius[1]
        kept, why = simplified(trace.normal[:count], trace.point[:count, :2], unit, goal)
    normals, offsets = np.empty((len(kept), 2)), np.empty(len(kept))
    rows, weights = np.full((len(kept), variables), -1), np.zeros((len(kept), variables))
    for at in range(len(kept)):
        k = kept[at]
        x = trace.normal[k, 0] / (program.radius[0] if program.radius[0] > 0 else 1.0)
        y = trace.normal[k, 1] / (program.radius[1] if program.radius[1] > 0 else 1.0)
        length = np.hypot(x, y)
        normals[at, 0], normals[at, 1] = x / length, y / length
        for m in range(variables):
            basic = trace.basic[k, m]
            if basic < len(program.number) and trace.prices[k, m] > WORTHLESS:
                rows[at, m] = program.number[basic]
                weights[at, m] = trace.prices[k, m] / (length * program.size[basic])
        offsets[at] = certified(normals[at], weights[at], rows[at], (place, program.centre, program.radius), team)
        found = normals[at, 0] * (program.centre[0] + program.radius[0] * trace.point[k, 0]) + normals[at, 1] * (
            program.centre[1] + program.radius[1] * trace.point[k, 1]
        )
        rounding = 64 * EPSILON * (abs(program.centre[0]) + abs(program.centre[1])) + SMALLEST
        lost = lost or not offsets[at] - found <= LOOSE * max(program.radius[0], program.radius[1]) + rounding
    for member in members:
        place[member] = -1
    if lost:
        return Windowed(np.empty((0, 2)), np.empty(0, dtype=np.int64), 0.0, normals, offsets, rows, weights, why)
    own = who.own[who.own_first[robot] : who.own_first[robot + 1]]
    everything = np.concatenate((normals, team[2][own])), np.concatenate((offsets, team[3][own]))
    vertices, edges, margin = cut_box(everything[0], everything[1], box[0][robot], box[1][robot])
    return Windowed(vertices, edges, margin, normals, offsets, rows, weights, why)


@njit(cache=True, nogil=True)
def project_some(
    robots: Integers,
    hops: int,
    most: int,
    who: Links,
    team: TeamRows,
    box: Boxes,
    goal: tuple[float, float, int],
) -> list[Windowed]:
    """Project the windows of some robots."""
    place = np.full(len(box[0]), -1)
    return [project_window(robot, hops, most, who, team, box, goal, place) for robot in robots]


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
        walked = project_some(np.arange(robots), window.hops, window.robots, who, team, box, goal)
        found = [_projection(polytope, who, robot, each) for robot, each in enumerate(walked)]
    failures: list[Failure] = []
    for robot in (robot for robot, each in enumerate(found) if each is None):
        alone = _searched(polytope, who, robot, window, solvers, stop)
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
    edge, at = np.nonzero(found.rows >= 0)
    entries = found.prices[edge, at], (edge, found.rows[edge, at])
    multipliers = sparse.csr_array(entries, shape=(len(found.offsets), len(polytope.constraints)))
    nothing = np.zeros(0)
    return Projection(outer, found.edges, None, found.normals, multipliers, nothing, nothing, REASONS[found.why])


def _searched(polytope: Polytope, who: Links, robot: int, window: Window, solvers: Sequence[Solver], stop: Stop) -> Projections:
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
    spread_out = sparse.csr_array((np.ones(len(number)), (np.arange(len(number)), number)), shape=(len(number), len(rows)))
    if alone.contradiction is not None:
        return Projections(contradiction=alone.contradiction @ spread_out)
    one = replace(alone.found[0], inner=None, multipliers=alone.found[0].multipliers @ spread_out)
    deepest = tuple(replace(each, plane=robot) for each in alone.failures if each.plane is None)
    return Projections((one,), (*deepest, failure) if failure.failed else deepest)


def _first(solvers: Sequence[Solver]) -> str | None:
    return name_of(solvers[0]) if solvers else None
