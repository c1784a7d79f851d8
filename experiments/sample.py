"""What do own data look like? One simulated minute of two robots as CSV files, as bags of ROS 1 and ROS 2, and as a log."""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from tyro.conf import Positional

from experiments.minute.log import write_log
from experiments.minute.measured import minute
from experiments.minute.recorded import write_bag, write_mcap
from experiments.minute.settings import write_settings
from experiments.minute.tables import write_tables
from experiments.show.command import command
from experiments.show.output import output_folder
from experiments.show.terminal import print_table
from filter import InvalidInput


@dataclass(frozen=True)
class Options:
    """Write a simulated minute of two robots in every form that own data come in, and the settings to convert each.

    Four sensors a robot, each at its own rate, errors uniform within the bounds that the settings declare; and the truth.
    minute.jsonl is the log that every conversion has to give. The same seed gives the same bytes.
    """

    out: Positional[Path]
    """Folder to write to: minute.csv, minute.mcap, minute.bag, minute.jsonl, and a minute_csv.toml and so on for each."""
    seed: int = 0
    """What is drawn, from 0 on."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Write the sample with command-line arguments; return the exit code."""
    return command("sample", Options, run, arguments, stopped="what was written is not complete")


def run(options: Options) -> int:
    """Write the sample; return the exit code.

    Raises:
        CorralError: An option or the folder cannot be used, or the package that writes bags is not there.
        OSError: Something cannot be written.
    """
    if options.seed < 0:
        raise InvalidInput("seed: a whole number from 0 on", options.seed)
    folder, made = output_folder(options.out), minute(np.random.default_rng(options.seed))
    write_mcap(folder / "minute.mcap", made)
    write_bag(folder / "minute.bag", made)
    write_tables(folder / "minute.csv", made)
    write_log(folder / "minute.jsonl", made)
    write_settings(folder, made)
    counts = Counter(each.stream for each in made.said)
    print_table(f"sample, in {folder}", {f"messages of {stream}": count for stream, count in sorted(counts.items())})
    return 0


if __name__ == "__main__":
    sys.exit(main())
