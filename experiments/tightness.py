"""How much do the filter's regions lose by forgetting? Against the linear program over the entire history of the same run.

Run `python -m experiments.tightness --help`. The exit code is the guarantee: 0 only if no robot was outside its region, the
filter's or the optimum's; 1 otherwise; 2 for bad input. How it is done, and what came out, is in docs/performance.md.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from concurrent.futures import Future, as_completed
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from rich.table import Table

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, rounded
from experiments.following.side_by_side import Case
from experiments.optimum.figures import draw_budgets, draw_over_time
from experiments.optimum.history import TANGENTS
from experiments.optimum.runs import BUDGETS, DEFAULT, Followed, Optimum, Variant, follow, optimum_at
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Counting, print_table, show_table, tell, too_short
from experiments.sweep.executors import executor
from filter import Array, InvalidInput, Stop
from sim.errors import ErrorKind

ENOUGH = 20.0  # seconds: what is forgotten costs nothing before there is anything to forget
SEARCHES = 64  # at most, of an optimum


@dataclass(frozen=True)
class Options:
    """Hold the filter's regions against those of a linear program in which all past positions are variables.

    Exit code 0 only if no robot was outside its region, the filter's or the optimum's; 1 otherwise; 2 for bad input.
    """

    robots: int = 6
    """Number of robots."""
    duration: float = 20.0
    """How long the run is [s]."""
    rate: float = 10.0
    """Steps a second [Hz]."""
    seed: int = 0
    """Where all randomness comes from."""
    errors: ErrorKind = "uniform"
    """Kind of the sensors' errors, always within their bounds."""
    every: int = 20
    """The optimum is found at every so many steps."""
    tangents: int = TANGENTS
    """Half-planes evenly around each displacement set in the optimum."""
    performance_ratio: float = 0.999
    """How exactly the optimum is found: inner over outer area, below 1; the ratios are of the inner area."""
    tangent_spacing: float = 30.0
    """Greatest angle between the tangents of a range, in the filter and in the optimum [degrees]."""
    alone: bool = False
    """Leave out the filters with other budgets, those that take less along, and the windows."""
    workers: int | None = None
    """Processes; as many as there are cores if not given."""
    out: Path = Path("runs/tightness")
    """Folder for summary and figures."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("tightness", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option or the output folder cannot be used.
    """
    check(options)
    folder = output_folder(options.out)
    runs, optima = compute(options)
    conflicts = [each.conflict for each in runs.values() if each.conflict is not None]
    if conflicts or any(not each.outers for each in optima):
        tell(f"records exclude one another: {'; '.join(conflicts) or 'the whole history'}")
        return 1
    summary = summary_of(options, runs, optima)
    summary["too_short"] = too_short("what the budgets and windows cost", seconds=(options.duration, ENOUGH))
    write_summary(folder, summary)
    draw_over_time(folder, runs, optima, options.rate)
    if not options.alone:
        draw_budgets(folder, {name: runs[name] for name in BUDGETS}, optima)
    print_runs(runs, optima)
    print_table(f"tightness, in {folder}", {key: value for key, value in summary.items() if not isinstance(value, list)})
    return int(summary["escapes"] != 0)


def check(options: Options) -> None:
    """Raise `InvalidInput` for options that cannot be used."""
    keep_within(options, every=(1, np.inf), tangents=(4, np.inf), performance_ratio=(0.5, 0.9999))
    if round(options.duration * options.rate) < options.every:
        raise InvalidInput(f"a duration of at least {options.every} steps", f"{options.duration!r} s")
    case_of(options).scenario()  # refuses what the simulator cannot do


def case_of(options: Options) -> Case:
    """Return the run that the options ask for."""
    return Case(options.errors, options.seed, options.robots, options.duration, options.rate)


def compute(options: Options) -> tuple[dict[str, Followed], list[Optimum]]:
    """Return what each variant of the filter made of the run, and the sampled optima."""
    case, spacing = case_of(options), float(np.radians(options.tangent_spacing))
    steps = range(options.every - 1, round(options.duration * options.rate), options.every)
    budgets = [DEFAULT] if options.alone else list(BUDGETS)
    variants = {name: Variant(*BUDGETS[name], spacing) for name in budgets}
    if not options.alone:
        variants["window"] = Variant(*BUDGETS[DEFAULT], spacing, window=True)
        variants["without pairs"] = Variant(*BUDGETS[DEFAULT], spacing, pairs=False)
        variants["without corners"] = Variant(*BUDGETS[DEFAULT], spacing, corners=False)
    stop = Stop(options.performance_ratio, 0.0, SEARCHES)
    with executor(options.workers) as pool, Counting(len(variants) + len(steps), "runs and optima") as progress:
        first = pool.submit(follow, case, variants.pop(DEFAULT), options.tangents)
        others = {name: pool.submit(follow, case, variant) for name, variant in variants.items()}
        history = first.result().history
        optima = {step: pool.submit(optimum_at, history, step, stop) for step in reversed(steps)} if history else {}
        every: list[Future[Any]] = [first, *others.values(), *optima.values()]
        for future in as_completed(every):
            future.result()  # raises what it raised
            progress.advance()
    runs = {name: future.result() for name, future in {**others, DEFAULT: first}.items()}
    order = [name for name in (*BUDGETS, "window", "without pairs", "without corners") if name in runs]
    return {name: runs[name] for name in order}, [optima[step].result() for step in sorted(optima)]


