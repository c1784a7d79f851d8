"""Holds poses of any time against regions: of the frame before and of the frame after, widened by how far a robot can get."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from experiments.following.located import there
from experiments.watchdog.claimed import Claimed
from experiments.watchdog.reach import Reach
from filter import Alarm, Array, Belief, Frame, InvalidInput, Mask, Team, watch


@dataclass(frozen=True, eq=False)
class Verdict:
    """What is proved of one estimator's poses of one time.

    Attributes:
        time: When [s].
        judged: (n,) the robots of which it has a pose.
        alarms: For each robot whose pose is proved wrong, the proof by which it is farthest off; its time is that of a frame.
        moved: (n,) how far each robot can have gone between that frame and the pose [m].
    """

    time: float
    judged: Mask
    alarms: dict[int, Alarm]
    moved: dict[int, float]

    @classmethod
    def of(cls, time: float, robots: int) -> Verdict:
        """Return the verdict on poses of so many robots of which nothing is proved yet."""
        return cls(time, np.zeros(robots, dtype=bool), {}, {})

    def take(self, belief: Belief, positions: Array, moved: Array, followed: Mask) -> None:
        """Add what a belief of another time proves.

        Args:
            belief: What is possible then.
            positions: (n, 2) the poses [m]; NaN where there is none.
            moved: (n,) how far each robot can have gone in between [m].
            followed: (n,) of which robots that is known; others may have been carried.
        """
        judged = np.isfinite(positions).all(axis=1) & there(belief) & belief.guarantee.in_force & followed
        self.judged[judged] = True
        outside = judged & ~belief.regions.contains(positions)
        # Most poses are inside: nothing can be proved of them.
        for alarm in watch(belief, np.where(outside[:, None], positions, np.nan), moved=moved) if outside.any() else ():
            known = self.alarms.get(alarm.robot)
            if known is None or alarm.distance > known.distance:
                self.alarms[alarm.robot], self.moved[alarm.robot] = alarm, float(moved[alarm.robot])


@dataclass(frozen=True, eq=False)
class Judge:
    """Judges poses between the frames of a log.

    A pose is possible only if the robot can have got there from where it was at the frame before, and from there to where it
    is at the frame after. Nothing is proved of one that is away, or may have been carried in between, nor by a region whose
    guarantee is suspended: a bound is known to be broken.

    Attributes:
        reach: How far robots can get.
        tolerance: How far the stamp of a pose may be from the time it is of [s].
    """

    reach: Reach
    tolerance: float

    @property
    def first(self) -> float:
        """Poses later than this are judged [s]."""
        return float(np.nextafter(self.reach.times[0] - self.tolerance, -np.inf))

    @property
    def last(self) -> float:
        """Poses not later than this are judged [s]."""
        return float(self.reach.times[-1] + self.tolerance)

    def verdicts(self, frame: int, beliefs: Sequence[Belief], claimed: Claimed) -> Iterator[Verdict]:
        """Yield a verdict on each time after the frame before and up to this one.

        Args:
            frame: Its number.
            beliefs: What the filter knows at this frame, and before it what it knew at the one before, if there is one.
            claimed: Whose poses.
        """
        times = self.reach.times
        after = times[frame - 1] if frame else self.first
        until = times[frame] if frame < len(times) - 1 else self.last
        for moment in claimed.moments(after, until):
            time, positions = float(claimed.times[moment]), claimed.positions[moment]
            verdict = Verdict.of(time, len(positions))
            for number, belief in enumerate(beliefs, frame + 1 - len(beliefs)):
                self._judge(number, belief, positions, verdict)
            yield verdict

    def _judge(self, frame: int, belief: Belief, positions: Array, verdict: Verdict) -> None:
        """Add what is proved by a frame."""
        span = verdict.time - self.tolerance, verdict.time + self.tolerance
        moved = self.reach.away(frame, *span)
        verdict.take(belief, positions, moved, ~self.reach.carried(frame, *span))


def judge_of(team: Team, frames: Sequence[Frame], claims: Sequence[Claimed], tolerance: float) -> Judge:
    """Return a judge for what is claimed of a team that is given some frames.

    Raises:
        InvalidInput: There is no frame, or no pose in their time.
    """
    if not frames:
        raise InvalidInput("a log with at least one frame", "none")
    judge = Judge(Reach.of(team, frames), tolerance)
    if not any(claimed.poses(judge.first, judge.last) for claimed in claims):
        begin, end = min(claimed.times[0] for claimed in claims), max(claimed.times[-1] for claimed in claims)
        span = f"poses between {judge.first:.3f} s and {judge.last:.3f} s, the log's first and last frame (see --offset)"
        raise InvalidInput(span, f"poses from {begin:.3f} s to {end:.3f} s")
    return judge
