"""Alarms on one robot's trajectory that follow one another are one episode, and what is behind it is told once."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.following.metrics import Words
from experiments.watchdog.behind import WORLD, Edge, in_words, traced
from experiments.watchdog.claimed import Claimed
from experiments.watchdog.judge import Verdict
from filter import Alarm, Belief, Step


@dataclass(frozen=True, eq=False)
class Episode:
    """Poses of one trajectory that are proved wrong, one after the other.

    Attributes:
        number: From 1 on, in the order of their begins.
        trajectory: r0, or r0_ and the estimator's name.
        start: Time of the first pose [s].
        end: Time of the last one [s].
        poses: How many they are.
        worst: The alarm that is farthest beyond its line.
        worst_time: Time of its pose [s].
        steps: Those to trace it back through.
    """

    number: int
    trajectory: str
    start: float
    end: float
    poses: int
    worst: Alarm
    worst_time: float
    steps: tuple[Step[Belief], ...] = ()

    def longer(self, time: float, alarm: Alarm, steps: tuple[Step[Belief], ...]) -> Episode:
        """Return the episode with one more pose."""
        grown = replace(self, end=time, poses=self.poses + 1)
        return replace(grown, worst=alarm, worst_time=time, steps=steps) if alarm.distance > self.worst.distance else grown

    def told(self, words: Words) -> tuple[Episode, str]:
        """Return the episode without its steps, and what is behind its worst alarm, in the words of the team."""
        edge = Edge(self.worst.time, WORLD, self.worst.robot, self.worst.normal)
        behind = traced(self.steps, [edge]) or self.worst.sources  # regions that no update has found have no proofs
        return replace(self, steps=()), in_words(behind, words)


class Episodes:
    """Joins alarms to episodes.

    Attributes:
        ended: Episodes, and what is behind each; all of them once `end` was called.
    """

    def __init__(self, words: Words = str) -> None:
        """Begin with none; words are those of the team, which has names."""
        self._words, self._open = words, dict[str, Episode]()
        self._count = 0
        self.ended: list[tuple[Episode, str]] = []

    def add(self, claimed: Claimed, verdict: Verdict, steps: Sequence[Step[Belief]]) -> dict[int, Episode]:
        """Take in a verdict with the last steps of the filter; return the episode of each robot with an alarm."""
        found = {}
        for robot in np.flatnonzero(verdict.judged).tolist():
            trajectory = f"r{robot}_{claimed.name}".removesuffix("_")
            if (alarm := verdict.alarms.get(robot)) is None:
                self._end(trajectory)
                continue
            back = tuple(step for step in steps if step.frame.time <= alarm.time)
            found[robot] = self._open[trajectory] = self._longer(trajectory, verdict.time, alarm, back)
        return found

    def end(self) -> None:
        """End what is going on."""
        for trajectory in list(self._open):
            self._end(trajectory)
        self.ended.sort(key=lambda each: each[0].number)

    def _longer(self, trajectory: str, time: float, alarm: Alarm, steps: tuple[Step[Belief], ...]) -> Episode:
        if trajectory in self._open:
            return self._open[trajectory].longer(time, alarm, steps)
        self._count += 1
        return Episode(self._count, trajectory, time, time, 1, alarm, time, steps)

    def _end(self, trajectory: str) -> None:
        if (episode := self._open.pop(trajectory, None)) is not None:
            self.ended.append(episode.told(self._words))
