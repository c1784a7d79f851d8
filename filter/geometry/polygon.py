"""Convex polygons in the plane, as half-planes and as vertices: one, or those of a whole team as a few arrays.

The half-planes are the truth of an outer polygon: each one is kept exactly as it was proved. The vertices are computed
from them, within `margin` outward: the hull of the vertices, widened by the margin, contains the polygon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import overload

import numpy as np

from filter.arrays import Array, Floats, Frozen, Integers, Mask, finite, read_only
from filter.compiled import compiled
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import (
    EPSILON,
    area_of,
    centroid_of,
    clip_box_into,
    clip_into,
    clip_room,
    hull_of,
    side_of_box,
    span_of,
)

# Sides of a box in the order of its edges: right, top, left, bottom.
SIDES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


@dataclass(frozen=True, eq=False)
class Polygon(Frozen):
    """A bounded convex polygon; a segment and a point are polygons too.

    Attributes:
        normals: (e, 2) outward normals of the edges, of length 1 to rounding, counter-clockwise.
        offsets: (e,) the polygon is {x : normals x <= offsets} [m].
        vertices: (e, 2) counter-clockwise; vertex k is where edge k begins [m].
        margin: The hull of the vertices widened by this contains the polygon [m].
    """

    normals: Array
    offsets: Array
    vertices: Array
    margin: float = 0.0

    @classmethod
    def box(cls, lower: Floats, upper: Floats) -> Polygon:
        """Return the rectangle between two corners, each (2,) [m].

        Raises:
            InvalidInput: A corner is not finite, or a lower one is above the upper one (an empty set).
        """
        low, high = finite("lower corner [m]", lower), finite("upper corner [m]", upper)
        if low.shape != (2,) or high.shape != (2,) or (low > high).any():
            corners = f"{low.tolist()}, {high.tolist()}"
            raise InvalidInput("a box with its lower corner (2,) below its upper corner (2,)", corners)
        vertices = np.array([[high[0], low[1]], high, [low[0], high[1]], low])
        return cls(SIDES, np.concatenate([high, -low]), vertices)

    @classmethod
    def from_vertices(cls, points: Floats) -> Polygon:
        """Return a polygon around the convex hull of (k, 2) points [m]; it errs outward by rounding.

        Raises:
            InvalidInput: There is no point (an empty set), or a coordinate is not finite.
        """
        hull = cls.hull(points)
        lower, upper = hull.bounds
        if (lower == upper).all():
            return cls.box(lower, upper)
        allowance = 8 * EPSILON * np.abs(hull.vertices).sum(axis=1).max()
        return cls.from_half_planes(hull.normals, hull.offsets + allowance, lower - allowance, upper + allowance)

    @classmethod
    def hull(cls, points: Floats) -> Polygon:
        """Return the convex hull of (k, 2) points [m]; its vertices are among them, its half-planes right to rounding.

        Raises:
            InvalidInput: There is no point (an empty set), or a coordinate is not finite.
        """
        array = finite("vertices [m]", points)
        if array.ndim != 2 or array.shape[1] != 2 or not len(array):
            raise InvalidInput("at least one point, as (k, 2) coordinates", f"shape {array.shape}")
        vertices = hull_of(array)
        edges = np.roll(vertices, -1, axis=0) - vertices
        if len(vertices) < 3:  # a point or a segment: bounded by caps, too
            along = edges[0] if len(vertices) == 2 else np.array([1.0, 0.0])
            edges = np.array([along, [-along[1], along[0]], -along, [along[1], -along[0]]])
            vertices = vertices[[0, 1, 1, 0]] if len(vertices) == 2 else vertices[[0, 0, 0, 0]]
        normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
        return cls(normals, (array @ normals.T).max(axis=0), vertices)

    @classmethod
    def from_half_planes(cls, normals: Floats, offsets: Floats, lower: Floats, upper: Floats) -> Polygon:
        """Return the part of a box that lies in all half-planes {x : normals x <= offsets}.

        Raises:
            InvalidInput: Nothing is left, or the box is not one.
        """
        box = cls.box(lower, upper)
        kept = clip(finite("normals", normals).reshape(-1, 2), finite("offsets [m]", offsets).reshape(-1), *box.bounds)
        if kept is None:
            raise InvalidInput("half-planes with a point of the box in common", "an empty set")
        return kept[0]

    @cached_property
    def area(self) -> float:
        """Area of the hull of the vertices [m2]."""
        return area_of(self.vertices)

    @cached_property
    def centroid(self) -> Array:
        """(2,) centre of mass [m]; of a polygon without area, the middle of its vertices."""
        return np.array(centroid_of(self.vertices))

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper corner (2,) of a box around the polygon; errs outward [m]."""
        return self.vertices.min(axis=0) - self.margin, self.vertices.max(axis=0) + self.margin

    def contains(self, points: Floats) -> Mask:
        """Return whether (..., 2) points satisfy every half-plane."""
        return np.all(np.asarray(points) @ self.normals.T <= self.offsets, axis=-1)

    def support(self, directions: Floats) -> Array:
        """Return (k,) upper bounds of direction . x over the polygon for (k, 2) directions [m]."""
        wanted = np.asarray(directions, dtype=float)
        rounding = 4 * EPSILON * np.abs(self.vertices).max()
        return (wanted @ self.vertices.T).max(axis=-1) + (self.margin + rounding) * np.abs(wanted).sum(axis=-1)

    def intersection(self, other: Polygon) -> Polygon | None:
        """Return what two polygons have in common, or None when that is proved to be nothing."""
        normals, offsets = np.concatenate([self.normals, other.normals]), np.concatenate([self.offsets, other.offsets])
        kept = clip(normals, offsets, *self.bounds)
        return kept[0] if kept else None


