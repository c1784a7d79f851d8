"""Figures 3, 12 and 13 of the paper, and relative positions, drawn for print."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.axes import Axes
from matplotlib.lines import Line2D
from matplotlib.patches import Patch
from matplotlib.patheffects import withStroke

from experiments.paper.frames import Localized, Relative
from experiments.paper.range_sector import least_overestimate, overestimate, polygon_of_rows
from experiments.show.print_style import AMBER, BLUE, FAINT, GREEN, INK, ORANGE, PAGE, PINK, SKY, panels, save, style, title
from filter.arrays import Array
from filter.geometry.polygon import Polygon

LETTERS = "abcdefgh"
EXAMPLES = ((0.05, 5.0), (0.05, 10.0), (0.10, 5.0), (0.10, 10.0))  # range error, bearing error [deg]: those of Fig. 3
WIDEST = 20.0  # bearing error that curves go to [deg]
THINNEST = 1e-6  # regions below this area are drawn as lines [m2]
APART = 7.0  # of a robot's number [points]


def draw_frames(folder: Path, frames: Sequence[Localized]) -> None:
    """Draw `frames.png`: the same formation from one robot's frame after the other (Figs. 12 and 13)."""
    with style():
        figure, axes = panels(1, len(frames), PAGE, 3.9 if len(frames) > 1 else 5.6)
        for panel, letter, localized in zip(axes, LETTERS, frames, strict=False):
            several = "s" * (len(localized.references) > 1)
            title(panel, letter, f"relative to robot{several} {', '.join(map(str, localized.references))}")
            _formation(panel, localized)
        _same_size(axes)
        figure.legend(handles=_legend(), loc="outside lower center", ncols=5, columnspacing=1.2, handletextpad=0.4)
        save(figure, folder, "frames")


def _formation(axes: Axes, localized: Localized) -> None:
    positions, seen = localized.formation.positions, localized.formation.bearings
    for robot, target in {(min(pair), max(pair)) for pair in zip(seen.robot.tolist(), seen.target.tolist(), strict=True)}:
        axes.plot(*positions[[robot, target]].T, color="#d5d9de", linewidth=0.5, zorder=1)
    for robot, region in enumerate(localized.belief.regions):
        _region(axes, region.outer)
        if np.isnan(localized.anchors[robot]).all():
            axes.plot(*region.outer.centroid, "*", color=ORANGE, markersize=5.5, markeredgewidth=0, zorder=5)
        _number(axes, robot, positions[robot], region.outer.centroid)
    anchored = (~np.isnan(localized.anchors)).sum(axis=1)
    for count, marker in ((0, "o"), (1, "D"), (2, "s")):
        axes.plot(*positions[anchored == count].T, **_truth(marker))
    axes.set(aspect="equal", xlabel="x [m]", ylabel="y [m]")


def _region(axes: Axes, outer: Polygon) -> None:
    width = 1.0 if outer.area > THINNEST else 1.6
    axes.fill(*outer.vertices.T, facecolor=SKY + "4d", edgecolor=BLUE, linewidth=width, joinstyle="round", zorder=3)


def _number(axes: Axes, robot: int, place: Array, centroid: Array) -> None:
    """Write a robot's number beside it, on the side away from its region's centroid."""
    away = place - centroid
    size = float(np.hypot(*away))
    x, y = APART * (away / size if size > THINNEST else np.array([0.7, 0.7]))
    halo = [withStroke(linewidth=1.6, foreground="white")]
    words = {"fontsize": 7, "ha": "center", "va": "center", "zorder": 7, "path_effects": halo}
    axes.annotate(str(robot), place, (x, y), textcoords="offset points", **words)  # type: ignore[arg-type]


def _same_size(several: Sequence[Axes]) -> None:
    """Give panels the same scale, each with its own middle."""
    limits = np.array([[panel.get_xlim(), panel.get_ylim()] for panel in several])
    middle, half = limits.mean(axis=2), np.ptp(limits, axis=2).max(axis=0) / 2
    for panel, (x, y) in zip(several, middle, strict=True):
        panel.set(xlim=(x - half[0], x + half[0]), ylim=(y - half[1], y + half[1]))


def _truth(marker: str) -> dict[str, Any]:
    return {
        "marker": marker,
        "linestyle": "none",
        "markerfacecolor": "white",
        "markeredgecolor": INK,
        "markeredgewidth": 0.9,
        "markersize": 4.2,
        "zorder": 6,
    }


def _legend() -> list[Line2D | Patch]:
    return [
        Patch(facecolor=SKY + "4d", edgecolor=BLUE, label="outer polygon"),
        Line2D([], [], label="robot", **_truth("o")),
        Line2D([], [], label="reference", **_truth("s")),
        Line2D([], [], label="one coordinate anchored", **_truth("D")),
        Line2D([], [], color=ORANGE, marker="*", linestyle="none", markersize=6, markeredgewidth=0, label="centroid"),
    ]


