"""Regions, written as soon as they are known: to standard output, and to a file."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType

from experiments.regions import FILES
from experiments.regions.as_jsonl import text_of
from experiments.regions.files import named
from experiments.regions.rows import rows_of
from filter import Belief


class Answers:
    """Writes regions as JSON lines, see docs/regions.md. Use as a context manager.

    Raises:
        OSError: One of both cannot be written, as when the reader of standard output has closed.
    """

    def __init__(self, folder: Path, names: Sequence[str]) -> None:
        self._names, self._path = names, folder / FILES["jsonl"]
        self._file = self._path.open("w", encoding="utf-8", newline="\n")

    def write(self, belief: Belief) -> None:
        """Write the regions of all robots, and see them off."""
        text = text_of(rows_of(self._names, belief.time, belief))
        with named(self._path):
            self._file.write(text)
            self._file.flush()
        with named(Path("standard output")):
            sys.stdout.write(text)
            sys.stdout.flush()

    def __enter__(self) -> Answers:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        with named(self._path):
            self._file.close()
