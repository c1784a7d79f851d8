"""Convex polygons that are cut line by line, their corners without rounding. Exact arithmetic, standard library only.

In whole numbers, of which nothing is ever reduced: x, y, w, with w > 0, are the corner (x / w, y / w), and a, b, c the
half-plane a p + b q <= c. A corner is where two of the lines given meet, so its numbers are no longer than their products.
On which side of a line a corner is say floats, wherever that is clear; else whole numbers do.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property
from math import inf, nan

from experiments.proof.exact import CHOSEN, KEPT, Vector, Whole, whole
from experiments.proof.reading import Broken

Three = tuple[int, int, int]
Two = tuple[float, float]
SIDES = ((0, -1), (1, 0), (0, 1), (-1, 0))  # of a box
DOUBT, TINY = 2.0**-50, 1e-300  # of floats, a share of what is summed, and more than is lost below the least of them


def three(*values: Fraction) -> Three:
    """Return a place as its corner, or a normal and an offset as their half-plane."""
    x, y, *rest = whole(*values)
    return x, y, rest[0]


class Polygon:
    """A convex set of places, at least one point.

    Attributes:
        floats: Its corners as floats; some may be the same [m].
    """

    def __init__(self, lines: Sequence[Three], corners: Sequence[Three], floats: Sequence[Two] | None = None) -> None:
        """Take the line that leads on from each corner, and the corners, with the floats nearest to these if they are known."""
        self._lines, self._corners = lines, corners
        self.floats = [_rounded(*corner) for corner in corners] if floats is None else floats

    @classmethod
    def box(cls, lower: Vector, upper: Vector) -> Polygon:
        """Return what is between two corners.

        Raises:
            Broken: That is nothing.
        """
        left, low, right, high, w = whole(*lower, *upper)
        if left > right or low > high:
            raise Broken("a box without a point")
        lines = [(a * w, b * w, c) for (a, b), c in zip(SIDES, (-low, right, high, -left), strict=True)]
        return cls(lines, [(left, low, w), (right, low, w), (right, high, w), (left, high, w)])

    @classmethod
    def around(cls, corners: Sequence[Vector]) -> Polygon:
        """Return the hull of some corners, which no line cuts."""
        return cls([], [three(*corner) for corner in corners])

    @property
    def corners(self) -> list[Vector]:
        """Its corners, counter-clockwise [m]."""
        return [(Fraction(x, w), Fraction(y, w)) for x, y, w in self._corners]

    @cached_property
    def largest(self) -> float:
        """No number in its corners is larger."""
        return max([abs(x) + abs(y) for x, y in self.floats])

    def reach(self, normal: Whole) -> int:
        """Return a number no smaller than the greatest normal . p, in steps of 2^-110 m; the normal's are 2^-60."""
        a, b = normal
        return max([-((-a * x - b * y << KEPT - CHOSEN) // w) for x, y, w in self._corners])

    def is_behind(self, line: Three) -> bool:
        """Return whether all of it is in a half-plane."""
        return max(self._beyond(line)) <= 0

    def _beyond(self, line: Three) -> list[int]:
        """Return a number for each corner, positive if it is beyond a line, 0 on it, negative behind it; one if all are behind.

        Floats say so if that is farther than all their rounding. With |a| + |b| = 1, corners and line are rounded to 2^-53 of
        themselves, and so are both products, their sum and where doubt ends: less than 8 times that of what is summed.
        """
        a, b, c = line
        try:
            size = abs(a) + abs(b)
            p, q, r = a / size, b / size, c / size
        except (OverflowError, ZeroDivisionError):
            p = q = r = nan
        doubt = DOUBT * (self.largest + abs(r)) + TINY
        low, high = r - doubt, r + doubt
        clear = [p * x + q * y for x, y in self.floats]
        if max(clear) < low:
            return [-1]
        return [
            -1 if value < low else 1 if value > high else a * x + b * y - c * w
            for value, (x, y, w) in zip(clear, self._corners, strict=True)
        ]

    def cut(self, line: Three) -> Polygon | None:
        """Return what is in a half-plane; None if that is nothing."""
        beyond = self._beyond(line)
        if max(beyond) <= 0 or min(beyond) > 0:
            return self if max(beyond) <= 0 else None
        kept = list[tuple[Three, Three, Two]]()
        for k, (now, following) in enumerate(zip(beyond, [*beyond[1:], beyond[0]], strict=True)):
            if now <= 0:
                kept.append((self._lines[k] if now < 0 or following <= 0 else line, self._corners[k], self.floats[k]))
            if now < 0 < following or following < 0 < now:
                corner = _meet(self._lines[k], line)
                kept.append((line if now < 0 else self._lines[k], corner, _rounded(*corner)))
        return Polygon(*zip(*kept, strict=True))

    def is_nearer(self, other: Polygon, distance: Fraction) -> bool:
        """Return whether all places of both are nearer to one another than a distance."""
        pairs, (far, unit_of) = ((p, q) for p in self._corners for q in other._corners), whole(distance)
        return all(
            ((x * v - u * w) ** 2 + (y * v - t * w) ** 2) * unit_of**2 < (far * w * v) ** 2 for (x, y, w), (u, t, v) in pairs
        )


def _rounded(x: int, y: int, w: int) -> Two:
    """Return a corner in floats; where it is too far away for them, all is in doubt."""
    try:
        return x / w, y / w
    except OverflowError:
        return inf, inf


def _meet(one: Three, other: Three) -> Three:
    """Return where two lines meet (Cramer's rule)."""
    (a, b, c), (d, e, f) = one, other
    turned, x, y = a * e - b * d, c * e - f * b, a * f - d * c
    return (x, y, turned) if turned > 0 else (-x, -y, -turned)
