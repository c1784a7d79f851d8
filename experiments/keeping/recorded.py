"""A run as a recording, with what happens in it as events."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np
from numpy.typing import NDArray

from experiments.following.checks import Escapes
from experiments.following.located import outers, there
from experiments.following.scenarios import Scenario
from experiments.following.steps import Contacts
from experiments.keeping.running import Keeper, Moment
from experiments.show.recording import Recording
from experiments.show.viewer import open_viewer
from filter import Inconsistent, Placed, Team

PICTURE_EVERY = 1.0  # [s]
ROUNDING = 1e-9  # of times [s]


def recorded(scenario: Scenario, path: Path, recording_id: str, *, inside: bool, view: bool, camera: bool = False) -> Recorded:
    """Return what records a scenario.

    Args:
        scenario: The run.
        path: The `.rrd` file.
        recording_id: The same for two runs that shall be compared.
        inside: Whether anything will be known from inside.
        view: Whether to show it in a live viewer, too, which is opened if need be.
        camera: Whether to record a picture of the scenario every second.

    Raises:
        NoViewer: No viewer can be opened.
        OSError: The file cannot be written.
    """
    recording = Recording(
        path,
        scenario.team,
        walls=scenario.walls,
        wall_height=scenario.wall_height,
        recording_id=recording_id,
        camera=camera,
        inside=inside,
        viewer=open_viewer() if view else None,
    )
    return Recorded(recording, scenario.team, scenario.picture if camera else None)


class Recorded(Keeper):
    """Keeps a recording: the regions, and as events what the filter drops, where the guarantee ends, and who sees whom."""

    def __init__(self, recording: Recording, team: Team, picture: Callable[[], NDArray[np.uint8]] | None = None) -> None:
        """Take a recording, and what draws a picture of the last frame every second, or None."""
        self._recording, self._team, self._picture = recording, team, picture
        self._contacts = Contacts(team)
        self._pictured = -PICTURE_EVERY
        self._guarantee = "in force"

    def keep(self, moment: Moment) -> None:
        """Take one step in."""
        step = moment.step
        self._recording.add(step.frame, step.belief)
        for event in step.belief.events:
            self._recording.event(self._team.words(event), "WARN")
        for change in step.frame.changes:
            how = "is placed" if isinstance(change, Placed) else "has left"
            self._recording.event(f"{self._team.name(change.robot)} {how}")
        self._warrant(step.belief)
        for words in self._contacts.changes(step.frame):
            self._recording.event(words)
        self._report(moment.escapes)
        if self._picture and step.frame.time - self._pictured >= PICTURE_EVERY - ROUNDING:
            self._recording.image(self._picture())
            self._pictured = step.frame.time

    def _warrant(self, belief: Any) -> None:
        """Record where the guarantee is suspended, and that it is, once."""
        suspended = np.flatnonzero(belief.guarantee.lapsed & there(belief)).tolist()
        if suspended or self._guarantee != "in force":
            self._recording.suspended({robot: outers(belief)[robot] for robot in suspended})
        if (told := self._team.words(belief.guarantee)) != self._guarantee:
            self._guarantee = told
            self._recording.event(f"guarantee {self._guarantee}", "WARN" if suspended else "INFO")

    def _report(self, escapes: Escapes) -> None:
        for what, robots in (("position", escapes.positions), ("heading", escapes.headings)):
            for robot in robots:
                self._recording.event(f"{self._team.name(robot)}: the {what} escaped", "ERROR")

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        if isinstance(error, Inconsistent):
            self._recording.event(self._team.words(error), "ERROR")
        self._recording.close()
