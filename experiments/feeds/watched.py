"""Other estimators' poses, held against what is answered: what is proved wrong is said at once."""

from __future__ import annotations

from collections.abc import Callable, Sequence
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
    or may have been carried in between, nor by a region whose guarantee is suspended.

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
        self._steps = now.lagged.steps
        begin = _before(self._steps[0])
        self.judged, self.unjudged = Judged(team, claims, begin, begin), 0

    def keep(self, answered: Answered) -> None:
        """Take one answer in; odometry alone has to wait for what is measured next."""
        steps, last = answered.now.lagged.steps, self.judged.last
        if steps[-1] is self._steps[-1]:
            return
        self._steps, begin = steps, _before(steps[0])
        if begin > last or steps[-1].belief.time < last - TOLERANCE:  # nobody knows any more, or stamps have jumped back
            self.unjudged += sum(claimed.poses(last, begin) for claimed in self.judged.claims)
            self.judged.last = begin
        for place in range(1, len(steps)):
            if steps[place].belief.time > self.judged.last:
                self._judge(steps[: place + 1], answered.now)

    def _judge(self, steps: Sequence[Known], now: Now) -> None:
        """Judge what is claimed of the time up to the last of some steps, as they are now: late records change them."""
        beliefs, until = [step.belief for step in steps[-2:]], steps[-1].belief.time + TOLERANCE
        followed = ~self._carried(beliefs[0].time, until, now)
        for claimed in self.judged.claims:
            moments, poses = claimed.moments(self.judged.last, until)[-AT_ONCE:], claimed.poses(self.judged.last, until)
            for moment in moments:
                verdict = self._verdict(claimed, moment, beliefs, now.motions, followed)
                self._files.write(self.judged.take(claimed, [verdict], steps))
                self._tell(claimed, moment, verdict)
            self.unjudged += poses - int(np.isfinite(claimed.positions[moments, :, 0]).sum())
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
        """Return (n,) who has come or gone in between."""
        carried = np.zeros(self._team.robots, dtype=bool)
        carried[[robot for time, robot in now.changes if since <= time <= until]] = True
        return carried

    def _tell(self, claimed: Claimed, moment: int, verdict: Verdict) -> None:
        for robot, alarm in verdict.alarms.items():
            trajectory = f"r{robot}_{claimed.name}".removesuffix("_")
            sources = "; ".join(map(self._team.words, alarm.sources)) or "what was known at the start"
            why = f"by {alarm.distance:.3f} m, by {sources}"
            self._say(f"{trajectory} is proved wrong", verdict.time, why, claimed.positions[moment, robot])

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._files.end(self.judged)


def _before(step: Known) -> float:
    """Return after which time a pose can be of a step's [s]."""
    return float(np.nextafter(step.belief.time - TOLERANCE, -np.inf))
