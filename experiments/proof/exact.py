"""Angles, arcs and displacements between exact bounds: rational arithmetic, standard library only."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import atan2, ceil, floor, isqrt, pi

Vector = tuple[Fraction, Fraction]
Between = tuple[Fraction, Fraction]  # lower and upper bound

PI = Fraction(31415926535897932384626433832795028841971, 10**40)
PI_ROUNDING = Fraction(1, 10**40)
CIRCLE = Fraction(4)  # more than half a turn
TURNS = 1000  # an angle of more turns is refused
DIGITS, KEPT = 200, 110  # binary digits after the point: of the series, and of what is rounded outward
TERMS = 60
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

    Reduced to half a turn, so that 60 terms of the series leave 3.2^60 / 60! < 2^-170. Each term is rounded down by one
    of 2^-200, which later terms multiply by e^3.2 at most, and pi is known to 10^-40: less than 2^-110 in all.

    Raises:
        ValueError: The angle is of more than 1000 turns.
    """
    turns = round(angle / (2 * PI))
    if abs(turns) > TURNS:
        raise ValueError(f"an angle of {turns} turns")
    reduced = angle - 2 * turns * PI
    x = (reduced.numerator << DIGITS) // reduced.denominator
    term, sums = 1 << DIGITS, [0, 0]
    for n in range(TERMS):
        sums[n % 2] += term if n % 4 < 2 else -term
        term = (term * x >> DIGITS) // (n + 1)
    cosine, sine = (value >> (DIGITS - KEPT) for value in sums)
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
        (x, y), (first, last) = normal, self.ends
        return most((y, -x), first) >= 0 and most((-y, x), last) >= 0 and most(normal, first) + most(normal, last) >= 0

    def covers(self, other: "Arc") -> bool:
        """Return whether it contains another on the circle, for sure."""
        if self.high - self.low >= 2 * (PI + PI_ROUNDING):
            return True
        turns = round((self.low + self.high - other.low - other.high) / (4 * PI))
        moved = other.turned(turns)
        return self.low <= moved.low and moved.high <= self.high

    def turned(self, turns: int) -> "Arc":
        """Return the same directions, so many whole turns on; errs outward."""
        by, rounding = 2 * turns * PI, 2 * abs(turns) * PI_ROUNDING
        return Arc(self.low + by - rounding, self.high + by + rounding)


def arc_around(centre: float, bound: float) -> Arc:
    """Return an arc; a bound of half a turn, as nearly as floats say it, is the whole circle."""
    reach = Fraction(bound) if bound < pi else CIRCLE
    return Arc(Fraction(centre) - reach, Fraction(centre) + reach)


def in_common(known: Arc, arcs: Sequence[Arc]) -> Arc:
    """Return an arc around all directions that several have in common, as one interval of real numbers.

    The narrowest come first; of two, the wider one cuts the hull of its pieces from the narrower one. An arc that would leave
    nothing is left out, as only one that breaks its bound can.
    """
    for arc in sorted(arcs, key=lambda one: one.high - one.low):
        known = _both(known, arc)
    return known


def _both(known: Arc, arc: Arc) -> Arc:
    narrow, wide = (arc, known) if arc.high - arc.low < known.high - known.low else (known, arc)
    if narrow.high - narrow.low >= 2 * PI:
        return known
    first, last = ceil((narrow.low - wide.high) / (2 * PI)) - 1, floor((narrow.high - wide.low) / (2 * PI)) + 1
    pieces = [wide.turned(turns) for turns in range(first, last + 1)]
    pieces = [piece for piece in pieces if piece.low <= narrow.high and narrow.low <= piece.high]
    if not pieces:
        return known
    low, high = min(piece.low for piece in pieces), max(piece.high for piece in pieces)
    return Arc(max(narrow.low, low), min(narrow.high, high))


def sector(normal: Vector, arc: Arc, near: Fraction, far: Fraction) -> Fraction:
    """Return a number no smaller than normal . d, for d in a direction of the arc and between near and far away."""
    if not arc.narrow or arc.may_contain(normal):
        return far * length(normal)
    slope = arc.most(normal)
    return slope * (far if slope > 0 else near)


@dataclass(frozen=True)
class Motion:
    """How one robot can have moved: at the end of a path, in a sector, and then a slip in any direction.

    Attributes:
        arc: Directions of the path's chord.
        least: Least signed length of the path [m].
        greatest: Greatest signed length of the path [m].
        bend: The heading is never farther from the chord's [rad].
        slip: [m].
    """

    arc: Arc
    least: Fraction
    greatest: Fraction
    bend: Fraction
    slip: Fraction

    @classmethod
    def of_odometry(cls, driven: Mapping[str, Fraction], heading: Arc) -> "Motion":
        """Return how a robot can have moved, from a heading on [rad]."""
        turn, turned, skew = abs(driven["turn"]), driven["turn_bound"], driven["direction_bound"]
        full = turn + turned >= 2 * (PI - PI_ROUNDING)
        arc = Arc(-CIRCLE, CIRCLE) if full else heading.widened(driven["turn"] / 2, turned / 2 + skew)
        least, greatest = driven["distance"] - driven["distance_bound"], driven["distance"] + driven["distance_bound"]
        return cls(arc, least, greatest, (turn + turned) / 2 + skew, driven["slip_bound"])

    @cached_property
    def chord(self) -> Fraction:
        """A number no greater than the chord's length by the path's."""
        return max(Fraction(0), unit(self.bend)[0][0]) if 2 * self.bend < PI - PI_ROUNDING else Fraction(0)

    def support(self, normal: Vector) -> Fraction:
        """Return a number no smaller than normal . u over the displacements u."""
        found = []
        if self.greatest >= 0:
            found.append(sector(normal, self.arc, max(Fraction(0), self.least) * self.chord, self.greatest))
        if self.least <= 0:
            back = (-normal[0], -normal[1])
            found.append(sector(back, self.arc, max(Fraction(0), -self.greatest) * self.chord, -self.least))
        return up(max(found) + self.slip * length(normal))
