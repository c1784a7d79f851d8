"""Where a robot can have gone: by one piece of motion, and by several, one after the other. Rational arithmetic alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import atan2, cos, sin

from experiments.proof.exact import (
    ANYWHERE,
    KEPT,
    PI,
    PI_ROUNDING,
    Arc,
    Between,
    Vector,
    Whole,
    angle_of,
    length,
    sector,
    steps,
    steps_long,
    unit,
    up,
    whole,
)

NOTHING = Fraction(0)


@dataclass(frozen=True)
class Piece:
    """How a robot moved for a while.

    Attributes:
        distance: Length of its path, negative when it drove backwards [m].
        distance_bound: [m].
        turn: Change of its heading [rad].
        turn_bound: [rad].
        direction_bound: How far its displacement can be turned from the middle of its headings [rad].
        slip_bound: A further displacement in any direction [m].
        aside: Which way it drives, from its forward axis [rad].
    """

    distance: Fraction
    distance_bound: Fraction
    turn: Fraction
    turn_bound: Fraction
    direction_bound: Fraction
    slip_bound: Fraction
    aside: Fraction

    @property
    def longest(self) -> Fraction:
        """Greatest length of its path [m]."""
        return abs(self.distance) + self.distance_bound

    @property
    def bend(self) -> Fraction:
        """Its way never differs by more from that to where it ended [rad]."""
        return (abs(self.turn) + self.turn_bound) / 2 + self.direction_bound

    @cached_property
    def chord(self) -> Fraction:
        """A number no greater than the length of its displacement by that of its path, slip aside."""
        return max(NOTHING, unit(self.bend)[0][0]) if 2 * self.bend < PI - PI_ROUNDING else NOTHING


@dataclass(frozen=True)
class Motion:
    """Displacements of one robot: in a sector, and then a slip in any direction.

    Attributes:
        arc: Directions of the sector.
        least: The least signed distance [m].
        greatest: The greatest signed distance [m].
        chord: What is between these can be nearer by this factor.
        slip: [m].
    """

    arc: Arc
    least: Fraction
    greatest: Fraction
    chord: Fraction
    slip: Fraction

    @classmethod
    def of(cls, piece: Piece, heading: Arc) -> Motion:
        """Return where a robot can have gone by one piece of motion, from a heading on [rad]."""
        full = abs(piece.turn) + piece.turn_bound >= 2 * (PI - PI_ROUNDING)
        off = piece.turn_bound / 2 + piece.direction_bound
        arc = ANYWHERE if full else heading.widened(piece.turn / 2 + piece.aside, off)
        least, greatest = piece.distance - piece.distance_bound, piece.distance + piece.distance_bound
        return cls(arc, least, greatest, piece.chord, piece.slip_bound)

    @classmethod
    def disc(cls, radius: Fraction) -> Motion:
        """Return all displacements that are so long at most [m]."""
        return cls(ANYWHERE, NOTHING, NOTHING, NOTHING, radius)

    @cached_property
    def _reaches(self) -> tuple[Whole | None, Whole | None, int]:
        """How near and how far it is ahead and back, None if it is not, and the slip, in steps of 2^-110, rounded outward."""
        ahead, back = (
            (-steps(-max(NOTHING, near) * self.chord), steps(far)) if far >= 0 else None
            for near, far in ((self.least, self.greatest), (-self.greatest, -self.least))
        )
        return ahead, back, steps(self.slip)

    def support(self, normal: Vector) -> Fraction:
        """Return a number no smaller than normal . u over the displacements u."""
        x, y, unit_of = whole(*normal)
        return Fraction(-(-self.reach((x, y)) // (unit_of << KEPT)), 1 << KEPT)

    def reach(self, normal: Whole) -> int:
        """Return the same of a normal in whole numbers, in steps of 2^-220 of its unit."""
        (ahead, back, slip), found = self._reaches, list[int]()
        if ahead:
            found.append(sector(normal, self.arc, *ahead))
        if back:
            found.append(sector((-normal[0], -normal[1]), self.arc, *back))
        return max(found) + slip * steps_long(normal)


@dataclass(frozen=True)
class Displaced:
    """Sets of displacements of one robot, each of which contains all that it can have done."""

    sets: Sequence[Motion]

    @classmethod
    def of(cls, pieces: Sequence[Piece], heading: Arc) -> Displaced:
        """Return where a robot can have gone by pieces of motion, one after the other, from a heading on [rad]."""
        if len(pieces) == 1:
            return cls([Motion.of(pieces[0], heading)])
        driven, slip = _driven(pieces), sum((piece.slip_bound for piece in pieces), NOTHING)
        disc = Motion.disc(slip + sum((one.piece.longest for one in driven), NOTHING))
        return cls([disc, *_about_the_mean(driven, heading, slip), *_within_a_cone(driven, heading, slip)])

    def support(self, normal: Vector) -> Fraction:
        """Return a number no smaller than normal . u over the displacements u."""
        return min(motion.support(normal) for motion in self.sets)


def turned(pieces: Sequence[Piece], heading: Arc) -> Arc:
    """Return a heading after pieces of motion [rad]."""
    turn, bound = (sum((getattr(piece, name) for piece in pieces), NOTHING) for name in ("turn", "turn_bound"))
    return heading.widened(turn, bound)


@dataclass(frozen=True)
class _Drive:
    """A piece that went somewhere: in a direction from the first heading, within so much to either side [rad]."""

    piece: Piece
    angle: Fraction
    off: Fraction

    @cached_property
    def deviations(self) -> tuple[Fraction, Fraction]:
        """How far it ended at most, along its direction and across, from where it would have as said [m]."""
        cosine, sine = unit(min(self.off, PI))[0][0], unit(min(self.off, PI / 2))[1][1]
        ahead = cosine * self.piece.chord if cosine > 0 else cosine
        return self.piece.distance_bound + self.piece.longest * (1 - ahead), self.piece.longest * sine


def _driven(pieces: Sequence[Piece]) -> list[_Drive]:
    found, turn, bound = list[_Drive](), NOTHING, NOTHING
    for piece in pieces:
        if piece.longest:
            off = bound + piece.turn_bound / 2 + piece.direction_bound
            found.append(_Drive(piece, turn + piece.turn / 2 + piece.aside, off))
        turn, bound = turn + piece.turn, bound + piece.turn_bound
    return found


def _about_the_mean(driven: Sequence[_Drive], heading: Arc, slip: Fraction) -> list[Motion]:
    """Return a sector about the sum of what was said, as wide as all deviations together; none if it is no sector.

    Its middle is a guess of floats: what the sum has across to it is a deviation, too.
    """
    way, along, across = _guessed(driven), NOTHING, NOTHING
    mean, beside = (NOTHING, NOTHING), (NOTHING, NOTHING)
    for one in driven:
        ahead, aside = one.deviations
        both = unit(one.angle - way)
        cosine, sine = (max(map(abs, bounds)) for bounds in both)
        along, across = along + ahead * cosine + aside * sine, across + ahead * sine + aside * cosine
        mean, beside = (_plus(total, one.piece.distance, bounds) for total, bounds in zip((mean, beside), both, strict=True))
    across = up(across + max(map(abs, beside)))
    nearest, farthest = -up(along - mean[0]), length((mean[1] + along, across))
    if nearest <= 0:
        return []
    return [Motion(heading.widened(way, angle_of((nearest, across)).high), nearest, farthest, Fraction(1), slip)]


def _guessed(driven: Sequence[_Drive]) -> Fraction:
    each = [(float(one.piece.distance), float(one.angle)) for one in driven]
    return Fraction(atan2(sum(size * sin(angle) for size, angle in each), sum(size * cos(angle) for size, angle in each)))


def _plus(total: Between, factor: Fraction, bounds: Between) -> Between:
    """Return bounds of a sum to which a product is added."""
    low, high = sorted(factor * bound for bound in bounds)
    return total[0] + low, total[1] + high


def _within_a_cone(driven: Sequence[_Drive], heading: Arc, slip: Fraction) -> list[Motion]:
    """Return a sector about all directions; none if it is no sector.

    What was driven to and fro, b at most either way, is added as a slip: of two sums of paths of length b within w of one
    direction, each ended at least b times the chord along it and at most b sin(w) beside it.
    """
    if not driven:
        return [Motion.disc(slip)]
    low, high = min(one.angle - one.off for one in driven), max(one.angle + one.off for one in driven)
    width = (high - low) / 2
    if 2 * width >= PI - PI_ROUNDING:
        return []
    (cosine, _), (_, sine) = unit(width)
    chord = max(NOTHING, cosine) * min(one.piece.chord for one in driven)
    ends = [(one.piece.distance - one.piece.distance_bound, one.piece.distance + one.piece.distance_bound) for one in driven]
    forth, back = (sum((max(NOTHING, sign * end[k]) for end in ends), NOTHING) for sign, k in ((1, 1), (-1, 0)))
    more = min(forth, back) * (2 * sine + 1 - chord)
    least, greatest = (sum((end[k] for end in ends), NOTHING) for k in range(2))
    return [Motion(heading.widened((low + high) / 2, width), least, greatest, chord, slip + more)]
