"""The one place that decides which filter follows real robots, and what an experiment needs to know of it at every step."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from itertools import tee
from pathlib import Path
from typing import Any, Literal

import numpy as np

from experiments.following.located import Located
from experiments.following.scenarios import Scenario
from experiments.following.steps import steps
from experiments.keeping.provable import Provable
from experiments.real_robots.carried import Carried
from experiments.real_robots.motion import Motions
from filter import (
    AngularIntervals,
    Belief,
    Doubted,
    Frame,
    Guarantee,
    InvalidInput,
    Judged,
    Late,
    Mask,
    Region,
    RobustFilter,
    SetMembershipFilter,
    Source,
    StartsOver,
    Step,
    Team,
    Tolerance,
    Turned,
)

Which = Literal["sets", "robust"]
KINDS = {"sets": SetMembershipFilter, "robust": RobustFilter}
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
        which: The one filter for all teams, or the robust one, which has evidence on cameras besides.

    Raises:
        InvalidInput: There are no proofs of what the robust filter does.
    """
    if proofs is not None and which == "robust":
        raise InvalidInput("--filter sets for --certificates", which)
    return believing(scenario, Carried(motions), proofs, TOLERANCE if tolerate else None, which)


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
    scenario: Scenario,
    carried: Carried,
    proofs: Path | None = None,
    tolerance: Tolerance | None = None,
    which: Which = "sets",
) -> Iterator[Followed]:
    """Follow with the one filter for all teams, which believes all that is not proved wrong, in frames about carried headings.

    Args:
        scenario: The run.
        carried: Makes its frames anew.
        proofs: A folder for all that is to be proved again, or None.
        tolerance: What may be wrong without harm, or None.
        which: Whether with evidence on cameras.
    """
    frames, own = tee(scenario.frames)
    told = carried.scenario(replace(scenario, frames=own))
    sets = KINDS[which](scenario.team, each_alone=proofs is not None, tolerance=tolerance, **SETS)
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
    guilty = [team.words(event.suspect) for event in events if isinstance(event, Judged) and event.verdict == "guilty"]
    guilty += [named(event, team) for event in events if isinstance(event, Turned | Late) and event.aside]
    return Followed(
        frame=frame,
        belief=Within(belief.regions, belief.headings.turned(0.0, jitter)),
        guarantee=belief.guarantee,
        silent=silent_in(step.frame, team.robots),
        rejected=tuple(sorted({replace(source, kind="bearing") for source in rejected}, key=str)),
        resets=sum(len(event.robots) for event in events if isinstance(event, StartsOver)),
        put_aside=tuple(guilty),
        events=tuple(map(team.words, events)),
        seconds=step.seconds,
    )


def named(event: Turned | Late, team: Team) -> str:
    """Return the name of the sensor that an event is about."""
    return f"{'camera clock' if isinstance(event, Late) else 'camera'} of {team.name(event.robot)}"


def silent_in(frame: Frame, robots: int) -> Mask:
    """Return (n,) of which robots a frame about carried headings says no motion."""
    return ~np.isin(np.arange(robots), [] if frame.odometry is None else frame.odometry.robot)
