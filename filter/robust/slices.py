"""Sets of poses cut into slices of heading: arcs with a polygon each, and the compiled arithmetic on them.

A wide heading is coupled to the position: where it is 10 degrees, a landmark's bearing puts the robot here; where it is 30
degrees, over there. So a set of poses is covered by slices, each the product of a narrow arc and of the polygon of positions
that go with it (the subpavings of interval analysis; Jaulin et al., Applied Interval Analysis, 2001).

All polygons have edges in the same directions and are given by their supports (COUNT,), how far they reach in each [m]: the
hull of two is the greater of their supports, the sum of two sets the sum of them. What is cut by other half-planes is replaced
by the smallest such polygon around it. Every operation errs outward, rounding included.

Slices are their first and last headings, low (s,) and high (s,) [rad], and their polygons, reach (s, COUNT) [m]. What cuts them
takes these last, cuts in place, and returns which slices are left, (s,). A sector (4,) is a bearing in the robot's frame and
its bound [rad], least and greatest range [m]. Without a bearing the bound is pi, without a range they are 0 and FARTHEST.
"""

from collections.abc import Sequence

import numpy as np

from filter.arrays import Array, Integers, Mask
from filter.compiled import compiled, put
from filter.geometry.angles import ANGLE_ROUNDING
from filter.geometry.convex import EPSILON, clip_box, span_of
from filter.geometry.sector import WIDEST, far_and_near, sides, trapezoid
from filter.poses.slices import COUNT, DIRECTIONS, HAIR_OF_CELL, QUARTER

Sighting = tuple[int, int, Array]  # who saw, what, and in which sector; a compass is a bearing of the robot itself
FARTHEST = 1e6  # what a bearing without a range says of the distance [m]
TANGENT_ANGLE = np.pi / 12  # between two tangents of the far side of a sector [rad]


@compiled
def sector_supports(centre: float, bound: float, nearest: float, farthest: float) -> Array:
    """Return supports of the trapezoid around a sector or, where that reaches less far or it is of WIDEST, of the disc."""
    outward = farthest * (1 + 64 * EPSILON)
    supports = np.full(COUNT, outward)
    if bound >= WIDEST:
        return supports
    corners = trapezoid(centre, bound, nearest, farthest)
    rounding = 64 * EPSILON * (1 + np.tan(bound)) * farthest
    for m in range(COUNT):
        reach = -np.inf
        for k in range(4):
            reach = max(reach, DIRECTIONS[m, 0] * corners[k, 0] + DIRECTIONS[m, 1] * corners[k, 1])
        supports[m] = min(outward, reach + rounding)
    return supports


@compiled
def move(distance: Array, turn: Array, aside: Array, arena: Array, low: Array, high: Array, reach: Array) -> Mask:
    """Move slices by one robot's odometry, within an arena: the trapezoid of each slice's own arc is added, its arc turned.

    Path, negative backwards [m], and turn [rad] are the least and the greatest, (2,); aside are the bound of the motion's
    direction [rad], the radius of the disc of slip [m], and where the robot drives, from its forward axis [rad]; the arena is
    given by its supports.
    """
    bend = min(np.pi / 2, max(abs(turn[0]), abs(turn[1])) / 2 + aside[0])
    wide = (turn[1] - turn[0]) / 4 + aside[0] + ANGLE_ROUNDING
    if max(abs(turn[0]), abs(turn[1])) >= 2 * np.pi:
        wide = np.pi  # the way back can be the shortest
    chord = np.cos(bend)
    for k in range(len(low)):
        centre = (low[k] + high[k] + (turn[0] + turn[1]) / 2) / 2 + aside[2]
        bound = (high[k] - low[k]) / 2 + wide
        if distance[0] >= 0:
            step = sector_supports(centre, bound, distance[0] * chord, distance[1])
        else:
            step = sector_supports(centre + np.pi, bound, max(0.0, -distance[1]) * chord, -distance[0])
            if distance[1] >= 0:
                step = np.maximum(step, sector_supports(centre, bound, 0.0, distance[1]))
        for m in range(COUNT):
            reach[k, m] += step[m] + aside[1] + 4 * EPSILON * abs(reach[k, m])
        low[k] += turn[0] - ANGLE_ROUNDING * (1 + abs(low[k]))
        high[k] += turn[1] + ANGLE_ROUNDING * (1 + abs(high[k]))
    return stay_within(arena, low, high, reach)


