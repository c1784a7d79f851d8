"""What other estimators say: where the robots of a team were, on the log's clock."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from experiments.following.frozen import freeze
from experiments.logs import Trajectory, find_trajectories, read_trajectory
from filter import Array


@dataclass(frozen=True, eq=False)
class Claimed:
    """Where one estimator says that the robots of a team were.

    Attributes:
        name: What its files are called after their robot; empty for r0.tum.
        times: (m,) increasing, on the log's clock [s].
        positions: (m, n, 2) [m]; NaN where it says nothing.
    """

    name: str
    times: Array
    positions: Array

    def __post_init__(self) -> None:
        freeze(self)

    @classmethod
    def of(cls, name: str, trajectories: Mapping[int, Trajectory], robots: int, offset: float) -> Claimed:
        """Return the trajectories of some of the robots, by their numbers, with an offset added to their stamps [s]."""
        stamps = {robot: trajectory.times + offset for robot, trajectory in trajectories.items()}
        times = np.unique(np.concatenate(list(stamps.values())))
        positions = np.full((len(times), robots, 2), np.nan)
        for robot, trajectory in trajectories.items():
            positions[np.searchsorted(times, stamps[robot]), robot] = trajectory.positions
        return cls(name, times, positions)

    def poses(self, after: float = -np.inf, until: float = np.inf) -> int:
        """Return how many poses are later than one time and not later than another [s]."""
        moments = self.moments(after, until)
        return int(np.isfinite(self.positions[moments.start : moments.stop, :, 0]).sum())

    def moments(self, after: float, until: float) -> range:
        """Return which times are later than one and not later than another [s]."""
        return range(*np.searchsorted(self.times, [after, until], side="right").tolist())


def claims_in(place: Path, pattern: str, robots: int, offset: float) -> tuple[Claimed, ...]:
    """Return what each estimator claims of so many robots: of one file, or of those in a folder, see `find_trajectories`.

    Raises:
        InvalidInput: There is none, a name tells no robot, or a file is no trajectory.
    """
    files = find_trajectories(place, pattern, robots)
    read = {name: {robot: read_trajectory(path) for robot, path in of.items()} for name, of in files.items()}
    return tuple(Claimed.of(name, trajectories, robots, offset) for name, trajectories in read.items())
