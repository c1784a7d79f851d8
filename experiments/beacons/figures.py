"""The figure: exact sets beside the filter's regions, how near they are, and what driving tells of headings."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.patches import Circle

from experiments.against_ekf.figures import BARE, FAINT, INK, LOOK, PALE, SETS, TUNED
from experiments.beacons.climbing import AtMost
from experiments.beacons.outcomes import Outcome, Verdict, rings_of, sights_of
from experiments.beacons.prices import Price
from experiments.beacons.rings import Rings
from experiments.beacons.scenes import DT
from experiments.beacons.summary import Found, of_kind, verdicts_on
from filter import Array, Mask

GOAL = 1.1  # of the ratio of areas
SHOWN = 4  # anchors around the robot of the first two panels
GRID = 400  # points along a side of what is painted
DRIVEN = {
    "moving": (SETS, "3 robots, 3 anchors"),
    "moving_known": (TUNED, "the same, headings known to ±10° at first"),
    "moving_six": (BARE, "6 robots, 2 anchors"),
}


def draw_figure(folder: Path, found: Found, prices: Sequence[Price] = ()) -> None:
    """Draw `range_only.png`: an example, one with a lie, the ratios of areas, areas and headings of those that drive."""
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(14.0, 9.6), layout="constrained")
        panels = figure.subplots(2, 3).ravel()
        for outcome, verdict in examples(found)[:1]:
            _near(panels[0], outcome, verdict)
            _with_a_lie(panels[1], outcome, verdict, [each for each in prices if each.strict is outcome])
        _sights(panels[2], verdicts_on(found, "bearings"))
        _ratios(panels[3], found)
        _over_time(panels[4], found, "areas")
        _over_time(panels[5], found, "arcs")
        for axes in panels[[0, 1, 2, 4, 5]]:
            axes.legend(*axes.get_legend_handles_labels(), loc="upper center", bbox_to_anchor=(0.5, -0.12), fontsize=9)
        figure.savefig(folder / "range_only.png")


def examples(found: Found) -> list[tuple[Outcome, Verdict]]:
    """Return those that stand alone among as many anchors as are shown."""
    return [each for each in verdicts_on(found, "alone") if len(each[0].scene.team.landmarks) == SHOWN]


def _near(axes: Axes, outcome: Outcome, verdict: Verdict) -> None:
    rings = rings_of(outcome.scene)
    _paint(axes, lambda points: rings.contains(points).all(axis=1), outcome.last[0].vertices)
    _circles(axes, rings)
    _outline(axes, outcome.last[0].vertices, SETS, f"the filter's region, {verdict.ratio:.3f} times", 2.2)
    _outline(axes, verdict.exact.inside, INK, "the exact hull", 1.0)
    _place(axes, outcome)
    axes.set_title(f"Ranges to {SHOWN} anchors: all that agrees [m]")


def _with_a_lie(axes: Axes, outcome: Outcome, verdict: Verdict, prices: Sequence[Price]) -> None:
    rings, (anything, long) = rings_of(outcome.scene), (verdict.tolerant[lies] for lies in ("any", "long"))
    enough = len(rings.least) - 1
    _paint(axes, lambda points: rings.contains(points).sum(axis=1) >= enough, anything.around)
    _circles(axes, rings)
    _outline(axes, anything.inside, TUNED, f"if one of them may be wrong: {verdict.price('any'):.1f} times", 1.6)
    _outline(axes, long.inside, SETS, f"if one may be too long: {verdict.price('long'):.1f} times", 1.6)
    times = " and ".join(f"{price.over_exact:.3f}" for price in prices if price.over_exact)
    for price, label in zip(prices, (f"the filter's regions, {times} times these", ""), strict=False):
        _outline(axes, price.tolerant.last[0].vertices, BARE, label, 0.8)
    _outline(axes, verdict.exact.inside, INK, "the exact hull of all that agrees", 1.0)
    _place(axes, outcome)
    axes.set_title("All that agrees with 3 of them [m]")


def _paint(axes: Axes, agree: Callable[[Array], Mask | np.bool], corners: Array) -> None:
    """Paint where places agree, with some room around corners that shall be seen."""
    low, high = corners.min(axis=0), corners.max(axis=0)
    low, high = low - 0.1 * (high - low).max(), high + 0.1 * (high - low).max()
    x, y = (np.linspace(low[k], high[k], GRID) for k in (0, 1))
    held = agree(np.stack(np.meshgrid(x, y), axis=-1).reshape(-1, 2)).reshape(GRID, GRID)
    axes.contourf(x, y, held, levels=[0.5, 1.5], colors=[PALE], alpha=0.5)
    axes.set(xlim=(low[0], high[0]), ylim=(low[1], high[1]), aspect="equal")
    axes.grid(visible=False)


def _circles(axes: Axes, rings: Rings) -> None:
    for centre, *radii in zip(rings.centres, rings.least, rings.greatest, strict=True):
        for radius in radii:
            axes.add_patch(Circle(tuple(centre), max(0.0, radius), fill=False, color=FAINT, linewidth=0.5))


def _outline(axes: Axes, corners: Array, colour: str, label: str, width: float) -> None:
    axes.plot(*np.concatenate([corners, corners[:1]]).T, color=colour, linewidth=width, label=label)


def _place(axes: Axes, outcome: Outcome) -> None:
    truth = outcome.scene.frames[-1].truth
    if truth is not None:
        axes.plot(*truth.positions[0], "o", color=INK, markersize=5, label="the robot")


def _sights(axes: Axes, verdicts: Sequence[tuple[Outcome, Verdict]]) -> None:
    axes.set_title("4 bearings, no heading [m]")
    if not verdicts:
        return
    outcome, verdict = sorted(verdicts, key=lambda each: each[1].exact.least)[len(verdicts) // 3]
    _paint(axes, sights_of(outcome.scene).within(outcome.scene.team.arena).contains, outcome.last[0].vertices)
    _outline(axes, outcome.last[0].vertices, SETS, f"the filter's region, {verdict.ratio:.3f} times", 2.2)
    _outline(axes, verdict.exact.inside, INK, "the exact hull", 1.0)
    _place(axes, outcome)
    axes.grid(visible=False)


def _ratios(axes: Axes, found: Found) -> None:
    by_anchors: dict[str, list[float]] = {}
    for outcome, verdict in verdicts_on(found, "alone"):
        by_anchors.setdefault(str(len(outcome.scene.team.landmarks)), []).append(verdict.ratio)
    by_anchors["teams"] = [
        ratio for _, verdict in found if isinstance(verdict, AtMost) for ratio in verdict.ratios if np.isfinite(ratio)
    ]
    by_anchors["bearings"] = [verdict.ratio for _, verdict in verdicts_on(found, "bearings")]
    for at, ratios in enumerate(by_anchors.values()):
        spread = at + np.linspace(-0.25, 0.25, len(ratios))
        axes.plot(spread, np.sort(ratios), "o", color=SETS, markersize=3)
    axes.axhline(GOAL, color=FAINT, linewidth=1, linestyle=(0, (4, 2)))
    axes.set_xticks(range(len(by_anchors)), list(by_anchors))
    axes.set(
        title="Area over that of the exact hull",
        xlabel="anchors of one robot; a team of four, at most; bearings",
        ylim=(0.98, None),
    )


def _over_time(axes: Axes, found: Found, what: str) -> None:
    for kind, (colour, label) in DRIVEN.items():
        outcomes = of_kind(found, kind)
        values = np.median(np.concatenate([getattr(each, what) for each in outcomes], axis=1), axis=1)
        times = DT * np.arange(1, len(values) + 1)
        axes.plot(times, values if what == "areas" else np.degrees(values), color=colour, linewidth=1.8, label=label)
    axes.set(xlabel="time [s]", title="Driving: area, median [m²]" if what == "areas" else "Driving: heading, median [± °]")
    axes.set(yscale="log" if what == "areas" else "linear", ylim=(None if what == "areas" else 0, None))
