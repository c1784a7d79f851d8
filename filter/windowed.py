"""One robot's window, projected: compiled from the rows of the team to certified edges."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.constraints import Columns
from filter.plane import EPSILON, cut_box
from filter.shadow import BEYOND, LONGEST, LONGEST_EACH, SMALLEST, WORTHLESS, Trace, no_trace, simplified, turn
from filter.simplex import FOUND, become_feasible, corner, spread
from filter.window import Boxes, Links, Program, members_of, program_of, rows_in

PROVED = -5  # what is behind an edge that is proved from several rows
# How far the first objective leads away from the robot itself.
ASIDE = 0.01
# What underflow can take from some hundred products.
TINY = 1e-300


class Windowed(NamedTuple):
    """What was found in one window.

    Attributes:
        vertices: (e, 2) of the outer polygon; none when the walk was lost or the window is empty [m].
        margin: The polygon's [m].
        lines: Normals (l, 2) and certified offsets (l,) of the shadow's edges that were kept, of the robot's own rows
            and of its box [m].
        behind: (e,) which of these lines each edge is.
        own: The robot's own rows.
        rows: (s, v) the rows that prove each edge of the shadow that was kept, -1 for none.
        prices: (s, v) their multipliers.
        why: What decided which edges were kept, a place in `REASONS`.
    """

    vertices: Array
    margin: float
    lines: tuple[Array, Array]
    behind: Integers
    own: Integers
    rows: Integers
    prices: Array
    why: int


@compiled
def certified(normal: Array, prices: Array, number: Integers, members: tuple[Integers, Array, Array], team: Columns) -> float:
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
    team: Columns
    box: Boxes
    goal: tuple[float, float, int]


@compiled
def walked(program: Program) -> tuple[bool, Trace]:
    """Return whether a walk around the first robot's shadow came through, and what it saw; in units of the robot's box."""
    variables = len(program.centre)
    first, second, start, prices = np.zeros(variables), np.zeros(variables), np.empty(variables), np.empty(variables)
    first[0], second[1] = min(1.0, program.radius[0] * 1e300), min(1.0, program.radius[1] * 1e300)
    for k in range(variables):  # near the direction that the walk begins in, yet along no axis
        prices[k] = (0.5 + 0.5 * spread(k + 1)) * (ASIDE if k else 1.0)
        start[k] = -prices[k] if k % 2 else prices[k]
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


@compiled
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


@compiled
def is_tight(program: Program, trace: Trace, k: int, normal: Array, offset: float) -> bool:
    """Return whether a proved edge is no farther out than its vertex, but for rounding."""
    reached = 0.0
    for m in range(2):
        reached += normal[m] * (program.centre[m] + program.radius[m] * trace.point[k, m])
    rounding = 64 * EPSILON * (abs(program.centre[0]) + abs(program.centre[1])) + SMALLEST
    return offset - reached <= BEYOND * max(program.radius[0], program.radius[1]) + rounding


@compiled
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
    own = task.who.own[task.who.own_first[robot] : task.who.own_first[robot + 1]]
    lines = np.concatenate((normals, task.team[2][own])), np.concatenate((offsets, task.team[3][own]))
    vertices, behind, margin = np.empty((0, 2)), np.empty(0, dtype=np.int64), 0.0
    if found:
        vertices, behind, margin = cut_box(lines[0], lines[1], task.box[0][robot], task.box[1][robot])
    return Windowed(vertices, margin, lines, behind, own, rows, prices, why)
