"""Angles, arcs and displacements between exact bounds: rational arithmetic, standard library only.

What is done often is done in whole numbers, over a common denominator or on a grid of 2^-110: nothing has to be reduced there.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property, lru_cache
from math import atan2, isqrt, lcm, pi
from typing import TypeVar

Vector = tuple[Fraction, Fraction]
Between = tuple[Fraction, Fraction]  # lower and upper bound
Whole = tuple[int, int]  # a vector, or two bounds, in whole numbers of some unit
Exact = TypeVar("Exact", int, Fraction)

ANGLES = 160  # binary digits of angles after the point: a step is 2^-160 rad
HALF = 0x3243F6A8885A308D313198A2E03707344A4093822  # a turn, in steps; truly it is less than a step longer
PI, PI_ROUNDING = Fraction(HALF, 1 << ANGLES), Fraction(1, 1 << ANGLES)
CIRCLE = Fraction(4)  # more than half a turn
TURNS = 1000  # an angle of more turns is refused
DIGITS, KEPT = 200, 110  # binary digits after the point: of the series, and of what is rounded outward
CHOSEN = 60  # binary digits of vectors that are chosen
ONE = 1 << CHOSEN
TERMS = 32
FINE = 1 << ANGLES - 90  # how well the angle of a vector is known, in steps


def whole(*values: Fraction) -> tuple[int, ...]:
    """Return numbers as whole ones over a common denominator, which comes last."""
    own = [value.denominator for value in values]
    common = lcm(*own)
    return (*[value.numerator * (common // each) for value, each in zip(values, own, strict=True)], common)


def nearly(*values: Fraction) -> tuple[float, ...]:
    """Return numbers as the floats next to them."""
    return (*[value.numerator / value.denominator for value in values],)


def below(value: Fraction, digits: int = ANGLES) -> int:
    """Return a number in steps of so many binary digits, as an angle, or the next whole number of them below."""
    return (value.numerator << digits) // value.denominator


def above(value: Fraction, digits: int = ANGLES) -> int:
    """Return the same, or the next whole number above."""
    return -((-value.numerator << digits) // value.denominator)


def steps(value: Fraction) -> int:
    """Return a number that is no smaller, in steps of 2^-110."""
    return above(value, KEPT)


def up(value: Fraction) -> Fraction:
    """Return a number of few digits that is no smaller."""
    return Fraction(steps(value), 1 << KEPT)


def length(vector: Vector) -> Fraction:
    """Return a number no smaller than the vector's length."""
    x, y, unit_of = whole(*vector)
    return Fraction(-(-steps_long((x, y)) // unit_of), 1 << KEPT)


@lru_cache(1 << 10)
def steps_long(vector: Whole) -> int:
    """Return a number greater than a vector's length, in steps of 2^-110 of its unit."""
    return isqrt((vector[0] ** 2 + vector[1] ** 2) << 2 * KEPT) + 1


def unit(angle: Fraction) -> tuple[Between, Between]:
    """Return bounds of cosine and sine; raises `ValueError` if the angle is of more than 1000 turns."""
    (a, b), (c, d) = direction(below(angle))
    scale = 1 << KEPT
    return (Fraction(a, scale), Fraction(b, scale)), (Fraction(c, scale), Fraction(d, scale))


def direction(angle: int) -> tuple[Whole, Whole]:
    """Return bounds of cosine and sine of an angle in steps, or one less than a step more, in steps of 2^-110.

    Reduced to an eighth of a turn to either side, so that 32 terms of the series leave 0.8^32 / 32! < 2^-120. Each term is
    rounded down by one of 2^-200, which later terms multiply by e^0.8 at most, and pi is known to 2^-160: less than 2^-110 in
    all.

    Raises:
        ValueError: The angle is of more than 1000 turns.
    """
    quarters = (2 * angle + HALF // 2) // HALF
    if abs(quarters) > 4 * TURNS:
        raise ValueError(f"an angle of {quarters // 4} turns")
    x = (2 * angle - quarters * HALF) << DIGITS - ANGLES - 1
    term, sums = 1 << DIGITS, [0, 0]
    for n in range(TERMS):
        sums[n % 2] += term if n % 4 < 2 else -term
        term = (term * x >> DIGITS) // (n + 1)
    cosine, sine = (value >> (DIGITS - KEPT) for value in sums)
    for _ in range(quarters % 4):
        cosine, sine = -sine - 1, cosine
    return (cosine - 1, cosine + 2), (sine - 1, sine + 2)


def angle_of(vector: Vector) -> "Arc":
    """Return an arc around a vector's angle, within half a turn of 0.

    Raises:
        ValueError: It has none.
    """
    guess, (x, y, _) = below(Fraction(atan2(vector[1], vector[0]))), whole(*vector)
    (cosine, _), (sine, _) = direction(guess)
    turned, ahead = cosine * y - sine * x, cosine * x + sine * y
    guess += (turned << ANGLES) // ahead  # Newton's step, from 1e-16 to 1e-32
    low, high = guess - FINE, guess + FINE
    first, last = direction(low), direction(high)
    if most((-y, x), first) <= 0 and most((y, -x), last) <= 0 and most((-x, -y), first) < 0:
        return Arc(low, high)
    raise ValueError("a vector without a direction")


def most(normal: tuple[Exact, Exact], bounds: tuple[Whole, Whole]) -> Exact:
    """Return the greatest normal . u over the bounds of u, in the product of their units."""
    (x, y), (cosine, sine) = normal, bounds
    return x * cosine[x > 0] + y * sine[y > 0]


@dataclass(frozen=True)
class Arc:
    """The directions from `first` to `last`, as real numbers, in steps of 2^-160 rad; sums and turns err outward."""

    first: int
    last: int

    @classmethod
    def between(cls, low: Fraction, high: Fraction) -> "Arc":
        """Return an arc around all from one angle to another [rad]."""
        return cls(below(low), above(high))

    @property
    def low(self) -> Fraction:
        """Its first angle [rad]."""
        return Fraction(self.first, 1 << ANGLES)

    @property
    def high(self) -> Fraction:
        """Its last angle [rad]."""
        return Fraction(self.last, 1 << ANGLES)

    @property
    def width(self) -> int:
        """How many steps it is wide."""
        return self.last - self.first

    @cached_property
    def ends(self) -> tuple[tuple[Whole, Whole], tuple[Whole, Whole]]:
        """Bounds of its first and last direction, in steps of 2^-110."""
        return direction(self.first), direction(self.last)

    @property
    def narrow(self) -> bool:
        """Whether it is less than half a turn, for sure, and not empty."""
        return 0 <= self.width < HALF

    def widened(self, centre: Fraction, bound: Fraction) -> "Arc":
        """Return the arc of the sums with centre +- bound."""
        more = above(bound)
        return Arc(self.first + below(centre) - more, self.last + above(centre) + more)

    @property
    def opposite(self) -> "Arc":
        """The directions half a turn on."""
        return Arc(self.first + HALF, self.last + HALF + 1)

    def most(self, normal: Vector) -> Fraction:
        """Return the greatest normal . u at the two ends."""
        x, y, unit_of = whole(*normal)
        return Fraction(self.steepest((x, y)), unit_of << KEPT)

    def steepest(self, normal: Whole) -> int:
        """Return the same in whole numbers, in steps of 2^-110 of the normal's unit."""
        first, last = self.ends
        return max(most(normal, first), most(normal, last))

    def may_contain(self, normal: tuple[Exact, Exact]) -> bool:
        """Return False only if the normal's direction is not in the arc."""
        (x, y), (first, last) = normal, self.ends
        if self.narrow:
            return most(normal, first) + most(normal, last) >= 0 and most((y, -x), first) >= 0 and most((-y, x), last) >= 0
        if not HALF + 1 < self.width < 2 * HALF:  # the rest of the circle is less than half of it
            return True
        return most((-y, x), last) >= 0 or most((y, -x), first) >= 0

    def covers(self, other: "Arc") -> bool:
        """Return whether it contains another on the circle, for sure."""
        if self.width >= 2 * (HALF + 1):
            return True
        moved = other.turned((self.first + self.last - other.first - other.last + 2 * HALF) // (4 * HALF))
        return self.first <= moved.first and moved.last <= self.last

    def turned(self, turns: int) -> "Arc":
        """Return the same directions, so many whole turns on."""
        by, more = 2 * turns * HALF, 2 * turns
        return Arc(self.first + by + min(0, more), self.last + by + max(0, more)) if turns else self


ANYWHERE = Arc.between(-CIRCLE, CIRCLE)


def arc_around(centre: float, bound: float) -> Arc:
    """Return an arc; a bound of half a turn, as nearly as floats say it, is the whole circle.

    Raises:
        ValueError: It has finer digits than 2^-160: what is claimed would be rounded outward.
    """
    middle, off = Fraction(centre), Fraction(bound) if bound < pi else CIRCLE
    arc = Arc.between(middle - off, middle + off)
    if (arc.low, arc.high) != (middle - off, middle + off):
        raise ValueError("an arc of finer digits than 2^-160")
    return arc


def claimed(centre: str, bound: str) -> Arc:
    """Return the arc that two C99 hexadecimal strings claim."""
    return arc_around(float.fromhex(centre), float.fromhex(bound))


def once_around(arc: Arc) -> Arc:
    """Return the same directions by an arc of one turn at most."""
    middle = (arc.first + arc.last) // 2
    return Arc(max(arc.first, middle - HALF - 1), min(arc.last, middle + HALF + 2))


def in_common(known: Arc, arcs: Sequence[Arc]) -> Arc:
    """Return an arc around all directions that several have in common, as one interval of real numbers.

    The narrowest come first; of two, the wider one cuts the hull of its pieces from the narrower one. An arc that would leave
    nothing is left out, as only one that breaks its bound can.
    """
    for arc in sorted(arcs, key=lambda one: one.width):
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
    around = angle_of(normal)
    return Arc(around.first + HALF // 2, around.last + 3 * HALF // 2 + 3)


def _both(known: Arc, arc: Arc) -> Arc:
    narrow, wide = (arc, known) if arc.width < known.width else (known, arc)
    if narrow.width >= 2 * HALF:
        return known
    pieces = _pieces(narrow, wide)
    if not pieces:
        return known
    first, last = min(piece.first for piece in pieces), max(piece.last for piece in pieces)
    return Arc(max(narrow.first, first), min(narrow.last, last))


def _pieces(narrow: Arc, wide: Arc) -> list[Arc]:
    """Return an arc as many turns on as it meets another."""
    if max(wide.width, narrow.width) >= 2 * (HALF + 1):
        return [narrow]
    first, last = (narrow.first - wide.last) // (2 * HALF), -((wide.first - narrow.last) // (2 * HALF))
    pieces = [wide.turned(turns) for turns in range(first, last + 1)]
    return [piece for piece in pieces if piece.first <= narrow.last and narrow.first <= piece.last]


def sector(normal: Whole, arc: Arc, near: int, far: int) -> int:
    """Return a number no smaller than normal . d, for d in a direction of the arc and between near and far away.

    All in whole numbers: distances in steps of 2^-110, what is returned in steps of 2^-220 of the normal's unit.
    """
    first, last = (most(normal, end) for end in arc.ends)
    if not (arc.narrow and first + last < 0) and arc.may_contain(normal):
        return far * steps_long(normal)
    slope = max(first, last)
    return slope * (far if slope > 0 else near)
