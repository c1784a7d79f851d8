"""What a log holds, as dataclasses, and how that is written. See docs/log.md; files are in `experiments.logs.log`."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, TypeVar

import numpy as np

from filter import (
    AngularIntervals,
    AnyBelief,
    Array,
    Bearing,
    Compass,
    Filter,
    Frame,
    Measurement,
    Odometry,
    Polygon,
    Range,
    Team,
    Truth,
)
from filter.arrays import finite, read_only
from filter.records.record import field_names

FORMAT = "corral-log"
VERSION = 1
ASIDE = "aside"  # a column of odometry that older logs do not have, nor those of robots that drive straight ahead


@dataclass(frozen=True, eq=False)
class InitialSet:
    """What is known of one robot at the start.

    Attributes:
        vertices: (e, 2) points; their convex hull contains the robot [m]. None: it is anywhere in the arena.
        heading: (centre, bound) of the interval that contains its heading [rad], or None: nothing is known.

    Raises:
        InvalidInput: There is no vertex, or a value is not finite or out of its range.
    """

    vertices: Array | None = None
    heading: tuple[float, float] | None = None

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
    """

    team: Team
    start: float
    rate: float | None

    def record(self) -> dict[str, Any]:
        """Return the header's record."""
        arena = [[value if np.isfinite(value) else None for value in corner] for corner in self.team.arena.tolist()]
        return {
            "record": "header",
            "format": FORMAT,
            "version": VERSION,
            "robots": int(self.team.robots),
            "landmarks": self.team.landmarks.tolist(),
            "arena": arena,
            "speed_limit": _one_or_each(self.team.speed_limit),
            "turn_rate_limit": _one_or_each(self.team.turn_rate_limit),
            "start": float(self.start),
            "rate": None if self.rate is None else float(self.rate),
        }


def _one_or_each(limits: Array) -> float | list[float]:
    """Return the limit that all robots have, or else each one's."""
    return float(limits[0]) if (limits == limits[0]).all() else limits.tolist()


class TruthAt(NamedTuple):
    """Where the robots were.

    Attributes:
        time: When [s].
        truth: All of them.
    """

    time: float
    truth: Truth


class FrameEnd(NamedTuple):
    """The end of a frame.

    Attributes:
        time: When [s].
    """

    time: float


Settled = TypeVar("Settled", bound=Frame | Measurement | Odometry)
Record = Odometry | Compass | Bearing | Range | TruthAt | FrameEnd


def settled(kind: type[Settled], **fields: Any) -> Settled:
    """Return a record of all its fields, checked before and arrays read-only, without a second look."""
    record = object.__new__(kind)
    vars(record).update(fields)
    return record


def initial_record(robot: int, known: InitialSet) -> dict[str, Any]:
    """Return the record of one robot's initial set."""
    heading = None if known.heading is None else {"centre": float(known.heading[0]), "bound": float(known.heading[1])}
    vertices = None if known.vertices is None else known.vertices.tolist()
    return {"record": "initial", "robot": robot, "vertices": vertices, "heading": heading}


def frame_records(frame: Frame, robots: int) -> list[dict[str, Any]]:
    """Return a frame's records: odometry, measurements, truth, and the one that ends it."""
    records = []
    if frame.odometry is not None:
        times = {"start": frame.odometry.start, "time": frame.odometry.time}
        records.append({"record": "odometry", **times, **_columns(frame.odometry, robots)})
    for measurement in frame.measurements:
        kind = type(measurement).__name__.lower()
        records.append({"record": kind, "time": measurement.time, **_columns(measurement, robots)})
    if frame.truth is not None:
        positions, headings = frame.truth.positions.tolist(), frame.truth.headings.tolist()
        records.append({"record": "truth", "time": float(frame.time), "positions": positions, "headings": headings})
    return [*records, {"record": "frame", "time": float(frame.time)}]


def _columns(record: Measurement | Odometry, robots: int) -> dict[str, list[Any]]:
    columns: dict[str, list[Any]] = {}
    for name in field_names(record):
        column = getattr(record, name).tolist()
        if name == ASIDE and not any(column):
            continue
        columns |= _targets(column, robots) if name == "target" else {name: column}
    return columns


def _targets(targets: list[int], robots: int) -> dict[str, list[int | None]]:
    """Return the columns of robots and of landmarks, numbered from 0 each; a column of nothing is left out."""
    mates = [body if body < robots else None for body in targets]
    marks = [body - robots if body >= robots else None for body in targets]
    columns = {"target": mates, "landmark": marks}
    return {name: column for name, column in columns.items() if any(body is not None for body in column)} or {"target": []}


def first_belief(filter_: Filter[AnyBelief], header: Header, initial: Sequence[InitialSet]) -> AnyBelief:
    """Return what a filter knows before the first frame.

    Raises:
        CorralError: What the filter raises.
    """
    return filter_.start(header.start, [known.polygon() for known in initial], initial_headings(initial))


def initial_headings(initial: Sequence[InitialSet]) -> AngularIntervals:
    """Return (n) arcs: the known ones, and whole circles where nothing is known."""
    pairs = np.array([known.heading or (0.0, np.pi) for known in initial])
    return AngularIntervals(pairs[:, 0], pairs[:, 1])
