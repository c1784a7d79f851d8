"""One window, projected onto a robot or onto a pair: compiled from the rows of the team to certified edges.

Of a pair i, j it is the position of j as seen from i, x_j - x_i, as in `Constraints`; of a robot j alone i is WORLD.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.convex import EPSILON, cut_box
from filter.linear.constraints import Columns
from filter.projection.shadow import BEYOND, LONGEST, LONGEST_EACH, SMALLEST, WORTHLESS, Trace, no_trace, simplified, turn
from filter.projection.simplex import FOUND, become_feasible, corner, spread
from filter.projection.window import Boxes, Links, Program, box_around, members_of, program_of, rows_in, rows_on

PROVED = -5  # what is behind an edge that is proved from several rows
# How far the first objective leads away from the plane that is projected onto.
ASIDE = 0.01
Members = tuple[Integers, Array, Array]  # the place of each robot (n,), centre and radius (v,) of the members' coordinates
# What underflow can take from some hundred products.
TINY = 1e-300


class Windowed(NamedTuple):
    """What was found in one window.

    Attributes:
        vertices: (e, 2) of the outer polygon; none when the walk was lost or the window is empty [m].
        margin: The polygon's [m].
        lines: Normals (l, 2) and certified offsets (l,) of the shadow's edges that were kept, and of the rows on the robot or
            the pair [m].
        behind: (e,) which of these lines each edge is; -4 to -1 for a side of the box.
        own: The rows on the robot or the pair.
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
def certified(i: int, j: int, normal: Array, prices: Array, number: Integers, members: Members, team: Columns) -> float:
    """Return an offset that holds in exact arithmetic for a direction of a robot's or a pair's position [m].

    The same bound as `LinearProgram.certified_bounds`, for prices >= 0 of a few rows.

    Args:
        i: A member, or WORLD.
        j: A member.
        normal: (2,).
        prices: (p,) of the rows.
        number: (p,) which constraints; -1 for none.
        members: Where the members are.
        team: i, j, normal and offset of all constraints.
    """
    (place, centre, radius), (first, second, normals, offsets) = members, team
    residual, size = np.zeros(len(centre)), np.zeros(len(centre))
    total, doubt, operations = 0.0, 0.0, 2 * (len(number) + len(centre) + 8) * EPSILON
    along, reach = 0.0, 0.0
    for side in range(2):
        robot = j if side == 0 else i
        if robot >= 0:
            for m in range(2):
                at = 2 * place[robot] + m
                residual[at] = normal[m] if side == 0 else -normal[m]
                size[at] = abs(normal[m])
                along += residual[at] * centre[at]
                reach += abs(residual[at] * centre[at])
    for k in range(len(number)):
        row, price = number[k], prices[k]
        if row < 0 or not 0 < price < np.inf:
            continue
        slack, magnitude = offsets[row], abs(offsets[row])
        for side in range(2):
            robot = second[row] if side == 0 else first[row]
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
    doubt += 16 * EPSILON * (reach + abs(total))
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


class Plane(NamedTuple):
    """What is projected onto: the first member's position, or that as seen from the second, in units of their boxes.

    Attributes:
        right: (v,) objective in the program's units whose value is the first coordinate.
        up: (v,) that of the second coordinate.
        size: (2,) what the coordinates are measured in [m].
        middle: (2,) where they are 0 [m].
        far: How large the positions' coordinates are, summed up [m].
    """

    right: Array
    up: Array
    size: Array
    middle: Array
    far: float


@compiled
def plane_of(program: Program, mutual: bool) -> Plane:
    """Return the plane of the first member, or of the pair of the first two."""
    variables, size, middle = len(program.centre), np.empty(2), np.empty(2)
    axes, far = np.zeros((2, variables)), np.abs(program.centre[: 4 if mutual else 2]).sum()
    for m in range(2):
        second = program.radius[2 + m] if mutual else 0.0
        size[m], middle[m] = program.radius[m] + second, program.centre[m]
        if size[m] > 0:
            axes[m, m] = program.radius[m] / size[m]
        if mutual:
            middle[m] -= program.centre[2 + m]
            axes[m, 2 + m] = -second / size[m] if size[m] > 0 else 0.0
    return Plane(axes[0], axes[1], size, middle, far)


