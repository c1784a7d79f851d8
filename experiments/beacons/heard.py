"""A real team that stands and measures ranges: some robots become anchors, its first seconds tell the bounds, ranges can lie.

The truth says where the anchors are and how wrong the first ranges are, and it judges.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from experiments.beacons.scenes import Scene
from experiments.following.frozen import freeze
from experiments.following.scenarios import Scenario
from filter import Array, Frame, Integers, InvalidInput, Range, Team, Truth

Lie = Literal["none", "longer", "moved"]
Bounds = Literal["common", "pair"]
STILL = 0.02  # what is tracked of a robot that stands may be spread by this [m]
AROUND = 3.0  # from the robots to the sides of the arena [m]
LIES = {"longer": 1.5, "moved": 1.0}  # by how much [m]
LASTS = 5.0  # how long a range is too long [s]; what was moved stays


@dataclass(frozen=True, eq=False)
class Heard:
    """Ranges of robots that stand.

    Attributes:
        names: (n) the robots.
        places: (n, 2) where they stand [m].
        time: (k,) when each range was measured, from the first one on [s].
        robot: (k,) who measured.
        target: (k,) whom.
        length: (k,) the range [m].
    """

    names: tuple[str, ...]
    places: Array
    time: Array
    robot: Integers
    target: Integers
    length: Array

    def __post_init__(self) -> None:
        freeze(self)

    @property
    def error(self) -> Array:
        """(k,) by how much each range is longer than the distance of the places [m]."""
        return self.length - np.hypot(*(self.places[self.target] - self.places[self.robot]).T)

    def number(self, name: str) -> int:
        """Return the number of a robot.

        Raises:
            InvalidInput: There is none of that name.
        """
        if name not in self.names:
            raise InvalidInput(f"a robot among {', '.join(self.names)}", name)
        return self.names.index(name)


def heard(scenario: Scenario) -> Heard:
    """Return what a scenario's robots measured.

    Raises:
        InvalidInput: There are landmarks or no ranges, or a robot's truth is not known, or not that of one that stands.
    """
    team, ranges, seen = scenario.team, list[Range](), [list[Array]() for _ in range(scenario.team.robots)]
    for frame in scenario.frames:
        ranges += [record for record in frame.measurements if isinstance(record, Range)]
        if frame.truth is not None:
            for robot in np.flatnonzero(np.isfinite(frame.truth.positions).all(axis=1)):
                seen[robot].append(frame.truth.positions[robot])
    if len(team.landmarks) or not ranges:
        raise InvalidInput("a log of robots that measure ranges to one another, without landmarks", "another one")
    names = tuple(map(team.name, range(team.robots)))
    places = np.array([_standing_at(name, each) for name, each in zip(names, seen, strict=True)])
    who, whom, length = (np.concatenate([getattr(each, name) for each in ranges]) for name in ("robot", "target", "range"))
    time = np.repeat([each.time for each in ranges], [len(each.robot) for each in ranges])
    return Heard(names, places, time - time[0], who, whom, length)


def _standing_at(name: str, seen: Sequence[Array]) -> Array:
    if not seen or np.ptp(seen, axis=0).max() > STILL:
        raise InvalidInput(f"a truth for {name} that stays where it is", "none" if not seen else "one that moves")
    return np.mean(seen, axis=0)


def bounds_of(said: Heard, learned: float, margin: float, bounds: Bounds) -> Array:
    """Return (k, 2) the least and the greatest error that each range may have, as the first seconds tell it [m].

    Args:
        said: What was measured.
        learned: How long these are [s].
        margin: By what share of their width the bounds are wider on either side.
        bounds: Whether they are the same for all, or those of each robot that measures each other one.

    Raises:
        InvalidInput: Somebody was not measured in the first seconds.
    """
    pair = said.robot * len(said.names) + said.target if bounds == "pair" else np.zeros(len(said.time), dtype=int)
    kinds, first = np.unique(pair), said.time <= learned
    of = {kind: said.error[first & (pair == kind)] for kind in kinds.tolist()}
    if not all(map(len, of.values())):
        raise InvalidInput(f"ranges of every pair in the first {learned:g} s", "none of some")
    ends = np.array([(errors.min(), errors.max()) for errors in of.values()])
    wider = margin * (ends[:, 1] - ends[:, 0])
    return np.stack([ends[:, 0] - wider, ends[:, 1] + wider], axis=1)[np.searchsorted(kinds, pair)]


def lied(said: Heard, lie: Lie, liar: tuple[int, int], since: float) -> Heard:
    """Return what would have been measured if something lied from a time on.

    Args:
        said: What was measured.
        lie: "longer": what the first one measures of the second is longer for five seconds; "moved": the second one was moved
            to the right, though nobody knows, for good.
        liar: Who measures, and whom.
        since: From when on [s].

    Raises:
        InvalidInput: Nothing was measured then that could lie.
    """
    if lie == "none":
        return said
    added = _longer(said, liar, since) if lie == "longer" else _moved(said, liar[1], since)
    if not added.any():
        who, whom = (said.names[each] for each in liar)
        raise InvalidInput(f"ranges of {who} to {whom} after {since:g} s, for a lie", "none")
    return replace(said, length=said.length + added)


def _longer(said: Heard, liar: tuple[int, int], since: float) -> Array:
    robot, target = liar
    which = (said.robot == robot) & (said.target == target) & (said.time > since) & (said.time <= since + LASTS)
    return LIES["longer"] * which


def _moved(said: Heard, target: int, since: float) -> Array:
    """Return by how much each range is longer as one of the robots is elsewhere than where it is known."""
    places = said.places.copy()
    places[target] += [LIES["moved"], 0.0]
    return np.where(said.time > since, said.error - replace(said, places=places).error, 0.0)


def scene_of(said: Heard, anchors: Sequence[int], limits: Array, since: float, every: float) -> Scene:
    """Return the scene in which all but the anchors can be anywhere at the start.

    Args:
        said: What is measured.
        anchors: The numbers of those whose places are known.
        limits: (k, 2) the least and the greatest error of each range [m].
        since: From when on there are frames [s].
        every: How often [s]; each has the newest range of each robot to each other one.

    Raises:
        InvalidInput: Nobody is left, nobody is an anchor, or there is nothing after the first seconds.
    """
    others = [robot for robot in range(len(said.names)) if robot not in anchors]
    times = np.arange(since + every, said.time[-1], every)
    if not 0 < len(others) < len(said.names) or not len(times):
        raise InvalidInput(
            "anchors, other robots, and ranges after the first seconds", f"{len(others)} robots, {len(times)} frames"
        )
    marks = {said.names[anchor]: said.places[anchor] for anchor in anchors}
    arena = np.array([said.places.min(axis=0) - AROUND, said.places.max(axis=0) + AROUND])
    team = Team([said.names[robot] for robot in others], marks, 0.0, 0.0, arena)
    records = _records(said, team, limits)
    truth = Truth(said.places[others], np.zeros(len(others)))
    frames = (Frame(time, None, (_newest(records, time - every, time),), truth) for time in times.tolist())
    return Scene("heard", team, (None,) * len(others), None, tuple(frames))


@dataclass(frozen=True, eq=False)
class _Records:
    """Ranges in the numbers of a team with anchors, (k,) each; what an anchor measured counts as measured of it."""

    time: Array
    pair: Integers
    robot: Integers
    target: Integers
    length: Array
    half: Array


def _records(said: Heard, team: Team, limits: Array) -> _Records:
    numbers = np.array([team.number_of(name) for name in said.names])
    robot, target = numbers[said.robot], numbers[said.target]
    swapped, pair = robot >= team.robots, robot * len(numbers) + target
    robot, target = np.where(swapped, target, robot), np.where(swapped, robot, target)
    known = robot < team.robots  # what anchors measured of one another tells nothing
    length, half = np.maximum(0.0, said.length - limits.mean(axis=1)), (limits[:, 1] - limits[:, 0]) / 2
    return _Records(said.time[known], pair[known], robot[known], target[known], length[known], half[known])


def _newest(records: _Records, after: float, until: float) -> Range:
    """Return the newest range of each robot to each other one within a time."""
    fresh = np.flatnonzero((records.time > after) & (records.time <= until))[::-1]
    newest = fresh[np.unique(records.pair[fresh], return_index=True)[1]]
    robot, target, length, half = (getattr(records, name)[newest] for name in ("robot", "target", "length", "half"))
    return Range(until, robot, target, length, half, 0.0)
