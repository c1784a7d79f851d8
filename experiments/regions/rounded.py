"""Polygons in float32, as ROS has them, that still contain what they stand for.

A polygon in float32 is no proof, it is a picture; but a picture that cuts off the robot would be a wrong one. So each corner
becomes the smallest box around it on a grid of numbers that float32 has, and the polygon is the hull of all these boxes. It
contains the corners, and so all that is between them. The hull is found in whole numbers, without any rounding.
"""

from __future__ import annotations

from collections.abc import Sequence
from math import ceil, floor, frexp, inf, ldexp, nextafter

from filter import InvalidInput

BITS, LEAST = 24, -149  # of a float32's significand; exponent of the least one
LARGEST = 3.4e38  # that there is in float32 [m]
Grid = tuple[int, int]


def rounded_outward(corners: Sequence[Sequence[float]], margin: float) -> list[tuple[float, float]]:
    """Return corners, counter-clockwise and each a float32, of a polygon that contains the given one and its margin [m].

    It is larger by less than two steps of float32 at its farthest coordinate: 1e-6 m at 8 m, 0.5 m at 4 000 km.

    Raises:
        InvalidInput: A coordinate is beyond what float32 has.
    """
    largest = max(abs(value) for corner in corners for value in corner) + margin
    if not largest < LARGEST:
        raise InvalidInput(f"coordinates below {LARGEST:g} m, as float32 has no others", f"{largest!r} m")
    step = max(frexp(largest)[1] - BITS, LEAST)
    boxes = {(i, j) for x, y in corners for i in _around(x, margin, step) for j in _around(y, margin, step)}
    return [(ldexp(i, step), ldexp(j, step)) for i, j in _hull(sorted(boxes))]


def _around(value: float, margin: float, step: int) -> tuple[int, int]:
    """Return the whole multiples of 2**step next to a value less and plus a margin."""
    low, high = value, value
    if margin:
        low, high = nextafter(value - margin, -inf), nextafter(value + margin, inf)
    return floor(ldexp(low, -step)), ceil(ldexp(high, -step))


def _hull(points: list[Grid]) -> list[Grid]:
    """Return the corners of the convex hull of points in order, counter-clockwise (Andrew, 1979)."""
    halves: list[list[Grid]] = []
    for way in (points, points[::-1]):
        half: list[Grid] = []
        for point in way:
            while len(half) > 1 and _turn(half[-2], half[-1], point) <= 0:
                half.pop()
            half.append(point)
        halves.append(half)
    return [*halves[0][:-1], *halves[1][:-1]] or points


def _turn(a: Grid, b: Grid, c: Grid) -> int:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])
