"""What a log holds. See docs/log.md; how it is written is in `experiments.logs.writing`, read in `experiments.logs.reading`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np

from experiments.logs.checks import finite, read_only
from filter import (
    AngularIntervals,
    AnyBelief,
    Array,
    Filter,
    Frame,
    Integers,
    InvalidInput,
    Left,
    Measurement,
    Odometry,
    Placed,
    Polygon,
    Team,
    Truth,
    Twist,
    changed,
)

FORMAT = "corral-log"
FIRST, SECOND = 1, 2  # versions of the format


@dataclass(frozen=True, eq=False)
class InitialSet:
    """What is known of one robot at the start.

    Attributes:
        vertices: (e, 2) points; their convex hull contains the robot [m]. None: it is anywhere in the arena.
        heading: (centre, bound) of the interval that contains its heading [rad], or None: nothing is known.
        there: Whether the robot is there at all; if not, nothing is said of it until it joins.

    Raises:
        InvalidInput: There is no vertex, or a value is not finite or out of its range.
    """

    vertices: Array | None = None
    heading: tuple[float, float] | None = None
    there: bool = True

    def __post_init__(self) -> None:
        if self.vertices is not None:
            object.__setattr__(self, "vertices", read_only(finite("vertices [m]", self.vertices)))
        if self.heading is not None:
            finite("heading [rad]", self.heading)
            finite("heading bound [rad]", self.heading[1], 0, np.pi)
        self.polygon()

    def polygon(self) -> Polygon | None:
        """Return the polygon, or None for the arena, as filters take it."""
        return None if self.vertices is None else Polygon.from_vertices(self.vertices)


@dataclass(frozen=True, eq=False)
class Header:
    """What holds for a whole log.

    Attributes:
        team: The robots, the landmarks and their limits.
        start: When the initial sets hold [s].
        rate: Frames a second [Hz], or None when they come irregularly.
        version: Of the format, 1 or 2. Names, limits of single robots, limits of acceleration and sensors make it 2.

    Raises:
        InvalidInput: There is no such version.
    """

    team: Team
    start: float
    rate: float | None = None
    version: int = FIRST

    def __post_init__(self) -> None:
        if self.version not in (FIRST, SECOND):
            raise InvalidInput(f"a log of version {FIRST} or {SECOND}", self.version)
        if self.team.is_named or self.team.sensors or not _alike(self.team):
            object.__setattr__(self, "version", SECOND)


def _alike(team: Team) -> bool:
    """Return whether all robots have the same limits of speed and turn rate, and none of acceleration."""
    same = all((limit == limit[0]).all() for limit in (team.speed_limit, team.turn_rate_limit))
    return same and bool(np.isinf([team.acceleration_limit, team.turn_acceleration_limit]).all())


class Joined(NamedTuple):
    """A robot is in a set from now on, whatever was known of it before.

    Attributes:
        time: When [s].
        robot: Its number.
        known: Where it is.
    """

    time: float
    robot: int
    known: InitialSet

    def placed(self) -> Placed:
        """Return it as filters take it."""
        heading = self.known.heading and AngularIntervals(*np.array(self.known.heading)[:, None])
        return Placed(self.time, self.robot, self.known.polygon(), heading)


class TruthAt(NamedTuple):
    """Where robots were.

    Attributes:
        time: When [s].
        robot: (k,) which robots.
        truth: Of those, in their order; NaN is what nobody knows.
    """

    time: float
    robot: Integers
    truth: Truth


class FrameEnd(NamedTuple):
    """The end of a frame, or a time for which regions are asked.

    Attributes:
        time: When [s].
    """

    time: float


Record = Odometry | Twist | Measurement | Joined | Left | TruthAt | FrameEnd
Settled = TypeVar("Settled", bound=Frame | Truth | Measurement | Odometry | Twist)


def settled(kind: type[Settled], **fields: Any) -> Settled:
    """Return a record of all its fields, checked before and arrays read-only, without a second look."""
    record = object.__new__(kind)
    vars(record).update(fields)
    return record


def first_belief(filter_: Filter[AnyBelief], header: Header, initial: Sequence[InitialSet]) -> AnyBelief:
    """Return what a filter knows before the first frame.

    Raises:
        CorralError: What the filter raises, or it is none that robots can join, and one is not there yet.
    """
    nowhere = np.clip(np.zeros(2), *header.team.arena)
    sets = [known.polygon() if known.there else Polygon.box(nowhere, nowhere) for known in initial]
    changes = [Left(header.start, robot) for robot, known in enumerate(initial) if not known.there]
    return changed(filter_, filter_.start(header.start, sets, initial_headings(initial)), changes)


def initial_headings(initial: Sequence[InitialSet]) -> AngularIntervals:
    """Return (n) arcs: the known ones, and whole circles where nothing is known."""
    pairs = np.array([known.heading or (0.0, np.pi) for known in initial])
    return AngularIntervals(pairs[:, 0], pairs[:, 1])
