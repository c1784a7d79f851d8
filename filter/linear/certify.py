"""Offsets that are proved from a few rows, compiled: the bound of `LinearProgram.certified_bounds`, for loops.

A corner of a polygon is in two rows. Every half-plane through it follows from them, with the sines as multipliers that write
its normal as a combination of theirs. So sides of boxes around polygons are proved, and rows through their corners.
"""

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled, sum_of
from filter.geometry.convex import EPSILON
from filter.linear.constraints import WORLD, Columns

Boxes = tuple[Array, Array]  # lower and upper corners (n, 2) of all robots
Members = tuple[Integers, Array, Array]  # the place of each robot (n,), centre and radius (v,) of the members' coordinates
Outlines = tuple[Array, Array, Integers, Integers]  # normals, vertices, the row behind each edge, and where each begins
# What underflow can take from some hundred products.
UNDERFLOW = 1e-300
# A multiplier below this says that a row does not matter.
WORTHLESS = 1e-12


@compiled
def members_at(members: Integers, place: Integers, box: Boxes) -> Members:
    """Return where some robots are, radii rounded up; their places among them are written into `place` (n,)."""
    centre, radius = np.empty(2 * len(members)), np.empty(2 * len(members))
    for k in range(len(members)):
        place[members[k]] = k
        for m in range(2):
            low, high = box[0][members[k], m], box[1][members[k], m]
            middle = (low + high) / 2
            centre[2 * k + m] = middle
            radius[2 * k + m] = max(high - middle, middle - low) * (1 + 4 * EPSILON)
    return place, centre, radius


@compiled
def certified(i: int, j: int, normal: Array, prices: Array, number: Integers, members: Members, team: Columns) -> float:
    """Return an offset that holds in exact arithmetic for a direction (2,) of x_j - x_i, or of x_j where i is WORLD [m].

    It follows from constraints by number (p,), with prices (p,). A price that is not above 0 and finite counts nothing, nor
    does a number beyond the last one.
    """
    (place, centre, radius), (first, second, normals, offsets) = members, team
    residual, size = np.zeros(len(centre)), np.zeros(len(centre))
    total, doubt, operations = 0.0, 0.0, 2 * (len(number) + len(centre) + 8) * EPSILON
    along, reach = 0.0, 0.0
    for robot, sign in ((j, 1.0), (i, -1.0)):
        if robot >= 0:
            for m in range(2):
                at = 2 * place[robot] + m
                residual[at] = sign * normal[m]
                size[at] = abs(normal[m])
                along += residual[at] * centre[at]
                reach += abs(residual[at] * centre[at])
    for k in range(len(number)):
        row, price = number[k], prices[k]
        if row >= len(offsets) or not 0 < price < np.inf:
            continue
        slack, magnitude = offsets[row], abs(offsets[row])
        for robot, sign in ((second[row], 1.0), (first[row], -1.0)):
            if robot >= 0:
                for m in range(2):
                    at, coefficient = 2 * place[robot] + m, sign * normals[row, m]
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
    return (along + total) + doubt * (1 + 1e-9) + UNDERFLOW * (1 + sum_of(radius))


@compiled
def imply(
    into: tuple[Array, Integers, Array],
    pairs: tuple[Integers, Integers],
    outlines: Outlines,
    asked: tuple[Integers, Array],
    team: Columns,
    box: Boxes,
) -> None:
    """Write certified offsets (q,) [m], and the rows (q, 2) and multipliers (q, 2) that prove each, 0 for a row of no use.

    Asked is which polygon (q,), and in which direction (q, 2) of length 1. The polygons are those of pairs i, j (g), from
    their own rows; what is behind an edge is no row if its number is beyond the last one.
    """
    (offsets, rows, prices), (i, j), (normals, vertices, behind, first), (whose, directions) = into, pairs, outlines, asked
    place, g = np.full(len(box[0]), -1), -1
    where = members_at(j[:0], place, box)
    for q in range(len(whose)):
        direction = directions[q]
        if whose[q] != g:
            g = whose[q]
            where = members_at(np.array([j[g]]) if i[g] == WORLD else np.array([j[g], i[g]]), place, box)
        following = _corner((normals, vertices), first[g], first[g + 1], direction)
        before = following - 1 if following > first[g] else first[g + 1] - 1
        rows[q, 0], rows[q, 1], prices[q] = behind[before], behind[following], 0.0
        turned = _across(normals[before], normals[following])
        parts = _across(direction, normals[following]), _across(normals[before], direction)
        for side in range(2):
            if rows[q, side] < len(team[3]) and turned != 0 and WORTHLESS < parts[side] / turned < np.inf:
                prices[q, side] = parts[side] / turned
        offsets[q] = certified(i[g], j[g], direction, prices[q], rows[q], where, team)


@compiled
def _corner(edges: tuple[Array, Array], begin: int, end: int, direction: Array) -> int:
    """Return the vertex that is farthest in a direction; an edge begins at each, and ends at the next.

    Where several rows meet in one point, vertices coincide: only two edges that turn past the direction prove anything tight.
    """
    (normals, vertices), chosen, most, turns_past = edges, begin, -np.inf, False
    for k in range(begin, end):
        a, b = normals[k - 1 if k > begin else end - 1], normals[k]
        between = _across(a, b) > 0 and _across(a, direction) >= 0 and _across(direction, b) >= 0
        along = direction[0] * vertices[k, 0] + direction[1] * vertices[k, 1]
        if (between, along) > (turns_past, most):
            chosen, most, turns_past = k, along, between
    return chosen


@compiled
def _across(a: Array, b: Array) -> float:
    """Return the cross product of two vectors (2,)."""
    return a[0] * b[1] - a[1] * b[0]
