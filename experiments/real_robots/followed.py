"""The one place that decides which filter follows real robots, and what an experiment needs to know of it at every step."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from time import perf_counter

import numpy as np

from experiments.follow.located import Located
from experiments.follow.scenarios import Scenario, initial_headings
from experiments.follow.steps import warmed_up
from experiments.real_robots.carried import Carried
from experiments.real_robots.motion import Motions
from filter.arrays import Mask
from filter.errors import Inconsistent
from filter.frame import Frame
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.robust.belief import Distrusted, Late, Restarted, Turned
from filter.robust.robust_filter import RobustFilter
from filter.sets.belief import Belief, Rejected, Source
from filter.sets.regions import Region
from filter.sets.set_membership import SetMembershipFilter
from filter.team import Team


@dataclass(frozen=True, eq=False)
class Followed:
    """What the filter knows at one frame.

    Attributes:
        frame: What it was given.
        belief: What it knows now.
        suspended: (n,) True for a robot whose region is not guaranteed now.
        silent: (n,) True for a robot whose commands have stopped: nothing is known of its motion.
        rejected: The measurements that were turned away at this frame.
        resets: How many robots were started over at this frame.
        put_aside: Which sensors are no longer trusted since this frame, as "camera of r2".
        events: What happened, in words.
        seconds: How long the filter took.
    """

    frame: Frame
    belief: Located
    suspended: Mask
    silent: Mask
    rejected: tuple[Source, ...]
    resets: int
    put_aside: tuple[str, ...]
    events: tuple[str, ...]
    seconds: float


def team_filter(scenario: Scenario, motions: Motions) -> Iterator[Followed]:
    """Follow the scenario with the filter for real robots, frame by frame.

    Args:
        scenario: The run.
        motions: The robots' commands.
    """
    return voting(scenario, Carried(motions), RobustFilter(scenario.team))


def voting(scenario: Scenario, carried: Carried, robust: RobustFilter) -> Iterator[Followed]:
    """Follow with a robust filter, which is given frames about carried headings."""
    warmed_up()
    positions = [known.polygon() for known in scenario.initial]
    headings = initial_headings(scenario.initial).turned(0.0, carried.bounds.jitter)
    belief = robust.start(scenario.header.start, positions, headings)
    for frame in scenario.frames:
        begin = perf_counter()
        told = carried.frame(frame)
        moved = robust.predict(belief, told.time, told.odometry)
        belief = robust.update(moved, told.measurements)
        events = (*moved.events, *belief.events)
        rejected = tuple(event.source for event in events if isinstance(event, Rejected))
        resets = sum(isinstance(event, Restarted) for event in events)
        doubted = [event for event in events if isinstance(event, Distrusted | Turned | Late) and event.aside]
        located = Within(belief.regions, belief.headings.turned(0.0, carried.bounds.jitter))
        seconds = perf_counter() - begin
        words = tuple(map(str, events))
        aside = tuple(named(event, scenario.team) for event in doubted)
        silent = ~np.isin(np.arange(scenario.team.robots), [] if told.odometry is None else told.odometry.robot)
        yield Followed(frame, located, ~belief.in_force, silent, rejected, resets, aside, words, seconds)


def named(event: Distrusted | Turned | Late, team: Team) -> str:
    """Return the name of the sensor that an event is about."""
    if isinstance(event, Distrusted):
        return f"{event.sensor} of {team.name(event.body)}"
    return f"{'camera clock' if isinstance(event, Late) else 'camera'} of {team.name(event.robot)}"


@dataclass(frozen=True, eq=False)
class Within:
    """Regions and heading intervals of a team.

    Attributes:
        regions: (n) where each robot is.
        headings: (n) arcs that contain the headings: those of the carried ones, widened by the jitter.
    """

    regions: tuple[Region, ...]
    headings: AngularIntervals


def rejecting(scenario: Scenario) -> Iterator[Followed]:
    """Follow with the plain filter that rejects what is proved to disagree, and starts over where that is not enough.

    A measurement that had to be rejected proves that some bound is broken; which, nobody knows, so that from then on
    nothing is guaranteed until the team has been started over from the arena.
    """
    warmed_up()
    plain = SetMembershipFilter(scenario.team, policy="reject")
    positions = [known.polygon() for known in scenario.initial]
    belief = plain.start(scenario.header.start, positions, initial_headings(scenario.initial))
    suspended = np.zeros(scenario.team.robots, dtype=bool)
    for frame in scenario.frames:
        begin = perf_counter()
        belief, conflict = _stepped(plain, belief, frame)
        rejected = tuple(event.source for event in belief.events if isinstance(event, Rejected))
        suspended = np.full(len(suspended), (bool(rejected) or bool(suspended.any())) and conflict is None)
        words = (*map(str, belief.events), *([f"started over: {conflict}"] if conflict else []))
        resets = len(suspended) if conflict else 0
        silent = np.zeros(len(suspended), dtype=bool)  # its bounds of motion say so themselves
        yield Followed(frame, belief, suspended, silent, rejected, resets, (), words, perf_counter() - begin)


def _stepped(plain: SetMembershipFilter, belief: Belief, frame: Frame) -> tuple[Belief, Inconsistent | None]:
    """Return the next belief; if all fails that of robots that can be anywhere, and why."""
    try:
        return plain.update(plain.predict(belief, frame.time, frame.odometry), frame.measurements), None
    except Inconsistent as conflict:
        return plain.start(frame.time, anywhere(plain.team)), conflict


def anywhere(team: Team) -> list[Polygon]:
    """Return the arena for each robot."""
    return [Polygon.box(*team.arena)] * team.robots
