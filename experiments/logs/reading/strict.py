"""The lines of a log after its initial sets, read strictly, a field at a time: what is wrong with a line is said here.

See docs/log.md. The first version has fewer kinds of records and fewer forms of them.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from experiments.logs.checks import AT_THE_CENTRE, field_names, read_only
from experiments.logs.reading.bodies import bodies_of, sensors_of
from experiments.logs.reading.fields import Fields
from experiments.logs.reading.heads import read_set
from experiments.logs.reading.pairs import VALUES, Bounded, without_pairs
from experiments.logs.records import FIRST, FrameEnd, Header, Joined, Record, TruthAt
from filter import (
    Bearing,
    Compass,
    Integers,
    InvalidInput,
    Left,
    Measurement,
    Odometry,
    Polygon,
    Position,
    Range,
    RelativeHeading,
    Truth,
    Twist,
)

ASIDE = "aside"  # a column that need not be there
SENSORS = ("sensor", "target_sensor")  # neither need these


class Strict:
    """Reads any line of one log after its initial sets."""

    def __init__(self, header: Header) -> None:
        (self._robots, self._marks), self._sensors = bodies_of(header), sensors_of(header)
        self._first, self._team = header.version == FIRST, header.team
        self._readers: dict[str, Callable[[Fields], Record]] = {
            "odometry": self._odometry,
            "compass": partial(self._measured, Compass),
            "bearing": partial(self._measured, Bearing),
            "range": partial(self._measured, Range),
            "truth": self._truth,
            "frame": self._frame,
        }
        if not self._first:
            self._readers |= {"twist": self._twist, "position": self._position}
            self._readers |= {"relative_heading": partial(self._measured, RelativeHeading)}
            self._readers |= {"initial": self._joined, "leave": self._left}

    def read(self, record: Fields) -> Record:
        """Return what a line says.

        Raises:
            InvalidInput: Such a record is unknown, or a field is not as it should be.
        """
        reader = self._readers.get(record.kind)
        if reader is None:
            raise InvalidInput(f"a record among {', '.join(self._readers)}", f'"{record.kind}"')
        found = reader(record)
        record.end()
        return found

    def _odometry(self, record: Fields) -> Odometry:
        self._even(record)
        start, time, robots = record.number("start"), record.number("time"), record.robots(self._robots)
        return Odometry(start, time, robots, **self._moved(Odometry, record))

    def _twist(self, record: Fields) -> Twist:
        self._even(record)
        return Twist(record.number("time"), record.robots(self._robots), **self._moved(Twist, record))

    def _moved(self, kind: type[Odometry | Twist], record: Fields) -> dict[str, Any]:
        names = [name for name in field_names(kind) if name not in ("robot", ASIDE)]
        if record.has(ASIDE) and not self._first:
            names.append(ASIDE)
        return {name: record.numbers(name) for name in names}

    def _measured(self, kind: type[Bounded], record: Fields) -> Bounded:
        single = not self._first and not record.lengths(besides="bound")
        self._even(record, "bound" if single else "")
        time = record.number("time")
        columns: dict[str, Any] = {"robot": record.robots(self._robots)}
        if kind is not Compass:
            columns["target"] = record.robots(self._robots, "target") if kind is RelativeHeading else self._targets(record)
        columns |= {name: record.numbers(name) for name in field_names(kind) if name not in (*columns, "bound", *SENSORS)}
        columns |= self._sensors_in(kind, record)
        if self._first or not record.is_a(list, "bound"):
            columns["bound"] = record.numbers("bound")
        else:
            bounds = [record.pair("bound", "a number or a pair [low, high]")] if single else record.bounds("bound")
            values = np.atleast_1d(columns[VALUES[kind]]).tolist()
            columns[VALUES[kind]], columns["bound"] = without_pairs(kind, values, bounds)
        found = kind(time, **columns)
        self._team.check(found)
        return found

    def _sensors_in(self, kind: type[Measurement], record: Fields) -> dict[str, Integers]:
        """Return the columns of sensors that are there; null is at the centre."""
        there = [name for name in SENSORS if name in field_names(kind) and record.has(name) and not self._first]
        found = {name: record.bodies(name, self._sensors) for name in there}
        return {
            name: np.array([AT_THE_CENTRE if each is None else each for each in found[name]], dtype=np.int64) for name in there
        }

    def _even(self, record: Fields, besides: str = "") -> None:
        """Refuse lists of several lengths: from version 2 on one entry is no column of any length."""
        lengths = record.lengths(besides)
        if not self._first and len(set(lengths.values())) > 1:
            raise InvalidInput(f"{record.kind}: lists of one length", lengths)

    def _targets(self, record: Fields) -> Integers:
        """Return the targets, numbered as in `Team`, of the columns `target` (robots) and `landmark`."""
        kinds = {"target": self._robots, "landmark": self._marks}
        found = {name: record.bodies(name, known) for name, known in kinds.items() if record.has(name)}
        if not found:
            raise InvalidInput('a field "target" or "landmark"', "neither")
        mates = found.get("target", [None] * len(found.get("landmark", [])))
        marks = found.get("landmark", [None] * len(mates))
        if len(mates) != len(marks) or any((mate is None) == (mark is None) for mate, mark in zip(mates, marks, strict=False)):
            raise InvalidInput("either a target or a landmark in every place", f"target {mates}, landmark {marks}")
        count = self._robots.count
        targets = [mate if mark is None else mark + count for mate, mark in zip(mates, marks, strict=True)]
        return np.array(targets, dtype=np.int64)

    def _position(self, record: Fields) -> Position:
        time = record.number("time")
        if record.has("normal_x"):
            self._even(record)
            robots, columns = record.robots(self._robots), ("normal_x", "normal_y", "offset")
            numbers = {name: record.numbers(name) for name in columns}
            return Position(time, robots, **numbers, **self._sensors_in(Position, record))
        robot, sensor = record.robot(self._robots), AT_THE_CENTRE
        if record.has("sensor"):
            sensor = record.body_or("sensor", self._sensors, AT_THE_CENTRE)
        if record.has("vertices"):
            return Position.within(time, robot, Polygon.from_vertices(record.points("vertices")), sensor)
        if record.has("normal"):
            return Position.half_plane(time, robot, record.pair("normal"), record.number("offset"), sensor)
        place = record.pair("position")
        if record.has("radius"):
            return Position.disc(time, robot, place, record.number("radius"), sensor=sensor)
        return Position.fix(time, robot, place, record.numbers("bound"), sensor)

    def _joined(self, record: Fields) -> Joined:
        return Joined(record.number("time"), record.robot(self._robots), read_set(record))

    def _left(self, record: Fields) -> Left:
        return Left(record.number("time"), record.robot(self._robots))

    def _truth(self, record: Fields) -> TruthAt:
        time, robots = record.number("time"), self._robots.count
        if not self._first and not record.has("positions"):
            robot, place, heading = record.robot(self._robots), record.place("position"), record.number_or("heading", np.nan)
            return TruthAt(time, _those([robot]), Truth(place, [heading]))
        points = record.points if self._first else record.places
        positions = points("positions")
        headings = record.numbers("headings") if self._first else record.numbers_or("headings", np.nan)
        if positions.shape != (robots, 2) or headings.shape != (robots,):
            raise InvalidInput(f"truth of {robots} robots", f"{len(positions)} positions, {headings.size} headings")
        return TruthAt(time, _those(range(robots)), Truth(read_only(positions), read_only(headings)))

    def _frame(self, record: Fields) -> FrameEnd:
        return FrameEnd(record.number("time"))


def _those(robots: Any) -> Integers:
    return read_only(np.array(robots, dtype=np.int64))
