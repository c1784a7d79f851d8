"""Many polygons at a time, as a few arrays: those of a whole team in one compiled loop."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import overload

import numpy as np

from filter.arrays import Array, Integers, Mask, chosen, read_only
from filter.compiled import compiled
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON, area_of, cut_into, room, side_of_box, span_of
from filter.geometry.polygon import Polygon


@dataclass(frozen=True, eq=False)
class Polygons(Sequence[Polygon]):
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

    def __post_init__(self) -> None:
        for name in ("normals", "offsets", "vertices", "margin", "first"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @classmethod
    def of(cls, polygons: Sequence[Polygon]) -> Polygons:
        """Return single polygons laid end to end."""
        first = np.cumsum([0, *(len(polygon.offsets) for polygon in polygons)])
        normals = np.concatenate([np.zeros((0, 2)), *(polygon.normals for polygon in polygons)])
        vertices = np.concatenate([np.zeros((0, 2)), *(polygon.vertices for polygon in polygons)])
        offsets = np.concatenate([np.zeros(0), *(polygon.offsets for polygon in polygons)])
        return cls(normals, offsets, vertices, np.array([polygon.margin for polygon in polygons], dtype=float), first)

    @classmethod
    def concatenate(cls, parts: Sequence[Polygons]) -> Polygons:
        """Return the polygons of all parts, in their order."""
        return cls(
            np.concatenate([part.normals for part in parts]),
            np.concatenate([part.offsets for part in parts]),
            np.concatenate([part.vertices for part in parts]),
            np.concatenate([part.margin for part in parts]),
            joined([part.first for part in parts]),
        )

    def __len__(self) -> int:
        return len(self.margin)

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

    def select(self, index: Integers) -> Polygons:
        """Return some of the polygons, by (k,) index."""
        edges, first = places(self.first, index)
        return Polygons(self.normals[edges], self.offsets[edges], self.vertices[edges], self.margin[index], first)

    @cached_property
    def owner(self) -> Integers:
        """(e,) whose each edge is."""
        return np.repeat(np.arange(len(self)), np.diff(self.first))

    @cached_property
    def areas(self) -> Array:
        """(n,) areas of the hulls of the vertices [m2]."""
        return read_only(_areas(self.vertices, self.first))

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

    def spans(self) -> AngularIntervals:
        """Return (n) arcs that contain the directions from the origin to every point of each polygon; they err outward [rad].

        The bound is pi where the origin is inside, or so near that no direction is excluded for sure.
        """
        return AngularIntervals(*_spans(self.vertices, self.margin, self.first))


def joined(firsts: Sequence[Integers]) -> Integers:
    """Return where the pieces of lists begin, (n + 1,), when lists of (n_k + 1,) beginnings each are laid end to end."""
    counts = np.concatenate([np.zeros(1, dtype=np.int64), *(np.diff(first) for first in firsts)])
    return np.cumsum(counts)


def places(first: Integers, index: Integers) -> tuple[Integers, Integers]:
    """Return the places of what some pieces of a list hold, one piece after the other, and where each piece then begins.

    Args:
        first: (n + 1,) where the pieces begin.
        index: (k,) which pieces.
    """
    counts = first[index + 1] - first[index]
    begins = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
    return np.repeat(first[index] - begins[:-1], counts) + np.arange(begins[-1]), begins


@dataclass(frozen=True, eq=False)
class Cuts:
    """What half-planes leave of boxes, several at a time.

    Attributes:
        polygons: (g) what is left; the whole box where that is nothing.
        edges: (e,) the half-plane behind each edge; -4 to -1 for a side of the box.
        empty: (g,) whether nothing is left, for sure.
    """

    polygons: Polygons
    edges: Integers
    empty: Mask


def cut_boxes(normals: Array, offsets: Array, groups: tuple[Integers, Integers, Integers], lower: Array, upper: Array) -> Cuts:
    """Cut each of g boxes by its own group of half-planes, as `cut_box` does.

    Args:
        normals: (r, 2) of length 1 to rounding.
        offsets: (r,) [m].
        groups: Half-planes in the order of their groups (r,), and where each group begins and ends in it, (g,) and (g,).
        lower: (g, 2) corners of the boxes [m].
        upper: (g, 2) corners of the boxes [m].
    """
    outlines, edges, empty = _cut(normals, offsets, groups, lower, upper)
    return Cuts(Polygons(*outlines), edges, empty)


@compiled
def _cut(
    normals: Array, offsets: Array, groups: tuple[Integers, Integers, Integers], lower: Array, upper: Array
) -> tuple[tuple[Array, Array, Array, Array, Integers], Integers, Mask]:
    order, begin, end = groups
    count, most = len(begin), (end - begin).sum() + 5 * len(begin)
    outward, reach, vertices = np.empty((most, 2)), np.empty(most), np.empty((most, 2))
    edges, margin = np.empty(most, dtype=np.int64), np.empty(count)
    first, empty = np.zeros(count + 1, dtype=np.int64), np.zeros(count, dtype=np.bool_)
    space, nothing = room((end - begin).max() if count else 0), order[:0]
    for g in range(count):
        at, lines = first[g], (normals, offsets, order[begin[g] : end[g]])
        size, margin[g] = cut_into((vertices[at:], edges[at:]), lines, lower[g], upper[g], space)
        if not size:
            empty[g], lines = True, (normals, offsets, nothing)
            size, margin[g] = cut_into((vertices[at:], edges[at:]), lines, lower[g], upper[g], space)
        for k in range(at, at + size):
            if edges[k] >= 0:
                outward[k, 0], outward[k, 1], reach[k] = normals[edges[k], 0], normals[edges[k], 1], offsets[edges[k]]
            else:
                outward[k, 0], outward[k, 1], reach[k] = side_of_box(edges[k], lower[g], upper[g])
        first[g + 1] = at + size
    end_of_all = first[count]
    outlines = outward[:end_of_all].copy(), reach[:end_of_all].copy(), vertices[:end_of_all].copy(), margin, first
    return outlines, edges[:end_of_all].copy(), empty


@compiled
def _areas(vertices: Array, first: Integers) -> Array:
    areas = np.empty(len(first) - 1)
    for k in range(len(areas)):
        areas[k] = area_of(vertices[first[k] : first[k + 1]])
    return areas


@compiled
def _spans(vertices: Array, margin: Array, first: Integers) -> tuple[Array, Array]:
    centre, bound = np.empty(len(margin)), np.empty(len(margin))
    for k in range(len(margin)):
        centre[k], bound[k] = span_of(vertices[first[k] : first[k + 1]], margin[k])
    return centre, bound
