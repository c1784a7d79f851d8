"""Angles, arcs and displacements between exact bounds: rational arithmetic, standard library only."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import atan2, ceil, cos, floor, isqrt, pi, sin

Vector = tuple[Fraction, Fraction]
Between = tuple[Fraction, Fraction]  # lower and upper bound

PI = Fraction(31415926535897932384626433832795028841971, 10**40)
PI_ROUNDING = Fraction(1, 10**40)
CIRCLE = Fraction(4)  # more than half a turn
TURNS = 1000  # an angle of more turns is refused
DIGITS, KEPT = 200, 110  # binary digits after the point: of the series, and of what is rounded outward
TERMS = 32
FINE = Fraction(1, 1 << 90)  # how well the angle of a vector is known [rad]


def up(value: Fraction) -> Fraction:
    """Return a number of few digits that is no smaller."""
    return Fraction(-((-value.numerator << KEPT) // value.denominator), 1 << KEPT)


def length(vector: Vector) -> Fraction:
    """Return a number no smaller than the vector's length."""
    square = vector[0] ** 2 + vector[1] ** 2
    return Fraction(isqrt((square.numerator << 2 * KEPT) // square.denominator) + 1, 1 << KEPT)


def unit(angle: Fraction) -> tuple[Between, Between]:
    """Return bounds of cosine and sine.

    Reduced to an eighth of a turn to either side, so that 32 terms of the series leave 0.8^32 / 32! < 2^-120. Each term is
    rounded down by one of 2^-200, which later terms multiply by e^0.8 at most, and pi is known to 10^-40: less than 2^-110 in
    all.

    Raises:
        ValueError: The angle is of more than 1000 turns.
    """
    quarters = round(angle / (PI / 2))
    if abs(quarters) > 4 * TURNS:
        raise ValueError(f"an angle of {quarters // 4} turns")
    reduced = angle - quarters * PI / 2
    x = (reduced.numerator << DIGITS) // reduced.denominator
    term, sums = 1 << DIGITS, [0, 0]
    for n in range(TERMS):
        sums[n % 2] += term if n % 4 < 2 else -term
        term = (term * x >> DIGITS) // (n + 1)
    cosine, sine = (value >> (DIGITS - KEPT) for value in sums)
    for _ in range(quarters % 4):
        cosine, sine = -sine - 1, cosine
    scale = 1 << KEPT
    return (Fraction(cosine - 1, scale), Fraction(cosine + 2, scale)), (Fraction(sine - 1, scale), Fraction(sine + 2, scale))


def angle_of(vector: Vector) -> Between:
    """Return bounds of a vector's angle, within half a turn of 0 [rad].

    Raises:
        ValueError: It has none.
    """
    guess = Fraction(atan2(vector[1], vector[0]))
    (x, _), (y, _) = unit(guess)
    guess += (x * vector[1] - y * vector[0]) / (x * vector[0] + y * vector[1])  # Newton's step, from 1e-16 to 1e-32
    low, high = guess - FINE, guess + FINE
    left, right = (-vector[1], vector[0]), (vector[1], -vector[0])
    if most(left, unit(low)) <= 0 and most(right, unit(high)) <= 0 and most((-vector[0], -vector[1]), unit(low)) < 0:
        return low, high
    raise ValueError("a vector without a direction")


def most(normal: Vector, direction: tuple[Between, Between]) -> Fraction:
    """Return the greatest normal . u over the bounds of u."""
    return sum((n * bounds[n > 0] for n, bounds in zip(normal, direction, strict=True)), Fraction(0))


@dataclass(frozen=True)
class Arc:
    """The directions from `low` to `high` [rad], as real numbers."""

    low: Fraction
    high: Fraction

    @cached_property
    def ends(self) -> tuple[tuple[Between, Between], tuple[Between, Between]]:
        """Its first and last direction."""
        return unit(self.low), unit(self.high)

    @property
    def narrow(self) -> bool:
        """Whether it is less than half a turn, for sure, and not empty."""
        return 0 <= self.high - self.low < PI - PI_ROUNDING

    def widened(self, centre: Fraction, bound: Fraction) -> "Arc":
        """Return the arc of the sums with centre +- bound."""
        return Arc(self.low + centre - bound, self.high + centre + bound)

    @property
    def opposite(self) -> "Arc":
        """The directions half a turn on; errs outward."""
        return Arc(self.low + PI - PI_ROUNDING, self.high + PI + PI_ROUNDING)

    def most(self, normal: Vector) -> Fraction:
        """Return the greatest normal . u at the two ends."""
        return max(most(normal, end) for end in self.ends)

    def may_contain(self, normal: Vector) -> bool:
        """Return False only if the normal's direction is not in the arc."""
        (x, y), (first, last), width = normal, self.ends, self.high - self.low
        if self.narrow:
            return most((y, -x), first) >= 0 and most((-y, x), last) >= 0 and most(normal, first) + most(normal, last) >= 0
        if not PI + PI_ROUNDING < width < 2 * (PI - PI_ROUNDING):  # the rest of the circle is less than half of it
            return True
        return most((-y, x), last) >= 0 or most((y, -x), first) >= 0

    def covers(self, other: "Arc") -> bool:
        """Return whether it contains another on the circle, for sure."""
        if self.high - self.low >= 2 * (PI + PI_ROUNDING):
            return True
        turns = round((self.low + self.high - other.low - other.high) / (4 * PI))
        moved = other.turned(turns)
        return self.low <= moved.low and moved.high <= self.high

    def turned(self, turns: int) -> "Arc":
        """Return the same directions, so many whole turns on; errs outward."""
        if not turns:
            return self
        by, rounding = 2 * turns * PI, 2 * abs(turns) * PI_ROUNDING
        return Arc(self.low + by - rounding, self.high + by + rounding)


def arc_around(centre: float, bound: float) -> Arc:
    """Return an arc; a bound of half a turn, as nearly as floats say it, is the whole circle."""
    reach = Fraction(bound) if bound < pi else CIRCLE
    return Arc(Fraction(centre) - reach, Fraction(centre) + reach)


def once_around(arc: Arc) -> Arc:
    """Return the same directions by an arc of one turn at most."""
    middle, half = (arc.low + arc.high) / 2, PI + PI_ROUNDING
    return Arc(max(arc.low, middle - half), min(arc.high, middle + half))


def in_common(known: Arc, arcs: Sequence[Arc]) -> Arc:
    """Return an arc around all directions that several have in common, as one interval of real numbers.

    The narrowest come first; of two, the wider one cuts the hull of its pieces from the narrower one. An arc that would leave
    nothing is left out, as only one that breaks its bound can.
    """
    for arc in sorted(arcs, key=lambda one: one.high - one.low):
        known = _both(known, arc)
    return known


def are_apart(a: Arc, b: Arc) -> bool:
    """Return whether two arcs have no direction in common, for sure."""
    return not _pieces(a, b)


def half_circle(normal: Vector) -> Arc:
    """Return an arc around the directions u with normal . u <= 0.

    Raises:
        ValueError: The normal has no direction.
    """
    low, high = angle_of(normal)
    return Arc(low + PI / 2 - PI_ROUNDING, high + 3 * PI / 2 + PI_ROUNDING)


def half_circle_about(angle: float) -> tuple[Vector, Arc]:
    """Return a normal nearly opposite to a direction [rad], and an arc around the directions u with normal . u <= 0."""
    normal = Fraction(-cos(angle)), Fraction(-sin(angle))
    bounds, middle = unit(Fraction(angle)), Fraction(angle)
    off = sum(max(abs(value + end) for end in between) for value, between in zip(normal, bounds, strict=True))
    return normal, Arc(middle - PI / 2, middle + PI / 2).widened(Fraction(0), 2 * off + PI_ROUNDING)


def _both(known: Arc, arc: Arc) -> Arc:
    narrow, wide = (arc, known) if arc.high - arc.low < known.high - known.low else (known, arc)
    if narrow.high - narrow.low >= 2 * PI:
        return known
    pieces = _pieces(narrow, wide)
    if not pieces:
        return known
    low, high = min(piece.low for piece in pieces), max(piece.high for piece in pieces)
    return Arc(max(narrow.low, low), min(narrow.high, high))


def _pieces(narrow: Arc, wide: Arc) -> list[Arc]:
    """Return an arc as many turns on as it meets another."""
    if max(wide.high - wide.low, narrow.high - narrow.low) >= 2 * (PI + PI_ROUNDING):
        return [narrow]
    first, last = floor((narrow.low - wide.high) / (2 * PI)), ceil((narrow.high - wide.low) / (2 * PI))
    pieces = [wide.turned(turns) for turns in range(first, last + 1)]
    return [piece for piece in pieces if piece.low <= narrow.high and narrow.low <= piece.high]


def sector(normal: Vector, arc: Arc, near: Fraction, far: Fraction) -> Fraction:
    """Return a number no smaller than normal . d, for d in a direction of the arc and between near and far away."""
    if arc.may_contain(normal):
        return far * length(normal)
    slope = arc.most(normal)
    return slope * (far if slope > 0 else near)
