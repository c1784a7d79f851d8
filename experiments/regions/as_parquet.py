"""Regions as a Parquet table, with the columns of the JSON lines; polygons are lists of [x, y]."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import pyarrow as pa
from pyarrow import parquet

from experiments.regions.files import named
from experiments.regions.rows import Row

ROWS = 10_000  # of a row group: so many are kept before they are written
POINTS = pa.list_(pa.list_(pa.float64()))
HEADING = pa.struct([("centre", pa.float64()), ("bound", pa.float64())])
EKF = pa.struct([("position", pa.list_(pa.float64())), ("heading", pa.float64()), ("covariance", POINTS)])
SCHEMA = pa.schema(
    [
        ("time", pa.float64()),
        ("robot", pa.string()),
        ("outer", POINTS),
        ("margin_m", pa.float64()),
        ("inner", POINTS),
        ("heading", HEADING),
        ("area_m2", pa.float64()),
        ("in_force", pa.bool_()),
        ("ekf", EKF),
    ]
)


class Writer:
    """Writes `regions.parquet`, some thousand rows at a time. Only `close` makes it a whole file.

    Raises:
        OSError: It cannot be written, as by each method.
    """

    def __init__(self, path: Path) -> None:
        self._path, self._waiting = path, list[dict[str, Any]]()
        self._file = path.open("wb")
        with named(path):
            self._table = parquet.ParquetWriter(self._file, SCHEMA, compression="zstd")

    def write(self, rows: Sequence[Row]) -> None:
        """Append a step."""
        self._waiting += [row.record() for row in rows]
        if len(self._waiting) >= ROWS:
            self._send()

    def _send(self) -> None:
        with named(self._path):
            self._table.write_table(pa.Table.from_pylist(self._waiting, SCHEMA))
        self._waiting.clear()

    def close(self) -> None:
        """Write what is left, and the table's end."""
        with named(self._path):
            try:
                if self._waiting:
                    self._send()
                self._table.close()
            finally:
                self._file.close()
