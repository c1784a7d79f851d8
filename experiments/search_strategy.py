"""The paper's search strategy on many random formations: adaptive against uniform directions, and its worst cases.

Figures 8, 11 and 14 of the paper, Lemma 7.2 and the promise that ends its section 7. Run
`python -m experiments.search_strategy --help`. The exit code is the guarantee: 0 only if no robot was outside its outer
polygon; 1 otherwise; 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, rounded
from experiments.paper.formations import Formation, draw_formation
from experiments.paper.recording import record_searches
from experiments.paper.search_curves import SEARCHES, Curves, curves_of
from experiments.paper.search_figures import PROMISES, draw_convergence, draw_searches, draw_worst_case, gaps, ratios
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Counting, print_table, show_table
from filter import Array, InvalidInput

LEAST_ROBOTS = 5
SAMPLE = 12  # robots of the paper's sample formation
PRINTED = (4, 5, 6, 7, 8, 10, 12, 15, 20, 25, 30)  # searches


@dataclass(frozen=True)
class Options:
    """Search the regions of many random formations, adaptively and by uniform directions.

    Exit code 0 only if no robot was outside its outer polygon; 1 otherwise; 2 for bad input.
    """

    formations: int = 200
    """Number of formations."""
    robots: tuple[int, int] = (5, 20)
    """Least and greatest number of robots of a formation."""
    bearing_bound: float = 5.0
    """Largest error of a bearing [degrees]."""
    seed: int = 0
    """Where all randomness comes from: the same seed, the same formations."""
    out: Path = Path("runs/search_strategy")
    """Folder for summary, figures and recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("search_strategy", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        InvalidInput: An option or the output folder cannot be used.
    """
    least, greatest = options.robots
    keep_within(options, formations=(1, np.inf))
    if not LEAST_ROBOTS <= least <= greatest:
        raise InvalidInput(f"a least number of robots from {LEAST_ROBOTS} on, and a greatest", f"{least} and {greatest}")
    folder = output_folder(options.out)
    formations, curves = search_all(options)
    summary = summary_of(options, formations, curves)
    write_summary(folder, summary)
    draw_convergence(folder, curves)
    draw_worst_case(folder, curves)
    hardest = hardest_of(curves)
    of_hardest = formations[curves[hardest].formation]
    draw_searches(folder, of_hardest, curves[hardest].robot)
    record_searches(folder / "search_strategy.rrd", of_hardest, {"frame of robot 0": of_hardest.anchors([0])})
    print_curves(curves)
    print_table(f"search_strategy, in {folder}", {key: value for key, value in summary.items() if not isinstance(value, list)})
    return int(summary["escapes"] != 0)


def search_all(options: Options) -> tuple[list[Formation], list[Curves]]:
    """Return the formations, and the curves of all their free robots."""
    generator = np.random.default_rng(options.seed)
    least, greatest = options.robots
    formations: list[Formation] = []
    curves: list[Curves] = []
    with Counting(options.formations, "formations") as progress:
        for number in range(options.formations):
            robots = int(generator.integers(least, greatest + 1))
            formations.append(draw_formation(generator, robots, np.radians(options.bearing_bound)))
            curves += curves_of(formations[-1], number)
            progress.advance()
    return formations, curves


def hardest_of(curves: Sequence[Curves]) -> int:
    """Return the place of the curve with the least performance ratio after twice the first four searches."""
    return int(np.argmin([ratios(each.adaptive)[4] for each in curves]))


def summary_of(options: Options, formations: Sequence[Formation], curves: Sequence[Curves]) -> dict[str, Value | list[float]]:
    """Return the run's summary; the lists are for 4, 5, ... 30 searches."""
    exact = np.array([each.area for each in curves])
    adaptive, uniform = (np.array([getattr(each, way) for each in curves]) for way in ("adaptive", "uniform"))
    ratio, gap = ratios(adaptive), gaps(adaptive, exact)
    vertices = np.array([each.vertices for each in curves])
    ended = [each.searches_to_the_end / each.vertices for each in curves if each.searches_to_the_end is not None]
    sample = ratio[[each.robots == SAMPLE for each in curves]]
    return {
        "formations": len(formations),
        "formations_redrawn": sum(formation.redrawn for formation in formations),
        "robots_min": min(map(len, formations)),
        "robots_max": max(map(len, formations)),
        "seed": options.seed,
        "bearing_bound_deg": options.bearing_bound,
        "variables": max(each.variables for each in curves),
        "projections": len(curves),
        "escapes": sum(each.escaped for each in curves),
        **{f"worst_after_{searches}": _digits(ratio.min(axis=0))[searches - SEARCHES[0]] for searches, _ in PROMISES},
        "promises_kept": all(ratio.min(axis=0)[searches - SEARCHES[0]] >= promised for searches, promised in PROMISES),
        "area_gap_bound_max": rounded(float((gap * SEARCHES**2).max())),
        "vertices_mean": rounded(float(vertices.mean())),
        "vertices_max": int(vertices.max()),
        "searches_over_vertices_max": rounded(max(ended)),
        "searches_to_the_end_unfinished": len(curves) - len(ended),
        "proved_ratio_shortfall_max": float(f"{max(_shortfalls(curves, ratio)):.1g}"),
        "adaptive_pr_mean": _digits(ratio.mean(axis=0)),
        "adaptive_pr_worst": _digits(ratio.min(axis=0)),
        f"adaptive_pr_mean_{SAMPLE}_robots": _digits(sample.mean(axis=0)) if len(sample) else None,
        "uniform_pr_mean": _digits(ratios(uniform).mean(axis=0)),
        "uniform_pr_worst": _digits(ratios(uniform).min(axis=0)),
        "adaptive_area_gap_mean": _digits(gap.mean(axis=0)),
        "uniform_area_gap_mean": _digits(gaps(uniform, exact).mean(axis=0)),
    }


def _shortfalls(curves: Sequence[Curves], ratio: Array) -> list[float]:
    """Return by how much the ratio that is proved after the last search is less than that of the solver's areas."""
    return [float(last - each.performance_ratio) for each, last in zip(curves, ratio[:, -1], strict=True)]


def _digits(values: Array) -> list[float]:
    return [rounded(float(value)) for value in values]


def print_curves(curves: Sequence[Curves]) -> None:
    """Print the performance ratios after some numbers of searches."""
    adaptive, uniform = (ratios(np.array([getattr(each, way) for each in curves])) for way in ("adaptive", "uniform"))
    columns = (adaptive.mean(axis=0), adaptive.min(axis=0), uniform.mean(axis=0), uniform.min(axis=0))
    names = ("largest triangle: mean", "worst", "uniform: mean", "worst")
    table = Table("searches", *names, title="performance ratio", title_justify="left")
    for searches in PRINTED:
        table.add_row(str(searches), *(f"{column[searches - SEARCHES[0]]:.3f}" for column in columns))
    for column in table.columns:
        column.justify = "right"
    show_table(table)


if __name__ == "__main__":
    sys.exit(main())
