"""Convex polygons in the plane, compiled: what is done to thousands of them in a step.

Vertices are (e, 2), counter-clockwise; edge k begins at vertex k.
"""

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled, put, sum_of

EPSILON = float(np.finfo(float).eps)
SMALLEST = 1e-100  # what is divided by is never smaller
Lines = tuple[Array, Array]  # normals (k, 2), of length 1 to rounding, and offsets (k,) [m]


@compiled
def clip_box(into: tuple[Array, Integers], lines: Lines, lower: Array, upper: Array) -> tuple[int, float]:
    """Cut a box with lower and upper corner (2,) [m] by k half-planes, one after the other (Sutherland and Hodgman, 1974).

    A vertex is cut away only where rounding leaves no doubt that it is outside, and new vertices lie outward of the cut
    by as much; half-planes that cut nothing are left out. Written are vertices (k + 4, 2) and, for each edge (k + 4,), the
    half-plane behind it, from k on the box's right, top, left and bottom side.

    Returns:
        How many vertices there are, 0 only if the set is proved empty; how far outward they can be short of the polygon [m].
    """
    (vertices, edges), (normals, offsets) = into, lines
    size, lines_count = 4, len(offsets)
    here, behind, beyond = np.empty((lines_count + 5, 2)), np.empty(lines_count + 5, dtype=np.int64), np.empty(lines_count + 5)
    after, behind_after = np.empty_like(here), np.empty_like(behind)
    middle_x, middle_y = (lower[0] + upper[0]) / 2, (lower[1] + upper[1]) / 2
    width, height = upper[0] - middle_x, upper[1] - middle_y
    largest = max(abs(middle_x), abs(middle_y)) + max(width, height)
    for side in range(4):
        here[side, 0], here[side, 1] = width if side < 2 else -width, height if 0 < side < 3 else -height
        behind[side] = lines_count + side
    for row in range(lines_count):
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
    return size, 4 * EPSILON * (lines_count + 4) * largest


@compiled
def line_behind(edge: int, lines: Lines, lower: Array, upper: Array) -> tuple[float, float, float]:
    """Return normal and offset of what is behind an edge, by its number in `clip_box`."""
    (normals, offsets), side = lines, edge - len(lines[1])
    if side < 0:
        return normals[edge, 0], normals[edge, 1], offsets[edge]
    if side < 2:
        return (1.0, 0.0, upper[0]) if side == 0 else (0.0, 1.0, upper[1])
    return (-1.0, 0.0, -lower[0]) if side == 2 else (0.0, -1.0, -lower[1])


@compiled
def hull_of(points: Array) -> Array:
    """Return the corners of the convex hull of (k, 2) points, counter-clockwise (monotone chain; Andrew, 1979)."""
    order = _in_order(points[:, 0].copy(), points[:, 1].copy())
    hull, size = np.empty((2 * len(points), 2)), 0
    for way in range(2):
        base = size
        for place in range(len(order)):
            point = points[order[place if way == 0 else len(order) - 1 - place]]
            if size > base and hull[size - 1, 0] == point[0] and hull[size - 1, 1] == point[1]:
                continue
            while size > base + 1 and not cross(hull[size - 2], hull[size - 1], point) > 0:
                size -= 1
            put(point, hull[size])
            size += 1
        size -= 1  # where one chain ends the other begins
    return hull[: max(size, 1)].copy()


@compiled
def _in_order(first: Array, then: Array) -> Integers:
    """Return the order of (k,) pairs of numbers; they are few, and a library's sort takes seconds to compile."""
    order = np.arange(len(first))
    for k in range(1, len(first)):
        place = k
        while place and (first[order[place - 1]], then[order[place - 1]]) > (first[k], then[k]):
            order[place] = order[place - 1]
            place -= 1
        order[place] = k
    return order


@compiled
def cross(a: Array, b: Array, c: Array) -> float:
    """Return twice the area of a triangle with corners (2,), positive where it turns left [m2]."""
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


@compiled
def area_of(vertices: Array) -> float:
    """Return the area of a simple polygon with (k, 2) counter-clockwise vertices, from 0 on [m2]."""
    total = 0.0
    for k in range(1, len(vertices) - 1):
        total += cross(vertices[0], vertices[k], vertices[k + 1])
    return max(0.0, total / 2)


@compiled
def centroid_of(vertices: Array) -> tuple[float, float]:
    """Return the centre of mass; of a polygon without area, the middle of its vertices."""
    count = len(vertices)
    middle_x, middle_y = sum_of(vertices[:, 0]) / count, sum_of(vertices[:, 1]) / count
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
def largest_of(points: Array) -> float:
    """Return the size of the largest coordinate of points (k, 2); 0 where there is none."""
    largest = 0.0
    for k in range(len(points)):
        largest = max(largest, abs(points[k, 0]), abs(points[k, 1]))
    return largest


@compiled
def span_of(vertices: Array, margin: float) -> tuple[float, float]:
    """Return centre and bound of an arc that contains the direction from the origin to every point; errs outward [rad].

    What is meant is the hull of the vertices (e, 2), widened by the margin [m]. The bound is pi when the origin is inside,
    or so near that no direction is excluded for sure.
    """
    doubt = 2 * margin + 8 * EPSILON * largest_of(vertices)
    nearest = _distance_of_edges(vertices) - doubt
    angles = np.arctan2(vertices[:, 1], vertices[:, 0])
    angles = angles[_in_order(angles, angles)]
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
