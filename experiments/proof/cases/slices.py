"""Slices of a robot's poses, each an arc of headings and how far its places reach. Exact arithmetic, standard library only.

They are proved at the end of one step, each is moved by what its robot can have driven with a heading in its own arc, and the
cases of a later step begin from them.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import ceil, cos, floor, pi, sin
from sys import float_info

from experiments.proof.cases.polygon import Polygon
from experiments.proof.exact import PI, PI_ROUNDING, Arc, Vector, arc_around
from experiments.proof.motion import Displaced, Piece, turned
from experiments.proof.reading import Broken, Record, exact

COUNT = 24  # directions in which a slice says how far it reaches
MOST_SLICES = 1024


def _towards(k: int) -> Vector:
    x, y = (value if abs(value) >= float_info.epsilon else 0.0 for value in (cos(2 * pi * k / COUNT), sin(2 * pi * k / COUNT)))
    return Fraction(x), Fraction(y)


DIRECTIONS = tuple(map(_towards, range(COUNT)))


@dataclass(frozen=True)
class Slice:
    """Poses with a heading in an arc, at places that reach so far in each direction.

    Attributes:
        arc: Of headings.
        reach: How far, in each of `DIRECTIONS` [m].
    """

    arc: Arc
    reach: Sequence[Fraction]

    def moved(self, pieces: Sequence[Piece]) -> Slice:
        """Return it after pieces of motion."""
        driven = Displaced.of(pieces, self.arc)
        reach = [each + driven.support(normal) for each, normal in zip(self.reach, DIRECTIONS, strict=True)]
        return Slice(turned(pieces, self.arc), reach)

    def holds(self, other: Slice) -> bool:
        """Return whether another one is within it, for sure."""
        far = all(mine >= its for mine, its in zip(self.reach, other.reach, strict=True))
        return far and self.arc.covers(other.arc)

    def around(self, polygon: Polygon) -> bool:
        """Return whether places of a polygon are all within its reach."""
        return all(polygon.is_behind(normal, far) for normal, far in zip(DIRECTIONS, self.reach, strict=True))

    def cut(self, polygon: Polygon) -> Polygon | None:
        """Return what its reach leaves of a polygon."""
        left: Polygon | None = polygon
        for normal, far in zip(DIRECTIONS, self.reach, strict=True):
            left = left and left.cut(normal, far)
        return left


def slices_in(line: Record, name: str) -> list[Slice]:
    """Return the slices that a line names so; none if it has no such entry.

    Raises:
        Broken: One of them is misshapen.
    """
    told = line.get(name, [])
    if len(told) > MOST_SLICES:
        raise Broken(f"{len(told)} {name}, where {MOST_SLICES} are the most")
    found = [Slice(arc_around(*(float(exact(end)) for end in one["arc"])), [*map(exact, one["reach"])]) for one in told]
    if any(len(each.reach) != COUNT for each in found):
        raise Broken(f"{name} with another number of directions than {COUNT}")
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
    arcs = [turn for each in slices if each.around(polygon) for turn in _turns(each.arc, arc)]
    at = arc.low
    while at < arc.high:
        farther = max((each.high for each in arcs if each.low <= at), default=at)
        if farther <= at:
            return False
        at = farther
    return bool(arcs)


def _turns(arc: Arc, where: Arc) -> list[Arc]:
    """Return an arc some whole turns on, as often as it may meet another; errs inward."""
    first, last = floor((where.low - arc.high) / (2 * PI)), ceil((where.high - arc.low) / (2 * PI))
    found = []
    for turns in range(first, last + 1):
        by, rounding = 2 * turns * PI, 2 * abs(turns) * PI_ROUNDING
        found.append(Arc(arc.low + by + rounding, arc.high + by - rounding))
    return found
