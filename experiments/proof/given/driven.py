"""What odometry and twists tell of a robot from any time to any other: cut, ended, filled up. Standard library only."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass, replace
from fractions import Fraction
from itertools import zip_longest
from math import inf

from experiments.proof.motion import NOTHING, Piece
from experiments.proof.reading import Broken


@dataclass(frozen=True)
class Limits:
    """What a robot can do.

    Attributes:
        speed: Where nothing is known of its motion [m/s].
        turn_rate: Likewise [rad/s].
        acceleration: How fast its speed can change, None where nobody knows [m/s2].
        turn_acceleration: Likewise [rad/s2].
    """

    speed: Fraction
    turn_rate: Fraction
    acceleration: Fraction | None = None
    turn_acceleration: Fraction | None = None

    def unknown(self, duration: Fraction) -> Piece:
        """Return what a robot can have done of which nothing else is known."""
        no = NOTHING
        return Piece(no, no, no, self.turn_rate * duration, no, self.speed * duration, no)


@dataclass(frozen=True)
class Part:
    """What one record tells of one robot.

    Attributes:
        start: From when on [s].
        end: Until when [s].
        piece: How the robot moved in all that time.
        steady: Whether it did so evenly within the bounds, as by a twist.
    """

    start: float
    end: float
    piece: Piece
    steady: bool

    def cut(self, limits: Limits, begin: float, end: float) -> Piece:
        """Return how the robot moved in a part of the time [s].

        In a share f of the time, with a time r left over, an even motion does f of the whole. With an acceleration of a at most
        it does a (time) r / 2 more or less than that; with a speed of v at most no more than v (time), and v r in what is left
        over. The bounds of direction and slip hold for any part.
        """
        if (begin, end) == (self.start, self.end):
            return self.piece
        piece, share = self.piece, self._share(begin, end)
        ends = (piece.distance - piece.distance_bound, piece.distance + piece.distance_bound)
        turns = (piece.turn - piece.turn_bound, piece.turn + piece.turn_bound)
        if self.steady:
            distances, turned = ((low * share, high * share) for low, high in (ends, turns))
            piece = replace(piece, slip_bound=piece.slip_bound * share)
        else:
            whole = Fraction(self.end) - Fraction(self.start)
            distances = _uneven(ends, share, whole, limits.speed, limits.acceleration)
            turned = _uneven(turns, share, whole, limits.turn_rate, limits.turn_acceleration)
        (distance, distance_bound), (turn, turn_bound) = _middle(*distances), _middle(*turned)
        return replace(piece, distance=distance, distance_bound=distance_bound, turn=turn, turn_bound=turn_bound)

    def until(self, limits: Limits, end: float) -> Part:
        """Return what is told of the time up to an earlier end [s]."""
        return replace(self, end=end, piece=self.cut(limits, self.start, end))

    def _share(self, begin: float, end: float) -> Fraction:
        return (Fraction(end) - Fraction(begin)) / (Fraction(self.end) - Fraction(self.start))


def _uneven(
    ends: tuple[Fraction, Fraction], share: Fraction, whole: Fraction, limit: Fraction, change: Fraction | None
) -> tuple[Fraction, Fraction]:
    """Return the least and the greatest that was done in a share of a time [s], of a whole between two ends."""
    some, rest = share * whole, (1 - share) * whole
    most = max(limit, max(map(abs, ends)) / whole)
    low, high = max(-most * some, ends[0] - most * rest), min(most * some, ends[1] + most * rest)
    if change is not None:
        off = change * some * rest / 2
        low, high = max(low, share * ends[0] - off), min(high, share * ends[1] + off)
    return low, high


def _middle(low: Fraction, high: Fraction) -> tuple[Fraction, Fraction]:
    return (low + high) / 2, (high - low) / 2


class Driven:
    """What has been told so far of one robot."""

    def __init__(self, limits: Limits) -> None:
        self._limits, self._parts, self._done = limits, list[Part](), -inf

    def add(self, part: Part) -> None:
        """Take in what one more record tells; a robot's next record ends its twists before.

        Raises:
            Broken: It takes no time, overlaps with other odometry, or ends a twist that was taken to hold for longer.
        """
        if not part.start < part.end:
            raise Broken(f"odometry from {part.start} s to {part.end} s, which takes no time")
        at = bisect_right(self._parts, part.start, key=lambda one: one.start)
        first = max(0, at - 1)
        self._parts[first : at + 1] = self._ended([*self._parts[first:at], part, *self._parts[at : at + 1]])

    def _ended(self, parts: list[Part]) -> Iterator[Part]:
        for one, following in zip_longest(parts, parts[1:]):
            if following is None or one.end <= following.start:
                yield one
            elif one.steady and following.start < self._done:
                raise Broken(f"odometry from {following.start} s on, where a twist was taken to hold until {self._done} s")
            elif one.steady:
                if following.start > one.start:
                    yield one.until(self._limits, following.start)
            else:
                raise Broken(f"odometry from {following.start} s on, where other odometry ends at {one.end} s")

    def pieces(self, begin: float, end: float) -> list[Piece]:
        """Return how the robot moved from one time to another [s], one after the other; nothing if no time passes."""
        found, now = list[Piece](), begin
        for part in (one for one in self._parts if one.start < end and one.end > begin):
            found += self._unknown(now, part.start)
            now = min(end, part.end)
            found.append(part.cut(self._limits, max(begin, part.start), now))
        return found + self._unknown(now, end)

    def _unknown(self, begin: float, end: float) -> list[Piece]:
        return [self._limits.unknown(Fraction(end) - Fraction(begin))] if begin < end else []

    def forget(self, time: float) -> None:
        """Forget what ended by a time [s], up to which the rest was relied on."""
        self._parts, self._done = [one for one in self._parts if one.end > time], time