@compiled
def walked(program: Program, plane: Plane) -> tuple[bool, Trace]:
    """Return whether a walk around the shadow on a plane came through, and what it saw."""
    variables = len(program.centre)
    start, prices = np.empty(variables), np.empty(variables)
    for k in range(variables):  # near the direction that the walk begins in, yet along no axis
        ahead = plane.right[k] if plane.right[k] != 0 else ASIDE * (1.0 - 2.0 * (k % 2))
        start[k] = (0.5 + 0.5 * spread(k + 1)) * ahead
        prices[k] = abs(start[k])
    basis, nothing, trace = corner(program.rows, start), no_trace(0, variables), no_trace(LONGEST, variables)
    limit = LONGEST + LONGEST_EACH * variables
    how, _ = become_feasible(program.rows, basis, prices, limit)
    found = (
        how == FOUND
        and turn(program.rows, basis, start, plane.right, np.pi / 2, nothing, limit) == FOUND
        and turn(program.rows, basis, plane.right, plane.up, 2 * np.pi, trace, limit) == FOUND
        and trace.filled[0] < LONGEST
    )
    return found, trace


@compiled
def vertices_of(trace: Trace, plane: Plane) -> Array:
    """Return the vertices (t, 2) of a shadow in the plane's units."""
    seen = np.zeros((trace.filled[0], 2))
    for k in range(len(seen)):
        for v in range(len(plane.right)):
            seen[k, 0] += plane.right[v] * trace.point[k, v]
            seen[k, 1] += plane.up[v] * trace.point[k, v]
    return seen


@compiled
def edge_of(program: Program, plane: Plane, trace: Trace, k: int, rows: Integers, prices: Array) -> tuple[float, float]:
    """Return the normal of one of a walk's edges, and write which constraints prove it, with which multipliers."""
    x = trace.normal[k, 0] / (plane.size[0] if plane.size[0] > 0 else 1.0)
    y = trace.normal[k, 1] / (plane.size[1] if plane.size[1] > 0 else 1.0)
    length = np.hypot(x, y)
    for m in range(len(rows)):
        basic = trace.basic[k, m]
        if basic < len(program.number) and trace.prices[k, m] > WORTHLESS:
            rows[m] = program.number[basic]
            prices[m] = trace.prices[k, m] / (length * program.size[basic])
    return x / length, y / length


@compiled
def is_tight(plane: Plane, vertex: Array, normal: Array, offset: float) -> bool:
    """Return whether a proved edge is no farther out than its vertex (2,), but for rounding."""
    reached = 0.0
    for m in range(2):
        reached += normal[m] * (plane.middle[m] + plane.size[m] * vertex[m])
    return offset - reached <= BEYOND * max(plane.size[0], plane.size[1]) + 64 * EPSILON * plane.far + SMALLEST


@compiled
def project_window(i: int, j: int, task: Task, place: Integers) -> Windowed:
    """Project a window onto the position of robot j, or onto x_j - x_i where i is not WORLD.

    Args:
        i: A robot, or WORLD.
        j: A robot.
        task: The team.
        place: (n,) scratch, all -1, and so again afterwards.
    """
    who = task.who
    members = members_of(i, j, task.hops, task.most, who.near, who.near_first, place)
    program = program_of(members, place, rows_in(members, place, who), task.team, task.box)
    plane = plane_of(program, i >= 0)
    found, trace = walked(program, plane)
    kept, why, vertices = np.empty(0, dtype=np.int64), 0, vertices_of(trace, plane)
    if found:
        count = trace.filled[0]
        kept, why = simplified(trace.normal[:count], vertices, plane.size[0] * plane.size[1], task.goal)
    normals, offsets = np.empty((len(kept), 2)), np.empty(len(kept))
    rows, prices = np.full((len(kept), len(program.centre)), -1), np.zeros((len(kept), len(program.centre)))
    for at in range(len(kept)):
        normals[at] = edge_of(program, plane, trace, kept[at], rows[at], prices[at])
        where = place, program.centre, program.radius
        offsets[at] = certified(i, j, normals[at], prices[at], rows[at], where, task.team)
        # A region's loose edge is for a solver to better; a pair's is cut by the rows that it had.
        found = found and (i >= 0 or is_tight(plane, vertices[kept[at]], normals[at], offsets[at]))
    for member in members:
        place[member] = -1
    own, box = rows_on(i, j, who), box_around(i, j, task.box)
    lines = np.concatenate((normals, task.team[2][own])), np.concatenate((offsets, task.team[3][own]))
    outline, behind, margin = np.empty((0, 2)), np.empty(0, dtype=np.int64), 0.0
    if found:
        outline, behind, margin = cut_box(lines[0], lines[1], box[0], box[1])
    return Windowed(outline, margin, lines, behind, own, rows, prices, why)
