"""Other estimators' poses, held against what is answered: what is proved wrong is said at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from itertools import pairwise
from types import TracebackType

import numpy as np

from experiments.feeds.beside import Answered, Beside
from experiments.feeds.now import Now
from experiments.keeping.watched import TOLERANCE, AlarmFiles
from experiments.watchdog.claimed import Claimed
from experiments.watchdog.judge import Verdict
from experiments.watchdog.reach import ROUNDING
from experiments.watchdog.watching import Judged
from filter import Array, Belief, Mask, Motions, Step, Team

AT_ONCE = 64  # so many instants of an estimator are judged between two steps: what is measured comes first

Known = Step[Belief]


class Watched(Beside):
    """Judges poses as far as steps of the filter have come, as `experiments.watch` does.

    A pose is possible only if the robot can have got there from where it was at the step before, and from there to where it is
    at the step after: by its odometry, as far as that has come, and else by its limits. Nothing is proved of one that is away,
    or may have been carried in between.

    Attributes:
        judged: What was judged.
        unjudged: How many poses were not, as there was no time, or nobody knows any more how robots moved.
    """

    def __init__(
        self,
        now: Now,
        team: Team,
        claims: Sequence[Claimed],
        files: AlarmFiles,
        say: Callable[[str, float, str, Array], None],
    ) -> None:
        """Begin with what is known at the start; of each alarm is said what is wrong, when [s], why, and where (2,) [m]."""
        self._team, self._files, self._say = team, files, say
        self._newest, self._changes = now.lagged.steps[-1], now.changes
        begin = float(np.nextafter(self._newest.belief.time - TOLERANCE, -np.inf))
        self.judged, self.unjudged = Judged(claims, begin, begin), 0

    def keep(self, answered: Answered) -> None:
        """Take one answer in; odometry alone has to wait for what is measured next."""
        steps = answered.now.lagged.steps
        if steps[-1] is self._newest:
            return
        for before, after in pairwise(self._chain(steps)):
            self._judge(before, after, answered.now)
        self._newest, self._changes = steps[-1], answered.now.changes

    def _chain(self, steps: Sequence[Known]) -> list[Known]:
        """Return the step that was judged last and those after it, all since the oldest: of before that no motion is known."""
        oldest, judged = steps[0].belief.time, self.judged
        newest = self._newest
        if steps[-1].belief.time < newest.belief.time:  # stamps have jumped back
            judged.last = oldest
        if oldest > newest.belief.time or steps[-1].belief.time < newest.belief.time:
            self.unjudged += sum(claimed.poses(judged.last, oldest) for claimed in judged.claims)
            judged.last, newest = max(judged.last, oldest), steps[0]
        return [newest, *(step for step in steps if step.belief.time > newest.belief.time)]

    def _judge(self, before: Known, after: Known, now: Now) -> None:
        """Judge what is claimed of the time up to a step."""
        until = after.belief.time + TOLERANCE
        through = [step for step in now.lagged.steps if step.belief.time < before.belief.time] + [before, after]
        followed = ~self._carried(before.belief.time, until, now)
        for claimed in self.judged.claims:
            moments = claimed.moments(self.judged.last, until)[-AT_ONCE:]
            missed = claimed.poses(self.judged.last, until)
            for moment in moments:
                verdict = self._verdict(claimed, moment, (before.belief, after.belief), now.motions, followed)
                self._files.write(self.judged.take(claimed, [verdict], through))
                self._tell(claimed, moment, verdict)
            self.unjudged += missed - int(np.isfinite(claimed.positions[moments, :, 0]).sum())
        self.judged.last = until

    def _verdict(self, claimed: Claimed, moment: int, beliefs: Sequence[Belief], motions: Motions, followed: Mask) -> Verdict:
        time, positions = float(claimed.times[moment]), claimed.positions[moment]
        verdict, clock = Verdict.of(time, len(positions)), self._way(motions, time - TOLERANCE, time + TOLERANCE)
        for belief in beliefs:
            way = self._way(motions, *sorted((belief.time, time)))
            verdict.take(belief, positions, way + clock + ROUNDING, followed)
        return verdict

    def _way(self, motions: Motions, start: float, time: float) -> Array:
        """Return (n,) how far robots can get from one time to another [m]."""
        farthest = self._team.speed_limit * (time - start)
        driven = motions.between(start, time)
        if driven is not None:
            farthest[driven.robot] = np.abs(driven.distance) + driven.distance_bound + driven.slip_bound
        return farthest

    def _carried(self, since: float, until: float, now: Now) -> Mask:
        """Return (n,) who has come or gone in between, or of whom it has turned out only now."""
        told = now.changes
        carried = np.zeros(self._team.robots, dtype=bool)
        carried[[robot for time, robot in told if since <= time <= until or (time, robot) not in self._changes]] = True
        return carried

    def _tell(self, claimed: Claimed, moment: int, verdict: Verdict) -> None:
        for robot, alarm in verdict.alarms.items():
            trajectory = f"r{robot}_{claimed.name}".removesuffix("_")
            why = f"by {alarm.distance:.3f} m, by {'; '.join(map(str, alarm.sources)) or 'what was known at the start'}"
            self._say(f"{trajectory} is proved wrong", verdict.time, why, claimed.positions[moment, robot])

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._files.end(self.judged)
