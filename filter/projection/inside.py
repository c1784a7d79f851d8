"""Points of a window's polytope that are proved to be in it, and the polygon that they span: compiled."""

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.convex import EPSILON, area_of, hull_of
from filter.geometry.simplify import vertices_worth_keeping
from filter.linear.certify import Boxes
from filter.linear.constraints import WORLD, Columns
from filter.projection.shadow import LONGEST, LONGEST_EACH, Trace, no_trace, turn
from filter.projection.simplex import FOUND, Basis, along
from filter.projection.window import WindowProgram

# Vertices are spared for as much area as edges are, yet never for more than this leaves.
LEAST_RATIO = 0.999
# A point is on a row when less than this share of the box is between them; so often is another one looked for.
CLOSE, ATTEMPTS = 4e-9, 8
# So many corners at most does an inner polygon have: a circle, of all shapes the worst, is left with 90 or so.
MOST_CORNERS = 128


@compiled
def inside_of(
    program: WindowProgram,
    walked: tuple[Trace, Basis, Array],
    seen: Array,
    numbers: Integers,
    where: tuple[Integers, Integers, Boxes],
    team: Columns,
) -> Array:
    """Return corners (p, 2) of a polygon of positions of the first member, every point of which is possible [m].

    What was walked is the shadow, to a vertex and an objective (v,); seen are its vertices (t, 2) in the plane. They are pulled
    towards a point in the middle until every row on the members, by number, holds for sure. There is no corner where none can
    be. The members come with the place of each robot among them (n,).
    """
    (members, place, box), (trace, basis, ahead) = where, walked
    middle, room = _point(program, middle_of(program, trace, basis, ahead), members, box), np.empty(len(numbers))
    for k in range(len(numbers)):
        room[k], _ = slack_at(middle, numbers[k], place, team)
    keep, corners, count = vertices_worth_keeping(seen, (1 - LEAST_RATIO) * area_of(seen)), np.empty((MOST_CORNERS, 2)), 0
    for vertex in range(len(seen)):
        if not keep[vertex] or count == MOST_CORNERS:
            continue
        point = _point(program, trace.point[vertex], members, box)
        _pull(point, middle, room, numbers, place, team)
        _put_within(point, members, box)
        if _holds(point, numbers, place, team):
            corners[count, 0], corners[count, 1] = point[0], point[1]
            count += 1
    return hull_of(corners[:count]) if count else corners[:0]


@compiled
def middle_of(program: WindowProgram, trace: Trace, basis: Basis, ahead: Array) -> Array:
    """Return a point (v,) that keeps clear of every row, if there is one, in the program's units.

    It is the mean of the shadow's vertices. Where these all lie on some rows, the walk goes on to the vertex that keeps
    farthest from these rows together, and so on; each of these counts as much as all of the shadow's.
    """
    middle, limit = np.zeros(len(ahead)), LONGEST + LONGEST_EACH * len(ahead)
    for k in range(trace.filled[0]):
        for v in range(len(ahead)):
            middle[v] += trace.point[k, v] / trace.filled[0]
    nothing, before, away = no_trace(0, len(ahead)), ahead, np.zeros(len(ahead))
    for attempt in range(ATTEMPTS):
        close = False
        away = np.zeros(len(ahead))
        for i in range(len(program.rows.offset)):
            if program.rows.offset[i] - along(program.rows, i, middle) < CLOSE:
                close = True
                for q in range(4):
                    away[program.rows.column[i, q]] -= program.rows.value[i, q]
        if not close or turn(program.rows, basis, before, away, np.pi / 2, nothing, limit) != FOUND:
            break
        before = away
        for v in range(len(ahead)):
            middle[v] += (basis.point[v] - middle[v]) / (attempt + 2)
    return middle


@compiled
def slack_at(point: Array, row: int, place: Integers, team: Columns) -> tuple[float, float]:
    """Return the slack of a row at a point (v,) of the members, and the rounding in it [m].

    The sign of a difference is right: there is none in rows +-x_k <= b.
    """
    first, second, normals, offsets = team
    slack, size, terms, exact = offsets[row], abs(offsets[row]), 0, True
    for side in range(2):
        robot = second[row] if side == 0 else first[row]
        if robot != WORLD:
            for m in range(2):
                coefficient = normals[row, m] if side == 0 else -normals[row, m]
                if coefficient != 0:
                    product = coefficient * point[2 * place[robot] + m]
                    slack -= product
                    size += abs(product)
                    terms += 1
                    exact = exact and abs(coefficient) == 1
    return slack, 0.0 if exact and terms == 1 else 8 * EPSILON * size


@compiled
def _point(program: WindowProgram, scaled: Array, members: Integers, box: Boxes) -> Array:
    """Return a point of the members [m]."""
    point = np.empty(len(scaled))
    for v in range(len(scaled)):
        point[v] = program.centre[v] + program.radius[v] * scaled[v]
    _put_within(point, members, box)
    return point


@compiled
def _put_within(point: Array, members: Integers, box: Boxes) -> None:
    """Put a point into the members' boxes, in place."""
    for k in range(len(members)):
        for m in range(2):
            point[2 * k + m] = min(max(point[2 * k + m], box[0][members[k], m]), box[1][members[k], m])


@compiled
def _pull(point: Array, middle: Array, room: Array, numbers: Integers, place: Integers, team: Columns) -> None:
    """Move a point towards the middle, where rows have so much room (r,), as far as each of them asks, in place."""
    share = 0.0
    for k in range(len(numbers)):
        slack, doubt = slack_at(point, numbers[k], place, team)
        lacking, gain = 4 * doubt - slack, room[k] - slack
        if lacking > 0:
            share = max(share, lacking / gain if gain > lacking else 1.0)
    for v in range(len(point)):
        point[v] += share * (middle[v] - point[v])


@compiled
def _holds(point: Array, numbers: Integers, place: Integers, team: Columns) -> bool:
    """Return whether a point satisfies the rows for sure, rounding counted against it."""
    for k in range(len(numbers)):
        slack, doubt = slack_at(point, numbers[k], place, team)
        if not slack >= doubt:
            return False
    return True
