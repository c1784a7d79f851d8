"""Everything a filter was given, as `log.jsonl`: one JSON record a line, exact to the last bit. See docs/log.md.

`LogWriter` writes while a run goes on; `LogReader` yields the same team, initial sets, records and frames again, and refuses
whatever it does not know. What a log holds is in `experiments.logs.records`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from itertools import chain
from pathlib import Path
from types import TracebackType
from typing import Any

from experiments.logs.gathering import Gathering, OwnStamp, arrival_of
from experiments.logs.reading.fast import Fast
from experiments.logs.reading.fields import Fields
from experiments.logs.reading.heads import InitialSets, read_header
from experiments.logs.reading.strict import Strict
from experiments.logs.records import Header, InitialSet, Record
from experiments.logs.text import TextFile
from experiments.logs.writing import frame_objects, header_object, initial_object, object_of
from filter import Arrival, Frame, InvalidInput, OutOfOrder, frames_of


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
    """Writes a log of its header's version, a frame or a record at a time; a run that is killed leaves every whole one.

    Use as a context manager, or call `close`.
    """

    def __init__(self, path: Path, header: Header, initial: Sequence[InitialSet]) -> None:
        self._header = header
        self._file = path.open("w", encoding="utf-8", newline="\n")
        try:
            known = [initial_object(header, robot, each) for robot, each in enumerate(initial) if each.there]
            self._write([header_object(header), *known])
        except OSError:
            with suppress(OSError):  # it would try again
                self.close()
            raise

    def write(self, frame: Frame) -> None:
        """Append a frame; raises `InvalidInput` if the log's version has nothing for what is in it."""
        self._write(frame_objects(self._header, frame))

    def append(self, record: Record) -> None:
        """Append a single record, as it comes; raises `InvalidInput` if the log's version has nothing for it."""
        self._write([object_of(self._header, record)])

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


@dataclass
class _Place:
    """Where reading has come to: the number of a line, from 1 on."""

    line: int = 0


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
        with self._located() as place:
            lines = self._lines()
            place.line, text = next(lines)
            self.header = read_header(Fields.parse(text))
            self.initial = self._initial(lines, place)
        self._fast, self._strict = Fast(self.header), Strict(self.header)

    def _initial(self, lines: Iterator[tuple[int, bytes]], place: _Place) -> tuple[InitialSet, ...]:
        sets = InitialSets(self.header)
        self._head = place.line
        while not sets.are_all_there:
            place.line, text = next(lines, (place.line, b""))
            if not text:
                raise sets.missing()
            if not sets.take(Fields.parse(text)):
                break
            self._head = place.line
        return sets.sets()

    def records(self) -> Iterator[Record]:
        """Yield the records after the initial sets, in the order of their lines, reading as it goes.

        Raises:
            InvalidLog: A line is not as docs/log.md says, or is cut off.
        """
        for _, record in self._records():
            yield record

    def frames(self) -> Iterator[Frame]:
        """Yield the frames in order, reading as it goes; every call starts from the beginning.

        They are those of the log as long as all comes in lock-step; from the first record on that does not, those that
        `frames_of` makes of what comes: it may come late by a second.

        Raises:
            InvalidLog: A line is not as docs/log.md says, is cut off, comes too late, or belongs to a frame that never ends.
        """
        gathering = Gathering(self.header)
        with self._located() as place:
            place.line = self._head
            records = self._records()
            for place.line, record in records:
                try:
                    frame = gathering.add(record)
                except OwnStamp:
                    yield from self._of_stream(gathering, chain([(place.line, record)], records), place)
                    return
                if frame is not None:
                    yield frame
            last = gathering.end()
            if last is not None:
                yield last

    def _of_stream(self, gathering: Gathering, records: Iterable[tuple[int, Record]], place: _Place) -> Iterator[Frame]:
        """Yield the frames of what waits, and of further records."""
        team = self.header.team

        def arrivals() -> Iterator[Arrival]:
            for place.line, record in records:
                yield arrival_of(record, team.robots)

        try:
            yield from frames_of(team, gathering.since, chain(gathering.waiting(), arrivals()))
        except OutOfOrder as error:
            raise InvalidInput(f"a time from {error.belief_time!r} s on", f"{error.time!r} s, which is too late") from None

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

    def _records(self) -> Iterator[tuple[int, Record]]:
        """Yield each record after the initial sets, with its line's number."""
        with self._located() as place:
            for place.line, text in self._lines():
                if place.line > self._head:
                    record = self._fast.read(text)
                    yield place.line, self._strict.read(Fields.parse(text)) if record is None else record

    def _lines(self) -> Iterator[tuple[int, bytes]]:
        """Yield each line with its number; blank ones say nothing."""
        nothing = True
        with self._readable():
            for line, text in enumerate(self._file.lines(), 1):
                if not text.isspace():
                    nothing = False
                    yield line, text
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
    def _located(self) -> Iterator[_Place]:
        """Give an error of the input its place."""
        place = _Place()
        try:
            yield place
        except InvalidLog:
            raise
        except InvalidInput as error:
            raise InvalidLog(self.path, place.line, error.expected, error.came) from None
