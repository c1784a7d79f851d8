"""How do your own data become a log? CSV files and bags of ROS 1 and ROS 2, by a file of settings, see docs/own-data.md."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from tyro.conf import Positional

from experiments.own_data import Converted, convert, read_settings
from experiments.recorded import opened
from experiments.show.command import command
from experiments.show.terminal import print_table, tell
from filter import InvalidInput


@dataclass(frozen=True)
class Options:
    """Write a log from your own data: CSV files, or a bag of ROS 1 or ROS 2. No ROS is needed.

    What cannot be read is told in the end, a line each. Exit code 0 if the log was written, 2 for bad input, 3 if it cannot be
    written. docs/own-data.md explains the settings, docs/log.md the log.
    """

    settings: Positional[Path]
    """A TOML file: the team, its streams, the bounds of their errors."""
    data: Positional[Path]
    """A folder of CSV files or one of them, a bag, a folder of rosbag2, or an .mcap or .db3 file."""
    out: Positional[Path]
    """The log to write, as in run.jsonl."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the conversion with command-line arguments; return the exit code."""
    return command("convert", Options, run, arguments, stopped="no log was written")


def run(options: Options) -> int:
    """Run the conversion; return the exit code.

    Raises:
        CorralError: The settings or the data cannot be used, or nothing came of them.
        OSError: The log cannot be written.
    """
    _check_out(options)
    settings = read_settings(options.settings)
    with opened(options.data, settings.types, settings.definitions) as data:
        converted = convert(settings, data, options.out, lambda number: tell(f"{number} messages read"))
    for line in converted.left_out:
        tell(line)
    if not converted.records:
        raise InvalidInput("data that records can be made of", "none; no log was written")
    _print(options.out, converted)
    return 0


def _check_out(options: Options) -> None:
    """Refuse to write over what is read, or over what is no file."""
    out, read = options.out, [path for path in (options.settings, options.data) if path.exists()]
    if out.exists() and (not out.is_file() or any(map(out.samefile, read))):
        raise InvalidInput("a log to write, a file of its own", f"{out}, which is something else")


def _print(path: Path, converted: Converted) -> None:
    counts = {f"{kind} records": count for kind, count in sorted(converted.records.items())}
    print_table("convert", {"log": str(path), "start_s": converted.start, "end_s": converted.end, **counts})


if __name__ == "__main__":
    sys.exit(main())
