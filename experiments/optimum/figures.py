"""The tightness experiment's figures."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure

from experiments.against_ekf.figures import BARE, FAINT, INK, LOOK, SETS, TUNED
from experiments.optimum.runs import DEFAULT, Followed, Optimum

GOAL = 1.05  # of the mean ratio


def draw_over_time(folder: Path, runs: Mapping[str, Followed], optima: Sequence[Optimum], rate: float) -> None:
    """Draw `over_time.png`: area over that of the whole history, and the areas themselves, over time."""
    times = np.array([each.step for each in optima]) / rate
    best = np.array([each.inner_areas for each in optima])
    default = runs[DEFAULT]
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(11.0, 4.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        own = default.areas[[each.step for each in optima]] / best
        left.fill_between(times, own.min(axis=1), own.max(axis=1), color=SETS, alpha=0.15, linewidth=0, label="its robots")
        left.plot(times, own.mean(axis=1), color=SETS, linewidth=2, label=f"filter, {DEFAULT} rows")
        if "window" in runs:
            windows = runs["window"].areas[[each.step for each in optima]] / best
            left.plot(times, windows.mean(axis=1), color=TUNED, linewidth=1.5, label="in windows")
        left.axhline(1.0, color=INK, linewidth=1)
        left.set(title="Area over that of the whole history's optimum", xlabel="time [s]", ylim=(0.98, None))
        left.legend(loc="upper left")
        for robot in range(best.shape[1]):
            right.plot(times, best[:, robot], "o", color=TUNED, markersize=4, label="optimum" if robot == 0 else None)
            right.plot(
                np.arange(len(default.areas)) / rate,
                default.areas[:, robot],
                color=SETS,
                linewidth=0.9,
                label="filter" if robot == 0 else None,
            )
        right.set(title="Area of each robot's region [m²]", xlabel="time [s]", yscale="log")
        right.legend(loc="upper right")
        figure.savefig(folder / "over_time.png")


def draw_budgets(folder: Path, runs: Mapping[str, Followed], optima: Sequence[Optimum]) -> None:
    """Draw `budgets.png`: area over that of the whole history, and time, for each budget of rows."""
    steps = [each.step for each in optima]
    best = np.array([each.inner_areas for each in optima])
    found = {name: run.areas[steps] / best for name, run in runs.items()}
    at = np.arange(len(runs))
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(11.0, 4.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        for label, colour, values in (
            ("mean", SETS, [each.mean() for each in found.values()]),
            ("95 %", BARE, [np.quantile(each, 0.95) for each in found.values()]),
        ):
            left.plot(at, np.array(values), "o-", color=colour, linewidth=1.8, label=label)
        left.axhline(GOAL, color=FAINT, linewidth=1, linestyle=(0, (4, 2)))
        left.set(title="Area over that of the whole history's optimum", ylim=(1.0, None))
        left.legend(loc="upper right")
        bars = right.bar(at, [run.step_median_ms for run in runs.values()], 0.7, color=SETS)
        right.bar_label(bars, fmt="%.0f", padding=2, fontsize=8, color=INK)
        right.set(title="Median step [ms]")
        for axes in (left, right):
            axes.set_xticks(at, list(runs))
            axes.set_xlabel("rows kept for each robot / each pair")
        figure.savefig(folder / "budgets.png")
