"""The single records of a log, between JSON objects and dataclasses. See docs/log.md; files are in `experiments.logs.log`."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np

from experiments.logs.fields import Fields
from filter import (
    AngularIntervals,
    AnyBelief,
    Array,
    Bearing,
    Compass,
    Filter,
    Frame,
    Integers,
    InvalidInput,
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
_MEASUREMENTS: dict[str, type[Compass | Bearing | Range]] = {"compass": Compass, "bearing": Bearing, "range": Range}


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


def read_header(record: Fields) -> Header:
    """Return the header of a log.

    Raises:
        InvalidInput: It is another format or version, or a field is not as it should be.
    """
    form, version = record.text("format"), record.whole("version")
    if (form, version) != (FORMAT, VERSION):
        raise InvalidInput(f'format "{FORMAT}", version {VERSION}', f'"{form}", version {version}')
    arena = record.points("arena", unknown=np.inf)
    arena[:1] = np.where(np.isinf(arena[:1]), -np.inf, arena[:1])
    team = Team(
        robots=record.whole("robots"),
        landmarks=record.points("landmarks"),
        speed_limit=record.number("speed_limit"),
        turn_rate_limit=record.number("turn_rate_limit"),
        arena=arena,
    )
    start, rate = record.number("start"), record.number_or_none("rate")
    record.end()
    if rate is not None and rate <= 0:
        raise InvalidInput("rate: a number above 0 [Hz], or null", repr(rate))
    return Header(team, start, rate)


def read_initial(record: Fields, team: Team, known: Collection[int]) -> tuple[int, InitialSet]:
    """Return a robot of the team and its initial set.

    Raises:
        InvalidInput: The robot's set is known already, or a field is not as it should be.
    """
    robot = record.whole("robot")
    if not 0 <= robot < team.robots:
        raise InvalidInput(f"robot: whole numbers from 0 to {team.robots - 1}", repr(robot))
    if robot in known:
        raise InvalidInput("one initial set a robot", f"robot {robot} again")
    vertices, interval = record.points_or_none("vertices"), record.object("heading")
    record.end()
    if interval is None:
        return robot, InitialSet(vertices)
    heading = interval.number("centre"), interval.number("bound")
    interval.end()
    return robot, InitialSet(vertices, heading)


def read_odometry(record: Fields, team: Team) -> Odometry:
    """Return odometry.

    Raises:
        InvalidInput: A field is not as it should be.
    """
    start, time, robots = record.number("start"), record.number("time"), record.robots(team.robots)
    names = [field.name for field in fields(Odometry)[3:] if field.name != ASIDE or record.has(ASIDE)]
    others = {name: record.numbers(name) for name in names}
    record.end()
    return Odometry(start, time, robots, **others)


def joined(parts: Sequence[Odometry]) -> Odometry | None:
    """Return the odometry of one instant's several records as one, or None for none."""
    if len(parts) < 2:
        return parts[0] if parts else None
    columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in field_names(parts[0])}
    return Odometry(parts[0].start, parts[0].time, **columns)


def read_measurement(record: Fields, team: Team) -> Measurement:
    """Return a measurement.

    Raises:
        InvalidInput: Such a record is unknown, or a field is not as it should be.
    """
    if record.kind not in _MEASUREMENTS:
        known = ", ".join(["odometry", *_MEASUREMENTS, "truth", "frame"])
        raise InvalidInput(f"a record among {known}", f'"{record.kind}"')
    kind = _MEASUREMENTS[record.kind]
    time = record.number("time")
    columns: dict[str, Any] = {"robot": record.robots(team.robots)}
    if kind is not Compass:
        columns["target"] = _read_targets(record, team)
    columns |= {field.name: record.numbers(field.name) for field in fields(kind) if field.name not in ("time", *columns)}
    record.end()
    return kind(time, **columns)


def _read_targets(record: Fields, team: Team) -> Integers:
    """Return the targets, numbered as in `Team`, of the columns `target` (robots) and `landmark`."""
    counts = {"target": team.robots, "landmark": len(team.landmarks)}
    found = {name: record.bodies(name, count) for name, count in counts.items() if record.has(name)}
    if not found:
        raise InvalidInput('a field "target" or "landmark"', "neither")
    mates = found.get("target", [None] * len(found.get("landmark", [])))
    marks = found.get("landmark", [None] * len(mates))
    if len(mates) != len(marks) or any((mate is None) == (mark is None) for mate, mark in zip(mates, marks, strict=False)):
        raise InvalidInput("either a target or a landmark in every place", f"target {mates}, landmark {marks}")
    targets = [mate if mark is None else mark + team.robots for mate, mark in zip(mates, marks, strict=True)]
    return np.array(targets, dtype=np.int64)


def read_truth(record: Fields, team: Team) -> tuple[float, Truth]:
    """Return the time and the truth.

    Raises:
        InvalidInput: It is not the truth of the whole team, or a field is not as it should be.
    """
    time, positions, headings = record.number("time"), record.points("positions"), record.numbers("headings")
    record.end()
    if positions.shape != (team.robots, 2) or headings.shape != (team.robots,):
        raise InvalidInput(f"truth of {team.robots} robots", f"{len(positions)} positions, {headings.size} headings")
    return time, Truth(read_only(positions), read_only(headings))
