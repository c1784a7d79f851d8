"""The one place that decides which filter follows real robots, and what an experiment needs to know of it at every step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import tee
from time import perf_counter

import numpy as np

from experiments.following.located import Located
from experiments.following.scenarios import Scenario
from experiments.following.steps import warmed_up
from experiments.logs import first_belief, initial_headings
from experiments.real_robots.carried import Carried
from experiments.real_robots.motion import Motions
from filter import (
    AngularIntervals,
    Distrusted,
    Doubted,
    Frame,
    Guarantee,
    Late,
    Mask,
    Region,
    Rejected,
    Restarted,
    RobustEvent,
    RobustFilter,
    SetMembershipFilter,
    Source,
    StartsOver,
    Team,
    Turned,
    follow,
)


@dataclass(frozen=True, eq=False)
class Followed:
    """What the filter knows at one frame.

    Attributes:
        frame: What it was given.
        belief: What it knows now.
        guarantee: For which robots what it knows is guaranteed, or since when and why it is not.
        lapsed: The same with what turned out at this frame: for a robot that has started over, that it was suspended until now.
        silent: (n,) True for a robot whose commands have stopped: nothing is known of its motion.
        rejected: The measurements that were turned away at this frame.
        resets: How many robots were started over at this frame.
        put_aside: Which sensors are no longer trusted since this frame, as "camera of r2".
        events: What happened, in words.
        seconds: How long the filter took.
    """

    frame: Frame
    belief: Located
    guarantee: Guarantee
    lapsed: Guarantee
    silent: Mask
    rejected: tuple[Source, ...]
    resets: int
    put_aside: tuple[str, ...]
    events: tuple[str, ...]
    seconds: float

    @property
    def suspended(self) -> Mask:
        """(n,) True for a robot whose region is not guaranteed now."""
        return ~self.guarantee.in_force


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
    jitter = carried.bounds.jitter
    positions = [known.polygon() for known in scenario.initial]
    begin = robust.start(scenario.header.start, positions, initial_headings(scenario.initial).turned(0.0, jitter))
    frames, own = tee(scenario.frames)
    for frame, step in zip(frames, follow(robust, begin, map(carried.frame, own), perf_counter), strict=True):
        told, belief, events = step.frame, step.belief, (*step.predicted.events, *step.belief.events)
        rejected = tuple(event.source for event in events if isinstance(event, Rejected))
        resets = sum(isinstance(event, Restarted) for event in events)
        doubted = [event for event in events if isinstance(event, Distrusted | Turned | Late) and event.aside]
        located = Within(belief.regions, belief.headings.turned(0.0, jitter))
        words = tuple(map(scenario.team.words, events))
        aside = tuple(named(event, scenario.team) for event in doubted)
        silent = ~np.isin(np.arange(scenario.team.robots), [] if told.odometry is None else told.odometry.robot)
        guarantees = belief.guarantee, lapsed(belief.guarantee, events)
        yield Followed(frame, located, *guarantees, silent, rejected, resets, aside, words, step.seconds)


def lapsed(guarantee: Guarantee, events: Sequence[RobustEvent]) -> Guarantee:
    """Return the guarantee as it was until now of robots that have started over, and as it is now of the others."""
    restarts = {event.robot: event for event in events if isinstance(event, Restarted)}
    since, because = guarantee.suspended_since.copy(), list(guarantee.because)
    for robot, event in restarts.items():
        since[robot], because[robot] = event.suspended_since, event.because
    return Guarantee(since, tuple(because))


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
    """Follow with the plain filter that goes on after a conflict; what is rejected is what was measured and is in conflict."""
    warmed_up()
    plain = SetMembershipFilter(scenario.team, policy="reject")
    belief = first_belief(plain, scenario.header, scenario.initial)
    silent = np.zeros(scenario.team.robots, dtype=bool)  # its bounds of motion say so themselves
    for step in follow(plain, belief, scenario.frames, perf_counter):
        events = step.belief.events
        rejected = tuple(source for event in events if isinstance(event, Doubted) for source in event.conflict)
        resets = sum(len(event.robots) for event in events if isinstance(event, StartsOver))
        words = tuple(map(scenario.team.words, events))
        guarantees = step.belief.guarantee, step.belief.guarantee
        yield Followed(step.frame, step.belief, *guarantees, silent, rejected, resets, (), words, step.seconds)
