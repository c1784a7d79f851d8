"""A recording of a standing formation: its regions search by search, from one robot's frame, then from another's."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product
from pathlib import Path

import numpy as np

from experiments.paper.formations import Formation
from experiments.paper.frames import localize
from experiments.show.recording import Recording
from experiments.show.terminal import Counting
from filter import Frame, Truth
from filter.arrays import Array
from filter.projection.stop import Stop
from filter.team import Team

SEARCHES = (*range(4, 17), 20, 25, 30)
MARGIN = 1.0  # around what a recording shows [m]
NO_WALLS = np.zeros((0, 4))


def record_searches(path: Path, formation: Formation, frames: Mapping[str, Array]) -> None:
    """Record the regions after so many searches in each of several frames, one after the other.

    A step of the recording is a number of searches; the second at which it is shown just counts the steps.

    Args:
        path: The `.rrd` file.
        formation: Whose regions.
        frames: (n, 2) anchors of each frame [m], by words for it.
    """
    arena = view_of(formation.positions)
    shown = Team(len(formation), speed_limit=0.0, turn_rate_limit=0.0, arena=arena)
    truth = Truth(formation.positions, formation.headings)
    recording = Recording(path, shown, recording_id=path.stem, walls=NO_WALLS, wall_height=0.0)
    with recording, Counting(len(frames) * len(SEARCHES), "steps of the recording") as progress:
        for time, (words, searches) in enumerate(product(frames, SEARCHES)):
            belief = localize(formation, frames[words], Stop(performance_ratio=1.0, searches=searches)).belief
            recording.add(Frame(float(time), None, (formation.bearings,), truth), belief)
            recording.event(f"{words}: at most {searches} searches a robot")
            progress.advance()


def view_of(positions: Array) -> Array:
    """Return (2, 2) lower and upper corner of what shows all positions [m]."""
    return np.array([positions.min(axis=0) - MARGIN, positions.max(axis=0) + MARGIN])
