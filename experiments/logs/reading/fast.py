"""The usual lines of a log, read fast: typed decoding, then columns without a second look.

A line that is refused here is read again, strictly, by `experiments.logs.reading.strict`, which says what is wrong with it.
What is accepted here is accepted there, and gives the same record to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import lru_cache, partial
from operator import eq
from typing import Any, TypeVar

import numpy as np
from msgspec import UNSET, DecodeError
from msgspec.structs import astuple
from numpy.typing import NDArray

from experiments.logs.checks import (
    AT_THE_CENTRE,
    LARGEST,
    TWO_TURNS,
    bearing_in_radians,
    field_names,
    heading_in_radians,
    read_only,
)
from experiments.logs.reading import typed
from experiments.logs.reading.bodies import Bodies, bodies_of, sensors_of
from experiments.logs.reading.pairs import VALUES, Bounded, without_pairs
from experiments.logs.records import FIRST, FrameEnd, Header, Record, TruthAt, settled
from filter import Array, Bearing, Compass, Integers, InvalidInput, Odometry, Position, Range, RelativeHeading, Truth, Twist

_NAMES: dict[type, list[str]] = {kind: field_names(kind) for kind in (Odometry, Twist, *VALUES)}
_MOST = {kind: LARGEST if kind is Range else np.pi for kind in VALUES}
_AXES = {name: read_only(np.array(column)) for name, column in (("normal_x", [1.0, 0, -1, 0]), ("normal_y", [0, 1.0, 0, -1]))}
Seen = TypeVar("Seen", Bearing, Range, RelativeHeading)


class _Unusual(Exception):
    """A line is wrong, or written as few are; the strict reader decides."""


class Fast:
    """Reads the usual lines of one log after its initial sets."""

    def __init__(self, header: Header) -> None:
        (self._robots, self._marks), self._sensors = bodies_of(header), sensors_of(header)
        self._everybody = read_only(np.arange(self._robots.count))
        self._make: dict[type[typed.Line], Any] = {
            typed.OdometryLine: self._odometry,
            typed.TwistLine: self._twist,
            typed.CompassLine: self._compass,
            typed.BearingLine: partial(self._sighted, Bearing),
            typed.RangeLine: partial(self._sighted, Range),
            typed.RelativeHeadingLine: self._related,
            typed.FixLine: self._fix,
            typed.TruthLine: self._truth,
            typed.SomeTruthLine: self._some_truth,
            typed.FrameLine: FrameEnd,
        }
        self._first = header.version == FIRST
        self._decode = (typed.first if self._first else typed.second).decode

    def read(self, text: bytes) -> Record | None:
        """Return a line's record, or None when the strict reader has to decide."""
        try:
            line = self._decode(text)
            values = astuple(line)
            if text.count(b":") != len(values) + 1 - values.count(UNSET):  # what comes twice is decoded once
                return None
            return self._make[type(line)](*values)
        except (DecodeError, RecursionError, InvalidInput, _Unusual):
            return None

    def _odometry(self, start: float, time: float, robot: Any, *values: Any) -> Odometry:
        if time < start or (self._first and values[-1] is not UNSET):
            raise _Unusual
        return settled(Odometry, start=start, time=time, **self._moved(Odometry, robot, values))

    def _twist(self, time: float, robot: Any, *values: Any) -> Twist:
        return settled(Twist, time=time, **self._moved(Twist, robot, values))

    def _moved(self, kind: type[Odometry | Twist], robot: Any, values: Sequence[Any]) -> dict[str, NDArray[Any]]:
        straight = values[-1] is UNSET
        columns = _columns([self._listed(robot)], values[:-1] if straight else values)
        if straight:
            columns.append(_zeros(columns[0].size))
        if len(set(columns[0].tolist())) < columns[0].size:
            raise _Unusual
        return dict(zip(_NAMES[kind], columns, strict=True))

    def _compass(self, time: float, robot: Any, value: Any, bound: Any, sensor: Any) -> Compass:
        columns = self._measured(Compass, [self._listed(robot)], [value, bound], [sensor])
        if not _is_small(columns["heading"]):
            heading_in_radians(columns["heading"], columns["bound"])
        return settled(Compass, time=time, **columns)

    def _related(self, time: float, robot: Any, mate: Any, value: Any, bound: Any, *sensors: Any) -> RelativeHeading:
        return self._sighted(RelativeHeading, time, robot, value, bound, mate, UNSET, *sensors)

    def _sighted(self, kind: type[Seen], time: float, robot: Any, value: Any, bound: Any, *rest: Any) -> Seen:
        *relative, mate, mark, sensor, tag = rest
        bodies = [self._listed(robot), self._target(mate, mark)]
        columns = self._measured(kind, bodies, [value, bound, *relative], [sensor, tag])
        if any(map(eq, columns["robot"].tolist(), columns["target"].tolist())):
            raise _Unusual
        if tag is not UNSET and (columns["target_sensor"][columns["target"] >= self._robots.count] != AT_THE_CENTRE).any():
            raise _Unusual
        if kind is not Range and not _is_small(columns[VALUES[kind]]):
            bearing_in_radians(columns[VALUES[kind]])
        return settled(kind, time=time, **columns)

    def _measured(
        self, kind: type[Bounded], bodies: list[Any], values: list[Any], sensors: list[Any]
    ) -> dict[str, NDArray[Any]]:
        """Return the columns of a measurement: bodies, values with their bounds, and what sensors are said."""
        said = [self._mounted(sensor) for sensor in sensors if sensor is not UNSET]
        if said and self._first:
            raise _Unusual
        value, bound, *relative = values
        if isinstance(bound, list) and not self._first:
            value, bound = _without_pairs(kind, value, bound, list not in map(type, (*bodies, *said, value, *relative)))
        columns = _columns([*bodies, *said], [value, bound, *relative])
        mounted, count = iter(columns[len(bodies) :]), len(columns[0])
        of_sensors = [_centres(count) if sensor is UNSET else next(mounted) for sensor in sensors]
        columns = [*columns[: len(bodies)], *columns[len(bodies) + len(said) :], *of_sensors]
        return dict(zip(_NAMES[kind], columns, strict=True))

    def _mounted(self, sensor: Any) -> Any:
        """Return a sensor's number, or a list of several ones'; null is at the centre."""
        if isinstance(sensor, list):
            return list(map(self._mounted, sensor))
        return AT_THE_CENTRE if sensor is None else self._body(sensor, self._sensors)

    def _fix(self, time: float, robot: Any, position: tuple[float, float], bound: Any, sensor: Any) -> Position:
        middle, half = np.array(position), np.array(bound)
        if half.shape not in ((), (2,)):
            raise _Unusual
        lower, upper = np.nextafter(middle - half, -np.inf), np.nextafter(middle + half, np.inf)
        if max(np.abs(lower).max(), np.abs(upper).max()) > LARGEST:
            raise _Unusual
        robots = read_only(np.full(4, self._body(robot, self._robots)))
        sensors = _centres(4) if sensor is UNSET else read_only(np.full(4, self._mounted(sensor)))
        offset = read_only(np.concatenate([upper, -lower]))
        return settled(Position, time=time, robot=robots, **_AXES, offset=offset, sensor=sensors)

    def _truth(self, time: float, positions: list[Any], headings: list[Any]) -> TruthAt:
        if not len(positions) == len(headings) == self._robots.count:
            raise _Unusual
        return TruthAt(time, self._everybody, Truth(positions, headings))

    def _some_truth(self, time: float, positions: Any, headings: Any, *one: Any) -> TruthAt:
        robot, position, heading = one
        if UNSET not in one and positions is headings is UNSET:
            who = read_only(np.array([self._body(robot, self._robots)]))
            places, headings = read_only(np.array([_place(position)])), read_only(np.array([_known(heading)]))
            return TruthAt(time, who, settled(Truth, positions=places, headings=headings))
        if one == (UNSET, UNSET, UNSET) and UNSET not in (positions, headings):
            return self._truth(time, [_place(place) for place in positions], [_known(each) for each in headings])
        raise _Unusual

    def _listed(self, robot: Any) -> Any:
        """Return a robot's number, or a list of several ones'."""
        if isinstance(robot, list):
            return [self._body(each, self._robots) for each in robot]
        return self._body(robot, self._robots)

    def _body(self, body: Any, known: Bodies) -> int:
        number = known.names.get(body, known.count) if isinstance(body, str) else body
        if number >= known.count:
            raise _Unusual
        return int(number)

    def _target(self, mate: Any, mark: Any) -> int | list[int]:
        """Return the target, or a list of them, numbered as in `Team`."""
        if not isinstance(mate, list) and not isinstance(mark, list):
            return self._seen(mate, mark)
        mates, marks = mate, mark
        if mate is UNSET:
            mates = [None] * len(mark)
        if mark is UNSET:
            marks = [None] * len(mate)
        if not (isinstance(mates, list) and isinstance(marks, list) and len(mates) == len(marks)):
            raise _Unusual
        return list(map(self._seen, mates, marks))

    def _seen(self, mate: Any, mark: Any) -> int:
        """Return which of the two is there, and the other one not."""
        mated = mate is not None and mate is not UNSET
        if mated != (mark is None or mark is UNSET):
            raise _Unusual
        return self._body(mate, self._robots) if mated else self._robots.count + self._body(mark, self._marks)


