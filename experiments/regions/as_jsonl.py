"""Regions as JSON lines: a line for each robot at each step, every float as it is."""

from __future__ import annotations

import json
from collections.abc import Sequence
from pathlib import Path

from experiments.regions.files import named
from experiments.regions.rows import Row


def text_of(rows: Sequence[Row]) -> str:
    """Return the lines of a step."""
    return "".join(json.dumps(row.record(), allow_nan=False) + "\n" for row in rows)


class Writer:
    """Writes `regions.jsonl`, a step at a time; a run that is killed leaves every whole step.

    Raises:
        OSError: It cannot be written, as by each method.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._file = path.open("w", encoding="utf-8", newline="\n")

    def write(self, rows: Sequence[Row]) -> None:
        """Append a step."""
        with named(self._path):
            self._file.write(text_of(rows))
            self._file.flush()

    def close(self) -> None:
        """Close the file."""
        with named(self._path):
            self._file.close()
