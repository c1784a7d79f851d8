"""Polygons around robots or pairs, and the rows that prove every edge of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from filter.arrays import Array, Frozen, Integers, Lists, Mask, places
from filter.geometry.many import Clipped, Polygons, areas_of
from filter.geometry.polygon import Polygon
from filter.projection.stop import Reason


@dataclass(frozen=True, eq=False)
class Weights(Lists):
    """Which rows of a polytope prove each of k claims, claim after claim.

    Attributes:
        row: (m,) rows.
        weight: (m,) the multiplier of each, above 0.
        first: (k + 1,) where those of each claim begin.
    """

    row: Integers
    weight: Array
    first: Integers

    @classmethod
    def of(cls, multipliers: Array) -> Weights:
        """Return what is not zero of (k, r) multipliers."""
        claim, row = np.nonzero(multipliers)
        first = np.searchsorted(claim, np.arange(len(multipliers) + 1))
        return cls(row, multipliers[claim, row], first)

    def rests_on(self, claim: int) -> tuple[Integers, Array]:
        """Return the rows that a claim is proved from, and their multipliers."""
        some = slice(self.first[claim], self.first[claim + 1])
        return self.row[some], self.weight[some]


@dataclass(frozen=True, eq=False)
class Hulls(Lists):
    """Convex hulls laid end to end, given by their corners; where there is none, nothing is known.

    Attributes:
        corners: (p, 2) counter-clockwise [m].
        first: (n + 1,) where those of each begin.
    """

    corners: Array
    first: Integers

    @classmethod
    def none(cls, count: int) -> Hulls:
        """Return so many of which nothing is known."""
        return cls(np.zeros((0, 2)), np.zeros(count + 1, dtype=np.int64))

    @classmethod
    def of(cls, polygons: Sequence[Polygon | None]) -> Hulls:
        """Return single hulls laid end to end."""
        corners = [np.zeros((0, 2)) if polygon is None else polygon.vertices for polygon in polygons]
        return cls(np.concatenate([np.zeros((0, 2)), *corners]), np.cumsum([0, *map(len, corners)]))

    def __getitem__(self, index: int) -> Polygon | None:
        corners = self.corners[self.first[index] : self.first[index + 1]]
        return Polygon.hull(corners) if len(corners) else None

    @property
    def known(self) -> Mask:
        """(n,) whether there is one."""
        return self.counts > 0

    @cached_property
    def areas(self) -> Array:
        """(n,) [m2]; 0 where there is none."""
        return areas_of(self.corners, self.first)


@dataclass(frozen=True, eq=False)
class Outlines(Frozen):
    """Polygons that contain robots, or pairs (x_j - x_i), each edge with its proof from the rows of a polytope.

    Attributes:
        outer: (n) polygons.
        weights: Of each of their edges (e); those that no row proves are sides of boxes.
        inner: (n) polygons of which every point is possible.
        searches: (n,) how many directions were searched, or edges kept.
        reasons: (n) what decided that, or None.
    """

    outer: Polygons
    weights: Weights
    inner: Hulls
    searches: Integers
    reasons: tuple[Reason | None, ...]

    @classmethod
    def at_a_glance(cls, clipped: Clipped, rows: int, reason: Reason | None = None) -> Outlines:
        """Return what own rows, of so many rows in all, and boxes say: larger, sound, nothing known from inside."""
        is_row, count = clipped.behind < rows, len(clipped.polygons)
        first = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(is_row)])
        weights = Weights(clipped.behind[is_row], np.ones(first[-1]), first)
        return cls(clipped.polygons, weights, Hulls.none(count), np.zeros(count, dtype=np.int64), (reason,) * count)

    @classmethod
    def concatenate(cls, parts: Sequence[Outlines]) -> Outlines:
        """Return the outlines of all parts, in their order."""
        some = [part for part in parts if len(part.outer)] or parts[:1]
        return (
            some[0]
            if len(some) == 1
            else cls(
                Polygons.concatenate([part.outer for part in some]),
                Weights.concatenate([part.weights for part in some]),
                Hulls.concatenate([part.inner for part in some]),
                np.concatenate([part.searches for part in some]),
                tuple(reason for part in some for reason in part.reasons),
            )
        )

    def select(self, index: Integers) -> Outlines:
        """Return some of the outlines, by (k,) index."""
        edges, _ = places(self.outer.first, index)
        reasons = tuple(self.reasons[k] for k in index.tolist())
        outer, inner = self.outer.select(index), self.inner.select(index)
        return Outlines(outer, self.weights.select(edges), inner, self.searches[index], reasons)


def in_order(pieces: Sequence[tuple[Integers, Outlines]]) -> Outlines:
    """Return the outlines of all n robots or pairs from pieces (numbers, their outlines); those without edges are left out."""
    numbers, every = np.concatenate([numbers for numbers, _ in pieces]), Outlines.concatenate([each for _, each in pieces])
    found = np.flatnonzero(every.outer.counts)
    wanted = found[np.argsort(numbers[found])]
    return every if np.array_equal(wanted, np.arange(len(numbers))) else every.select(wanted)
