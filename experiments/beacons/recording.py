"""A recording of a team that measures ranges alone."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from experiments.beacons.scenes import Scene
from experiments.following.located import outers
from experiments.show.recording import Recording
from experiments.show.terminal import StepProgress
from filter import Filter, follow

NO_WALLS = np.zeros((0, 4))


def record(path: Path, filter_: Filter[Any], scene: Scene) -> None:
    """Follow a scene once more and record it as `.rrd`; raises what the filter raises, and `OSError`."""
    recording = Recording(path, scene.team, recording_id=path.stem, walls=NO_WALLS, wall_height=0.0)
    belief, said = filter_.start(0.0, scene.initial, scene.headings), ""
    with recording, StepProgress(len(scene.frames)) as progress:
        for step in follow(filter_, belief, scene.frames):
            recording.add(step.frame, step.belief)
            lapsed, outer = np.flatnonzero(step.belief.guarantee.lapsed).tolist(), outers(step.belief)
            recording.suspended({robot: outer[robot] for robot in lapsed})
            for event in step.belief.events:
                recording.event(scene.team.words(event), "WARN")
            half = np.degrees(np.median(step.belief.headings.bound))
            if said != (said := f"headings known to +-{half:.0f} degrees (median)"):
                recording.event(said)
            progress.advance(step.frame.time, step.seconds)
