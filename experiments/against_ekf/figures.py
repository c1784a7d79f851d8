"""The comparison's figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter, NullFormatter
from scipy.stats import chi2

from experiments.following.ellipses import DIMENSION
from experiments.following.metrics import Value
from experiments.show.colours import PALETTE
from filter import Array
from sim.errors import ERROR_KINDS

Series = Mapping[str, Sequence[Mapping[str, Sequence[float]]]]  # of each kind of errors, of each run

INK, FAINT, GRID = "#24272e", "#6b7280", "#e5e7eb"
SETS, TUNED, PALE, BARE = ("#{:02x}{:02x}{:02x}".format(*PALETTE[k]) for k in (0, 1, 4, 5))
LOOK: dict[Any, Any] = {
    "font.family": "DejaVu Sans",
    "font.size": 10,
    "axes.titlesize": 11,
    "axes.titleweight": "bold",
    "axes.titlelocation": "left",
    "axes.edgecolor": FAINT,
    "axes.labelcolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "axes.grid.axis": "y",
    "grid.color": GRID,
    "xtick.color": INK,
    "ytick.color": INK,
    "text.color": INK,
    "legend.frameon": False,
    "figure.dpi": 150,
}
BAND = 0.95  # probability of the band around a consistent filter's NEES


def draw_all(folder: Path, summary: Mapping[str, Value], series: Series) -> None:
    """Draw every figure as PNG.

    Args:
        folder: Where to.
        summary: Of the sweep.
        series: What each run of each kind of errors was like in every second.
    """
    with mpl.rc_context(LOOK):
        for name, figure in (
            ("containment", containment(summary)),
            ("area", area_over_time(summary, series)),
            ("nees", nees_over_time(series)),
            ("rmse", rmse(summary)),
        ):
            figure.savefig(folder / f"{name}.png")


def nees_band(runs: int) -> tuple[float, float]:
    """Return the band that the mean NEES over so many independent runs of a consistent filter is in, mostly."""
    low, high = chi2.ppf([(1 - BAND) / 2, (1 + BAND) / 2], DIMENSION * runs) / runs
    return float(low), float(high)


def containment(summary: Mapping[str, Value]) -> Figure:
    """Return how often the truth was inside, and how often an estimate was proved wrong, by kind of errors."""
    figure, (left, right) = _panels(2, (11.0, 4.4), width_ratios=[1.5, 1])
    held = {
        ("outer polygon", SETS): "set_containment",
        ("EKF, 99.7 % ellipse", TUNED): "ekf_containment_997",
        ("EKF, 95 % ellipse", PALE): "ekf_containment_95",
    }
    _bars(left, summary, held, lambda value: "100" if value == 1 else f"{100 * value:.3g}", 100)
    left.set(title="The truth is inside: share of robot-steps [%]", ylim=(0, 108), yticks=[0, 25, 50, 75, 100])
    wrong = {
        ("its point", TUNED): "ekf_proved_wrong_share",
        ("all of its 99.7 % ellipse", PALE): "ekf_ellipse_proved_wrong_share",
    }
    _bars(right, summary, wrong, lambda value: "0" if value == 0 else f"{100 * value:.2g}", 100)
    right.set(title="The EKF proved wrong by the polygons [%]", ylim=(0, max(1.0, right.get_ylim()[1] * 1.12)))
    return figure


def rmse(summary: Mapping[str, Value]) -> Figure:
    """Return the point errors by kind of errors, of positions and of relative ones."""
    figure, panels = _panels(2, (11.0, 4.0))
    for axes, prefix, title in zip(panels, ("", "relative_"), ("Positions", "Relative positions"), strict=True):
        bars = {("polygon's centroid", SETS): f"set_{prefix}rmse_m", ("EKF's mean", TUNED): f"ekf_{prefix}rmse_m"}
        _bars(axes, summary, bars, lambda value: f"{100 * value:.2g}", 100)
        axes.set(title=f"{title}: RMSE [cm], smaller is better", ylim=(0, axes.get_ylim()[1] * 1.12))
    return figure


def area_over_time(summary: Mapping[str, Value], series: Series) -> Figure:
    """Return the mean area of polygons and of ellipses over time, a panel for each kind of errors."""
    figure, panels = _panels(len(ERROR_KINDS), (13.0, 4.0), sharey=True)
    for axes, kind in zip(panels, ERROR_KINDS, strict=True):
        final = {}
        for key, name, colour in (
            ("set_area_m2", "outer polygon, guaranteed", SETS),
            ("ekf_area_997_m2", "EKF, 99.7 % ellipse", TUNED),
        ):
            runs = _of_runs(series, kind, key)
            seconds = np.arange(runs.shape[1]) + 0.5
            axes.fill_between(seconds, *np.quantile(runs, [0.1, 0.9], axis=0), color=colour, alpha=0.15, linewidth=0)
            axes.plot(seconds, runs.mean(axis=0), color=colour, linewidth=1.8, label=name)
            final[key] = float(runs.mean(axis=0)[-1])
        axes.set(title=kind, yscale="log", xlim=(0, None))
        axes.set_xlabel(f"time [s]\n\n{_verdict(summary, kind, final)}", fontsize=9)
        axes.grid(visible=True, axis="both")
    panels[0].set_ylabel("area of one robot's region [m²]")
    _plain_powers(panels[0])
    _legend(
        figure,
        panels[0],
        "Smaller is better, if the truth is inside. Mean over robots and runs, the middle 80 % of runs shaded",
    )
    return figure


def _verdict(summary: Mapping[str, Value], kind: str, final: Mapping[str, float]) -> str:
    """Say in words whose regions are smaller at the end, and what they hold."""
    ratio = final["set_area_m2"] / final["ekf_area_997_m2"]
    times = max(ratio, 1 / ratio)
    smaller = f"{'Ellipses' if ratio > 1 else 'Polygons'} end {times:.{0 if times >= 10 else 1}f} times smaller."
    held = [100 * float(str(summary[f"{kind}_{key}"])) for key in ("ekf_containment_997", "set_containment")]
    return f"{smaller}\nEllipses hold {held[0]:.3g} %, polygons {held[1]:.3g} %."


def nees_over_time(series: Series) -> Figure:
    """Return the EKF's normalised estimation error squared over time, with the band of a consistent filter."""
    figure, (axes,) = _panels(1, (9.0, 4.4))
    runs = max(len(series[kind]) for kind in ERROR_KINDS)
    low, high = nees_band(runs)
    axes.axhspan(low, high, color=FAINT, alpha=0.25, linewidth=0, label=f"{BAND:.0%} band of {runs} independent runs")
    axes.axhline(DIMENSION, color=FAINT, linewidth=1)
    for kind, colour in zip(ERROR_KINDS, (SETS, TUNED, PALE, BARE), strict=True):
        mean = _of_runs(series, kind, "ekf_nees").mean(axis=0)
        axes.plot(np.arange(len(mean)) + 0.5, mean, color=colour, linewidth=1.8, label=kind)
    axes.set(title="The EKF's NEES of positions: expected are 2, more is overconfident", yscale="log", xlabel="time [s]")
    axes.set_xlim(0, None)
    axes.legend(loc="upper left", bbox_to_anchor=(1.0, 1.0))
    _plain_powers(axes)
    return figure


