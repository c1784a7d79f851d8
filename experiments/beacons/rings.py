"""Where ranges to known places leave a robot, exactly: rings in common, and the same if one of the ranges lies.

Independent of the filter: it is what the filter's regions are held against.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from experiments.beacons.arcs import Hull, RoundSet, hull_between
from experiments.following.frozen import freeze
from filter import Array, InvalidInput, Mask

Lies = Literal["any", "long"]
ROOM = 1e-9  # by which rings are made narrower and wider, relative to their lengths: far above rounding


@dataclass(frozen=True, eq=False)
class Rings:
    """Distances to known places, each between two bounds.

    Attributes:
        centres: (k, 2) the places [m].
        least: (k,) the distance is at least this [m]; below 0 says nothing.
        greatest: (k,) and at most this [m]; infinite says nothing.
    """

    centres: Array
    least: Array
    greatest: Array

    def __post_init__(self) -> None:
        freeze(self)
        if not len(self.least) or not np.isfinite(self.centres).all() or np.isnan([self.least, self.greatest]).any():
            raise InvalidInput("one ring or more, with finite centres and bounds that are numbers", "others")

    @classmethod
    def measured(cls, centres: Array, ranges: Array, bound: Array | float) -> Rings:
        """Return rings of ranges [m] that are off by a bound each, or by one for all, at most [m]."""
        return cls(centres, ranges - bound, ranges + bound)

    def contains(self, points: Array) -> Mask:
        """Return (p, k) whether each of (p, 2) points is in each ring."""
        distance = _distances(points, self.centres)
        return np.asarray((distance >= self.least) & (distance <= self.greatest))

    def without(self, which: int, lies: Lies) -> Rings:
        """Return what is left if one range lies: nothing of it, or its far side if it can only be too long."""
        least, greatest = self.least.copy(), self.greatest.copy()
        least[which] = -np.inf
        if lies == "any":
            greatest[which] = np.inf
        return replace(self, least=least, greatest=greatest)

    def widened(self, by: float) -> Rings:
        """Return rings that are wider by a length on both sides, or narrower if it is below 0 [m]."""
        return replace(self, least=self.least - by, greatest=self.greatest + by)

    def within(self, box: Array) -> RoundSet:
        """Return the places in a box (2, 2) [m] that are in all rings."""
        radii = np.concatenate([self.least, self.greatest])
        circles = np.column_stack([np.concatenate([self.centres, self.centres]), radii])
        return RoundSet(circles[(radii > 0) & np.isfinite(radii)], box, self._excess, ROOM * self.size(box) / 10)

    def size(self, box: Array) -> float:
        """Return the greatest of all lengths [m]."""
        lengths = np.concatenate(
            [np.abs(self.centres).ravel(), np.abs(box).ravel(), np.abs([self.least, self.greatest]).ravel()]
        )
        return float(lengths[np.isfinite(lengths)].max())

    def _excess(self, points: Array) -> Array:
        distance = _distances(points, self.centres)
        return np.asarray(np.maximum(distance - self.greatest, self.least - distance).max(axis=1))


def _distances(points: Array, centres: Array) -> Array:
    apart = points[:, None] - centres
    return np.hypot(apart[..., 0], apart[..., 1])


def exact_hull(rings: Rings, box: Array) -> Hull:
    """Return the hull of the places in a box (2, 2) [m] that are in all rings."""
    return _hull_of_union([rings], box)


def tolerant_hull(rings: Rings, box: Array, lies: Lies) -> Hull:
    """Return the hull of the places in a box (2, 2) [m] that are in all rings but one, at most.

    Args:
        rings: Of which one may be wrong, whichever it is.
        box: Where the robot is.
        lies: Whether what is wrong can be anything, or is a range that is too long: then its greatest distance holds.
    """
    return _hull_of_union([rings.without(which, lies) for which in range(len(rings.least))], box)


def _hull_of_union(cases: list[Rings], box: Array) -> Hull:
    room = ROOM * max(case.size(box) for case in cases)
    narrow, wide = ([case.widened(by).within(box + grown) for case in cases] for by, grown in _both(room))
    return hull_between(narrow, wide)


def _both(room: float) -> tuple[tuple[float, Array], tuple[float, Array]]:
    """Return how rings grow and how a box does, for a set that is narrower and for one that is wider."""
    outward = np.array([[-room], [room]])
    return (-room, np.zeros((2, 1))), (room, outward)
