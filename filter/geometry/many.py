"""Many polygons at a time, as a few arrays: those of a whole team in one compiled loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import overload

import numpy as np

from filter.arrays import Array, Frozen, Integers, Lists, Mask, chosen, read_only
from filter.compiled import compiled
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON, Lines, area_of, clip_box, line_behind, span_of
from filter.geometry.polygon import Polygon

Groups = tuple[Integers, Integers]  # where each of g groups begins and ends, (g,) and (g,)


@dataclass(frozen=True, eq=False)
class Polygons(Lists, Sequence[Polygon]):
    """Polygons laid end to end: the edges of polygon k are first[k] to first[k + 1].

    Attributes:
        normals: (e, 2) as in `Polygon`, as are offsets (e,), vertices (e, 2) and margin (n,) [m].
        first: (n + 1,) where the edges of each begin.
    """

    normals: Array
    offsets: Array
    vertices: Array
    margin: Array
    first: Integers
    of_lists = ("margin",)

    @classmethod
    def of(cls, polygons: Sequence[Polygon]) -> Polygons:
        """Return single polygons laid end to end."""
        none, each = (np.zeros((0, 2)), np.zeros(0), np.zeros((0, 2))), ((p.normals, p.offsets, p.vertices) for p in polygons)
        normals, offsets, vertices = map(np.concatenate, zip(none, *each, strict=True))
        first = np.cumsum([0, *(len(polygon.offsets) for polygon in polygons)])
        return cls(normals, offsets, vertices, np.array([polygon.margin for polygon in polygons], dtype=float), first)

    @overload
    def __getitem__(self, index: int) -> Polygon: ...

    @overload
    def __getitem__(self, index: slice) -> list[Polygon]: ...

    def __getitem__(self, index: int | slice) -> Polygon | list[Polygon]:
        k = chosen("a polygon", index, len(self))
        if isinstance(k, range):
            return [self[each] for each in k]
        edges = slice(self.first[k], self.first[k + 1])
        return Polygon._of(self.normals[edges], self.offsets[edges], self.vertices[edges], float(self.margin[k]))

    @cached_property
    def owner(self) -> Integers:
        """(e,) whose each edge is."""
        return np.repeat(np.arange(len(self)), self.counts)

    @cached_property
    def areas(self) -> Array:
        """(n,) areas of the hulls of the vertices [m2]."""
        return read_only(areas_of(self.vertices, self.first))

    def boxes(self) -> tuple[Array, Array]:
        """Return lower and upper corners (n, 2) of boxes around the polygons; they err outward [m]."""
        begin = self.first[:-1]
        low, high = np.minimum.reduceat(self.vertices, begin), np.maximum.reduceat(self.vertices, begin)
        outward = (self.margin + 8 * EPSILON * np.maximum(np.abs(low), np.abs(high)).max(axis=1))[:, None]
        return low - outward, high + outward

    def corners(self) -> list[Array]:
        """Return the vertices (e, 2) of each polygon [m]."""
        return np.split(self.vertices, self.first[1:-1]) if len(self) else []

    def contains(self, points: Array) -> Mask:
        """Return (n,) whether each polygon's half-planes hold at its own of (n, 2) points [m]."""
        broken = (self.normals * points[self.owner]).sum(axis=1) > self.offsets
        return np.bincount(self.owner[broken], minlength=len(self)) == 0

    def turned_about(self, which: Mask) -> Polygons:
        """Return {-x} where (n,) says so, and {x} elsewhere: exact."""
        sign = np.where(which[self.owner], -1.0, 1.0)[:, None]
        return Polygons(sign * self.normals, self.offsets, sign * self.vertices, self.margin, self.first)

    def spans(self, sign: Array, points: Array, by: Array, radius: Array) -> AngularIntervals:
        """Return (n) arcs that contain the directions from the origin to places, of which polygons tell, see `span_of` [rad].

        These are sign x + point - by, and up to a radius from there: x is any point of a polygon; each has a sign, 1 or -1, of
        (n,), a point and a way by of (n, 2), and a radius of (n,) [m].
        """
        return AngularIntervals.of_found(*_spans((self.vertices, self.margin, self.first), sign, (points, by), radius))


