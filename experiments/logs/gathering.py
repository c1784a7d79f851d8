"""From records to frames: everything since the previous frame is one instant. See docs/log.md."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from experiments.logs.records import FIRST, FrameEnd, Header, Joined, Left, Record, TruthAt, settled
from filter import Frame, InvalidInput, Measurement, Odometry, Truth, Twist
from filter.records.record import field_names


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
        self._truths: list[TruthAt] = []
        self._shown: set[int] = set()

    def add(self, record: Record) -> Frame | None:
        """Take a record in; return the frame that it ends, or None.

        Raises:
            InvalidInput: The record does not fit what came before.
        """
        if isinstance(record, Odometry):
            self._add_odometry(record)
            return None
        self._at(record.time)
        if isinstance(record, FrameEnd):
            return self._close(record.time)
        if isinstance(record, TruthAt):
            self._add_truth(record)
        elif isinstance(record, Twist | Joined | Left):
            raise InvalidInput("odometry, measurements or truth of a frame (see LogReader.records)", type(record).__name__)
        else:
            self._measurements.append(record)
        return None

    def end(self) -> None:
        """Raise `InvalidInput` when records wait for a frame, or no frame came at all."""
        without = "" if self._header.version == FIRST else " (LogReader.records reads logs without frames)"
        if self._time is not None:
            expected = f"a frame record for the records at {self._time!r} s{without}"
            raise InvalidInput(expected, "the end of the file: the log is cut off")
        if self._previous is None:
            raise InvalidInput(f"at least one frame{without}", "the end of the file")

    def _add_odometry(self, odometry: Odometry) -> None:
        self._at(odometry.time)
        if self._previous is None and odometry.time == self._header.start:
            raise InvalidInput(f"no odometry at the start, {self._header.start!r} s", "odometry")
        since = self._header.start if self._previous is None else self._previous
        if odometry.start != since:
            raise InvalidInput(f"odometry since the last frame, {since!r} s", f"since {odometry.start!r} s")
        robots = set(odometry.robot.tolist())
        if twice := self._moved & robots:
            raise InvalidInput("odometry of each robot at most once a frame", f"robot {min(twice)} again")
        self._moved |= robots
        self._odometry.append(odometry)

    def _add_truth(self, record: TruthAt) -> None:
        robots = set(record.robot.tolist())
        if twice := robots & self._shown:
            raise InvalidInput("one truth of each robot a frame", f"another of robot {min(twice)}")
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
        frame = settled(Frame, time=time, odometry=odometry, measurements=measurements, truth=truth)
        self._clear()
        self._previous = time
        return frame


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
    return Truth(positions, headings)
