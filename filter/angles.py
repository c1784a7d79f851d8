"""Angles and angular intervals, with everything that wraps.

All angles are radians, counter-clockwise, wrapped to (-pi, pi]. Intervals are sets: each operation returns an interval
that contains every angle the exact operation could give, rounding included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Floats, Integers, Mask, finite, read_only
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

    def __len__(self) -> int:
        return len(self.centre)

    def __getitem__(self, index: slice | Integers) -> AngularIntervals:
        return AngularIntervals(self.centre[index], self.bound[index])

    def replaced(self, index: Integers, arcs: AngularIntervals) -> AngularIntervals:
        """Return the arcs with some of them, by (k,) index, replaced by k others."""
        centre, bound = self.centre.copy(), self.bound.copy()
        centre[index], bound[index] = arcs.centre, arcs.bound
        return AngularIntervals(centre, bound)

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
        allowance = ROUNDING * (1 + np.abs(by))
        return AngularIntervals(self.centre + by, np.where(self.empty, self.bound, self.bound + bound + allowance))

    def intersection(self, other: AngularIntervals) -> AngularIntervals:
        """Return the smallest arcs that contain what each pair of arcs has in common.

        Two wide arcs can meet at both ends; the result then is their hull inside the narrower one (errs outward).
        """
        swap = other.bound < self.bound
        centre, bound = np.where(swap, other.centre, self.centre), np.where(swap, other.bound, self.bound)
        offset = wrap(np.where(swap, self.centre, other.centre) - centre)
        wider = np.where(swap, self.bound, other.bound)
        low, high = np.full(len(centre), np.inf), np.full(len(centre), -np.inf)
        for turn in (-2 * np.pi, 0.0, 2 * np.pi):  # the wider arc may reach into the narrower one from either side
            piece_low = np.maximum(-bound, offset + turn - wider - ROUNDING)
            piece_high = np.minimum(bound, offset + turn + wider + ROUNDING)
            meets = piece_low <= piece_high
            low = np.where(meets, np.minimum(low, piece_low), low)
            high = np.where(meets, np.maximum(high, piece_high), high)
        empty = (low > high) | self.empty | other.empty
        unchanged = (low <= -bound) & (high >= bound)
        with np.errstate(invalid="ignore"):
            middle, half = (low + high) / 2, (high - low) / 2
        return AngularIntervals(
            np.where(empty | unchanged, centre, centre + middle),
            np.where(empty, -1.0, np.where(unchanged, bound, half + ROUNDING)),
        )
