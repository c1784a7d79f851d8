"""The minute as a folder of CSV files: one for each stream of each robot, a header line, stamps in whole nanoseconds."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterator
from pathlib import Path

from experiments.minute.said import Distance, Minute, North, PoseSaid, Said, Seen
from experiments.show.output import write_whole

HEADERS = {
    "odometry": ("stamp", "x", "y", "heading"),
    "compass": ("stamp", "heading"),
    "detections": ("stamp", "id", "range", "bearing"),
    "uwb": ("stamp", "id", "range"),
    "truth": ("stamp", "x", "y", "heading"),
}


def write_tables(folder: Path, minute: Minute) -> None:
    """Write the files; floats come back exactly.

    Raises:
        OSError: They cannot be written.
    """
    folder.mkdir(exist_ok=True)
    for robot in minute.starts:
        for stream, header in HEADERS.items():
            said = sorted((each for each in minute.said if (each.robot, each.stream) == (robot, stream)), key=_stamp)
            text = io.StringIO()
            table = csv.writer(text, lineterminator="\n")
            table.writerow(header)
            table.writerows(row for each in said for row in _rows(each))
            write_whole(folder / f"{robot}_{stream}.csv", text.getvalue())


def _stamp(said: Said) -> int:
    return said.stamp


def _rows(said: Said) -> Iterator[tuple[str | int | float, ...]]:
    match said.value:
        case PoseSaid() as pose:
            yield said.stamp, pose.x, pose.y, pose.turned.heading
        case North(turned):
            yield said.stamp, turned.heading
        case Seen(targets):
            for name, (distance, bearing) in targets.items():
                yield said.stamp, name, distance, bearing
        case Distance(target, distance):
            yield said.stamp, target, distance
