"""How figures that reproduce the paper's look: set for print, in its columns' widths."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import matplotlib as mpl
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.show.colours import PALETTE

COLUMN, PAGE = 3.45, 7.1  # widths [inch]
BLUE, ORANGE, GREEN, PINK, AMBER, SKY = ("#{:02x}{:02x}{:02x}".format(*colour) for colour in PALETTE)
INK, FAINT, GRID = "#1f2328", "#8a919c", "#e6e8eb"
STYLE: dict[Any, Any] = {
    "font.family": "STIXGeneral",
    "mathtext.fontset": "stix",
    "font.size": 9,
    "axes.titlesize": 9,
    "axes.labelsize": 9,
    "legend.fontsize": 8,
    "xtick.labelsize": 8,
    "ytick.labelsize": 8,
    "axes.linewidth": 0.6,
    "axes.edgecolor": INK,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.axisbelow": True,
    "axes.grid": True,
    "grid.color": GRID,
    "grid.linewidth": 0.5,
    "xtick.major.width": 0.6,
    "ytick.major.width": 0.6,
    "lines.linewidth": 1.3,
    "lines.markersize": 4,
    "legend.frameon": False,
    "figure.dpi": 300,
    "savefig.bbox": "tight",
    "savefig.pad_inches": 0.03,
}


def style() -> Any:
    """Return a context in which figures have this look."""
    return mpl.rc_context(STYLE)


def panels(rows: int, columns: int, width: float, height: float, **options: Any) -> tuple[Figure, list[Axes]]:
    """Return a figure of so many inches and its axes, row by row."""
    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, list(figure.subplots(rows, columns, squeeze=False, **options).ravel())


def save(figure: Figure, folder: Path, name: str) -> None:
    """Write the figure as PNG."""
    figure.savefig(folder / f"{name}.png")


def title(axes: Axes, letter: str, words: str) -> None:
    """Name a panel as papers do."""
    axes.set_title(f"({letter}) {words}", loc="left")
