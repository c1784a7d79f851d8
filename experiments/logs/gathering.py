"""From records to frames. See docs/log.md.

As long as records come in lock-step, everything since the previous frame is one instant. From the first record on that does
not, as its stamp is its own, `filter.frames_of` cuts and joins what comes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import cast

import numpy as np

from experiments.logs.checks import field_names, read_only
from experiments.logs.records import FIRST, FrameEnd, Header, Joined, Record, TruthAt, settled
from filter import Arrival, Frame, InvalidInput, Left, Measurement, Odometry, Placed, Truth, Twist


class OwnStamp(Exception):
    """A record does not belong to the frame that is being gathered, but has a stamp of its own."""


class Gathering:
    """The records since the last frame."""

    def __init__(self, header: Header) -> None:
        self._header = header
        self._previous: float | None = None
        self._clear()

    def _clear(self) -> None:
        self._time: float | None = None
        self._odometry: list[Odometry] = []
        self._moved: set[int] = set()
        self._measurements: list[Measurement] = []
        self._changes: list[Placed | Left] = []
        self._truths: list[TruthAt] = []
        self._shown: set[int] = set()

    def add(self, record: Record) -> Frame | None:
        """Take a record in; return the frame that it ends, or None.

        Raises:
            OwnStamp: It is not in lock-step with the frames; nothing has been taken in.
            InvalidInput: The record does not fit what came before.
        """
        if not self._is_in_step(record):
            raise OwnStamp
        if isinstance(record, Odometry):
            self._add_odometry(record)
            return None
        self._at(record.time)
        if isinstance(record, FrameEnd):
            return self._close(record.time)
        if isinstance(record, TruthAt):
            self._add_truth(record)
        elif isinstance(record, Joined | Left):
            self._changes.append(record.placed() if isinstance(record, Joined) else record)
        else:
            self._measurements.append(cast(Measurement, record))
        return None

    def _is_in_step(self, record: Record) -> bool:
        """Return whether a record can be of the frame that is being gathered; in version 1 only odometry may be of no frame."""
        if isinstance(record, Twist):
            return False
        same = self._time is None or record.time == self._time
        if isinstance(record, Odometry):
            return same and record.start == self.since
        return same or self._header.version == FIRST

    @property
    def since(self) -> float:
        """When the last frame was, or the initial sets [s]."""
        return self._header.start if self._previous is None else self._previous

    def waiting(self) -> list[Arrival]:
        """Return what has been taken in since the last frame."""
        robots = self._header.team.robots
        return [*self._odometry, *self._changes, *self._measurements, *(arrival_of(truth, robots) for truth in self._truths)]

    def end(self) -> Frame | None:
        """Return a frame of what waits for one, if the log's version does without.

        Raises:
            InvalidInput: Records wait for a frame in vain, or no frame came at all.
        """
        if self._time is not None:
            if self._header.version != FIRST and self._previous is None:
                return self._close(self._time)
            expected = f"a frame record for the records at {self._time!r} s"
            raise InvalidInput(expected, "the end of the file: the log is cut off")
        if self._previous is None:
            raise InvalidInput("at least one frame", "the end of the file")
        return None

    def _add_odometry(self, odometry: Odometry) -> None:
        self._at(odometry.time)
        if self._previous is None and odometry.time == self._header.start:
            raise InvalidInput(f"no odometry at the start, {self._header.start!r} s", "odometry")
        robots = set(odometry.robot.tolist())
        if twice := self._moved & robots:
            raise InvalidInput("odometry of each robot at most once a frame", f"{self._header.team.name(min(twice))} again")
        self._moved |= robots
        self._odometry.append(odometry)

    def _add_truth(self, record: TruthAt) -> None:
        robots = set(record.robot.tolist())
        if twice := robots & self._shown:
            raise InvalidInput("one truth of each robot a frame", f"another of {self._header.team.name(min(twice))}")
        self._shown |= robots
        self._truths.append(record)

    def _at(self, time: float) -> None:
        """Check that a record's time belongs to the frame that is being gathered."""
        if self._time is not None and time != self._time:
            raise InvalidInput(f"the frame's time, {self._time!r} s", f"{time!r} s")
        if self._previous is None and time < self._header.start:
            raise InvalidInput(f"a time from the start, {self._header.start!r} s, on", f"{time!r} s")
        if self._previous is not None and time <= self._previous:
            raise InvalidInput(f"a time after the last frame's, {self._previous!r} s", f"{time!r} s")
        self._time = time

    def _close(self, time: float) -> Frame:
        odometry, measurements = _joined(self._odometry), tuple(self._measurements)
        truth = _seen_together(self._truths, self._header.team.robots)
        changes = tuple(self._changes)
        frame = settled(Frame, time=time, odometry=odometry, measurements=measurements, truth=truth, changes=changes)
        self._clear()
        self._previous = time
        return frame


def arrival_of(record: Record, robots: int) -> Arrival:
    """Return a record, of a team of so many robots, as `frames_of` takes it."""
    match record:
        case FrameEnd():
            return Frame(record.time)
        case TruthAt():
            return Frame(record.time, truth=_seen_together([record], robots))
        case Joined():
            return record.placed()
    return record


def _joined(parts: Sequence[Odometry]) -> Odometry | None:
    """Return the odometry of one instant's several records as one, or None for none."""
    if len(parts) < 2:
        return parts[0] if parts else None
    columns = {name: np.concatenate([getattr(part, name) for part in parts]) for name in field_names(parts[0])}
    return Odometry(parts[0].start, parts[0].time, **columns)


def _seen_together(parts: Sequence[TruthAt], robots: int) -> Truth | None:
    """Return the truth of one instant's several records as one, or None for none."""
    if not parts:
        return None
    if len(parts[0].robot) == robots:
        return parts[0].truth
    positions, headings = np.full((robots, 2), np.nan), np.full(robots, np.nan)
    for part in parts:
        positions[part.robot], headings[part.robot] = part.truth.positions, part.truth.headings
    return settled(Truth, positions=read_only(positions), headings=read_only(headings))
