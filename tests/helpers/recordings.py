"""Reads recordings back."""

import subprocess
from pathlib import Path

import rerun_cli
from rerun.chunk import RrdReader


def rerun(*arguments):
    """Run `rerun rrd`: the program itself, as its Python module always exits with 0."""
    command = [Path(rerun_cli.__file__).with_name("rerun"), "rrd", *arguments]
    return subprocess.run(command, capture_output=True, text=True, check=False)


def rows_of(path, entity, column):
    """Return the rows of one entity in order: step, t, and the value of one column."""
    rows = []
    for chunk in RrdReader(path).stream().filter(content=entity, is_static=False):
        batch = chunk.to_record_batch()
        if column in batch.schema.names:
            columns = (batch.column(batch.schema.names.index(name)).to_pylist() for name in ("step", "t", column))
            rows += [{"step": step, "t": time, "value": value} for step, time, value in zip(*columns, strict=True)]
    return sorted(rows, key=lambda row: row["step"])
