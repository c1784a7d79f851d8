"""What a step takes, and how much memory, over the size of the team."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FixedLocator, FuncFormatter, NullLocator

from experiments.against_ekf.figures import FAINT, LOOK, SETS, TUNED
from experiments.growth.size import Size

REAL_TIME = 100.0  # a step at 10 Hz [ms]


def draw_scaling(folder: Path, sizes: Sequence[Size]) -> None:
    """Draw `scaling.png`: time and memory over the number of robots, on logarithmic scales."""
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(11.0, 4.6), layout="constrained")
        left, right = figure.subplots(1, 2)
        _times(left, sizes)
        _memory(right, sizes)
        figure.savefig(folder / "scaling.png")


def _times(axes: Axes, sizes: Sequence[Size]) -> None:
    robots, median = _known(sizes, "step_median_ms")
    axes.fill_between(robots, median, _known(sizes, "step_p95_ms")[1], color=SETS, alpha=0.2)
    axes.plot(robots, median, "o-", color=SETS, label="Corral, in windows; up to 95 % shaded")
    axes.plot(*_known(sizes, "ekf_step_median_ms"), "s-", color=TUNED, label="joint extended Kalman filter")
    axes.axhline(REAL_TIME, color=FAINT, linewidth=1, linestyle="--", label="10 steps a second")
    axes.set(title="Time of a step [ms]", yscale="log")
    _robots(axes, sizes)
    axes.legend(loc="upper left")


def _memory(axes: Axes, sizes: Sequence[Size]) -> None:
    axes.plot(*_known(sizes, "memory_mib"), "o-", color=SETS)
    axes.set(title="Memory of the whole process, simulator included [MiB]", ylim=(0, None))
    _robots(axes, sizes)


def _known(sizes: Sequence[Size], key: str) -> tuple[list[int], list[float]]:
    """Return the sizes of which a quantity is known, and the quantity."""
    known = [size for size in sizes if getattr(size, key) is not None]
    return [size.robots for size in known], [getattr(size, key) for size in known]


def _robots(axes: Axes, sizes: Sequence[Size]) -> None:
    axes.set(xscale="log", xlabel="robots")
    axes.xaxis.set_major_locator(FixedLocator([size.robots for size in sizes]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.xaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
    axes.grid(visible=True, axis="both")
