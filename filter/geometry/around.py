"""What is around polygons of several lists, those of each place together: what holds whichever list is right."""

from collections.abc import Sequence

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.convex import EPSILON, Lines, hull_of
from filter.geometry.many import Polygons, clip_boxes

CAPS = 4  # bound a point, or a segment


def lines_around(several: Sequence[Polygons]) -> tuple[Array, Array, Integers]:
    """Return half-planes around polygon k of each of several lists of n, for every k, by the directions of their hulls' edges.

    These are normals (e, 2), offsets (e,) that no support exceeds [m], and (n + 1,) where those of each k begin; of polygons
    that are the same they are their own.
    """
    parts = ([getattr(each, name) for each in several] for name in ("vertices", "normals", "offsets"))
    vertices, normals, offsets = map(np.concatenate, parts)
    before = np.cumsum([0, *(len(each.vertices) for each in several[:-1])])
    first, margin = np.stack([each.first for each in several]) + before[:, None], np.stack([each.margin for each in several])
    lines = _around(vertices, (normals, offsets), first, margin)
    counts = np.bincount(lines[:, 3].astype(np.int64), minlength=len(several[0]))
    return lines[:, :2].copy(), lines[:, 2].copy(), np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])


def hulls_of(several: Sequence[Polygons]) -> Polygons:
    """Return (n) polygons, each around its own ones in several lists of n; they err outward."""
    normals, offsets, first = lines_around(several)
    boxes = [each.boxes() for each in several]
    lower, upper = np.min([low for low, _ in boxes], axis=0), np.max([high for _, high in boxes], axis=0)
    return clip_boxes(normals, offsets, (first[:-1], first[1:]), lower, upper).polygons


@compiled
def _around(vertices: Array, lines: Lines, first: Integers, margin: Array) -> Array:
    """Return (e, 4) normals, offsets, and the number k that they are of, of b lists with polygons from first (b, n + 1) on."""
    (lists, count), size = margin.shape, 0
    found = np.empty((len(vertices) + CAPS * count, 4))
    for k in range(count):
        begin, end = first[:, k], first[:, k + 1]
        same = _are_same(lines, begin, end)
        hull = vertices[:0] if same else _hull(vertices, begin, end)
        edges = end[0] - begin[0] if same else len(hull) if len(hull) > 2 else CAPS
        for edge in range(edges):
            if same:
                x, y, far = lines[0][begin[0] + edge, 0], lines[0][begin[0] + edge, 1], lines[1][begin[0] + edge]
            else:
                (x, y), far = _outward(hull, edge), -np.inf
                for b in range(lists):
                    far = max(far, _support(vertices[begin[b] : end[b]], margin[b, k], x, y))
            found[size, 0], found[size, 1], found[size, 2], found[size, 3] = x, y, far, k
            size += 1
    return found[:size].copy()


@compiled
def _hull(vertices: Array, begin: Integers, end: Integers) -> Array:
    """Return the corners of the convex hull of all vertices of some polygons."""
    points, size = np.empty(((end - begin).sum(), 2)), 0
    for b in range(len(begin)):
        for m in range(begin[b], end[b]):
            points[size, 0], points[size, 1] = vertices[m, 0], vertices[m, 1]
            size += 1
    return hull_of(points)


@compiled
def _support(vertices: Array, margin: float, x: float, y: float) -> float:
    """Return an upper bound of x and y times a place in a polygon, above that of `Polygon.support`, however that is rounded."""
    most, largest = -np.inf, 0.0
    for m in range(len(vertices)):
        most = max(most, x * vertices[m, 0] + y * vertices[m, 1])
        largest = max(largest, abs(vertices[m, 0]), abs(vertices[m, 1]))
    return most + (margin + 8 * EPSILON * largest) * (abs(x) + abs(y))


@compiled
def _outward(hull: Array, edge: int) -> tuple[float, float]:
    """Return the normal of an edge of a hull, or of a cap of a point or a segment."""
    count = len(hull)
    start = edge if count > 2 else 0
    x, y = 1.0, 0.0
    if count > 1:
        x, y = hull[(start + 1) % count, 0] - hull[start, 0], hull[(start + 1) % count, 1] - hull[start, 1]
    for _ in range(edge if count <= 2 else 0):
        x, y = -y, x
    length = np.hypot(x, y)
    return y / length, -x / length


@compiled
def _are_same(lines: Lines, begin: Integers, end: Integers) -> bool:
    """Return whether some polygons are the same."""
    normals, offsets = lines
    for b in range(1, len(begin)):
        if end[b] - begin[b] != end[0] - begin[0]:
            return False
        for m in range(end[0] - begin[0]):
            one, other = begin[0] + m, begin[b] + m
            if normals[one, 0] != normals[other, 0] or normals[one, 1] != normals[other, 1] or offsets[one] != offsets[other]:
                return False
    return True