@dataclass(frozen=True, eq=False)
class Clipped(Frozen):
    """What half-planes leave of boxes, several at a time.

    Attributes:
        polygons: (g) what is left; the whole box where that is nothing.
        behind: (e,) the half-plane, of r, behind each edge; from r on the box's right, top, left and bottom side.
        empty: (g,) whether nothing is left, for sure.
    """

    polygons: Polygons
    behind: Integers
    empty: Mask


def clip_boxes(normals: Array, offsets: Array, groups: Groups, lower: Array, upper: Array) -> Clipped:
    """Cut each of g boxes with corners (g, 2) by its own group of r half-planes, as `clip_box` does [m]."""
    begin, end = groups
    most, count = int((end - begin).sum()) + 4 * len(begin), len(begin)
    lines, vertices, behind = (np.empty((most, 2)), np.empty(most)), np.empty((most, 2)), np.empty(most, dtype=np.int64)
    margin, first, empty = np.empty(count), np.zeros(count + 1, dtype=np.int64), np.zeros(count, dtype=bool)
    _clip((*lines, vertices, behind), (margin, first, empty), (normals, offsets), groups, (lower, upper))
    outward, reach, corners = (column[: first[-1]].copy() for column in (*lines, vertices))
    return Clipped(Polygons(outward, reach, corners, margin, first), behind[: first[-1]].copy(), empty)


@compiled
def _clip(
    edges: tuple[Array, Array, Array, Integers], each: tuple[Array, Integers, Mask], lines: Lines, groups: Groups, box: Lines
) -> None:
    """Write normals, offsets, vertices and rows of the edges, and margin, beginning and emptiness of each polygon."""
    (outward, reach, vertices, behind), (margin, first, empty) = edges, each
    (normals, offsets), (begin, end), (lower, upper) = lines, groups, box
    for g in range(len(begin)):
        at, own = first[g], (normals[begin[g] : end[g]], offsets[begin[g] : end[g]])
        into = vertices[at:], behind[at:]
        size, margin[g] = clip_box(into, own, lower[g], upper[g])
        if not size:
            empty[g], own = True, (normals[:0], offsets[:0])
            size, margin[g] = clip_box(into, own, lower[g], upper[g])
        for k in range(at, at + size):
            outward[k, 0], outward[k, 1], reach[k] = line_behind(behind[k], own, lower[g], upper[g])
            behind[k] += begin[g] if behind[k] < len(own[1]) else len(offsets) - len(own[1])
        first[g + 1] = at + size


@compiled
def areas_of(vertices: Array, first: Integers) -> Array:
    """Return (n,) areas of polygons whose vertices lie end to end [m2]; 0 where there are none."""
    areas = np.empty(len(first) - 1)
    for k in range(len(areas)):
        areas[k] = area_of(vertices[first[k] : first[k + 1]])
    return areas


@compiled
def _spans(polygons: tuple[Array, Array, Integers], sign: Array, moved: tuple[Array, Array], radius: Array) -> Array:
    """Return (2, n) centres and bounds of spans."""
    (vertices, margin, first), (points, by), spans = polygons, moved, np.empty((2, len(sign)))
    for k in range(len(sign)):
        places, size = np.empty((first[k + 1] - first[k], 2)), 0.0
        for axis in range(2):
            point, way, most = points[k, axis], by[k, axis], 0.0
            for m in range(len(places)):
                vertex = vertices[first[k] + m, axis]
                places[m, axis], most = sign[k] * vertex + (point - way), max(most, abs(vertex))
            size += abs(point) + abs(way) + most
        spans[0, k], spans[1, k] = span_of(places, margin[k] + radius[k] + 4 * EPSILON * size)
    return spans
