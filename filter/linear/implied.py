"""What two neighbouring edges of a polygon say of any other direction, proved: compiled.

A corner of a polygon is in two rows. Every half-plane through it follows from them, with the sines as multipliers that write
its normal as a combination of theirs. So sides of boxes around polygons are proved, and rows through their corners.
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.linear.certify import Boxes, certified, members_at
from filter.linear.constraints import WORLD, Columns

# A multiplier below this says that a row does not matter.
WORTHLESS = 1e-12

Outlines = tuple[Array, Array, Integers, Integers]  # normals, vertices, the row behind each edge, and where each begins


@compiled
def imply(
    into: tuple[Array, Integers, Array],
    pairs: tuple[Integers, Integers],
    outlines: Outlines,
    asked: tuple[Integers, Array],
    team: Columns,
    box: Boxes,
) -> None:
    """Write certified offsets, and the two rows and multipliers that prove each.

    Args:
        into: Offsets (q,) [m], rows (q, 2) and multipliers (q, 2), 0 for a row of no use.
        pairs: i and j (g) of each polygon.
        outlines: The polygons, from rows on their own robot or pair; what is behind an edge is no row from `len(team)` on.
        asked: Which polygon (q,), and in which direction (q, 2) of length 1.
        team: i, j, normal and offset of all rows.
        box: Lower and upper corners (n, 2) of all robots.
    """
    (offsets, rows, prices), (i, j), (normals, vertices, behind, first), (whose, directions) = into, pairs, outlines, asked
    place = np.full(len(box[0]), -1)
    for q in range(len(whose)):
        g, direction = whose[q], directions[q]
        members = np.array([j[g]]) if i[g] == WORLD else np.array([j[g], i[g]])
        following = _corner((normals, vertices), first[g], first[g + 1], direction)
        before = following - 1 if following > first[g] else first[g + 1] - 1
        rows[q, 0], rows[q, 1], prices[q] = behind[before], behind[following], 0.0
        turned = across(normals[before], normals[following])
        for side in range(2):
            part = across(direction, normals[following]) if side == 0 else across(normals[before], direction)
            if rows[q, side] < len(team[3]) and turned != 0 and WORTHLESS < part / turned < np.inf:
                prices[q, side] = part / turned
        offsets[q] = certified(i[g], j[g], direction, prices[q], rows[q], members_at(members, place, box), team)


@compiled
def _corner(edges: tuple[Array, Array], begin: int, end: int, direction: Array) -> int:
    """Return the vertex that is farthest in a direction; an edge begins at each, and ends at the next.

    Where several rows meet in one point, vertices coincide: only two edges that turn past the direction prove anything tight.
    """
    (normals, vertices), chosen, most, turns_past = edges, begin, -np.inf, False
    for k in range(begin, end):
        a, b = normals[k - 1 if k > begin else end - 1], normals[k]
        between = across(a, b) > 0 and across(a, direction) >= 0 and across(direction, b) >= 0
        along = direction[0] * vertices[k, 0] + direction[1] * vertices[k, 1]
        if (between, along) > (turns_past, most):
            chosen, most, turns_past = k, along, between
    return chosen


@compiled
def across(a: Array, b: Array) -> float:
    """Return the cross product of two vectors (2,)."""
    return a[0] * b[1] - a[1] * b[0]
