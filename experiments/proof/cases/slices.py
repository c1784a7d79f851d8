"""Slices of a robot's poses, each an arc of headings and how far its places reach. Exact arithmetic, standard library only.

They are proved at the end of one step, each is moved by what its robot can have driven with a heading in its own arc, and the
cases of a later step begin from them.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property
from math import cos, pi, sin
from sys import float_info

from experiments.proof.cases.polygon import Polygon, Three
from experiments.proof.exact import HALF, KEPT, Arc, Vector, below, claimed, whole
from experiments.proof.motion import Displaced, Piece, turned
from experiments.proof.reading import Broken, Record, exact

COUNT = 24  # directions in which a slice says how far it reaches
MOST_SLICES = 1024
FRAMES_KEPT = 8  # of slices that are moved
STEPS = 1 << KEPT  # of a metre


def _towards(k: int) -> Vector:
    x, y = (value if abs(value) >= float_info.epsilon else 0.0 for value in (cos(2 * pi * k / COUNT), sin(2 * pi * k / COUNT)))
    return Fraction(x), Fraction(y)


DIRECTIONS = tuple(map(_towards, range(COUNT)))
*_PARTS, UNIT = whole(*(part for normal in DIRECTIONS for part in normal))
IN_UNITS = tuple(zip(_PARTS[::2], _PARTS[1::2], strict=True))  # the same in whole numbers


@dataclass(frozen=True)
class Slice:
    """Poses with a heading in an arc, at places that reach so far in each direction.

    Attributes:
        arc: Of headings.
        reach: How far, in each of `DIRECTIONS`, in steps of 2^-110 m.
    """

    arc: Arc
    reach: Sequence[int]

    @cached_property
    def _lines(self) -> list[Three]:
        return [(x << KEPT, y << KEPT, far * UNIT) for (x, y), far in zip(IN_UNITS, self.reach, strict=True)]

    def moved(self, pieces: Sequence[Piece]) -> Slice:
        """Return it after pieces of motion."""
        sets = Displaced.of(pieces, self.arc).sets
        driven = (min([motion.reach(normal) for motion in sets]) for normal in IN_UNITS)
        reach = [each - -more // (UNIT << KEPT) for each, more in zip(self.reach, driven, strict=True)]
        return Slice(turned(pieces, self.arc), reach)

    def holds(self, other: Slice) -> bool:
        """Return whether another one is within it, for sure."""
        return self.reaches(other) and self.arc.covers(other.arc)

    def reaches(self, other: Slice) -> bool:
        """Return whether its places reach as far as those of another one."""
        return all(mine >= its for mine, its in zip(self.reach, other.reach, strict=True))

    def around(self, polygon: Polygon) -> bool:
        """Return whether places of a polygon are all within its reach."""
        return all(map(polygon.is_behind, self._lines))

    def cut(self, polygon: Polygon) -> Polygon | None:
        """Return what its reach leaves of a polygon."""
        left: Polygon | None = polygon
        for line in self._lines:
            left = left and left.cut(line)
        return left


def slices_in(line: Record, name: str) -> list[Slice]:
    """Return the slices that a line names so, if any; how far they reach is rounded down, which claims more.

    Raises:
        Broken: One of them is misshapen.
    """
    told = line.get(name, [])
    if len(told) > MOST_SLICES:
        raise Broken(f"{len(told)} {name}, where {MOST_SLICES} are the most")
    found = [Slice(claimed(*one["arc"]), [below(exact(far), KEPT) for far in one["reach"]]) for one in told]
    if any(len(each.reach) != COUNT for each in found):
        raise Broken(f"{name} with another number of directions than {COUNT}")
    return found


class TakenAlong:
    """The slices of a line, which are moved when they are asked for; as they were at the last frames asked for is kept."""

    def __init__(self, line: Record, frame: int, name: str = "slices") -> None:
        """Take a line with slices by a name, and the number of its frame."""
        self._first, self._told, self._found = frame, {name: line.get(name, [])}, dict[int, list[Slice]]()

    @property
    def is_empty(self) -> bool:
        """Whether there are none."""
        return not any(self._told.values())

    def at(self, now: int, pieces: Callable[[int], Sequence[Piece]]) -> list[Slice]:
        """Return them at a frame, given the pieces of motion before each frame since they were told."""
        if self.is_empty:
            return []
        begin = max([frame for frame in self._found if frame <= now], default=self._first)
        found = self._found.get(begin) or slices_in(self._told, *self._told)
        for frame in range(begin + 1, now + 1):
            found = self._found[frame] = [each.moved(pieces(frame)) for each in found]
        self._found = dict(sorted(self._found.items())[-FRAMES_KEPT:])
        return found


def check_roots(roots: Sequence[Slice], proved: Sequence[Slice]) -> None:
    """Check that cases begin from all slices that were proved of a robot, as they are now, in the same order.

    Raises:
        Broken: One is missing, or is more than was proved.
    """
    if len(roots) != len(proved):
        raise Broken(f"cases that begin from {len(roots)} slices, where {len(proved)} were proved")
    if not all(root.holds(each) for root, each in zip(roots, proved, strict=True)):
        raise Broken("cases that begin from less than the slices that were proved before, moved")


def are_around(slices: Sequence[Slice], polygon: Polygon, arc: Arc) -> bool:
    """Return whether poses, all in a polygon and with a heading in an arc, are within slices, for sure."""
    return _is_covered(arc, [each.arc for each in slices if _turns(each.arc, arc) and each.around(polygon)])


def are_within(some: Sequence[Slice], slices: Sequence[Slice]) -> bool:
    """Return whether all poses in some slices are within others, for sure."""
    return all(_is_covered(one.arc, [each.arc for each in slices if each.reaches(one)]) for one in some)


def _is_covered(arc: Arc, arcs: Sequence[Arc]) -> bool:
    """Return whether every angle of an arc is in one of some others, for sure."""
    parts = [turn for each in arcs for turn in _turns(each, arc)]
    at = arc.first
    while at < arc.last:
        farther = max((each.last for each in parts if each.first <= at), default=at)
        if farther <= at:
            return False
        at = farther
    return bool(parts)


def _turns(arc: Arc, where: Arc) -> list[Arc]:
    """Return an arc some whole turns on, as often as it meets another; errs inward."""
    first, last = (where.first - arc.last) // (2 * HALF), -((arc.first - where.last) // (2 * HALF))
    turned = ((2 * turns * HALF, 2 * turns) for turns in range(first, last + 1))
    found = [Arc(arc.first + by + max(0, more), arc.last + by + min(0, more)) for by, more in turned]
    return [each for each in found if each.first <= where.last and where.first <= each.last]
