"""Bounds that are pairs: measured - true lies in [low, high]. Here they become a value and a bound on either side.

The interval of true values that those say contains the declared one, whatever floats round.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import inf, nextafter

from filter import Bearing, Compass, InvalidInput, Range, RelativeHeading

Bounded = Compass | Bearing | Range | RelativeHeading  # what has a value, within a bound
VALUES: dict[type[Bounded], str] = {Compass: "heading", Bearing: "bearing", Range: "range", RelativeHeading: "heading"}


def without_pairs(
    kind: type[Bounded], values: Sequence[float], bounds: Sequence[float | tuple[float, float]]
) -> tuple[list[float], list[float]]:
    """Return values and bounds of one kind of measurement without pairs; one value, or one bound, stands for all.

    Raises:
        InvalidInput: A pair is the wrong way round.
    """
    count = max(len(values), len(bounds)) if values and bounds else 0
    places = ((values[k % len(values)], bounds[k % len(bounds)]) for k in range(count))
    found = [_centred(kind, value, bound) for value, bound in places]
    return [value for value, _ in found], [bound for _, bound in found]


def _centred(kind: type[Bounded], value: float, bound: float | tuple[float, float]) -> tuple[float, float]:
    if isinstance(bound, float):
        return value, bound
    found = centred(value, *bound)
    return from_zero(*found) if kind is Range else found


def centred(value: float, low: float, high: float) -> tuple[float, float]:
    """Return the middle and half the width of an interval that contains [value - high, value - low].

    Algorithm:
        Floats err, and their errors are floats: `_minus`. Where there is none the result is exact; elsewhere the bound is
        larger by all errors, and rounded up.

    Raises:
        InvalidInput: The pair is the wrong way round.
    """
    if low > high:
        raise InvalidInput("bound: pairs [low, high], the lower one first", f"[{low!r}, {high!r}]")
    shift = (low + high) / 2
    middle, lost = _minus(value, shift)
    (below, lost_below), (above, lost_above) = _minus(high, shift), _minus(shift, low)
    bound, rounding = max(below, above), abs(lost) + abs(lost_below) + abs(lost_above)
    return middle, _up(_up(bound + rounding)) if rounding else bound


def from_zero(middle: float, bound: float) -> tuple[float, float]:
    """Return an interval in which what is at least 0 of another one lies, with a middle that is at least 0, too.

    Distances are: what a negative middle says of them is how large they are at most.
    """
    if middle >= 0:
        return middle, bound
    most, lost = _minus(bound, -middle)
    half = max(_up(most) if lost > 0 else most, 0.0) / 2
    return (half, half) if 2 * half >= most else (_up(half), _up(half))  # the least of all floats has no half


def _minus(a: float, b: float) -> tuple[float, float]:
    """Return a - b as floats have it, and what that lacks, exactly."""
    difference = a - b
    back = a - difference
    return difference, (a - (difference + back)) + (back - b)


def _up(value: float) -> float:
    return nextafter(value, inf)
