"""The usual lines of a log, read fast: typed decoding, then columns without a second look.

A line that is refused here is read again, strictly, by `experiments.logs.records`, which says what is wrong with it. What is
accepted here is accepted there, and gives the same record to the last bit.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial
from operator import eq
from typing import Annotated, Any

import numpy as np
from msgspec import UNSET, DecodeError, Meta, Struct, UnsetType
from msgspec.json import Decoder
from msgspec.structs import astuple
from numpy.typing import NDArray

from experiments.logs.records import FrameEnd, Record, TruthAt, settled
from filter import Bearing, Compass, Odometry, Range, Team, Truth
from filter.arrays import LARGEST
from filter.records.record import field_names

Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Meta(ge=0, le=LARGEST)]
HalfTurn = Annotated[float, Meta(ge=0, le=np.pi)]
RightAngle = Annotated[float, Meta(ge=0, lt=np.pi / 2)]
Turned = Annotated[float, Meta(ge=-2 * np.pi, le=2 * np.pi)]
Share = Annotated[float, Meta(ge=0, lt=1)]
Whole = Annotated[int, Meta(ge=0)]
Robots = Whole | list[Whole]
Seen = Whole | list[Whole | None] | UnsetType | None


class _Unusual(Exception):
    """A line is wrong, or written as few are; the strict reader decides."""


class _Line(Struct, tag_field="record", forbid_unknown_fields=True, gc=False):
    """Base of lines."""


class _OdometryLine(_Line, tag="odometry"):
    start: Number
    time: Number
    robot: Robots
    distance: Number | list[Number]
    distance_bound: Positive | list[Positive]
    turn: Number | list[Number]
    turn_bound: Positive | list[Positive]
    direction_bound: RightAngle | list[RightAngle]
    slip_bound: Positive | list[Positive]
    aside: Turned | list[Turned] | UnsetType = UNSET


class _CompassLine(_Line, tag="compass"):
    time: Number
    robot: Robots
    heading: Number | list[Number]
    bound: HalfTurn | list[HalfTurn]


class _BearingLine(_Line, tag="bearing"):
    time: Number
    robot: Robots
    bearing: Number | list[Number]
    bound: RightAngle | list[RightAngle]
    target: Seen = UNSET
    landmark: Seen = UNSET


class _RangeLine(_Line, tag="range"):
    time: Number
    robot: Robots
    range: Positive | list[Positive]
    bound: Positive | list[Positive]
    relative_bound: Share | list[Share]
    target: Seen = UNSET
    landmark: Seen = UNSET


class _TruthLine(_Line, tag="truth"):
    time: Number
    positions: list[tuple[Number, Number]]
    headings: list[Number]


class _FrameLine(_Line, tag="frame"):
    time: Number


_decode = Decoder(_OdometryLine | _CompassLine | _BearingLine | _RangeLine | _TruthLine | _FrameLine).decode
_NAMES: dict[type, list[str]] = {kind: field_names(kind) for kind in (Odometry, Compass, Bearing, Range)}


class Lines:
    """Reads the usual lines of a log about one team."""

    def __init__(self, team: Team) -> None:
        self._robots, self._marks = team.robots, len(team.landmarks)
        self._make: dict[type[_Line], Any] = {
            _OdometryLine: self._odometry,
            _CompassLine: self._compass,
            _BearingLine: partial(self._sighting, Bearing),
            _RangeLine: partial(self._sighting, Range),
            _TruthLine: self._truth,
            _FrameLine: FrameEnd,
        }

    def read(self, text: bytes) -> Record | None:
        """Return a line's record, or None when the strict reader has to decide."""
        try:
            line = _decode(text)
            values = astuple(line)
            if text.count(b":") != len(values) + 1 - values.count(UNSET):  # what comes twice is decoded once
                return None
            return self._make[type(line)](*values)
        except (DecodeError, RecursionError, _Unusual):
            return None

    def _odometry(self, start: float, time: float, robot: Any, *values: Any) -> Odometry:
        columns = _columns([self._known(robot)], [0.0 if value is UNSET else value for value in values])
        if time < start or len(set(columns[0].tolist())) < columns[0].size:
            raise _Unusual
        return settled(Odometry, start=start, time=time, **dict(zip(_NAMES[Odometry], columns, strict=True)))

    def _compass(self, time: float, robot: Any, *values: Any) -> Compass:
        columns = _columns([self._known(robot)], values)
        return settled(Compass, time=time, **dict(zip(_NAMES[Compass], columns, strict=True)))

    def _sighting(self, kind: type[Bearing | Range], time: float, robot: Any, *others: Any) -> Bearing | Range:
        *values, mate, mark = others
        columns = _columns([self._known(robot), self._target(mate, mark)], values)
        if any(map(eq, columns[0].tolist(), columns[1].tolist())):
            raise _Unusual
        return settled(kind, time=time, **dict(zip(_NAMES[kind], columns, strict=True)))

    def _truth(self, time: float, positions: list[tuple[float, float]], headings: list[float]) -> TruthAt:
        if not len(positions) == len(headings) == self._robots:
            raise _Unusual
        return TruthAt(time, Truth(positions, headings))

    def _known(self, robot: Any) -> Any:
        """Return a robot or several, all of the team."""
        if (max(robot, default=0) if isinstance(robot, list) else robot) >= self._robots:
            raise _Unusual
        return robot

    def _target(self, mate: Any, mark: Any) -> int | list[int]:
        """Return the target, or a list of them, numbered as in `Team`."""
        if not isinstance(mate, list) and not isinstance(mark, list):
            return self._body(mate, mark)
        mates, marks = mate, mark
        if mate is UNSET:
            mates = [None] * len(mark)
        if mark is UNSET:
            marks = [None] * len(mate)
        if not (isinstance(mates, list) and isinstance(marks, list) and len(mates) == len(marks)):
            raise _Unusual
        return list(map(self._body, mates, marks))

    def _body(self, mate: Any, mark: Any) -> int:
        is_mate = isinstance(mate, int)
        number, count, first = (mate, self._robots, 0) if is_mate else (mark, self._marks, self._robots)
        if is_mate == isinstance(mark, int) or number >= count:
            raise _Unusual
        return int(first + number)


def _columns(bodies: Sequence[Any], values: Sequence[Any]) -> list[NDArray[Any]]:
    """Return read-only columns of one length, of whole numbers and of floats; a number stands for a column of it."""
    together = [*bodies, *values]
    if list in map(type, together):
        lengths = {len(each) for each in together if isinstance(each, list)}
        if len(lengths) > 1:
            raise _Unusual
        (count,) = lengths
        columns = [_column(each, count, np.int64) for each in bodies] + [_column(each, count, np.float64) for each in values]
    else:
        columns = [np.array((each,)) for each in together]
    for column in columns:
        column.setflags(write=False)
    return columns


def _column(value: Any, count: int, kind: type) -> NDArray[Any]:
    return np.array(value, dtype=kind) if isinstance(value, list) else np.full(count, value, dtype=kind)
