"""How far a robot can get between a frame and any other time.

Odometry tells of a motion as a whole, and nothing of its parts. So what is used between two frames is a speed: no robot is
faster than the team's speed limit or, where its odometry allows more, than the longest path of this odometry in its time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.following.frozen import freeze
from filter import Array, Frame, Mask, Team

ROUNDING = 1e-9  # of sums of lengths, by far [m]


@dataclass(frozen=True, eq=False)
class Reach:
    """How far the robots of a team can get.

    Attributes:
        times: (f,) of the frames [s].
        speeds: (f, n) greatest speed from each frame to the next, from the last one on, and before the first [m/s].
        lengths: (f, n) longest path from the first frame to each [m].
        changed: (f, n) whether a robot is placed or leaves at a frame: it can have been carried since the one before.
    """

    times: Array
    speeds: Array
    lengths: Array
    changed: Mask

    def __post_init__(self) -> None:
        freeze(self)

    @classmethod
    def of(cls, team: Team, frames: Sequence[Frame]) -> Reach:
        """Return how far a team can get that was given these frames, of which there is at least one."""
        times, speeds = np.array([frame.time for frame in frames]), np.tile(team.speed_limit, (len(frames), 1))
        for place, frame in enumerate(frames[1:]):
            if (driven := frame.odometry) is not None:
                path = np.abs(driven.distance) + driven.distance_bound + driven.slip_bound
                faster = path / (driven.time - driven.start)
                speeds[place, driven.robot] = np.maximum(speeds[place, driven.robot], faster)
        speeds[-1] = speeds[-2:].max(axis=0)
        steps = speeds[:-1] * np.diff(times)[:, None]
        changed = np.zeros((len(frames), team.robots), dtype=bool)
        for place, frame in enumerate(frames):
            changed[place, [change.robot for change in frame.changes]] = True
        return cls(times, speeds, np.concatenate([np.zeros((1, team.robots)), np.cumsum(steps, axis=0)]), changed)

    def away(self, frame: int, earliest: float, latest: float) -> Array:
        """Return (n,) how far robots can be from where they were at a frame, at any time from one to another [m]."""
        there = self.lengths[frame]
        return np.maximum(np.abs(self._until(earliest) - there), np.abs(self._until(latest) - there)) + ROUNDING

    def carried(self, frame: int, earliest: float, latest: float) -> Mask:
        """Return (n,) which robots may have been carried between a frame and any time from one to another."""
        first = np.searchsorted(self.times, min(earliest, self.times[frame]), side="right")
        last = max(frame, int(np.searchsorted(self.times, latest)))
        return np.asarray(self.changed[first : last + 1].any(axis=0))

    def _until(self, time: float) -> Array:
        """Return (n,) the longest path from the first frame to a time [m]; negative before it."""
        place = max(0, int(np.searchsorted(self.times, time, side="right")) - 1)
        return np.asarray(self.lengths[place] + (time - self.times[place]) * self.speeds[place])
