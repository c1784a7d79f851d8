"""Where frames come from, behind one type: a log here, the simulator in `experiments.following.simulated`."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from experiments.logs import Header, InitialSet, LogReader
from filter import Array, Frame, Team

CORNERS = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])


@dataclass(frozen=True, eq=False)
class Scenario:
    """A run of a team: what is known before it, what a filter is given as it goes on, and where it takes place.

    Attributes:
        header: The team, when the run starts, and its rate.
        initial: (n) what is known of each robot at the start.
        frames: The frames, to be taken once.
        count: Number of frames, or None when it shows only at the end.
        walls: (w, 4) lower x, lower y, upper x, upper y of each wall [m].
        wall_height: [m].
        picture: Draws an image (height, width, 3) of the last frame taken, or None where nothing can.
    """

    header: Header
    initial: tuple[InitialSet, ...]
    frames: Iterator[Frame]
    count: int | None
    walls: Array
    wall_height: float
    picture: Callable[[], NDArray[np.uint8]] | None

    @property
    def team(self) -> Team:
        """The team."""
        return self.header.team

    @property
    def names(self) -> tuple[str, ...]:
        """(n) what the robots are called."""
        return tuple(map(self.team.name, range(self.team.robots)))


def from_log(path: Path) -> Scenario:
    """Return the scenario of a log.

    Raises:
        InvalidLog: The file cannot be read, or its head is not as docs/log.md says; a later fault comes with its frame.
    """
    return of_log(LogReader(path))


def of_log(log: LogReader) -> Scenario:
    """Return the scenario of a log whose head is read; a later fault comes with its frame, as `InvalidLog`."""
    return Scenario(log.header, log.initial, log.frames(), None, np.zeros((0, 4)), 0.0, None)
