"""The figures of a run with real robots."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.ticker import FuncFormatter

from experiments.against_ekf.figures import LOOK, SETS, TUNED
from experiments.real_robots.metrics import Table
from filter import Array, Mask, Team

SUSPENDED, ESCAPED, REJECTED = "#fde2c8", "#d62728", "#7c3aed"
POINTS = 4000  # of a line: more cannot be seen


def draw_all(folder: Path, table: Table, team: Team) -> None:
    """Draw `area.png` and `error.png`."""
    with mpl.rc_context(LOOK):
        area(table, team).savefig(folder / "area.png")
        error(table, team).savefig(folder / "error.png")


def area(table: Table, team: Team) -> Figure:
    """Return each robot's area over time, with the suspended intervals, the rejected measurements and the escapes."""
    figure, panels = _panels(team)
    for robot, axes in enumerate(panels):
        _line(axes, table.time, table.area[:, robot], SETS, "outer polygon")
        _line(axes, table.time, table.ekf_area[:, robot], TUNED, "EKF, 99.7 % ellipse")
        _marks(axes, table, robot)
        axes.set(yscale="log")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: f"{value:g}"))
        axes.set_ylabel(f"{team.name(robot)} [m²]")
    return _finished(figure, panels, "Area of each robot's region: smaller is better, if the truth is inside")


def error(table: Table, team: Team) -> Figure:
    """Return the error of each robot's point over time."""
    figure, panels = _panels(team)
    for robot, axes in enumerate(panels):
        _line(axes, table.time, table.error[:, robot], SETS, "polygon's centroid")
        _line(axes, table.time, table.ekf_error[:, robot], TUNED, "EKF's mean")
        _marks(axes, table, robot)
        axes.set_ylabel(f"{team.name(robot)} [m]")
        axes.set_ylim(0, None)
    return _finished(figure, panels, "Error of each robot's point: smaller is better")


def stretches(times: Array, holds: Mask) -> Iterator[tuple[float, float]]:
    """Yield beginning and end of every stretch of time in which something holds: to the first frame where it does not."""
    edges = np.diff(np.concatenate([[0], holds.astype(np.int64), [0]]))
    for begin, end in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True):
        yield float(times[begin]), float(times[min(int(end), len(times) - 1)])


def _panels(team: Team) -> tuple[Figure, list[Axes]]:
    figure = Figure(figsize=(11.0, 1.2 + 1.7 * team.robots), layout="constrained")
    return figure, list(figure.subplots(team.robots, 1, squeeze=False, sharex=True)[:, 0])


def _line(axes: Axes, times: Array, values: Array, colour: str, name: str) -> None:
    every = max(1, len(times) // POINTS)
    axes.plot(times[::every], values[::every], color=colour, linewidth=1.2, label=name)


def _marks(axes: Axes, table: Table, robot: int) -> None:
    for begin, end in stretches(table.time, table.suspended[:, robot]):
        axes.axvspan(begin, end, color=SUSPENDED, linewidth=0, zorder=0)
    rejected = table.time[table.rejected[:, robot] > 0]
    outside = table.time[table.known[:, robot] & ~table.inside[:, robot]]
    foot = axes.get_xaxis_transform()
    axes.plot(rejected, np.full(len(rejected), 0.03), "|", color=REJECTED, markersize=7, transform=foot, label="rejected")
    axes.plot(outside, np.full(len(outside), 0.97), "v", color=ESCAPED, markersize=4, transform=foot, label="truth outside")


def _finished(figure: Figure, panels: list[Axes], title: str) -> Figure:
    panels[-1].set_xlabel("time [s]")
    panels[0].set_title(title)
    shade = mpl.patches.Patch(color=SUSPENDED, label="guarantee suspended")
    handles, _ = panels[0].get_legend_handles_labels()
    figure.legend(handles=[*handles, shade], loc="outside lower center", ncols=len(handles) + 1)
    return figure