def draw_relative(folder: Path, localized: Localized, relatives: Sequence[Relative]) -> None:
    """Draw `relative.png`: regions of x_i - x_j, each with the region of x_i in the common frame at the same size."""
    with style():
        figure, axes = panels(1, len(relatives), PAGE, 2.9)
        for panel, letter, relative in zip(axes, LETTERS, relatives, strict=False):
            i, j = relative.robot, relative.other
            title(panel, letter, f"robot {i} as seen from robot {j}")
            place = localized.formation.positions[i]
            common = localized.belief.regions[i].outer.vertices - place + relative.truth
            panel.fill(*common.T, facecolor="none", edgecolor=FAINT, linewidth=0.9, linestyle=(0, (4, 2)), zorder=2)
            _region(panel, relative.region.outer)
            panel.plot(*relative.region.outer.centroid, "*", color=ORANGE, markersize=6, markeredgewidth=0, zorder=5)
            panel.plot(*relative.truth, **_truth("o"))
            panel.set(aspect="equal", xlabel=f"$x_{{{i}}} - x_{{{j}}}$ [m]", ylabel=f"$y_{{{i}}} - y_{{{j}}}$ [m]")
            panel.set_adjustable("datalim")
        dashed = Line2D(
            [], [], color=FAINT, linewidth=0.9, linestyle=(0, (4, 2)), label="its region in the common frame, moved here"
        )
        region, robot, *_, centroid = _legend()
        figure.legend(handles=[region, dashed, robot, centroid], loc="outside lower center", ncols=4)
        save(figure, folder, "relative")


def draw_range_bearing(folder: Path) -> None:
    """Draw `range_bearing.png`: a range and bearing as a polygon, what it adds, and what more tangents gain (Fig. 3)."""
    with style():
        figure, axes = panels(2, 3, PAGE, 4.7)
        order = [axes[0], axes[1], axes[3], axes[4]]
        for panel, letter, (range_error, degrees) in zip(order, "abde", EXAMPLES, strict=True):
            _example(panel, letter, range_error, degrees)
        _overestimates(axes[2])
        _tangents(axes[5])
        save(figure, folder, "range_bearing")


def _example(axes: Axes, letter: str, range_error: float, degrees: float) -> None:
    half = np.radians(degrees)
    share = float(overestimate(range_error, half)) - 1
    title(axes, letter, f"$\\pm${range_error:.0%}, $\\pm${degrees:g}°: +{share:.1%} area")
    turn = np.linspace(-half, half, 60)
    circle = np.stack([np.cos(turn), np.sin(turn)])
    sector = np.concatenate([(1 + range_error) * circle, (1 - range_error) * circle[:, ::-1]], axis=1)
    polygon = polygon_of_rows(range_error, half).vertices
    axes.fill(*polygon.T, facecolor=ORANGE + "80", edgecolor=ORANGE, linewidth=1.0, label=r"polygon $\hat U$")
    axes.fill(*sector, facecolor="white", edgecolor="none")
    axes.fill(*sector, facecolor=SKY + "66", edgecolor=BLUE, linewidth=0.8, label="sector $U$")
    axes.set(aspect="equal", xlim=(0.86, 1.16), ylim=(-0.22, 0.22), xlabel="along the bearing [m]", ylabel="across [m]")
    if letter == "a":
        axes.legend(loc="upper left", borderaxespad=0.2, handlelength=1.2)


def _overestimates(axes: Axes) -> None:
    degrees = np.linspace(0.1, WIDEST, 200)
    for range_error, colour in ((0.02, PINK), (0.05, ORANGE), (0.10, BLUE), (0.20, GREEN)):
        axes.plot(degrees, overestimate(range_error, np.radians(degrees)), color=colour, label=f"$\\pm${range_error:.0%}")
    title(axes, "c", "one tangent: the paper's formula")
    axes.set(xlabel="bearing error ± [deg]", ylabel=r"Area$(\hat U)$ / Area$(U)$", xlim=(0, WIDEST), ylim=(1, 3))
    axes.legend(title="range error", loc="upper left", title_fontsize=8, handlelength=1.4, labelspacing=0.25)


def _tangents(axes: Axes) -> None:
    degrees = np.linspace(0.1, WIDEST, 200)
    for tangents, colour in ((1, ORANGE), (2, BLUE), (3, GREEN)):
        rows = f"{tangents} tangent{'s' * (tangents > 1)}, {tangents + 3} rows"
        axes.plot(degrees, overestimate(0.05, np.radians(degrees), tangents), color=colour, label=rows)
    hull = least_overestimate(0.05, np.radians(degrees))
    axes.plot(degrees, hull, color=AMBER, linestyle=(0, (4, 2)), label="any number: the hull")
    title(axes, "f", "more tangents, range $\\pm$5%")
    axes.set(xlabel="bearing error ± [deg]", ylabel=r"Area$(\hat U)$ / Area$(U)$", xlim=(0, WIDEST), ylim=(1, 2))
    axes.legend(loc="upper left", handlelength=1.4, labelspacing=0.25)
