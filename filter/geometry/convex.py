"""Convex polygons in the plane, compiled: what is done to thousands of them in a step.

Vertices are (e, 2), counter-clockwise; edge k begins at vertex k.
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers, Mask
from filter.compiled import compiled

EPSILON = float(np.finfo(float).eps)


@compiled
def cut_box(normals: Array, offsets: Array, lower: Array, upper: Array) -> tuple[Array, Integers, float]:
    """Cut a box by half-planes, one after the other (Sutherland and Hodgman, 1974).

    A vertex is cut away only where rounding leaves no doubt that it is outside, and new vertices lie outward of the cut
    by as much; half-planes that cut nothing are left out.

    Args:
        normals: (k, 2), of length 1 to rounding.
        offsets: (k,) [m].
        lower: (2,) corner of the box [m].
        upper: (2,) corner of the box [m].

    Returns:
        Vertices (e, 2); the half-plane behind each edge (e,), with -4 to -1 for the box's right, top, left and bottom side;
        and how far outward the vertices can be short of the polygon [m]. No vertex proves that the set is empty.
    """
    vertices, edges = np.empty((len(offsets) + 4, 2)), np.empty(len(offsets) + 4, dtype=np.int64)
    size, margin = cut_box_into((vertices, edges), normals, offsets, lower, upper)
    return vertices[:size].copy(), edges[:size].copy(), margin


@compiled
def cut_box_into(into: tuple[Array, Integers], normals: Array, offsets: Array, lower: Array, upper: Array) -> tuple[int, float]:
    """Do what `cut_box` does into vertices (k + 4, 2) and edges (k + 4,); return how many were written, and the margin."""
    return cut_into(into, (normals, offsets, np.arange(len(offsets))), lower, upper, room(len(offsets)))


Room = tuple[Array, Array, Integers, Integers, Array]  # vertices and edges before and after a cut, and how far beyond it
Lines = tuple[Array, Array, Integers]  # normals (r, 2) and offsets (r,), and which of them are meant


@compiled
def room(count: int) -> Room:
    """Return room to cut a box by so many half-planes."""
    vertices, edges = np.empty((2, count + 5, 2)), np.empty((2, count + 5), dtype=np.int64)
    return vertices[0], vertices[1], edges[0], edges[1], np.empty(count + 5)


@compiled
def cut_into(into: tuple[Array, Integers], lines: Lines, lower: Array, upper: Array, space: Room) -> tuple[int, float]:
    """Do what `cut_box` does in room that is there; return how many vertices and edges were written, and the margin."""
    (vertices, edges), (normals, offsets, rows) = into, lines
    here, after, behind, behind_after, beyond = space
    middle_x, middle_y = (lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2
    width, height = upper[0] - middle_x, upper[1] - middle_y
    largest = max(abs(middle_x), abs(middle_y)) + max(width, height)
    here[0], here[1], here[2], here[3] = (width, -height), (width, height), (-width, height), (-width, -height)
    behind[0], behind[1], behind[2], behind[3] = -4, -3, -2, -1
    size = 4
    for row in rows:
        a, b = normals[row, 0], normals[row, 1]
        doubt = 8 * EPSILON * (abs(offsets[row]) + (abs(a) + abs(b)) * largest)
        level = offsets[row] - (a * middle_x + b * middle_y) + doubt
        some = False
        for m in range(size):
            beyond[m] = a * here[m, 0] + b * here[m, 1] - level
            some = some or beyond[m] > 0
        if not some:
            continue
        kept = 0
        for m in range(size):
            before = m - 1 if m else size - 1
            if (beyond[before] > 0) != (beyond[m] > 0):
                share = beyond[before] / (beyond[before] - beyond[m])
                after[kept, 0] = here[before, 0] + share * (here[m, 0] - here[before, 0])
                after[kept, 1] = here[before, 1] + share * (here[m, 1] - here[before, 1])
                behind_after[kept] = row if beyond[m] > 0 else behind[before]
                kept += 1
            if beyond[m] <= 0:
                after[kept, 0], after[kept, 1] = here[m, 0], here[m, 1]
                behind_after[kept] = behind[m]
                kept += 1
        here, after, behind, behind_after, size = after, here, behind_after, behind, kept
        if not size:
            break
    for m in range(size):
        vertices[m, 0], vertices[m, 1], edges[m] = here[m, 0] + middle_x, here[m, 1] + middle_y, behind[m]
    return size, 4 * EPSILON * (len(rows) + 4) * largest


@compiled
def side_of_box(side: int, lower: Array, upper: Array) -> tuple[float, float, float]:
    """Return normal and offset of a side of a box, -4 to -1 for right, top, left and bottom."""
    if side < -2:
        return (1.0, 0.0, upper[0]) if side == -4 else (0.0, 1.0, upper[1])
    return (-1.0, 0.0, -lower[0]) if side == -2 else (0.0, -1.0, -lower[1])


@compiled
def hull_of(points: Array) -> Array:
    """Return the corners of the convex hull of (k, 2) points, counter-clockwise (monotone chain; Andrew, 1979)."""
    order = np.argsort(points[:, 1], kind="mergesort")
    order = order[np.argsort(points[order, 0], kind="mergesort")]
    hull, size = np.empty((2 * len(points), 2)), 0
    for way in range(2):
        base = size
        for place in range(len(order)):
            point = points[order[place if way == 0 else len(order) - 1 - place]]
            if size > base and hull[size - 1, 0] == point[0] and hull[size - 1, 1] == point[1]:
                continue
            while size > base + 1 and not _turns_left(hull[size - 2], hull[size - 1], point):
                size -= 1
            hull[size] = point
            size += 1
        size -= 1  # where one chain ends the other begins
    return hull[: max(size, 1)].copy()


@compiled
def _turns_left(a: Array, b: Array, c: Array) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0


@compiled
def area_of(vertices: Array) -> float:
    """Return the area of a simple polygon with (k, 2) counter-clockwise vertices, from 0 on [m2]."""
    total = 0.0
    for k in range(1, len(vertices) - 1):
        x0, y0 = vertices[k, 0] - vertices[0, 0], vertices[k, 1] - vertices[0, 1]
        x1, y1 = vertices[k + 1, 0] - vertices[0, 0], vertices[k + 1, 1] - vertices[0, 1]
        total += x0 * y1 - x1 * y0
    return max(0.0, total / 2)


@compiled
def centroid_of(vertices: Array) -> tuple[float, float]:
    """Return the centre of mass; of a polygon without area, the middle of its vertices."""
    count = len(vertices)
    middle_x, middle_y = vertices[:, 0].mean(), vertices[:, 1].mean()
    total, size, moment_x, moment_y = 0.0, 0.0, 0.0, 0.0
    for k in range(count):
        x0, y0 = vertices[k, 0] - middle_x, vertices[k, 1] - middle_y
        x1, y1 = vertices[(k + 1) % count, 0] - middle_x, vertices[(k + 1) % count, 1] - middle_y
        cross = x0 * y1 - x1 * y0
        total += cross
        size += x0 * x0 + y0 * y0
        moment_x += (x0 + x1) * cross
        moment_y += (y0 + y1) * cross
    if total <= 64 * EPSILON * size:
        return middle_x, middle_y
    return middle_x + moment_x / (3 * total), middle_y + moment_y / (3 * total)


@compiled
def span_of(vertices: Array, margin: float) -> tuple[float, float]:
    """Return centre and bound of an arc that contains the direction from the origin to every point; errs outward [rad].

    The bound is pi when the origin is inside, or so near that no direction is excluded for sure.

    Args:
        vertices: (e, 2) [m].
        margin: The hull of the vertices widened by this is meant [m].
    """
    doubt = 2 * margin + 8 * EPSILON * np.abs(vertices).max()
    nearest = _distance_of_edges(vertices) - doubt
    angles = np.sort(np.arctan2(vertices[:, 1], vertices[:, 0]))
    widest, gap = 0, -1.0  # what is not seen is one gap; from the inside none is as wide as half a turn
    for k in range(len(angles)):
        following = angles[k + 1] if k + 1 < len(angles) else angles[0] + 2 * np.pi
        if following - angles[k] > gap:
            widest, gap = k, following - angles[k]
    half = np.pi - gap / 2
    if nearest <= 2 * doubt or half >= np.pi / 2:
        return 0.0, np.pi
    return angles[widest] + gap + half, half + 2 * doubt / nearest + 4e-14


@compiled
def _distance_of_edges(vertices: Array) -> float:
    """Return the distance of the origin from the nearest edge [m]."""
    nearest = np.inf
    for k in range(len(vertices)):
        following = (k + 1) % len(vertices)
        x, y = vertices[k, 0], vertices[k, 1]
        along_x, along_y = vertices[following, 0] - x, vertices[following, 1] - y
        length = max(along_x * along_x + along_y * along_y, 1e-300)
        share = min(1.0, max(0.0, -(x * along_x + y * along_y) / length))
        nearest = min(nearest, np.hypot(x + share * along_x, y + share * along_y))
    return nearest


@compiled
def worthy(normals: Array, offsets: Array, removable: Mask, budget: int, allowance: float) -> tuple[Mask, float]:
    """Return which edges of a polygon to keep so that little area is added, and how much is [m2].

    Greedy: the edge whose removal adds the least area goes first; edges go as long as there are more removable ones than
    the budget, or all that went add no more than the allowance.

    Args:
        normals: (e, 2) counter-clockwise.
        offsets: (e,) best from a point inside, for the rounding [m].
        removable: (e,) the others stay, and count nothing.
        budget: How many of them may stay.
        allowance: How much area may be added anyway [m2]; negative for none.
    """
    count = len(offsets)
    keep = np.ones(count, dtype=np.bool_)
    if not count:
        return keep, 0.0
    before, after = np.arange(-1, count - 1), np.arange(1, count + 1)
    before[0], after[count - 1] = count - 1, 0
    added = np.full(count, np.inf)
    for k in range(count):
        if removable[k]:
            added[k] = _added_area(normals, offsets, before[k], k, after[k])
    left, spent = removable.sum(), 0.0
    while left:
        least = -1
        for k in range(count):
            if keep[k] and removable[k] and (least < 0 or added[k] < added[least]):
                least = k
        if left <= budget and not spent + added[least] <= allowance:
            break
        keep[least], left = False, left - 1
        spent += added[least]
        last, following = before[least], after[least]
        after[last], before[following] = following, last
        for k in (last, following):
            if removable[k]:
                added[k] = _added_area(normals, offsets, before[k], k, after[k])
    return keep, spent


@compiled
def worthy_vertices(vertices: Array, allowance: float) -> Mask:
    """Return which vertices of a convex polygon to keep so that little area is cut off, as `worthy` does for edges.

    Args:
        vertices: (e, 2) counter-clockwise; some may coincide [m].
        allowance: How much area may be cut off in all [m2].
    """
    count = len(vertices)
    keep, before, after = np.ones(count, dtype=np.bool_), np.arange(-1, count - 1), np.arange(1, count + 1)
    if count <= 3:
        return keep
    before[0], after[count - 1] = count - 1, 0
    cut = np.empty(count)
    for k in range(count):
        cut[k] = _triangle(vertices, before[k], k, after[k])
    left, spent = count, 0.0
    while left > 3:
        least = -1
        for k in range(count):
            if keep[k] and (least < 0 or cut[k] < cut[least]):
                least = k
        spent += cut[least]
        if not spent <= allowance:
            break
        keep[least], left = False, left - 1
        last, following = before[least], after[least]
        after[last], before[following] = following, last
        for k in (last, following):
            cut[k] = _triangle(vertices, before[k], k, after[k])
    return keep


@compiled
def _triangle(vertices: Array, a: int, b: int, c: int) -> float:
    """Return the area between three vertices [m2]."""
    x0, y0 = vertices[b, 0] - vertices[a, 0], vertices[b, 1] - vertices[a, 1]
    x1, y1 = vertices[c, 0] - vertices[a, 0], vertices[c, 1] - vertices[a, 1]
    return abs(x0 * y1 - x1 * y0) / 2


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
