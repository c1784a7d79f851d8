"""Angles and angular intervals, with everything that wraps.

All angles are radians, counter-clockwise, wrapped to (-pi, pi]. Intervals are sets: each operation returns an interval that
contains every angle the exact operation could give, rounding included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import (
    MOST_ROBOTS,
    Array,
    Floats,
    Integers,
    Mask,
    finite,
    floats,
    instance,
    read_only,
    settle,
    shown,
    whole_number,
)
from filter.compiled import compiled
from filter.errors import InvalidInput, OutOfRange

# One operation on angles of a few turns is off by a few units in the last place of 2 pi; this covers it many times.
ANGLE_ROUNDING = 1e-14


def wrap(angle: Floats) -> Array:
    """Return angles of any shape wrapped to (-pi, pi] [rad], NaN for one that is not finite; InvalidInput if they are none."""
    array = floats("angles [rad]", angle)
    inside = (-np.pi < array) & (array <= np.pi)  # as it is, to the last bit
    with np.errstate(invalid="ignore"):
        return np.where(inside, array, -(np.mod(np.pi - array, 2 * np.pi) - np.pi))


@dataclass(frozen=True, eq=False)
class AngularIntervals:
    """Arcs of the circle, `centre +- bound`. Raises InvalidInput if a value is not finite, or the columns differ in length.

    Attributes:
        centre: (k,) middle of each arc [rad], in (-pi, pi].
        bound: (k,) half-width of each arc [rad]; pi is the whole circle, a negative one the empty set.
    """

    centre: Array
    bound: Array

    def __post_init__(self) -> None:
        centre, bound = finite("centre of an arc [rad]", self.centre), finite("bound of an arc [rad]", self.bound)
        try:
            centre, bound = (each.copy() for each in np.broadcast_arrays(np.atleast_1d(centre), bound))
        except ValueError:
            raise InvalidInput("a centre and a bound for each arc", f"{centre.shape} and {bound.shape}") from None
        if centre.ndim != 1:
            raise InvalidInput("centres and bounds of arcs as numbers or (k,) columns", f"shape {centre.shape}")
        wrapped, outward = _wrapped(centre, bound)
        settle(self, centre=read_only(wrapped), bound=read_only(outward))

    @classmethod
    def circles(cls, count: int) -> AngularIntervals:
        """Return so many whole circles: nothing is known. Raises InvalidInput if that is no whole number, or too large."""
        arcs = whole_number("number of arcs", count, 0, MOST_ROBOTS)
        return cls._of(np.zeros(arcs), np.full(arcs, np.pi))

    @classmethod
    def of_found(cls, centre: Array, bound: Array) -> AngularIntervals:
        """Return (k) arcs of finite centres and bounds that were found, without a look [rad]."""
        return cls._of(*_wrapped(centre, bound))

    @classmethod
    def _of(cls, centre: Array, bound: Array) -> AngularIntervals:
        """Return arcs that are known to be wrapped and of one length, without a look."""
        arcs = object.__new__(cls)
        settle(arcs, centre=read_only(centre), bound=read_only(bound))
        return arcs

    def __len__(self) -> int:
        return len(self.centre)

    def __getitem__(self, index: int | slice | Integers | Mask) -> AngularIntervals:
        try:
            centre, bound = np.atleast_1d(self.centre[index], self.bound[index])
        except Exception:  # numpy has several for an index that is none
            raise OutOfRange(f"arcs among 0 to {len(self) - 1}", shown(index)) from None
        if centre.ndim != 1 or isinstance(index, np.ma.MaskedArray):
            raise OutOfRange(f"arcs among 0 to {len(self) - 1} by a number, a slice or a (k,) column", shown(index))
        return AngularIntervals._of(centre, bound)

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
        """Return (k,) whether each arc contains the angle, or its own of (k,) angles [rad]; not one that is not finite.

        Raises InvalidInput if they are no angles, or not one for each arc.
        """
        return np.abs(wrap(self._each("angles [rad]", floats("angles [rad]", angle)) - self.centre)) <= self.bound

    def turned(self, by: Floats, bound: Floats = 0.0) -> AngularIntervals:
        """Return the arcs after a turn by `by +- bound` [rad]: {a + t}.

        Raises InvalidInput if a value is not finite, a bound is negative, or there is not one for each arc.
        """
        turn = self._each("turns [rad]", finite("turns [rad]", by))
        wider = self._each("bounds of turns [rad]", finite("bounds of turns [rad]", bound, 0))
        return self.turned_by(turn, wider)

    def turned_by(self, by: Array, bound: Array) -> AngularIntervals:
        """Return the same for turns and bounds (k,) that were checked before, without a look [rad]."""
        return AngularIntervals._of(*_turned(self.centre, self.bound, by, bound))

    def _each(self, name: str, values: Array) -> Array:
        if values.shape == self.centre.shape:
            return values
        if values.shape not in ((), (1,)):
            raise InvalidInput(f"{name}: one, or one for each of {len(self)} arcs", f"shape {values.shape}")
        return np.full(self.centre.shape, values)

    def intersection(self, other: AngularIntervals) -> AngularIntervals:
        """Return the smallest arcs that contain what each pair of arcs has in common.

        Two wide arcs can meet at both ends; the result then is their hull inside the narrower one (errs outward). Raises
        InvalidInput if the others are no arcs, or not as many.
        """
        instance("other arcs", other, AngularIntervals)
        if len(other) != len(self):
            raise InvalidInput(f"as many other arcs, {len(self)}", f"{len(other)} arcs")
        return AngularIntervals._of(*_intersections(self.centre, self.bound, other.centre, other.bound))

    def narrowed(self, begin: Integers, end: Integers, others: AngularIntervals) -> AngularIntervals:
        """Return the arcs cut by others, begin[k] to end[k] of them each; one of which that leaves nothing stays as it is."""
        return AngularIntervals._of(*_narrowed((self.centre, self.bound), begin, end, (others.centre, others.bound)))


def narrowest(low: Array, high: Array) -> tuple[float, float]:
    """Return centre and bound of the narrowest arc around some arcs, (s,) from low to high [rad]; it errs outward."""
    turns = np.floor(low / (2 * np.pi)) * 2 * np.pi
    first, last = (np.append(ends - turns - 2 * np.pi, ends - turns) for ends in (low, high))  # the circle twice
    order, count = np.argsort(first), len(low)
    lows, ends = first[order], np.maximum.accumulate(last[order])
    gaps = lows[count:] - ends[count - 1 : -1]  # those in front of the second circle's arcs: all are behind them once
    widest = int(np.argmax(gaps))
    if gaps[widest] <= 0:
        return 0.0, np.pi
    begin, end = lows[count + widest], ends[count - 1 + widest] + 2 * np.pi
    return float((begin + end) / 2), float((end - begin) / 2 + 1e-12)


@compiled
def _wrapped(centre: Array, bound: Array) -> Array:
    """Return (2, k) centres and bounds of arcs, in (-pi, pi] and up to pi."""
    arcs = np.empty((2, len(centre)))
    for k in range(len(centre)):
        angle, wide = centre[k], abs(centre[k]) > np.pi and bound[k] >= 0
        arcs[0, k] = angle if -np.pi < angle <= np.pi else np.pi - np.mod(np.pi - angle, 2 * np.pi)
        arcs[1, k] = min(np.pi, bound[k] + ANGLE_ROUNDING * abs(angle) if wide else bound[k])
    return arcs


@compiled
def turned(centre: float, bound: float, by: float, wider: float) -> tuple[float, float]:
    """Return centre and bound of an arc after a turn, as `AngularIntervals.turned` does [rad]; one that is empty stays so."""
    angle = centre + by
    outward = ANGLE_ROUNDING * (1 + abs(by) + abs(angle))
    if not -np.pi < angle <= np.pi:
        angle -= 2 * np.pi * np.ceil((angle - np.pi) / (2 * np.pi))
    return angle, min(np.pi, bound + wider + outward) if bound >= 0 else bound


@compiled
def _turned(centre: Array, bound: Array, by: Array, wider: Array) -> Array:
    """Return (2, k) centres and bounds."""
    arcs = np.empty((2, len(centre)))
    for k in range(len(centre)):
        arcs[0, k], arcs[1, k] = turned(centre[k], bound[k], by[k], wider[k])
    return arcs


@compiled
def intersection(centre: float, bound: float, other_centre: float, other_bound: float) -> tuple[float, float]:
    """Return centre and bound of what two arcs have in common, as `AngularIntervals.intersection` does [rad]."""
    if other_bound < bound:
        centre, bound, other_centre, other_bound = other_centre, other_bound, centre, bound
    offset = other_centre - centre  # within two whole turns, as centres are wrapped
    offset -= 2 * np.pi * np.rint(offset / (2 * np.pi))
    low, high = np.inf, -np.inf
    for turn in range(-1, 2):  # the wider arc may reach into the narrower one from either side
        piece_low = max(-bound, offset + 2 * np.pi * turn - other_bound - ANGLE_ROUNDING)
        piece_high = min(bound, offset + 2 * np.pi * turn + other_bound + ANGLE_ROUNDING)
        if piece_low <= piece_high:
            low, high = min(low, piece_low), max(high, piece_high)
    if low > high or bound < 0 or other_bound < 0:
        return centre, -1.0
    if low <= -bound and high >= bound:
        return centre, bound
    middle = centre + (low + high) / 2
    return middle - 2 * np.pi * np.ceil((middle - np.pi) / (2 * np.pi)), (high - low) / 2 + 2 * ANGLE_ROUNDING


@compiled
def _intersections(centre: Array, bound: Array, other_centre: Array, other_bound: Array) -> Array:
    """Return (2, k) centres and bounds."""
    arcs = np.empty((2, len(centre)))
    for k in range(len(centre)):
        arcs[0, k], arcs[1, k] = intersection(centre[k], bound[k], other_centre[k], other_bound[k])
    return arcs


@compiled
def _narrowed(arcs: tuple[Array, Array], begin: Integers, end: Integers, others: tuple[Array, Array]) -> Array:
    """Return (2, k) centres and bounds."""
    left = np.stack(arcs)
    for k in range(len(begin)):
        for m in range(begin[k], end[k]):
            centre, bound = intersection(left[0, k], left[1, k], others[0][m], others[1][m])
            if bound >= 0:
                left[0, k], left[1, k] = centre, bound
    return left
