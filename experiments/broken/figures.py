"""What came of each kind of fault, and how soon the filter was right again, drawn for print."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from matplotlib.axes import Axes

from experiments.broken.outcome import SOON, Outcome
from experiments.broken.told import by_kind, is_right, of_size
from experiments.show.print_style import BLUE, FAINT, GRID, INK, ORANGE, PAGE, panels, save, style, title

# How faults are named for people.
WORDS = {
    "slip": "wheel slip",
    "kidnap": "kidnapping",
    "start": "wrong start",
    "compass": "bad compass",
    "swap": "markers exchanged",
    "misread": "misread marker",
    "biased": "biased camera",
    "moved": "landmark moved",
}
THICK, THIN = 0.5, 0.16  # of bars: large faults and small ones
UNDER = 0.38  # small ones are so far below [rows]
LATE = SOON + 2  # where those are drawn that are right later than that, or never


def draw_faults(folder: Path, outcomes: Sequence[Outcome]) -> None:
    """Draw `faults.png`: shares of what came of faults, by kind, and the good frames until the filter was right."""
    kinds = by_kind(outcomes)
    with style():
        figure, (left, right) = panels(1, 2, PAGE, 0.7 + 0.36 * len(kinds), sharey=True, width_ratios=(3, 2))
        for row, some in enumerate(kinds.values()):
            _bar(left, row, of_size(some, below=False), THICK)
            _bar(left, row + UNDER, of_size(some, below=True), THIN)
            _frames(right, row, of_size(some, below=False))
        title(left, "a", "what came of it: large faults, and below them small ones")
        title(right, "b", "good frames until right (large)")
        left.set(xlim=(0, 1), xlabel="share of the episodes", ylim=(len(kinds) - 0.4, -0.5))
        left.set_yticks(range(len(kinds)), [WORDS[kind] for kind in kinds])
        left.xaxis.set_major_formatter(lambda value, _: f"{100 * value:.0f} %")
        right.set(xlim=(-0.7, LATE + 0.7))
        right.set_xticks([*range(0, SOON + 1, 2), LATE], [*map(str, range(0, SOON + 1, 2)), "later,\nnever"])
        right.axvspan(SOON + 1, LATE + 0.7, color=GRID, zorder=0)
        for axes in (left, right):
            axes.grid(visible=False, axis="y")
            axes.tick_params(axis="y", length=0)
        handles = [left.bar(0, 0, color=colour, label=name) for name, colour in LEGEND.items()]
        figure.legend(handles=handles, loc="outside lower center", ncols=3, columnspacing=1.6)
        save(figure, folder, "faults")


RIGHT = "right soon, and in the end"
HONEST = "not right soon: suspended, or named too late"
WRONG = "outside while said to be in force"
LEGEND = {RIGHT: BLUE, HONEST: "#c4c9d0", WRONG: ORANGE}


def fate(outcome: Outcome) -> str:
    """Return what came of an episode; one that was outside while in force when that could be known is wrong, right or not."""
    if outcome.outside_in_force:
        return WRONG
    return RIGHT if is_right(outcome) else HONEST


def _bar(axes: Axes, row: float, outcomes: Sequence[Outcome], thickness: float) -> None:
    left = 0.0
    for name, colour in LEGEND.items():
        count = sum(fate(outcome) == name for outcome in outcomes)
        width = count / max(1, len(outcomes))
        axes.barh(row, width, thickness, left, color=colour)
        if count and thickness == THICK:
            ink = INK if name == HONEST else "white"
            axes.text(left + width / 2, row, str(count), color=ink, ha="center", va="center", fontsize=7)
        left += width


def _frames(axes: Axes, row: int, outcomes: Sequence[Outcome]) -> None:
    """Draw a dot for each number of frames, its area in proportion to the episodes."""
    soon = [outcome.first_right if is_right(outcome) and outcome.first_right is not None else LATE for outcome in outcomes]
    frames, counts = np.unique(soon, return_counts=True)
    colours = [BLUE if frame < LATE else FAINT for frame in frames]
    axes.scatter(frames, np.full(len(frames), row), 140 * counts / max(1, len(soon)), color=colours, zorder=3, linewidth=0)