def _panels(
    columns: int, size: tuple[float, float], sharey: bool = False, width_ratios: Sequence[float] | None = None
) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=size, layout="constrained")
    return figure, list(figure.subplots(1, columns, squeeze=False, sharey=sharey, width_ratios=width_ratios)[0])


def _bars(
    axes: Axes, summary: Mapping[str, Value], bars: Mapping[tuple[str, str], str], words: Callable[[float], str], unit: float
) -> None:
    """Draw groups of bars, one for each kind of errors, each bar with its value above."""
    width = 0.8 / len(bars)
    for place, ((name, colour), key) in enumerate(bars.items()):
        values = [float(str(summary.get(f"{kind}_{key}") or 0.0)) for kind in ERROR_KINDS]
        at = np.arange(len(ERROR_KINDS)) + (place - (len(bars) - 1) / 2) * width
        drawn = axes.bar(at, [unit * value for value in values], 0.92 * width, color=colour, label=name)
        axes.bar_label(drawn, [words(value) for value in values], padding=2, fontsize=8, color=INK)
    axes.set_xticks(np.arange(len(ERROR_KINDS)), ERROR_KINDS)
    axes.tick_params(axis="x", length=0)
    axes.legend(loc="upper center", bbox_to_anchor=(0.5, -0.1), ncols=len(bars))


def _of_runs(series: Series, kind: str, key: str) -> Array:
    """Return (runs, seconds) of a quantity, to the length of the shortest run."""
    runs = [run[key] for run in series[kind]]
    shortest = min(map(len, runs))
    return np.array([run[:shortest] for run in runs])


def _legend(figure: Figure, axes: Axes, title: str) -> None:
    handles, labels = axes.get_legend_handles_labels()
    figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), title=title, title_fontsize=9)


def _plain_powers(axes: Axes) -> None:
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_minor_formatter(NullFormatter())
