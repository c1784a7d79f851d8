"""The monitor at work: the filter goes through a log, and what others claim is judged on the way."""

from __future__ import annotations

import csv
from collections import deque
from collections.abc import Iterable, Sequence
from pathlib import Path

from experiments.following.scenarios import Scenario
from experiments.following.steps import steps
from experiments.show.terminal import StepProgress
from experiments.watchdog.claimed import Claimed
from experiments.watchdog.episodes import Episode, Episodes
from experiments.watchdog.judge import Judge, Verdict
from filter import Belief, SetMembershipFilter, Step, Team

PLACE = ("normal_x", "normal_y", "offset_m", "moved_m", "frame_s")
ALARM = ("time_s", "robot", "trajectory", "distance_m", *PLACE, "episode", "sources")
EPISODE = ("episode", "trajectory", "start_s", "end_s", "poses", "distance_max_m", "worst_s", "behind")
Row = tuple[object, ...]


class Judged:
    """Collects verdicts on what other estimators claim.

    Attributes:
        team: Of whom.
        claims: What is judged.
        first: Poses later than this are judged [s].
        last: Poses not later than this are, or were so far [s].
        checks: How many poses were judged.
        alarms: How many of them are proved wrong.
    """

    def __init__(self, team: Team, claims: Sequence[Claimed], first: float, last: float) -> None:
        self.team, self.claims, self.first, self.last, self.checks, self.alarms = team, claims, first, last, 0, 0
        self._episodes = Episodes(team.words)

    @property
    def episodes(self) -> Sequence[tuple[Episode, str]]:
        """The episodes that have ended, each with what is behind it."""
        return self._episodes.ended

    def take(self, claimed: Claimed, verdicts: Iterable[Verdict], through: Sequence[Step[Belief]]) -> list[Row]:
        """Take in verdicts on an estimator, and steps to trace them back through; return a row of `ALARM` for each alarm."""
        rows = []
        for verdict in verdicts:
            episodes = self._episodes.add(claimed, verdict, through)
            self.checks += int(verdict.judged.sum())
            self.alarms += len(episodes)
            rows += [self._row(claimed, verdict, robot, episode) for robot, episode in episodes.items()]
        return rows

    def _row(self, claimed: Claimed, verdict: Verdict, robot: int, episode: Episode) -> Row:
        alarm = verdict.alarms[robot]
        place = (*alarm.normal.tolist(), alarm.offset, verdict.moved[robot], alarm.time)
        sources = "; ".join(map(self.team.words, alarm.sources))
        return (verdict.time, self.team.name(robot), claimed.name, alarm.distance, *place, episode.number, sources)

    def end(self) -> None:
        """End the episodes that go on: there is no further step."""
        self._episodes.end()


class Watching(Judged):
    """Judges what other estimators claim as a filter goes through a log."""

    def __init__(self, team: Team, judge: Judge, claims: Sequence[Claimed], back: float) -> None:
        """Prepare for alarms to be traced back so far [s]."""
        super().__init__(team, claims, judge.first, judge.last)
        self._judge, self._back, self._steps, self._frame = judge, back, deque[Step[Belief]](), 0

    def run(self, scenario: Scenario, path: Path) -> None:
        """Judge every pose as the filter goes through a log, and write every alarm.

        Raises:
            CorralError: What the log or the filter raises.
        """
        with path.open("w", encoding="utf-8", newline="") as file, StepProgress(scenario.count) as progress:
            writer = csv.writer(file, lineterminator="\n")
            writer.writerow(ALARM)
            for step in steps(SetMembershipFilter(scenario.team), scenario):
                writer.writerows(self.judged(step))
                progress.advance(step.frame.time, step.seconds)
        self.end()

    def judged(self, step: Step[Belief]) -> list[Row]:
        """Judge every pose since the frame before that of the next step; return a row of `ALARM` for every alarm."""
        self._remember(step)
        beliefs, through, rows = [step.belief for step in list(self._steps)[-2:]], list(self._steps), list[Row]()
        for claimed in self.claims:
            rows += self.take(claimed, self._judge.verdicts(self._frame, beliefs, claimed), through)
        self._frame += 1
        return rows

    def _remember(self, step: Step[Belief]) -> None:
        """Keep the steps to trace back through from this one and from the one before."""
        self._steps.append(step)
        while len(self._steps) > 2 and self._steps[0].frame.time < self._steps[-2].frame.time - self._back:
            self._steps.popleft()


def write_episodes(path: Path, episodes: Sequence[tuple[Episode, str]]) -> None:
    """Write a row for every episode."""
    with path.open("w", encoding="utf-8", newline="") as file:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(EPISODE)
        for each, behind in episodes:
            worst = (each.worst.distance, each.worst_time)
            writer.writerow((each.number, each.trajectory, each.start, each.end, each.poses, *worst, behind))
