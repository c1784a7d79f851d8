"""A recording of one size of team."""

from __future__ import annotations

from pathlib import Path

from experiments.following.steps import steps
from experiments.growth.size import Case
from experiments.show.recording import Recording
from experiments.show.terminal import StepProgress
from filter import SetMembershipFilter, Window


def record_size(case: Case, path: Path) -> None:
    """Follow a team once more, in windows, and record it as `.rrd`, with a progress bar.

    Raises:
        CorralError: What the simulator or the filter raises.
    """
    scenario = case.scenario()
    recording = Recording(
        path,
        scenario.team,
        recording_id=f"scaling_{case.robots}_{case.seed}",
        walls=scenario.walls,
        wall_height=scenario.wall_height,
        inside=False,
    )
    with recording, StepProgress(case.frames) as progress:
        for step in steps(SetMembershipFilter.light(scenario.team, scope=Window()), scenario):
            recording.add(step.frame, step.belief)
            progress.advance(step.frame.time, step.seconds)
