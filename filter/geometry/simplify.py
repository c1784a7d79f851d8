"""Which edges of a convex polygon to leave out so that it grows by little, and which vertices so that it shrinks by little."""

import numpy as np

from filter.arrays import Array, Mask
from filter.compiled import compiled, sum_of
from filter.geometry.convex import cross


@compiled
def edges_worth_keeping(
    normals: Array, offsets: Array, removable: Mask, budget: int | np.int64, allowance: float
) -> tuple[Mask, float]:
    """Return which edges of a polygon to keep so that little area is added, and how much is [m2].

    Edges go as long as there are more removable ones than the budget, or all that went add no more than the allowance [m2],
    none if that is negative. Those that are not removable stay, and count nothing. Normals are counter-clockwise, offsets best
    from a point inside, for the rounding [m].
    """
    return _worth_keeping(True, normals, offsets, removable, budget, 0, allowance)


@compiled
def vertices_worth_keeping(vertices: Array, allowance: float) -> Mask:
    """Return which of (e, 2) counter-clockwise vertices, of which some may coincide, to keep so that little area is cut off.

    They go as long as all that went cut off no more than the allowance [m2]; three stay.
    """
    count = len(vertices)
    return _worth_keeping(False, vertices, np.empty(0), np.ones(count, dtype=np.bool_), count, 3, allowance)[0]


@compiled
def _worth_keeping(
    are_edges: bool, rows: Array, offsets: Array, removable: Mask, budget: int | np.int64, fewest: int, allowance: float
) -> tuple[Mask, float]:
    """Return which edges, or vertices, to keep, and how much area the others change; those go first that change little."""
    count = len(rows)
    keep, before, after = np.ones(count, dtype=np.bool_), np.arange(-1, count - 1), np.arange(1, count + 1)
    left, spent = sum_of(removable), 0.0
    if left <= fewest:
        return keep, spent
    before[0], after[count - 1] = count - 1, 0
    change = np.empty(count)
    for k in range(count):
        if removable[k]:
            change[k] = _change(are_edges, rows, offsets, before[k], k, after[k])
    while left > fewest:
        least = -1
        for k in range(count):
            if keep[k] and removable[k] and (least < 0 or change[k] < change[least]):
                least = k
        if left <= budget and not spent + change[least] <= allowance:
            break
        keep[least] = False
        left -= 1
        spent += change[least]
        last, following = before[least], after[least]
        after[last], before[following] = following, last
        for k in (last, following):
            if removable[k]:
                change[k] = _change(are_edges, rows, offsets, before[k], k, after[k])
    return keep, spent


@compiled
def _change(are_edges: bool, rows: Array, offsets: Array, before: int, k: int, after: int) -> float:
    """Return the area that removing an edge adds, or that removing a vertex cuts off [m2]."""
    if are_edges:
        return _added_area(rows, offsets, before, k, after)
    return abs(cross(rows[before], rows[k], rows[after])) / 2


@compiled
def _added_area(normals: Array, offsets: Array, before: int, edge: int, after: int) -> float:
    """Return the area of the triangle that removing an edge adds; infinite where its neighbours do not meet beyond it [m2]."""
    starts, x0, y0 = _meet(normals, offsets, before, edge)
    ends, x1, y1 = _meet(normals, offsets, edge, after)
    meets, x2, y2 = _meet(normals, offsets, before, after)
    if not (starts and ends and meets):
        return np.inf
    return abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) / 2


@compiled
def _meet(normals: Array, offsets: Array, first: int, second: int) -> tuple[bool, float, float]:
    """Return whether a second line turns left of the first by less than half a turn, and where they meet."""
    a, b, c = normals[first, 0], normals[first, 1], offsets[first]
    d, e, f = normals[second, 0], normals[second, 1], offsets[second]
    turn = a * e - b * d
    if turn <= 0:
        return False, 0.0, 0.0
    return True, (c * e - b * f) / turn, (a * f - c * d) / turn
