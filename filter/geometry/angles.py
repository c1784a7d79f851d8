"""Angles and angular intervals, with everything that wraps.

All angles are radians, counter-clockwise, wrapped to (-pi, pi]. Intervals are sets: each operation returns an interval
that contains every angle the exact operation could give, rounding included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Floats, Integers, Mask, finite, read_only
from filter.compiled import compiled
from filter.errors import InvalidInput

# One operation on angles of a few turns is off by a few units in the last place of 2 pi; this covers it many times.
ROUNDING = 1e-14


def wrap(angle: Floats) -> Array:
    """Return the angle(s) wrapped to (-pi, pi] [rad], any shape."""
    array = np.asarray(angle, dtype=float)
    inside = (-np.pi < array) & (array <= np.pi)  # as it is, to the last bit
    return np.where(inside, array, -(np.mod(np.pi - array, 2 * np.pi) - np.pi))


@dataclass(frozen=True, eq=False)
class AngularIntervals:
    """Arcs of the circle, `centre +- bound`.

    Attributes:
        centre: (k,) middle of each arc [rad], in (-pi, pi].
        bound: (k,) half-width of each arc [rad]; pi is the whole circle, a negative one the empty set.
    """

    centre: Array
    bound: Array

    def __post_init__(self) -> None:
        centre, bound = (
            np.atleast_1d(finite("centre of an arc [rad]", self.centre)),
            finite("bound of an arc [rad]", self.bound),
        )
        try:
            centre, bound = np.broadcast_arrays(centre, bound)
        except ValueError:
            raise InvalidInput("a centre and a bound for each arc", f"{centre.shape} and {bound.shape}") from None
        turns = np.abs(centre) > np.pi
        outward = np.where(turns & (bound >= 0), bound + ROUNDING * np.abs(centre), bound)
        object.__setattr__(self, "centre", read_only(wrap(centre)))
        object.__setattr__(self, "bound", read_only(np.minimum(outward, np.pi)))

    @classmethod
    def circles(cls, count: int) -> AngularIntervals:
        """Return `count` whole circles: nothing is known."""
        return cls(np.zeros(count), np.full(count, np.pi))

    @classmethod
    def _of(cls, centre: Array, bound: Array) -> AngularIntervals:
        """Return arcs that are known to be wrapped and of one length, without a look."""
        arcs = object.__new__(cls)
        object.__setattr__(arcs, "centre", read_only(centre))
        object.__setattr__(arcs, "bound", read_only(bound))
        return arcs

    def __len__(self) -> int:
        return len(self.centre)

    def __getitem__(self, index: slice | Integers) -> AngularIntervals:
        return AngularIntervals._of(self.centre[index], self.bound[index])

    def replaced(self, index: Integers, arcs: AngularIntervals) -> AngularIntervals:
        """Return the arcs with some of them, by (k,) index, replaced by k others."""
        centre, bound = self.centre.copy(), self.bound.copy()
        centre[index], bound[index] = arcs.centre, arcs.bound
        return AngularIntervals._of(centre, bound)

    @property
    def empty(self) -> Mask:
        """(k,) True where the arc has no point; proved, as every operation errs outward."""
        return self.bound < 0

    @property
    def full(self) -> Mask:
        """(k,) True where the arc is the whole circle."""
        return self.bound >= np.pi

    def contains(self, angle: Floats) -> Mask:
        """Return (k,) whether each arc contains the angle [rad]."""
        return np.abs(wrap(np.asarray(angle) - self.centre)) <= self.bound

    def turned(self, by: Array | float, bound: Array | float = 0.0) -> AngularIntervals:
        """Return the arcs after a turn by `by +- bound` [rad]: {a + t}."""
        turn, wider = (np.broadcast_to(np.asarray(each, dtype=float), self.centre.shape) for each in (by, bound))
        return AngularIntervals._of(*_turned(self.centre, self.bound, turn, wider))

    def intersection(self, other: AngularIntervals) -> AngularIntervals:
        """Return the smallest arcs that contain what each pair of arcs has in common.

        Two wide arcs can meet at both ends; the result then is their hull inside the narrower one (errs outward).
        """
        return AngularIntervals._of(*_intersections(self.centre, self.bound, other.centre, other.bound))


@compiled
def _turned(centre: Array, bound: Array, by: Array, wider: Array) -> Array:
    """Return centres and bounds (2, k) of turned arcs."""
    arcs = np.empty((2, len(centre)))
    for k in range(len(centre)):
        turned = centre[k] + by[k]
        outward = ROUNDING * (1 + abs(by[k]) + abs(turned))
        arcs[0, k] = turned if -np.pi < turned <= np.pi else turned - 2 * np.pi * np.ceil((turned - np.pi) / (2 * np.pi))
        arcs[1, k] = bound[k] if bound[k] < 0 else min(np.pi, bound[k] + wider[k] + outward)
    return arcs


@compiled
def intersection(centre: float, bound: float, other_centre: float, other_bound: float) -> tuple[float, float]:
    """Return centre and bound of what two arcs have in common, as `AngularIntervals.intersection` does [rad]."""
    if other_bound < bound:
        centre, bound, other_centre, other_bound = other_centre, other_bound, centre, bound
    offset = other_centre - centre  # within two whole turns, as centres are wrapped
    offset -= 2 * np.pi * np.round(offset / (2 * np.pi))
    low, high = np.inf, -np.inf
    for turn in range(-1, 2):  # the wider arc may reach into the narrower one from either side
        piece_low = max(-bound, offset + 2 * np.pi * turn - other_bound - ROUNDING)
        piece_high = min(bound, offset + 2 * np.pi * turn + other_bound + ROUNDING)
        if piece_low <= piece_high:
            low, high = min(low, piece_low), max(high, piece_high)
    if low > high or bound < 0 or other_bound < 0:
        return centre, -1.0
    if low <= -bound and high >= bound:
        return centre, bound
    middle = centre + (low + high) / 2
    return middle - 2 * np.pi * np.ceil((middle - np.pi) / (2 * np.pi)), (high - low) / 2 + 2 * ROUNDING


@compiled
def _intersections(centre: Array, bound: Array, other_centre: Array, other_bound: Array) -> Array:
    """Return centres and bounds (2, k) of what pairs of arcs have in common."""
    arcs = np.empty((2, len(centre)))
    for k in range(len(centre)):
        arcs[0, k], arcs[1, k] = intersection(centre[k], bound[k], other_centre[k], other_bound[k])
    return arcs