def clip(normals: Array, offsets: Array, lower: Array, upper: Array) -> tuple[Polygon, Integers] | None:
    """Return what half-planes leave of a box as a polygon, and what is behind each edge, both as in `clip_box`.

    It errs outward alone, also where it is thin or a point. None proves that nothing is left.
    """
    vertices, behind = np.empty((len(offsets) + 4, 2)), np.empty(len(offsets) + 4, dtype=np.int64)
    size, margin = clip_box_into((vertices, behind), (normals, offsets), lower, upper)
    if not size:
        return None
    everything, edges = (np.concatenate([normals, SIDES]), np.concatenate([offsets, upper, -lower])), behind[:size].copy()
    return Polygon(everything[0][edges], everything[1][edges], vertices[:size].copy(), margin), edges


@dataclass(frozen=True, eq=False)
class Polygons(Frozen, Sequence[Polygon]):
    """Polygons laid end to end: the edges of polygon k are first[k] to first[k + 1].

    Attributes:
        normals: (e, 2) as in `Polygon`.
        offsets: (e,) [m].
        vertices: (e, 2) [m].
        margin: (n,) [m].
        first: (n + 1,) where the edges of each begin.
    """

    normals: Array
    offsets: Array
    vertices: Array
    margin: Array
    first: Integers

    @classmethod
    def of(cls, polygons: Sequence[Polygon]) -> Polygons:
        """Return single polygons laid end to end."""
        first = np.cumsum([0, *(len(polygon.offsets) for polygon in polygons)])
        normals = np.concatenate([np.zeros((0, 2)), *(polygon.normals for polygon in polygons)])
        vertices = np.concatenate([np.zeros((0, 2)), *(polygon.vertices for polygon in polygons)])
        offsets = np.concatenate([np.zeros(0), *(polygon.offsets for polygon in polygons)])
        return cls(normals, offsets, vertices, np.array([polygon.margin for polygon in polygons], dtype=float), first)

    def __len__(self) -> int:
        return len(self.margin)

    @overload
    def __getitem__(self, index: int) -> Polygon: ...

    @overload
    def __getitem__(self, index: slice) -> list[Polygon]: ...

    def __getitem__(self, index: int | slice) -> Polygon | list[Polygon]:
        if isinstance(index, slice):
            return [self[k] for k in range(*index.indices(len(self)))]
        k = range(len(self))[index]
        edges = slice(self.first[k], self.first[k + 1])
        return Polygon(self.normals[edges], self.offsets[edges], self.vertices[edges], float(self.margin[k]))

    @cached_property
    def owner(self) -> Integers:
        """(e,) whose each edge is."""
        return np.repeat(np.arange(len(self)), np.diff(self.first))

    @cached_property
    def areas(self) -> Array:
        """(n,) areas of the hulls of the vertices [m2]."""
        return read_only(areas_of(self.vertices, self.first))

    def contains(self, points: Array) -> Mask:
        """Return (n,) whether each polygon's half-planes hold at its own of (n, 2) points [m]."""
        broken = (self.normals * points[self.owner]).sum(axis=1) > self.offsets
        return np.bincount(self.owner[broken], minlength=len(self)) == 0

    def mirrored(self, points: Array) -> Polygons:
        """Return {point - x} with an own one of (n, 2) points for each: as seen from the polygons; errs outward [m]."""
        where = points[self.owner]
        largest = np.maximum.reduceat(np.abs(self.vertices).max(axis=1), self.first[:-1]) if len(self) else np.zeros(0)
        rounding = 4 * EPSILON * (np.abs(points).sum(axis=1) + largest)
        offsets = self.offsets - (self.normals * where).sum(axis=1) + rounding[self.owner]
        return Polygons(-self.normals, offsets, where - self.vertices, self.margin + rounding, self.first)

    def turned_about(self, which: Mask) -> Polygons:
        """Return {-x} where (n,) says so, and {x} elsewhere: exact."""
        sign = np.where(which[self.owner], -1.0, 1.0)[:, None]
        return Polygons(sign * self.normals, self.offsets, sign * self.vertices, self.margin, self.first)

    def spans(self) -> AngularIntervals:
        """Return (n) arcs that contain the directions from the origin to every point of each polygon; they err outward [rad].

        The bound is pi where the origin is inside, or so near that no direction is excluded for sure.
        """
        return AngularIntervals(*_spans(self.vertices, self.margin, self.first).T)


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


