"""Who can be wrong in a conflict: everybody who was there or said anything; and whom the conflict itself names."""

from collections.abc import Collection, Iterable, Sequence

from filter.diagnosis.told import Who, said
from filter.linear.sources import NOBODY, Source
from filter.records.frame import Frame
from filter.sets.suspect import Suspect


def everybody(frames: Sequence[Frame], there: Collection[int], robots: int, since: float) -> tuple[Suspect, ...]:
    """Return who can be wrong since a time [s], whatever the conflict: the pasts of robots there, and all who said anything.

    What was known rests on what was known before, and that ties robots to others whom nobody saw lately: so nobody is left out.
    The arena is not suspected.

    Args:
        frames: The last instants.
        there: Which robots are.
        robots: How many are in the team.
        since: The suspects' time [s].
    """
    told = set[Who]().union(*(said(tuple(frame.measurements)) for frame in frames))
    return _suspects(told | {("past", robot, NOBODY) for robot in there}, robots, since)


def named_by(conflict: Iterable[Source], robots: int, since: float) -> tuple[Suspect, ...]:
    """Return those whom the parts of a conflict stand for, of a team of so many robots, since a time [s]."""
    return _suspects({who for source in conflict for who in _behind(source)}, robots, since)


def _behind(source: Source) -> set[Who]:
    """Return who can be behind one part of a conflict."""
    robot, target = (NOBODY if body is None else body for body in (source.robot, source.target))
    if source.kind == "compass":
        return {("compass", robot, NOBODY)}
    if source.kind == "position":
        return {("sensor", robot, NOBODY)}
    if source.kind in ("bearing", "range", "relative heading"):
        return {("sensor", robot, NOBODY), ("body", NOBODY, target), ("sighting", robot, target)}
    pasts = {("past", body, NOBODY) for body in (robot, target) if body != NOBODY}
    return set() if source.kind == "arena" else pasts


def _suspects(told: Iterable[Who], robots: int, since: float) -> tuple[Suspect, ...]:
    """Return suspects, in an order of their own; whoever is seen can have exchanged its marker with any third robot."""
    found = {who for who in told if who[0] != "sighting" or who[2] != NOBODY}
    pairs = [who[1:] for who in found if who[0] == "sighting" and who[2] < robots]
    for robot, target in pairs:
        found |= {("exchange", min(target, other), max(target, other)) for other in {*range(robots)} - {robot, target}}
    return tuple(Suspect.of(who, since) for who in sorted(found))
