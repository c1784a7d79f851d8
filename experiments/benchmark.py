"""What does one exact projection cost, and is it right? Side by side with other ways, in one run, as ratios.

Run `python -m experiments.benchmark --help`, or `make bench`. The exit code is 0 only if every edge that the compiled walk
proved agrees with PIQP's support; 1 otherwise; 2 for bad input. What came out is in docs/performance.md.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, rounded
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Counting, print_table, show_table, tell, too_short
from experiments.sweep.own_process import in_own_process
from experiments.sweep.timing import medians
from experiments.timed.agreement import Agreement, Shares, agreement_of, shares_of
from experiments.timed.figures import draw_ratios
from experiments.timed.grids import draw_grid
from experiments.timed.ways import POLYTOPE, SEARCH, Problem, by_kernel, ways

AGREED = 1e-8  # [m]
ENOUGH = 30  # windows timed: with fewer, a busy second of the machine decides
REPEATS = {"piqp_solve": 5, "highs_warm_solve": 5, "kernel": 3}  # of each way in each window; of the others one


@dataclass(frozen=True)
class Options:
    """Time one projection of a window by several ways, and hold the compiled walk against PIQP in many windows.

    Exit code 0 only if every edge agrees with PIQP's; 1 otherwise; 2 for bad input.
    """

    windows: int = 300
    """Windows in which every edge is held against PIQP's support."""
    timed: int = 40
    """Windows in which the ways are timed."""
    robots: int = 12
    """Robots of a window."""
    directions: int = 8
    """Edges of each window that are held against PIQP's support, evenly chosen."""
    duration: float = 5.0
    """How long the team runs whose steps are timed [s]."""
    seed: int = 0
    """Where all randomness comes from."""
    out: Path = Path("runs/benchmark")
    """Folder for summary and figure."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("benchmark", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        InvalidInput: An option or the output folder cannot be used.
    """
    some = (1, np.inf)
    keep_within(options, windows=some, timed=some, directions=some, robots=(2, np.inf), duration=(0.2, np.inf))
    folder = output_folder(options.out)
    ((times, agreement, shares),) = in_own_process(measured, options)
    summary = summary_of(options, times, agreement, shares)
    summary["too_short"] = too_short("ratios of times", windows_timed=(options.timed, ENOUGH))
    write_summary(folder, summary)
    draw_ratios(folder, times, options.robots)
    print_ways(times)
    print_table(f"benchmark, in {folder}", summary)
    if POLYTOPE not in times:
        tell("polytope was left out: it is not installed (pip install '.[bench]')")
    return int(not max(agreement.apart, agreement.above) <= AGREED)


def measured(options: Options) -> Iterator[tuple[dict[str, float], Agreement, dict[str, Shares]]]:
    """Yield, once, the median time of each way [s], how the walk and PIQP agree, and where a step's time goes."""
    generator = np.random.default_rng(options.seed)
    times, agreement = timed(options, generator), agreed(options, generator)
    yield times, agreement, {scope: shares_of(options.seed, options.duration, scope) for scope in ("team", "window")}


def drawn(options: Options, generator: np.random.Generator) -> Problem:
    """Return a window and one of its robots."""
    return Problem(draw_grid(generator, options.robots), int(generator.integers(options.robots)))


def timed(options: Options, generator: np.random.Generator) -> dict[str, float]:
    """Return the median time of each way, all of them in turn in every window [s]."""
    first = drawn(options, generator)
    by_kernel(first, first.task(SEARCH))  # compiled here, or read from the cache, outside of the timings
    with Counting(options.timed, "windows timed") as progress:
        return medians((ways(drawn(options, generator)) for _ in range(options.timed)), REPEATS, progress.advance)


def agreed(options: Options, generator: np.random.Generator) -> Agreement:
    """Return how the walk and PIQP agree in all windows."""
    with Counting(options.windows, "windows held against PIQP") as progress:
        total = Agreement()
        for _ in range(options.windows):
            total = total.joined(agreement_of(drawn(options, generator), options.directions))
            progress.advance()
    return total


def summary_of(options: Options, times: dict[str, float], agreement: Agreement, shares: dict[str, Shares]) -> dict[str, Value]:
    """Return the run's summary."""
    kernel = times["kernel"]
    outside = times.get(POLYTOPE)
    return {
        "robots": options.robots,
        "variables": 2 * options.robots,
        "seed": options.seed,
        "windows_timed": options.timed,
        **{f"{name}_median_ms": rounded(1e3 * seconds) for name, seconds in times.items()},
        "kernel_in_piqp_solves": rounded(kernel / times["piqp_solve"]),
        "kernel_in_highs_warm_solves": rounded(kernel / times["highs_warm_solve"]),
        "piqp_search_over_kernel": rounded(times["piqp_search"] / kernel),
        "highs_warm_search_over_kernel": rounded(times["highs_warm_search"] / kernel),
        "kernel_inside_over_kernel": rounded(times["kernel_inside"] / kernel),
        "polytope_over_kernel": None if outside is None else rounded(outside / kernel),
        "windows": agreement.windows,
        "edges_compared": agreement.edges,
        "edges_mean": rounded(agreement.vertices / agreement.windows),
        "agreement_max_m": rounded(agreement.apart),
        "kernel_above_piqp_bound_max_m": rounded(agreement.above),
        "kernel_below_piqp_bound_max_m": rounded(agreement.below),
        "agreement_mean_m": rounded(agreement.total / max(1, agreement.edges)),
        "fallbacks": agreement.fallbacks,
        "fallback_share": rounded(agreement.fallbacks / agreement.windows),
        **{f"step_{scope}_median_ms": rounded(1e3 * share.step) for scope, share in shares.items()},
        **{f"step_{scope}_share_not_projection": rounded(share.other) for scope, share in shares.items()},
    }


def print_ways(times: dict[str, float]) -> None:
    """Print the ways, the fastest first, in milliseconds and in kernels."""
    table = Table("way", "median [ms]", "kernels", title="one projection of a window (a solve: one direction)")
    for name, seconds in sorted(times.items(), key=lambda item: item[1]):
        table.add_row(name, f"{1e3 * seconds:.3f}", f"{seconds / times['kernel']:.2f}")
    for column in table.columns[1:]:
        column.justify = "right"
    show_table(table)


if __name__ == "__main__":
    sys.exit(main())