def _is_small(angles: Array) -> bool:
    """Return whether it is one angle that nobody takes for degrees [rad]."""
    return angles.size == 1 and abs(angles.item()) <= TWO_TURNS


def _place(position: Any) -> Any:
    return (np.nan, np.nan) if position is None else position


def _known(heading: float | None) -> float:
    return np.nan if heading is None else heading


def _without_pairs(kind: type[Bounded], value: Any, bound: list[Any], alone: bool) -> tuple[Any, Any]:
    """Return values and bounds without pairs, within their limits; a list alone among numbers is a pair itself."""
    given: list[Any] = [bound] if alone else bound
    if not all(isinstance(each, float) or len(each) == 2 for each in given) or (alone and list in map(type, bound)):
        raise _Unusual
    if isinstance(value, list) and len(value) != len(bound):
        raise _Unusual
    values, bounds = without_pairs(kind, value if isinstance(value, list) else [value], given)
    if not all(0 <= each <= _MOST[kind] for each in bounds) or not all(abs(each) <= LARGEST for each in values):
        raise _Unusual
    return (values[0], bounds[0]) if alone else (values, bounds)


def _columns(bodies: Sequence[Any], values: Sequence[Any]) -> list[NDArray[Any]]:
    """Return read-only columns of one length, of whole numbers and of floats; a number stands for a column of it."""
    if list not in map(type, (*bodies, *values)):
        columns = [np.array((each,)) for each in values]
        for column in columns:
            column.setflags(write=False)
        return [*map(_alone, bodies), *columns]
    lengths = {len(each) for each in (*bodies, *values) if isinstance(each, list)}
    if len(lengths) > 1:
        raise _Unusual
    (count,) = lengths
    columns = [_column(each, count, np.int64) for each in bodies] + [_column(each, count, np.float64) for each in values]
    return [read_only(column) for column in columns]


@lru_cache(1024)
def _alone(body: int) -> Integers:
    """Return a column of one body; records share it, as nobody can write to it."""
    return read_only(np.array([body]))


@lru_cache(1024)
def _centres(count: int) -> Integers:
    return read_only(np.full(count, AT_THE_CENTRE))


@lru_cache(1024)
def _zeros(count: int) -> Array:
    return read_only(np.zeros(count))


def _column(value: Any, count: int, kind: type) -> NDArray[Any]:
    return np.array(value, dtype=kind) if isinstance(value, list) else np.full(count, value, dtype=kind)
