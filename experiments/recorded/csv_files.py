"""A folder of CSV files, or one CSV file: a header line, then one row a message."""

from __future__ import annotations

import csv
from collections.abc import Collection, Iterator, Sequence
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from experiments.logs import TextFile
from experiments.recorded.inputs import Message, Taker, Topic
from experiments.recorded.words import nearest
from filter import InvalidInput

DELIMITERS = (";", "\t", ",")  # the first one that the header line has
PATTERNS = ("*.csv", "*.csv.gz", "*.CSV")


class CsvFiles:
    """The CSV files of a folder and of those in it, or a single one; by gzip or not, with a byte order mark or without.

    Attributes:
        key: "file".
        topics: One for each file, named by its path in the folder.

    Raises:
        InvalidInput: A file cannot be read, or has no header line; or the folder has none.
    """

    key = "file"

    def __init__(self, path: Path) -> None:
        files = sorted({file for pattern in PATTERNS for file in path.rglob(pattern)}) if path.is_dir() else [path]
        if not files:
            raise InvalidInput(f"{path}: a folder with files of the name *.csv or *.csv.gz", "none")
        self._paths = {file.relative_to(path).as_posix() if path.is_dir() else file.name: file for file in files}
        self.topics = [_topic(name, file) for name, file in self._paths.items()]

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Do nothing: files are open only while they are read."""

    def has_field(self, topic: Topic, path: str) -> bool:
        """Return whether there is such a column."""
        return path in topic.fields

    def taker(self, topic: Topic, path: str) -> Taker:
        """Return a function that takes a column's text from a row.

        Raises:
            InvalidInput: There is no such column.
        """
        if path not in topic.fields:
            raise InvalidInput(f"{topic.name}: a column of its header line: {nearest(path, topic.fields)}", f'"{path}"')
        if list(topic.fields).count(path) > 1:
            raise InvalidInput(f"{topic.name}: each column once", f'several called "{path}"')
        column = list(topic.fields).index(path)
        return lambda row: row[column]

    def flows(self, topics: Collection[str]) -> list[Iterator[Message]]:
        """Return the rows of some files, file by file."""
        return [self.rows(name) for name in topics]

    def rows(self, name: str) -> Iterator[Message]:
        """Yield the rows of one file.

        Raises:
            InvalidInput: A row has more or fewer columns than the header.
        """
        for place, row in _rows(name, self._paths[name]):
            yield Message(name, place, None, row)


def _topic(name: str, path: Path) -> Topic:
    """Return what there is to know of a file: its columns, and how many rows."""
    try:
        header = next(_lines(name, path), "")
        count = sum(1 for line in TextFile(path).lines() if line.strip()) - 1
    except OSError as error:
        raise InvalidInput("a readable CSV file", f"{path}: {error.strerror or error}") from None
    if not header.strip():
        raise InvalidInput(f"{path}: a header line with the names of the columns", "an empty file")
    return Topic(name, "CSV", count, "", _header(header))


def _header(line: str) -> Sequence[str]:
    return [name.strip() for name in next(csv.reader([line], delimiter=_delimiter(line)))]


def _delimiter(line: str) -> str:
    return next((each for each in DELIMITERS if each in line), ",")


def _lines(name: str, path: Path) -> Iterator[str]:
    try:
        for line in TextFile(path).lines():
            yield line.decode()
    except (OSError, UnicodeDecodeError) as error:
        raise InvalidInput(f"{name}: a readable CSV file, UTF-8", getattr(error, "strerror", None) or error) from None


def _rows(name: str, path: Path) -> Iterator[tuple[str, Sequence[Any]]]:
    lines = _lines(name, path)
    header = next(lines, "")
    columns = len(_header(header))
    rows = csv.reader(lines, delimiter=_delimiter(header))
    for row in rows:
        place = f"{name}, line {rows.line_num + 1}"
        if not any(row):
            continue
        if len(row) != columns:
            remedy = "; take out the line if the recording was cut off there"
            raise InvalidInput(f"{place}: {columns} columns, as in the header{remedy}", f"{len(row)}")
        yield place, row
