"""Opens what there is at a path, whatever it is."""

from __future__ import annotations

from collections.abc import Collection
from pathlib import Path

from experiments.recorded.bags import ENDINGS, Bag
from experiments.recorded.csv_files import CsvFiles
from filter import InvalidInput

TABLES = (".csv", ".csv.gz")


def opened(path: Path, types: str, definitions: Collection[Path]) -> Bag | CsvFiles:
    """Return a bag, a folder of CSV files, or a single one.

    Args:
        path: Of a file .bag, .mcap, .db3 or .csv, or of a folder: of rosbag2, or of CSV files.
        types: Which ROS 2 bags without definitions are from, as in "humble"; "" if nobody said so.
        definitions: Files package/msg/Name.msg with further definitions of messages.

    Raises:
        InvalidInput: It is none of these, or cannot be read.
    """
    if not path.exists():
        raise InvalidInput("a recording: a folder or a file", f"{path}, which is not there")
    if path.suffix in ENDINGS or (path / "metadata.yaml").exists() or any(each.suffix in ENDINGS for each in _within(path)):
        return Bag(path, types, definitions)
    if not path.is_dir() and not path.name.lower().endswith(TABLES):
        raise InvalidInput(f"a file {', '.join((*ENDINGS, *TABLES))}, or a folder of rosbag2 or of CSV files", str(path))
    if types or definitions:
        raise InvalidInput("[input] without types and definitions, as CSV files have none", "one")
    return CsvFiles(path)


def _within(path: Path) -> list[Path]:
    return list(path.iterdir()) if path.is_dir() else []
