"""Who can be wrong in a conflict: all parts of it stand for somebody, and one of these is it, if only one is."""

from collections.abc import Collection, Iterable, Sequence

from filter.diagnosis.told import Who, said
from filter.linear.sources import Source
from filter.records.frame import Frame
from filter.sets.suspect import Suspect


def suspects_of(conflict: Iterable[Source], frames: Sequence[Frame], robots: int, since: float) -> tuple[Suspect, ...]:
    """Return who can be wrong since a time [s], in an order of their own, in a conflict in a team of so many robots.

    What was known of a robot before the last frame rests on all that was measured by it and of it before that, and on what was
    known of the mates that this ties it to: so these are suspected, too. The arena is not.
    """
    found, pasts = set[Suspect](), set[int]()
    for source in conflict:
        if source.kind == "compass":
            found.add(Suspect("compass", source.robot, None, since))
        elif source.kind == "position":
            found.add(Suspect("sensor", source.robot, None, since))
        elif source.kind in ("bearing", "range", "relative heading", "sighting"):
            found |= _of_a_sighting(source.robot, source.target, robots, since)
        elif source.kind != "arena":
            pasts |= {source.robot} if source.target is None else {source.robot, source.target}
    told = [said(tuple(frame.measurements)) for frame in frames[:-1]]
    pasts |= {body for some in told for body in _mates(pasts, some) if body < robots}
    found |= {Suspect("past", robot, None, since) for robot in pasts}
    for some in told:
        found |= _behind(pasts, some, robots, since)
    return tuple(sorted(found, key=lambda suspect: suspect.who))


def everybody(frames: Sequence[Frame], there: Collection[int], robots: int, since: float) -> tuple[Suspect, ...]:
    """Return who can be wrong since a time [s], whatever the conflict: the pasts of robots there, and all who said anything."""
    pasts = [Source("region", since, robot) for robot in sorted(there)]
    return suspects_of(pasts, [*frames, Frame(frames[-1].time)], robots, since)


def _of_a_sighting(robot: int, target: int | None, robots: int, since: float) -> set[Suspect]:
    found = {Suspect("sensor", robot, None, since), Suspect("sighting", robot, target, since)}
    found.add(Suspect("body", None, target, since))
    if target is not None and target < robots:
        others = set(range(robots)) - {robot, target}
        found |= {Suspect("exchange", min(target, other), max(target, other), since) for other in others}
    return found


def _mates(pasts: set[int], told: set[Who]) -> set[int]:
    """Return the bodies that were seen by some robots, or have seen them."""
    pairs = [{robot, target} for kind, robot, target in told if kind == "sighting" and target >= 0]
    return {body for pair in pairs if pair & pasts for body in pair}


def _behind(pasts: set[int], told: set[Who], robots: int, since: float) -> set[Suspect]:
    """Return who has a part in what was known of some robots."""
    found = set[Suspect]()
    for kind, robot, target in told:
        if kind == "compass" and robot in pasts:
            found.add(Suspect("compass", robot, None, since))
        elif kind == "sighting" and target < 0 and robot in pasts:
            found.add(Suspect("sensor", robot, None, since))
        elif kind == "sighting" and target >= 0 and {robot, target} & pasts:
            found |= _of_a_sighting(robot, target, robots, since)
    return found