def clip_boxes(normals: Array, offsets: Array, groups: tuple[Integers, Integers], lower: Array, upper: Array) -> Clipped:
    """Cut each of g boxes by its own group of half-planes, as `clip_box` does.

    Args:
        normals: (r, 2) of length 1 to rounding.
        offsets: (r,) [m].
        groups: Where each group begins and ends among the half-planes, (g,) and (g,).
        lower: (g, 2) corners of the boxes [m].
        upper: (g, 2) corners of the boxes [m].
    """
    begin, end = groups
    most, count = int((end - begin).sum()) + 4 * len(begin), len(begin)
    lines, vertices, behind = (np.empty((most, 2)), np.empty(most)), np.empty((most, 2)), np.empty(most, dtype=np.int64)
    margin, first, empty = np.empty(count), np.zeros(count + 1, dtype=np.int64), np.zeros(count, dtype=bool)
    _clip((*lines, vertices, behind), (margin, first, empty), (normals, offsets), groups, (lower, upper))
    edges = slice(first[-1])
    normals_of, offsets_of, corners = (column[edges].copy() for column in (*lines, vertices))
    outlines = Polygons(normals_of, offsets_of, corners, margin, first)
    return Clipped(outlines, behind[edges].copy(), empty)


@compiled
def _clip(
    edges: tuple[Array, Array, Array, Integers],
    each: tuple[Array, Integers, Mask],
    lines: tuple[Array, Array],
    groups: tuple[Integers, Integers],
    box: tuple[Array, Array],
) -> None:
    """Write normals, offsets, vertices and rows of the edges, and margin, beginning and emptiness of each polygon."""
    (outward, reach, vertices, behind), (margin, first, empty) = edges, each
    (normals, offsets), (begin, end), (lower, upper) = lines, groups, box
    room = clip_room((end - begin).max() if len(begin) else 0)
    for g in range(len(begin)):
        at, rows = first[g], end[g] - begin[g]
        into = vertices[at:], behind[at:]
        size, margin[g] = clip_into(into, (normals[begin[g] : end[g]], offsets[begin[g] : end[g]]), lower[g], upper[g], room)
        if not size:
            empty[g], rows = True, 0
            size, margin[g] = clip_into(into, (normals[:0], offsets[:0]), lower[g], upper[g], room)
        for k in range(at, at + size):
            if behind[k] < rows:
                behind[k] += begin[g]
                outward[k, 0], outward[k, 1], reach[k] = normals[behind[k], 0], normals[behind[k], 1], offsets[behind[k]]
            else:
                outward[k, 0], outward[k, 1], reach[k] = side_of_box(behind[k] - rows, lower[g], upper[g])
                behind[k] += len(offsets) - rows
        first[g + 1] = at + size


@compiled
def areas_of(vertices: Array, first: Integers) -> Array:
    """Return (n,) areas of polygons whose vertices lie end to end [m2]; 0 where there are none."""
    areas = np.empty(len(first) - 1)
    for k in range(len(areas)):
        areas[k] = area_of(vertices[first[k] : first[k + 1]])
    return areas


@compiled
def _spans(vertices: Array, margin: Array, first: Integers) -> Array:
    """Return (n, 2) centre and bound of the span of each polygon."""
    spans = np.empty((len(margin), 2))
    for k in range(len(margin)):
        spans[k, 0], spans[k, 1] = span_of(vertices[first[k] : first[k + 1]], margin[k])
    return spans
