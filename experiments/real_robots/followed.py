"""The one place that decides which filter follows real robots, and what an experiment needs to know of it at every step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from itertools import tee
from pathlib import Path
from time import perf_counter
from typing import Any, Literal

import numpy as np

from experiments.following.located import Located
from experiments.following.scenarios import Scenario
from experiments.following.steps import steps, warmed_up
from experiments.keeping.provable import Provable
from experiments.logs import initial_headings
from experiments.real_robots.carried import Carried
from experiments.real_robots.motion import Motions
from filter import (
    AngularIntervals,
    Belief,
    Distrusted,
    Doubted,
    Frame,
    Guarantee,
    InvalidInput,
    Judged,
    Late,
    Mask,
    Region,
    Rejected,
    Restarted,
    RobustEvent,
    RobustFilter,
    Rules,
    SetMembershipFilter,
    Source,
    StartsOver,
    Step,
    Team,
    Tolerance,
    Turned,
    follow,
)

Which = Literal["sets", "robust"]
# Pairs and corners add nothing where odometry leaves so much open; finer slices and tangents do (docs/real-robots.md).
SETS: dict[str, Any] = {"policy": "reject", "pairs": 0, "corners": False, "slices": 36, "tangent_spacing": 0.1}
# Barcodes are misread for some pictures in a row, less than a second.
TOLERANCE = Tolerance(window=20.0, suspects="identities")


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


def team_filter(
    scenario: Scenario, motions: Motions, tolerate: int = 1, proofs: Path | None = None, which: Which = "sets"
) -> Iterator[Followed]:
    """Follow the scenario with the filter for real robots, frame by frame.

    Args:
        scenario: The run.
        motions: The robots' commands.
        tolerate: How many wrong votes on a robot do no harm, 0 or 1.
        proofs: A folder for all that is to be proved again, or None; not with the robust filter.
        which: The one filter for all teams, or the robust filter.

    Raises:
        InvalidInput: There are no proofs of what the robust filter does.
    """
    if proofs is not None and which == "robust":
        raise InvalidInput("--filter sets for --certificates", which)
    if which == "robust":
        return voting(scenario, Carried(motions), RobustFilter(scenario.team, Rules(tolerate)))
    return believing(scenario, Carried(motions), proofs, TOLERANCE if tolerate else None)


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
        silent = silent_in(told, scenario.team.robots)
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

    regions: Sequence[Region]
    headings: AngularIntervals


def believing(
    scenario: Scenario, carried: Carried, proofs: Path | None = None, tolerance: Tolerance | None = None
) -> Iterator[Followed]:
    """Follow with the one filter for all teams, which believes all that is not proved wrong, in frames about carried headings.

    Args:
        scenario: The run.
        carried: Makes its frames anew.
        proofs: A folder for all that is to be proved again, or None.
        tolerance: What may be wrong without harm, or None.
    """
    frames, own = tee(scenario.frames)
    told = carried.scenario(replace(scenario, frames=own))
    sets = SetMembershipFilter(scenario.team, each_alone=proofs is not None, tolerance=tolerance, **SETS)
    with nullcontext() if proofs is None else Provable(proofs, told, tolerance) as kept:
        for frame, step in zip(frames, steps(sets, told), strict=True):
            if kept is not None:
                kept.keep(step)
            yield believed(frame, step, carried.bounds.jitter, scenario.team)


def believed(frame: Frame, step: Step[Belief], jitter: float, team: Team) -> Followed:
    """Return a step of the one filter; what is rejected is what was just measured and is in a conflict."""
    belief, events = step.belief, (*step.predicted.events, *step.belief.events)
    doubts = [event for event in events if isinstance(event, Doubted)]
    rejected = {source for event in doubts for source in event.conflict if source.kind in ("bearing", "range")}
    guilty = (event.suspect for event in events if isinstance(event, Judged) and event.verdict == "guilty")
    return Followed(
        frame=frame,
        belief=Within(belief.regions, belief.headings.turned(0.0, jitter)),
        guarantee=belief.guarantee,
        lapsed=belief.guarantee,
        silent=silent_in(step.frame, team.robots),
        rejected=tuple(sorted({replace(source, kind="bearing") for source in rejected}, key=str)),
        resets=sum(len(event.robots) for event in events if isinstance(event, StartsOver)),
        put_aside=tuple(map(team.words, guilty)),
        events=tuple(map(team.words, events)),
        seconds=step.seconds,
    )


def silent_in(frame: Frame, robots: int) -> Mask:
    """Return (n,) of which robots a frame about carried headings says no motion."""
    return ~np.isin(np.arange(robots), [] if frame.odometry is None else frame.odometry.robot)
