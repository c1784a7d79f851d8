"""A filter follows a scenario, and what is seen on the way."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from time import perf_counter

from experiments.following.metrics import rounded
from experiments.following.scenarios import Scenario
from experiments.logs import LogWriter, first_belief
from filter import AnyBelief, Bearing, Filter, Frame, Range, Step, Team, follow, warm_up

GLANCE = 0.5  # who was seen so short a time ago is in sight [s]


@cache
def warmed_up() -> float:
    """Compile or load all that is compiled, once in a process, so that no step waits for it; return how long that took [s]."""
    begin = perf_counter()
    warm_up()
    return rounded(perf_counter() - begin)


def steps(
    filter_: Filter[AnyBelief], scenario: Scenario, log: LogWriter | None = None, *, warm: bool = True, every: float = 0.0
) -> Iterator[Step[AnyBelief]]:
    """Start a filter, and let it follow a scenario; each step takes its time.

    A frame is logged before the filter sees it, so that one which the filter refuses can be replayed.

    Args:
        filter_: Any filter.
        scenario: What it is given.
        log: Where that is written, too, or None.
        warm: Whether to load before all that any filter needs, so that no step waits; without, what is needed is loaded in
            the first steps, which is sooner done.
        every: Frames of so long a time are one step; 0 for a step each [s].

    Raises:
        CorralError: What the scenario or the filter raises.
    """
    if warm:
        warmed_up()
    belief = first_belief(filter_, scenario.header, scenario.initial)
    frames = scenario.frames if log is None else _logged(scenario.frames, log)
    return follow(filter_, belief, frames, perf_counter, every)


def _logged(frames: Iterator[Frame], log: LogWriter) -> Iterator[Frame]:
    for frame in frames:
        log.write(frame)
        yield frame


@dataclass
class Contacts:
    """Notices when robots come into sight of something, and when they are on their own again.

    Attributes:
        team: Whose contacts.
    """

    team: Team
    _seen: dict[tuple[int, int], float] = field(default_factory=dict)
    _links: set[tuple[int, int]] = field(default_factory=set)
    _linked: set[int] = field(default_factory=set)

    def changes(self, frame: Frame) -> list[str]:
        """Return in words what has changed since the last frame; of a stream it is a part of what is seen."""
        for record in frame.measurements:
            if isinstance(record, Bearing | Range):
                self._seen |= dict.fromkeys(zip(record.robot.tolist(), record.target.tolist(), strict=True), frame.time)
        self._seen = {pair: time for pair, time in self._seen.items() if frame.time - time < GLANCE}
        links = {(robot, target) for robot, target in self._seen if target >= self.team.robots}
        linked = {body for pair in self._seen for body in pair if body < self.team.robots}
        name = self.team.name
        words = [f"{name(robot)} sees {name(target)}" for robot, target in sorted(links - self._links)]
        words += [f"{name(robot)} no longer sees {name(target)}" for robot, target in sorted(self._links - links)]
        words += [f"{name(robot)} is on its own" for robot in sorted(self._linked - linked)]
        words += [f"{name(robot)} is in sight of the team" for robot in sorted(linked - self._linked)]
        self._links, self._linked = links, linked
        return words
