"""Everything a filter was given, as `log.jsonl`: one JSON record a line, exact to the last bit. See docs/log.md.

`LogWriter` writes while a run goes on; `LogReader` yields the same team, initial sets and frames again, and refuses
whatever it does not know. The form of the single records is in `experiments.logs.records`.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from contextlib import contextmanager, suppress
from pathlib import Path
from types import TracebackType
from typing import Any

from experiments.logs.fields import Fields
from experiments.logs.records import (
    Header,
    InitialSet,
    frame_records,
    initial_record,
    joined,
    read_header,
    read_initial,
    read_measurement,
    read_odometry,
    read_truth,
)
from experiments.logs.text import TextFile
from filter import Frame, InvalidInput, Measurement, Odometry, Truth


class InvalidLog(InvalidInput):
    """A log cannot be used.

    Attributes:
        path: The file.
        line: Number of the line at fault, from 1 on; 0 for the file as a whole.
    """

    def __init__(self, path: Path, line: int, expected: str, came: Any) -> None:
        super().__init__(expected, came)
        place = f"{path}, line {line}" if line else f"{path}"
        self.args = (f"{place}: {self.args[0]}",)
        self.path = path
        self.line = line


class LogWriter:
    """Writes a log, a frame at a time; a run that is killed leaves every whole frame.

    Use as a context manager, or call `close`.
    """

    def __init__(self, path: Path, header: Header, initial: Sequence[InitialSet]) -> None:
        self._robots = header.team.robots
        self._file = path.open("w", encoding="utf-8", newline="\n")
        try:
            self._write([header.record(), *(initial_record(robot, known) for robot, known in enumerate(initial))])
        except OSError:
            with suppress(OSError):  # it would try again
                self.close()
            raise

    def write(self, frame: Frame) -> None:
        """Append a frame."""
        self._write(frame_records(frame, self._robots))

    def close(self) -> None:
        """Close the file."""
        self._file.close()

    def _write(self, records: Sequence[dict[str, Any]]) -> None:
        self._file.write("".join(json.dumps(record, allow_nan=False) + "\n" for record in records))
        self._file.flush()

    def __enter__(self) -> LogWriter:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


class LogReader:
    """Reads a log, strictly.

    Attributes:
        path: The file.
        header: Team, time of the initial sets, rate.
        initial: What is known of each robot at the start, in the robots' order.

    Raises:
        InvalidLog: The file cannot be read, or its header or its initial sets are not as docs/log.md says.
    """

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._readable():
            self._file = TextFile(path)
        lines = self._lines()
        self._head, record = next(lines)
        with self._located(self._head):
            record.expect("header")
            self.header = read_header(record)
        self.initial = self._initial(lines)

    def _initial(self, lines: Iterator[tuple[int, Fields]]) -> tuple[InitialSet, ...]:
        robots = self.header.team.robots
        found: dict[int, InitialSet] = {}
        while len(found) < robots:
            self._head, record = next(lines, (self._head, None))
            with self._located(self._head):
                if record is None:
                    raise InvalidInput(f"{robots} initial sets", f"{len(found)}, then the end of the file")
                record.expect("initial")
                robot, known = read_initial(record, self.header.team, found)
            found[robot] = known
        return tuple(found[robot] for robot in range(robots))

    def frames(self) -> Iterator[Frame]:
        """Yield the frames in order, reading as it goes; every call starts from the beginning.

        Raises:
            InvalidLog: A line is not as docs/log.md says, is cut off, or belongs to a frame that never ends.
        """
        gathering = _Gathering(self.header)
        line = self._head
        for line, record in self._lines():
            if line <= self._head:
                continue
            with self._located(line):
                frame = gathering.add(record)
            if frame is not None:
                yield frame
        with self._located(line):
            gathering.end()

    def copy(self, path: Path) -> None:
        """Write the same bytes to another file; a log that is compressed becomes plain.

        Raises:
            InvalidLog: The log cannot be read, or is compressed but not whole.
            OSError: The other file cannot be written.
        """
        with path.open("wb") as file:
            file.writelines(self._blocks())

    def _blocks(self) -> Iterator[bytes]:
        with self._readable():
            yield from self._file.blocks()

    def _lines(self) -> Iterator[tuple[int, Fields]]:
        """Yield each line's number and fields; blank lines say nothing."""
        nothing = True
        with self._readable():
            for line, text in enumerate(self._file.lines(), 1):
                if not text.isspace():
                    with self._located(line):
                        fields = Fields.parse(text)
                    nothing = False
                    yield line, fields
        if nothing:
            raise InvalidLog(self.path, 0, "a log with a header", "an empty file")

    @contextmanager
    def _readable(self) -> Iterator[None]:
        """Give an error of the file its place."""
        try:
            yield
        except OSError as error:
            raise InvalidLog(self.path, 0, "a readable log", error.strerror) from None

    @contextmanager
    def _located(self, line: int) -> Iterator[None]:
        """Give an error of the input its place."""
        try:
            yield
        except InvalidLog:
            raise
        except InvalidInput as error:
            raise InvalidLog(self.path, line, error.expected, error.came) from None


