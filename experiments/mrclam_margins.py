"""How much worse may real robots be? A run, made harder in many ways, through the filter with its defaults.

Run `python -m experiments.mrclam_margins --help`. Bounds are broken here on purpose, so that there is no guarantee to keep:
what counts is how often a truth is outside, and for how long. What came out is in docs/real-robots.md.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

import numpy as np
from rich.table import Table

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value
from experiments.following.steps import steps
from experiments.real_robots.bounds import Bounds
from experiments.real_robots.data import read_tables, run_of
from experiments.real_robots.followed import Which, team_filter
from experiments.real_robots.frames import frames
from experiments.real_robots.harder import HARDER
from experiments.real_robots.kalman import kalman_filter
from experiments.real_robots.metrics import Tally, summary_of
from experiments.real_robots.motion import Motions
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import gathered, show_table
from experiments.sweep.executors import executor
from filter import InvalidInput

SHOWN = {
    "escape_share": "outside",
    "longest_escape_s": "for [s]",
    "suspended_share": "suspended",
    "rejected": "rejected",
    "outer_area_median_m2": "area [m2]",
    "set_rmse_m": "RMSE [m]",
    "ekf_rmse_m": "EKF [m]",
}
KEPT = ("checks", *SHOWN, "escapes_in_force", "heading_escapes", "resets", "outer_area_p95_m2", "ekf_containment_997")


@dataclass(frozen=True)
class Options:
    """Follow a run of the MRCLAM data set, made harder in many ways: errors, clocks, speeds, barcodes, gaps.

    Bounds are broken here on purpose: what counts is how often a truth is outside, and for how long. Exit code 0 once all is
    done, 2 for bad input.
    """

    data: Path
    """Folder of a run, as MRCLAM_Dataset6."""
    changes: str = ",".join(HARDER)
    """How it is made harder, with commas."""
    start: float = 0.0
    """When to start, since the first command or measurement [s]."""
    duration: float | None = None
    """How long at most [s]; to the end if not given."""
    workers: int | None = None
    """How many processes; one on each core if not given."""
    filter: Which = "sets"
    """With which filter, as experiments.mrclam has it."""
    tolerate: Literal[0, 1] = 1
    """How many wrong votes on a robot do no harm, as experiments.mrclam has it."""
    seed: int = 0
    """Where in its initial set each robot starts, and what chance decides of a change."""
    out: Path = Path("runs/mrclam_margins")
    """Folder for the summary."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("mrclam_margins", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option, a file of the data, or the output folder cannot be used.
    """
    keep_within(options, seed=(0, np.inf))
    names = options.changes.split(",")
    unknown = [name for name in names if name not in HARDER]
    if unknown or len(set(names)) < len(names):
        raise InvalidInput(f"different changes among {', '.join(HARDER)}", repr(options.changes))
    if not any(len(log.truth) for log in read_tables(options.data).logs.values()):
        raise InvalidInput("a run whose truth is known", "no file of truth")
    folder = output_folder(options.out)
    with executor(options.workers) as pool:
        found = gathered([pool.submit(judged, options, name) for name in names], "runs")
    rows = dict(zip(names, found, strict=True))
    write_summary(folder, {f"{name}_{key}": value for name, row in rows.items() for key, value in row.items()})
    show(rows)
    return 0


def judged(options: Options, name: str) -> dict[str, Value]:
    """Return the figures of one run that was made harder."""
    tables = HARDER[name].made_of(read_tables(options.data), np.random.default_rng(options.seed))
    data, team, declared = run_of(tables), sorted(tables.logs), Bounds()
    bounds, tally = declared.chained(), Tally(options.start)
    scenario, single = (
        frames(data, team, options.start, options.duration, bounds=each, generator=np.random.default_rng(options.seed))
        for each in (bounds, declared)
    )
    estimates = steps(kalman_filter(single.team), single)
    sets = team_filter(scenario, Motions(data, team, bounds), options.tolerate, which=options.filter)
    for step, estimate in zip(sets, estimates, strict=True):
        tally.add(step, estimate.belief)
    figures = summary_of(tally.table(), options.start, tally.resets)
    return {key: figures[key] for key in KEPT} | {"put_aside": "; ".join(tally.put_aside)}


def show(rows: Mapping[str, Mapping[str, Value]]) -> None:
    """Print the table."""
    table = Table("run", *SHOWN.values(), title="made harder", title_justify="left")
    for name, row in rows.items():
        table.add_row(name, *(_shown(row[key]) for key in SHOWN))
    show_table(table)


def _shown(value: Value) -> str:
    return f"{value:.3g}" if isinstance(value, float) else str(value)


if __name__ == "__main__":
    sys.exit(main())
