"""Convex polygons that are cut line by line, their corners without rounding. Exact arithmetic, standard library only.

In whole numbers, of which nothing is ever reduced: x, y, w, with w > 0, are the corner (x / w, y / w), and a, b, c the
half-plane a p + b q <= c. A corner is where two of the lines given meet, so its numbers are no longer than their products.
"""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from functools import cached_property

from experiments.proof.exact import Vector, whole
from experiments.proof.reading import Broken

Three = tuple[int, int, int]
SIDES = ((0, -1), (1, 0), (0, 1), (-1, 0))  # of a box


def three(*values: Fraction) -> Three:
    """Return a place as its corner, or a normal and an offset as their half-plane."""
    x, y, *rest = whole(*values)
    return x, y, rest[0]


class Polygon:
    """A convex set of places, at least one point."""

    def __init__(self, lines: Sequence[Three], corners: Sequence[Three]) -> None:
        """Take the line that leads on from each corner, and the corners."""
        self._lines, self._corners = lines, corners

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
    def floats(self) -> list[tuple[float, float]]:
        """The same in floats; some may be the same."""
        return [(x / w, y / w) for x, y, w in self._corners]

    @property
    def largest(self) -> float:
        """No number in them is larger."""
        return max([abs(x) + abs(y) for x, y in self.floats])

    def most(self, normal: Vector) -> Fraction:
        """Return the greatest normal . p."""
        (a, b, unit_of), best, of_best = whole(*normal), 0, 0
        for x, y, w in self._corners:
            if not of_best or (a * x + b * y) * of_best > best * w:
                best, of_best = a * x + b * y, w
        return Fraction(best, of_best * unit_of)

    def is_behind(self, line: Three) -> bool:
        """Return whether all of it is in a half-plane."""
        a, b, c = line
        return max([a * x + b * y - c * w for x, y, w in self._corners]) <= 0

    def cut(self, line: Three) -> Polygon | None:
        """Return what is in a half-plane; None if that is nothing."""
        a, b, c = line
        beyond = [a * x + b * y - c * w for x, y, w in self._corners]
        if max(beyond) <= 0 or min(beyond) > 0:
            return self if max(beyond) <= 0 else None
        kept = list[tuple[Three, Three]]()
        for k, (now, following) in enumerate(zip(beyond, [*beyond[1:], beyond[0]], strict=True)):
            if now <= 0:
                kept.append((self._lines[k] if now < 0 or following <= 0 else line, self._corners[k]))
            if now < 0 < following:
                kept.append((line, _meet(self._lines[k], line)))
            if following < 0 < now:
                kept.append((self._lines[k], _meet(self._lines[k], line)))
        return Polygon(*zip(*kept, strict=True))

    def is_nearer(self, other: Polygon, distance: Fraction) -> bool:
        """Return whether all places of both are nearer to one another than a distance."""
        pairs, (far, unit_of) = ((p, q) for p in self._corners for q in other._corners), whole(distance)
        return all(
            ((x * v - u * w) ** 2 + (y * v - t * w) ** 2) * unit_of**2 < (far * w * v) ** 2 for (x, y, w), (u, t, v) in pairs
        )


def _meet(one: Three, other: Three) -> Three:
    """Return where two lines meet (Cramer's rule)."""
    (a, b, c), (d, e, f) = one, other
    turned, x, y = a * e - b * d, c * e - f * b, a * f - d * c
    return (x, y, turned) if turned > 0 else (-x, -y, -turned)
