"""The figure of a real team that stands: where everybody can be at the end, and how that became so."""

from __future__ import annotations

from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure

from experiments.against_ekf.figures import FAINT, INK, LOOK
from experiments.beacons.outcomes import Outcome
from experiments.show.colours import colour_of

ALARM = "#c0392b"


def draw_standing(folder: Path, outcome: Outcome, lie: float | None) -> None:
    """Draw `standing_team.png`: the regions after the last step, and areas over time with when something lied [s]."""
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(12.0, 5.2), layout="constrained")
        left, right = figure.subplots(1, 2)
        _map(left, outcome)
        _areas(right, outcome)
        if lie is not None:
            right.axvline(lie, color=FAINT, linestyle=(0, (4, 2)), label="a lie begins")
        since = outcome.checks.suspended
        if since is not None:
            right.axvline(float(since.suspended_since.min()), color=ALARM, label="guarantee suspended")
        right.legend(loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=3)
        figure.savefig(folder / "standing_team.png")


def _map(axes: Axes, outcome: Outcome) -> None:
    team, truth = outcome.scene.team, outcome.scene.frames[-1].truth
    for robot, region in enumerate(outcome.last):
        axes.fill(*region.vertices.T, facecolor=(*_colour(robot), 0.25), edgecolor=_colour(robot), linewidth=1.8)
    if truth is not None:
        axes.plot(*truth.positions.T, "o", color=INK, markersize=4)
    axes.plot(*team.landmarks.T, "^", color=INK, markersize=9)
    places = np.concatenate([[region.centroid for region in outcome.last], team.landmarks])
    for name, place in zip(team.names, places, strict=True):
        axes.annotate(name, place, xytext=(9, 9), textcoords="offset points", fontsize=11)
    axes.set(title="Regions at the end, truths and anchors [m]", aspect="equal")
    axes.grid(visible=False)


def _areas(axes: Axes, outcome: Outcome) -> None:
    times = [frame.time for frame in outcome.scene.frames]
    for robot, areas in enumerate(outcome.areas.T):
        axes.plot(times, areas, color=_colour(robot), linewidth=1.8, label=outcome.scene.team.name(robot))
    axes.set(title="Area of each region [m²]", xlabel="time [s]", yscale="log")


def _colour(robot: int) -> tuple[float, float, float]:
    red, green, blue = colour_of(robot)
    return red / 255, green / 255, blue / 255
