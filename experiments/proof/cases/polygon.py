"""Convex polygons that are cut line by line, their corners without rounding. Exact arithmetic, standard library only."""

from __future__ import annotations

from collections.abc import Sequence
from fractions import Fraction
from math import inf, isfinite

from experiments.proof.edges import across
from experiments.proof.exact import Vector
from experiments.proof.reading import Broken
from experiments.proof.shown import dot

Line = tuple[Vector, Fraction]  # normal . p = offset
# Floats say which corners matter; where they are nearer than this share of the numbers in them, fractions decide.
DOUBT = 1e-12
LEAST_DOUBT = 1e-290  # where products of floats are too small to be right to a share


class Polygon:
    """A convex set of places, at least one point.

    Attributes:
        corners: Counter-clockwise [m]; some may be the same.
        floats: The same in floats.
        largest: No number in them is larger, for sure.
    """

    def __init__(self, lines: Sequence[Line], corners: Sequence[Vector]) -> None:
        """Take the line that leads on from each corner, and the corners."""
        self._lines, self.corners = lines, corners
        self.floats = [(float(x), float(y)) for x, y in corners]
        self.largest = max(abs(x) + abs(y) for x, y in self.floats)

    @classmethod
    def box(cls, lower: Vector, upper: Vector) -> Polygon:
        """Return what is between two corners.

        Raises:
            Broken: That is nothing.
        """
        (left, low), (right, high), one, no = lower, upper, Fraction(1), Fraction(0)
        if left > right or low > high:
            raise Broken("a box without a point")
        lines = [((no, -one), -low), ((one, no), right), ((no, one), high), ((-one, no), -left)]
        return cls(lines, [(left, low), (right, low), (right, high), (left, high)])

    @classmethod
    def around(cls, corners: Sequence[Vector]) -> Polygon:
        """Return the hull of some corners, which no line cuts."""
        return cls([], corners)

    def along(self, normal: Vector) -> list[float]:
        """Return normal . p of all corners, to a share `DOUBT` of the numbers in it; infinity where floats cannot tell."""
        x, y = float(normal[0]), float(normal[1])
        return [value if isfinite(value := x * p + y * q) else inf for p, q in self.floats]

    def most(self, normal: Vector) -> Fraction:
        """Return the greatest normal . p."""
        along = self.along(normal)
        least = max(along) - self._doubt(normal) if isfinite(max(along)) else -inf
        return max(dot(normal, corner) for corner, value in zip(self.corners, along, strict=True) if value >= least)

    def is_behind(self, normal: Vector, offset: Fraction) -> bool:
        """Return whether normal . p <= offset everywhere."""
        return self.is_clearly_behind(normal, float(offset)) or self.most(normal) <= offset

    def is_clearly_behind(self, normal: Vector, offset: float) -> bool:
        """Return whether normal . p <= offset everywhere, though either is rounded."""
        return max(self.along(normal)) < offset - self._doubt(normal) - DOUBT * abs(offset)

    def cut(self, normal: Vector, offset: Fraction) -> Polygon | None:
        """Return what is behind a line, normal . p <= offset; None if that is nothing."""
        if self.is_behind(normal, offset):
            return self
        beyond = [dot(normal, corner) - offset for corner in self.corners]
        if min(beyond) > 0:
            return None
        line, kept = (normal, offset), list[tuple[Line, Vector]]()
        for k, (now, following) in enumerate(zip(beyond, [*beyond[1:], beyond[0]], strict=True)):
            if now <= 0:
                kept.append((self._lines[k] if now < 0 or following <= 0 else line, self.corners[k]))
            if now < 0 < following:
                kept.append((line, _meet(self._lines[k], line)))
            if following < 0 < now:
                kept.append((self._lines[k], _meet(self._lines[k], line)))
        return Polygon(*zip(*kept, strict=True))

    def _doubt(self, normal: Vector) -> float:
        """Return by how much numbers along a normal can be wrong."""
        return LEAST_DOUBT + DOUBT * float(abs(normal[0]) + abs(normal[1])) * self.largest


def _meet(a: Line, b: Line) -> Vector:
    """Return where two lines meet (Cramer's rule)."""
    ((ax, ay), p), ((bx, by), q) = a, b
    turned = across(a[0], b[0])
    return (p * by - q * ay) / turned, (ax * q - bx * p) / turned
