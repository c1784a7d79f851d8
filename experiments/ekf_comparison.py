"""Sets against ellipses: the same simulated runs through the set-membership filter and through an extended Kalman filter.

Run `python -m experiments.ekf_comparison --help`. The exit code is the guarantee: 0 only if every position, every heading and
every relative position of every run was inside its set; 1 otherwise; 2 for bad input. How it is done, and what came out, is
in docs/ekf.md.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from math import inf
from pathlib import Path
from typing import Any

from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn, TimeRemainingColumn

from experiments.against_ekf.figures import draw_all, nees_band
from experiments.against_ekf.recording import record
from experiments.against_ekf.table import kept_every_truth, print_comparison, summary_of, write_csv, write_markdown
from experiments.against_ekf.tuning import CONSERVATIVE, TUNED
from experiments.following.ellipses import DIMENSION
from experiments.following.frozen import keep_within
from experiments.following.metrics import Value
from experiments.following.side_by_side import SERIES, Case, compare
from experiments.paper.merge_orders import compare_orders
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Terminal, print_table, tell, too_short
from experiments.sweep.executors import executor
from experiments.sweep.results import Result, Results, carry_out
from sim.errors import ERROR_KINDS

RECORDED = "bias"  # the kind whose first run is recorded
ENOUGH_RUNS, ENOUGH_SECONDS = 20, 60.0  # initial sets are smaller than what an EKF makes of them: who is ahead turns with time


@dataclass(frozen=True)
class Options:
    """Compare guaranteed regions with an extended Kalman filter's ellipses over many simulated runs.

    Exit code 0 only if every position, heading and relative position of every run was inside its set; 1 otherwise; 2 for bad
    input. A sweep that was stopped or killed goes on with --resume.
    """

    runs: int = 40
    """Number of runs for each kind of errors."""
    robots: int = 6
    """Number of robots."""
    duration: float = 60.0
    """How long a run is [s]."""
    seed: int = 0
    """Of the first run; the others have the seeds that follow."""
    workers: int | None = None
    """Processes on this machine; as many as it has cores if not given."""
    scheduler: str | None = None
    """Compute on the Dask cluster whose scheduler has this address, tcp://...; needs the extra "cluster"."""
    resume: bool = False
    """Go on with the sweep in the folder: what is finished is not computed again."""
    out: Path = Path("runs/ekf_comparison")
    """Folder for the results, tables, figures and the recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("ekf_comparison", Options, run, arguments, stopped="--resume goes on from the runs that are finished")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option, the folder or the cluster cannot be used.
    """
    cases = cases_of(options)
    next(iter(cases.values())).scenario()  # refuses what the simulator cannot do
    results = Results(options.out, fingerprint(options))
    results.open(options.resume)
    folder = output_folder(options.out)
    sweep(options, results, cases)
    found = {name: results.read(name) or {} for name in cases}
    kept = report(options, folder, cases, found)
    record(cases[f"{RECORDED}-{options.seed}"], folder / "ekf_comparison.rrd")
    if not kept:
        tell("a set lost the truth: some bound or some code is wrong; runs.csv tells where")
    return int(not kept)


def cases_of(options: Options) -> dict[str, Case]:
    """Return the runs by their names, the kinds of errors one after the other.

    Raises:
        InvalidInput: There is no run.
    """
    keep_within(options, runs=(1, inf))
    seeds = range(options.seed, options.seed + options.runs)
    cases = [Case(errors, seed, options.robots, options.duration) for errors in ERROR_KINDS for seed in seeds]
    return {case.name: case for case in cases}


def fingerprint(options: Options) -> dict[str, Any]:
    """Return all that decides a run's result but its kind of errors and its seed."""
    tuning: dict[str, Any] = {kind: asdict(noise) for kind, noise in TUNED.items()} | {"conservative": asdict(CONSERVATIVE)}
    return {"robots": options.robots, "duration": options.duration, "tuning": tuning}


def sweep(options: Options, results: Results, cases: Mapping[str, Case]) -> None:
    """Compute the runs that are missing, with a progress bar."""
    columns = (BarColumn(), MofNCompleteColumn(), TextColumn("runs"), TimeElapsedColumn(), TimeRemainingColumn())
    with executor(options.workers, options.scheduler) as pool, Progress(*columns, console=Terminal(stderr=True)) as progress:
        for _ in progress.track(carry_out(results, pool, compare, cases), total=len(cases)):
            pass


def report(options: Options, folder: Path, cases: Mapping[str, Case], found: Mapping[str, Result]) -> bool:
    """Write and print what came out; return whether the sets kept every truth."""
    rows = [found[name]["row"] for name in cases]
    timings = [{"errors": case.errors, "seed": case.seed, **found[name]["timings"]} for name, case in cases.items()]
    write_csv(folder / "runs.csv", rows)
    write_csv(folder / "timings.csv", timings)
    orders = compare_orders(options.seed)
    low, high = nees_band(options.runs)
    summary: dict[str, Value] = {
        "robots": options.robots,
        "duration_s": options.duration,
        "seed": options.seed,
        "runs": len(rows),
        "checks": sum(row["checks"] for row in rows),
        "nees_expected": DIMENSION,
        "nees_band_low": low,
        "nees_band_high": high,
        **summary_of(rows, timings),
        **orders,
    }
    counts = {"runs": (options.runs, ENOUGH_RUNS), "seconds_a_run": (options.duration, ENOUGH_SECONDS)}
    summary["too_short"] = too_short("who has the smaller areas and errors", **counts)
    kept = kept_every_truth(rows) and orders["order_set_containment"] == 1
    write_summary(folder, summary)
    write_markdown(folder / "table.md", summary)
    print_comparison(
        f"ekf_comparison: {len(rows)} runs of {options.duration:g} s, {summary['checks']} checks, in {folder}", summary
    )
    print_table("bearings of a standing team, merged in different orders", orders)
    draw(folder, summary, cases, found)
    return bool(kept)


def draw(folder: Path, summary: Mapping[str, Value], cases: Mapping[str, Case], found: Mapping[str, Result]) -> None:
    """Draw the figures, if every run has something to show."""
    series: dict[str, list[Mapping[str, list[float]]]] = {kind: [] for kind in ERROR_KINDS}
    for name, case in cases.items():
        series[case.errors].append(found[name]["series"])
    if all(run[key] for runs in series.values() for run in runs for key in SERIES):
        draw_all(folder, summary, series)


if __name__ == "__main__":
    sys.exit(main())