class _Gathering:
    """The records since the last frame."""

    def __init__(self, header: Header) -> None:
        self._header = header
        self._previous: float | None = None
        self._clear()

    def _clear(self) -> None:
        self._time: float | None = None
        self._odometry: list[Odometry] = []
        self._measurements: list[Measurement] = []
        self._truth: Truth | None = None

    def add(self, record: Fields) -> Frame | None:
        """Take a record in; return the frame that it ends, or None.

        Raises:
            InvalidInput: The record is wrong in itself or does not fit what came before.
        """
        match record.kind:
            case "odometry":
                self._add_odometry(read_odometry(record, self._header.team))
            case "truth":
                self._add_truth(*read_truth(record, self._header.team))
            case "frame":
                return self._close(record)
            case _:
                measurement = read_measurement(record, self._header.team)
                self._at(measurement.time)
                self._measurements.append(measurement)
        return None

    def end(self) -> None:
        """Raise `InvalidInput` when records wait for a frame, or no frame came at all."""
        if self._time is not None:
            raise InvalidInput(f"a frame record for the records at {self._time!r} s", "the end of the file: the log is cut off")
        if self._previous is None:
            raise InvalidInput("at least one frame", "the end of the file")

    def _add_odometry(self, odometry: Odometry) -> None:
        self._at(odometry.time)
        if self._previous is None and odometry.time == self._header.start:
            raise InvalidInput(f"no odometry at the start, {self._header.start!r} s", "odometry")
        since = self._header.start if self._previous is None else self._previous
        if odometry.start != since:
            raise InvalidInput(f"odometry since the last frame, {since!r} s", f"since {odometry.start!r} s")
        moved = {robot for part in self._odometry for robot in part.robot.tolist()}
        if twice := moved & set(odometry.robot.tolist()):
            raise InvalidInput("odometry of each robot at most once a frame", f"robot {min(twice)} again")
        self._odometry.append(odometry)

    def _add_truth(self, time: float, truth: Truth) -> None:
        self._at(time)
        if self._truth is not None:
            raise InvalidInput("one truth a frame", "another")
        self._truth = truth

    def _at(self, time: float) -> None:
        """Check that a record's time belongs to the frame that is being gathered."""
        if self._time is not None and time != self._time:
            raise InvalidInput(f"the frame's time, {self._time!r} s", f"{time!r} s")
        if self._previous is None and time < self._header.start:
            raise InvalidInput(f"a time from the start, {self._header.start!r} s, on", f"{time!r} s")
        if self._previous is not None and time <= self._previous:
            raise InvalidInput(f"a time after the last frame's, {self._previous!r} s", f"{time!r} s")
        self._time = time

    def _close(self, record: Fields) -> Frame:
        time = record.number("time")
        record.end()
        self._at(time)
        frame = Frame(time, joined(self._odometry), tuple(self._measurements), self._truth)
        self._clear()
        self._previous = time
        return frame
