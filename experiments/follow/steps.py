"""The loop: a filter follows a scenario, frame by frame."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cache
from time import perf_counter

from experiments.follow.metrics import rounded
from experiments.follow.scenarios import Scenario, initial_headings
from experiments.logs.log import LogWriter
from filter.frame import Frame
from filter.measurements import Compass
from filter.sets.belief import Belief
from filter.sets.set_membership import SetMembershipFilter
from filter.team import Team
from filter.warm_up import warm_up


@cache
def warmed_up() -> float:
    """Compile or load all that is compiled, once in a process, so that no step waits for it; return how long that took [s]."""
    begin = perf_counter()
    warm_up()
    return rounded(perf_counter() - begin)


@dataclass(frozen=True, eq=False)
class Step:
    """One step of a filter.

    Attributes:
        frame: What it was given.
        predicted: What it knew before it saw the frame's measurements.
        belief: What it knows now.
        seconds: How long predict and update took together.
    """

    frame: Frame
    predicted: Belief
    belief: Belief
    seconds: float


def steps(team_filter: SetMembershipFilter, scenario: Scenario, log: LogWriter | None = None) -> Iterator[Step]:
    """Yield the filter's step at every frame: predict with the odometry, then update with the measurements.

    A frame is logged before the filter sees it, so that one which the filter refuses can be replayed.

    Raises:
        CorralError: What the scenario or the filter raises.
    """
    warmed_up()
    positions = [known.polygon() for known in scenario.initial]
    belief = team_filter.start(scenario.header.start, positions, initial_headings(scenario.initial))
    for frame in scenario.frames:
        if log is not None:
            log.write(frame)
        begin = perf_counter()
        predicted = team_filter.predict(belief, frame.time, frame.odometry) if frame.time > belief.time else belief
        belief = team_filter.update(predicted, frame.measurements)
        yield Step(frame, predicted, belief, perf_counter() - begin)


@dataclass
class Contacts:
    """Notices when robots come into sight of something, and when they are on their own again.

    Attributes:
        team: Whose contacts.
    """

    team: Team
    _links: set[tuple[int, int]] = field(default_factory=set)
    _linked: set[int] = field(default_factory=set)

    def changes(self, frame: Frame) -> list[str]:
        """Return in words what has changed since the last frame."""
        records = [record for record in frame.measurements if not isinstance(record, Compass)]
        pairs = {pair for record in records for pair in zip(record.robot.tolist(), record.target.tolist(), strict=True)}
        links = {(robot, target) for robot, target in pairs if target >= self.team.robots}
        linked = {body for pair in pairs for body in pair if body < self.team.robots}
        name = self.team.name
        words = [f"{name(robot)} sees {name(target)}" for robot, target in sorted(links - self._links)]
        words += [f"{name(robot)} no longer sees {name(target)}" for robot, target in sorted(self._links - links)]
        words += [f"{name(robot)} is on its own" for robot in sorted(self._linked - linked)]
        words += [f"{name(robot)} is in sight of the team" for robot in sorted(linked - self._linked)]
        self._links, self._linked = links, linked
        return words