@compiled
def tighten(reach: Array, normals: Array, offsets: Array) -> tuple[Array, float]:
    """Cut one polygon by half-planes, in place: reach is then that of the smallest polygon around what is left.

    Returns:
        The vertices of what is left, and how far outward they can be short of it [m]. No vertex proves that it is empty.
    """
    lower = np.array([-reach[2 * QUARTER], -reach[3 * QUARTER]])
    upper = np.array([reach[0], reach[QUARTER]])
    if lower[0] > upper[0] or lower[1] > upper[1]:
        return np.empty((0, 2)), 0.0
    lines, most = (np.concatenate((DIRECTIONS, normals)), np.concatenate((reach, offsets))), COUNT + len(offsets) + 4
    room = np.empty((most, 2))
    size, margin = clip_box((room, np.empty(most, dtype=np.int64)), lines, lower, upper)
    vertices = room[:size]
    for m in range(COUNT if len(vertices) else 0):
        farthest = -np.inf
        for k in range(len(vertices)):
            farthest = max(farthest, DIRECTIONS[m, 0] * vertices[k, 0] + DIRECTIONS[m, 1] * vertices[k, 1])
        reach[m] = min(reach[m], farthest + 2 * margin)
    return vertices, margin


@compiled
def _narrow(low: Array, high: Array, k: int, centre: float, bound: float) -> bool:
    """Cut a slice's arc down to what it shares with another arc, in place; return whether there is anything."""
    middle, half = (low[k] + high[k]) / 2, (high[k] - low[k]) / 2
    if half + bound >= np.pi - 1e-9:  # they can meet at both ends
        return True
    offset = centre - middle
    offset -= 2 * np.pi * np.round(offset / (2 * np.pi))
    slack = ANGLE_ROUNDING * (1 + abs(centre) + abs(middle))
    low[k], high[k] = max(low[k], middle + offset - bound - slack), min(high[k], middle + offset + bound + slack)
    return low[k] <= high[k]


@compiled
def narrow(sector: Array, low: Array, high: Array, _reach: Array) -> Mask:
    """Cut slices down to the headings that a compass says, as the bearing of a sector."""
    left = np.ones(len(low), dtype=np.bool_)
    for k in range(len(low)):
        left[k] = _narrow(low, high, k, sector[0], sector[1])
    return left


@compiled
def _sector_rows(place: Array, centre: float, bound: float, nearest: float, farthest: float) -> tuple[Array, Array]:
    """Return half-planes around all x from which a place is in a sector: with d = place - x in it."""
    wide = min(bound, np.pi)
    around, reach = far_and_near(centre, wide, nearest, farthest, TANGENT_ANGLE)
    beside = sides(centre, wide) if wide < np.pi / 2 else np.empty((0, 2))
    normals, shifts = -np.concatenate((around, beside)), np.concatenate((reach, np.zeros(len(beside))))
    rounding = 64 * EPSILON * (abs(place[0]) + abs(place[1]) + farthest)
    for k in range(len(normals)):
        shifts[k] += normals[k, 0] * place[0] + normals[k, 1] * place[1] + rounding
    return normals, shifts


