"""Where each robot is, and why: the regions of a team, as arrays."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import overload

import numpy as np

from filter.arrays import Array, Floats, Frozen, Integers, Mask, chosen, floats, read_only
from filter.errors import InvalidInput
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.linear.polytope import Polytope
from filter.projection.claims import Hulls, Outlines
from filter.projection.proved import NO_AREA, performance_ratio
from filter.projection.stop import Reason


@dataclass(frozen=True, eq=False)
class Region:
    """Where one robot is.

    Attributes:
        outer: Contains the robot, as long as every declared bound holds.
        inner: Every point of it is possible; None when nothing is known from inside (after a prediction, say).
        searches: How many directions were searched, or how many edges of the exact projection were kept.
        reason: What decided that (see `Projection`), or None when nothing was projected.
        causes: For each edge of the outer polygon the numbers of its sources in the belief's table; for a side of
            the box what the box comes from.
    """

    outer: Polygon
    inner: Polygon | None
    searches: int
    reason: Reason | None
    causes: tuple[Integers, ...]

    @property
    def performance_ratio(self) -> float:
        """Area inside over area outside (eq. 7), in [0, 1]; 0 without an inner polygon."""
        return performance_ratio(self.inner, self.outer)


@dataclass(frozen=True, eq=False)
class Regions(Frozen, Sequence[Region]):
    """Where each of n robots is; one of them is a `Region`.

    Attributes:
        outer: (n) polygons that contain the robots, as long as every declared bound holds.
        inner: (n) polygons of which every point is possible, as far as any is known.
        searches: (n,)
        reasons: (n) see `Region`.
        cause: (m,) the numbers of the edges' sources in the belief's table, with repetitions.
        cause_first: (e + 1,) where those of each edge of the outer polygons begin.
    """

    outer: Polygons
    inner: Hulls
    searches: Integers
    reasons: tuple[Reason | None, ...]
    cause: Integers
    cause_first: Integers

    @classmethod
    def of(cls, polytope: Polytope, outlines: Outlines) -> Regions:
        """Return outlines from a polytope's rows as regions, each edge with its causes."""
        weights, outer = outlines.weights, outlines.outer
        sides = weights.counts == 0 if len(polytope.origin) else np.zeros(len(weights), dtype=bool)
        counts = np.where(sides, 1, weights.counts)
        first = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
        cause, is_side = np.empty(first[-1], dtype=np.int64), np.repeat(sides, counts)
        cause[~is_side] = polytope.constraints.source[weights.row]
        cause[is_side] = polytope.origin[outer.owner[sides]]
        return cls(outer, outlines.inner, outlines.searches, outlines.reasons, cause, first)

    @classmethod
    def at_a_glance(cls, polytope: Polytope) -> Regions:
        """Return each robot's region from its own rows alone, without a projection: larger, sound, not known from inside."""
        clipped = polytope.of_robots(np.arange(len(polytope.lower)))
        return cls.of(polytope, Outlines.at_a_glance(clipped, len(polytope.constraints)))

    def __len__(self) -> int:
        return len(self.outer)

    @overload
    def __getitem__(self, index: int) -> Region: ...

    @overload
    def __getitem__(self, index: slice) -> list[Region]: ...

    def __getitem__(self, index: int | slice) -> Region | list[Region]:
        k = chosen("a robot", index, len(self))
        if isinstance(k, range):
            return [self[each] for each in k]
        edges = range(self.outer.first[k], self.outer.first[k + 1])
        of_each = (np.unique(self.cause[self.cause_first[edge] : self.cause_first[edge + 1]]) for edge in edges)
        causes = tuple(map(read_only, of_each))
        return Region(self.outer[k], self.inner[k], int(self.searches[k]), self.reasons[k], causes)

    @cached_property
    def performance_ratios(self) -> Array:
        """(n,) area inside over area outside (eq. 7), in [0, 1]; 0 without an inner polygon."""
        outer, begin = self.outer, self.outer.first[:-1]
        extent = np.maximum.reduceat(outer.vertices, begin) - np.minimum.reduceat(outer.vertices, begin)
        extent += 2 * outer.margin[:, None]
        without = outer.areas <= NO_AREA * (extent**2).sum(axis=1)
        ratios = np.minimum(1.0, self.inner.areas / np.where(without, 1.0, outer.areas))
        return np.where(self.inner.known, np.where(without, 1.0, ratios), 0.0)

    def contains(self, positions: Floats) -> Mask:
        """Return (n,) whether each outer polygon contains its own of (n, 2) positions [m]; none one that is not finite.

        Raises `InvalidInput` if it is not a position for each robot.
        """
        places = floats("positions [m]", positions)
        if places.shape != (len(self), 2):
            raise InvalidInput(f"positions of {len(self)} robots, (n, 2)", f"shape {places.shape}")
        known = np.asarray(np.isfinite(places).all(axis=1))
        return self.outer.contains(np.where(known[:, None], places, 0.0)) & known
