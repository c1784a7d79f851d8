"""Which format is written by what; the packages of a format are loaded, and needed, only by who asks for it."""

from __future__ import annotations

from collections.abc import Sequence
from importlib import import_module
from importlib.util import find_spec
from pathlib import Path
from typing import Literal, Protocol, get_args

from experiments.regions.rows import Row
from filter import InvalidInput

Format = Literal["jsonl", "mcap", "parquet", "ros2"]
FORMATS: tuple[Format, ...] = get_args(Format)
NEEDS: dict[Format, tuple[str, ...]] = {
    "jsonl": (),
    "mcap": ("mcap", "foxglove_schemas_protobuf"),
    "parquet": ("pyarrow",),
    "ros2": ("mcap",),
}
FILES: dict[Format, str] = {
    "jsonl": "regions.jsonl",
    "mcap": "regions.mcap",
    "parquet": "regions.parquet",
    "ros2": "regions_ros2.mcap",
}


class Writer(Protocol):
    """Writes regions, a step at a time."""

    def write(self, rows: Sequence[Row]) -> None:
        """Append a step."""

    def close(self) -> None:
        """Make it a whole file."""


def check_packages(form: Format) -> None:
    """Raise `InvalidInput` if a package is not installed that a format needs."""
    for package in NEEDS[form]:
        if find_spec(package) is None:
            name = package.replace("_", "-")
            raise InvalidInput(f"the package {name} to write {form} (pip install {name}; Corral's extra data has it)", "none")


def regions_writer(form: Format, folder: Path) -> Writer:
    """Return what writes regions in a format, to its one of `FILES` in a folder.

    Raises:
        InvalidInput: A package that it needs is not installed.
        OSError: The file cannot be written.
    """
    check_packages(form)
    made: Writer = import_module(f"experiments.regions.as_{form}").Writer(folder / FILES[form])
    return made