def ratios(followed: Followed, optima: Sequence[Optimum]) -> Array:
    """Return (k, n) of each sampled step and robot the area of the filter's region over that of the optimum, at most.

    At most, as the optimum's inner polygon is taken.
    """
    return np.array([followed.areas[each.step] / each.inner_areas for each in optima])


def summary_of(options: Options, runs: dict[str, Followed], optima: Sequence[Optimum]) -> dict[str, Value | list[float]]:
    """Return the run's summary; the lists are for the budgets in turn."""
    default = runs[DEFAULT]
    found, own = ratios(default, optima), np.array([default.areas[each.step] for each in optima])
    outside = sum(each.outside(default.truths[each.step]) for each in optima)
    budgets = {name: each for name, each in runs.items() if name in BUDGETS}
    windows = ratios(runs["window"], optima) if "window" in runs else None
    return {
        "robots": options.robots,
        "duration_s": options.duration,
        "rate_hz": options.rate,
        "seed": options.seed,
        "errors": options.errors,
        "tangents": options.tangents,
        "tangent_spacing_deg": options.tangent_spacing,
        "checks": sum(each.areas.size for each in runs.values()) + found.size,
        "escapes": sum(each.escapes for each in runs.values()) + outside,
        "escapes_of_optimum": outside,
        "samples": found.size,
        "area_ratio_mean": rounded(float(found.mean())),
        "area_ratio_median": rounded(float(np.median(found))),
        "area_ratio_p95": rounded(float(np.quantile(found, 0.95))),
        "area_ratio_max": rounded(float(found.max())),
        "area_ratio_mean_at_least": rounded(float((own / np.array([each.outer_areas for each in optima])).mean())),
        "area_ratio_of_sums": rounded(float(np.sum(own) / np.sum([each.inner_areas for each in optima]))),
        "optimum_beyond_filter_max_m": rounded(max(each.beyond(default.outers[each.step]) for each in optima)),
        "window_area_ratio_mean": None if windows is None else rounded(float(windows.mean())),
        "window_area_ratio_p95": None if windows is None else rounded(float(np.quantile(windows, 0.95))),
        **{
            f"{name.replace(' ', '_')}_area_ratio_mean": rounded(float(ratios(runs[name], optima).mean()))
            for name in ("without pairs", "without corners")
            if name in runs
        },
        "optimum_variables_max": max(each.variables for each in optima),
        "optimum_rows_max": max(each.rows for each in optima),
        "optimum_searches_mean": rounded(float(np.mean([each.searches for each in optima]))),
        "optimum_last_s": rounded(optima[-1].seconds),
        "budget_rows_per_robot": [float(BUDGETS[name][0]) for name in budgets],
        "budget_rows_per_pair": [float(BUDGETS[name][1]) for name in budgets],
        "budget_area_ratio_mean": [rounded(float(ratios(each, optima).mean())) for each in budgets.values()],
        "budget_area_ratio_p95": [rounded(float(np.quantile(ratios(each, optima), 0.95))) for each in budgets.values()],
        "budget_step_median_ms": [rounded(each.step_median_ms) for each in budgets.values()],
        "area_ratio_mean_of_step": [rounded(float(value)) for value in found.mean(axis=1)],
    }


def print_runs(runs: dict[str, Followed], optima: Sequence[Optimum]) -> None:
    """Print what each variant of the filter is worth, and what it costs."""
    names = ("rows a robot/a pair", "area ratio: mean", "95 %", "greatest", "rows", "step [ms]", "escapes")
    table = Table(*names, title="the filter's area over that of the whole history", title_justify="left")
    for name, each in runs.items():
        found = ratios(each, optima)
        values = (found.mean(), np.quantile(found, 0.95), found.max())
        table.add_row(
            name, *(f"{value:.4f}" for value in values), str(each.rows_max), f"{each.step_median_ms:.1f}", str(each.escapes)
        )
    for column in table.columns[1:]:
        column.justify = "right"
    show_table(table)


if __name__ == "__main__":
    sys.exit(main())