@compiled
def see_place(place: Array, sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    """Cut slices down to the poses from which a place (2,) [m] is in the sector."""
    left = np.ones(len(low), dtype=np.bool_)
    for k in range(len(low)):
        centre, bound = (low[k] + high[k]) / 2 + sector[0], (high[k] - low[k]) / 2 + sector[1] + 4 * ANGLE_ROUNDING
        normals, offsets = _sector_rows(place, centre, bound, sector[2], sector[3])
        vertices, margin = tighten(reach[k], normals, offsets)
        left[k] = len(vertices) > 0
        if left[k] and sector[1] < np.pi / 2:
            middle, half = span_of(place - vertices, margin + 4 * EPSILON * np.abs(place).max())
            left[k] = half >= np.pi / 2 or _narrow(low, high, k, middle - sector[0], half + sector[1])
    return left


@compiled
def see_body(body: Array, sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    """Cut slices down to the poses from which a body, by its supports, is in the sector.

    With d in the sector, x = x_body - d: the sum of the body's polygon and the sector turned round.
    """
    left, apart = np.ones(len(low), dtype=np.bool_), np.empty(COUNT)
    rows, bare = np.empty((0, 2)), np.empty(0)
    for k in range(len(low)):
        centre, bound = (low[k] + high[k]) / 2 + sector[0], (high[k] - low[k]) / 2 + sector[1] + 4 * ANGLE_ROUNDING
        supports = sector_supports(centre + np.pi, bound, sector[2], sector[3])
        for m in range(COUNT):
            reach[k, m] = min(reach[k, m], body[m] + supports[m] + 4 * EPSILON * abs(body[m]))
        left[k] = len(tighten(reach[k], rows, bare)[0]) > 0
        if left[k] and sector[1] < np.pi / 2:
            for m in range(COUNT):
                apart[m] = body[m] + reach[k, (m + 2 * QUARTER) % COUNT] + 4 * EPSILON * abs(body[m])
            vertices, margin = tighten(apart, rows, bare)
            if len(vertices):
                middle, half = span_of(vertices, margin)
                left[k] = half >= np.pi / 2 or _narrow(low, high, k, middle - sector[0], half + sector[1])
    return left


@compiled
def seen_from(sector: Array, low: Array, high: Array, reach: Array) -> Array:
    """Return supports around every place that is in the sector of a pose of these slices."""
    farthest = np.full(COUNT, -np.inf)
    for k in range(len(low)):
        centre, bound = (low[k] + high[k]) / 2 + sector[0], (high[k] - low[k]) / 2 + sector[1] + 4 * ANGLE_ROUNDING
        supports = sector_supports(centre, bound, sector[2], sector[3])
        for m in range(COUNT):
            farthest[m] = max(farthest[m], reach[k, m] + supports[m] + 4 * EPSILON * abs(reach[k, m]))
    return farthest


@compiled
def stay_within(body: Array, _low: Array, _high: Array, reach: Array) -> Mask:
    """Cut slices down to the positions in a polygon, by its supports."""
    left = np.ones(len(reach), dtype=np.bool_)
    rows, bare = np.empty((0, 2)), np.empty(0)
    for k in range(len(reach)):
        if (reach[k] > body).any():
            put(np.minimum(reach[k], body), reach[k])
            left[k] = len(tighten(reach[k], rows, bare)[0]) > 0
    return left


@compiled
def regrid(grid: tuple[Array, Array, Array], group: Integers, low: Array, high: Array, reach: Array) -> None:
    """Sort slices into the cells of a grid of headings: in each group at most one slice a cell, the hull of what is in it.

    What is enlarged is the grid, low, high and reach of the slices of all cells in a circle (groups, cells), where inf and -inf
    are nothing. Slices of different groups (s,), numbers from 0 on, are not put together.
    """
    (first, last, farthest), turn = grid, 2 * np.pi
    cells = first.shape[1]
    width = turn / cells
    for k in range(len(low)):
        # What is a hair over an edge stays with its cell, or neighbours would be put together again and again.
        top = min(high[k], low[k] + turn)
        begin = int(np.floor(low[k] / width + HAIR_OF_CELL))
        end = max(begin, int(np.ceil(top / width - HAIR_OF_CELL)) - 1)
        for cell in range(begin, end + 1):
            m, g = cell % cells, group[k]
            away = turn * ((cell - m) // cells)
            slack = ANGLE_ROUNDING * (1 + abs(away))
            first[g, m] = min(first[g, m], (low[k] if cell == begin else cell * width) - away - slack)
            last[g, m] = max(last[g, m], (top if cell == end else (cell + 1) * width) - away + slack)
            put(np.maximum(farthest[g, m], reach[k]), farthest[g, m])


def see_any(bodies: Sequence[Array], sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    """Cut slices down to the poses from which one of several bodies, each by its supports, is in the sector."""
    each = [(low.copy(), high.copy(), reach.copy()) for _ in bodies]
    left = np.array([see_body(body, sector, *mine) for body, mine in zip(bodies, each, strict=True)])
    low[:] = np.where(left, [mine[0] for mine in each], np.inf).min(axis=0)
    high[:] = np.where(left, [mine[1] for mine in each], -np.inf).max(axis=0)
    reach[:] = np.where(left[:, :, None], [mine[2] for mine in each], -np.inf).max(axis=0)
    return np.asarray(left.any(axis=0))
