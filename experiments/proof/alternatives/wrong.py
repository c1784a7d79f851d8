"""What is left of a frame if one thing is wrong, and who can be wrong. Standard library only.

One thing is a kind, a robot and a target, -1 for nobody: the "past" of a robot, its "compass", its "sensor" (all others that
it has), a "body" that is not where it should be, a "sighting" by a robot of a target, or the "exchange" of two robots' markers.
"""

from collections.abc import Collection, Iterable
from dataclasses import replace
from fractions import Fraction

from experiments.proof.exact import ANYWHERE
from experiments.proof.given.frame import Frame, Reading, Start, Who, Within
from experiments.proof.given.log import Log
from experiments.proof.reading import Broken, shown

Wrong = tuple[str, int, int]
NOBODY = -1
# Whether a robot, and whether a target is named; robots are counted before landmarks.
KINDS = {"past": (1, 0), "compass": (1, 0), "sensor": (1, 0), "body": (0, 1), "sighting": (1, 1), "exchange": (1, 1)}


def wrong_in(log: Log, told: object) -> Wrong:
    """Return a thing that can be wrong, as a record says it; raises `Broken` if there is no such thing."""
    if isinstance(told, list) and len(told) == 3 and told[0] in KINDS and type(told[1]) is type(told[2]) is int:
        kind, robot, target = told
        bodies = log.robots if kind == "exchange" else log.robots + len(log.landmarks)
        of_robot, of_target = KINDS[kind]
        is_robot = 0 <= robot < log.robots if of_robot else robot == NOBODY
        if is_robot and (0 <= target < bodies if of_target else target == NOBODY) and robot != target:
            return kind, robot, target
    raise Broken(f"one thing that can be wrong was expected, not {shown(told)}")


def words(log: Log, wrong: Wrong) -> str:
    """Return what is wrong in words."""
    names = [*log.names, *log.marks]
    return " ".join([wrong[0], *(names[body] for body in wrong[1:] if body != NOBODY)])


def without(frame: Frame, wrong: Wrong) -> Frame:
    """Return what is left of a frame: nothing of what would be wrong, or what was read of two bodies as of one another."""
    kind, robot, target = wrong
    if kind == "past":
        return frame
    readings, other = dict[Who, list[Reading]](), {robot: target, target: robot} if kind == "exchange" else {}
    for (what, who, whom), several in frame.readings.items():
        seen = other.get(whom, whom) if whom is not None else None
        is_said = {
            "compass": what == "compass" and who == robot,
            "sensor": what != "compass" and who == robot,
            "body": whom == target,
            "sighting": (who, whom) == (robot, target),
            "exchange": seen == who,  # nobody sees itself
        }
        if not is_said[kind]:
            readings.setdefault((what, who, seen), []).extend(several)
    places = {who: several for who, several in frame.places.items() if kind != "sensor" or who != robot}
    return replace(frame, readings=readings, places=places)


def without_both(frame: Frame, exchanged: Wrong) -> Frame:
    """Return what is left of a frame if nobody knows whether two robots wore each other's markers then."""
    return without(without(frame, ("body", NOBODY, exchanged[1])), ("body", NOBODY, exchanged[2]))


def without_robots(frame: Frame, robots: Collection[int]) -> Frame:
    """Return what is left of a frame without all that some robots measured, and that was measured of them."""
    readings = {who: several for who, several in frame.readings.items() if who[1] not in robots and who[2] not in robots}
    return replace(frame, readings=readings, places={who: some for who, some in frame.places.items() if who not in robots})


def without_ties(frame: Frame, robots: Collection[int], count: int) -> Frame:
    """Return what is left of a frame without what some robots measured of any of so many, and these of them."""
    apart = {who for who in frame.readings if who[2] is not None and who[2] < count and not {*who[1:]}.isdisjoint(robots)}
    return replace(frame, readings={who: several for who, several in frame.readings.items() if who not in apart})


def apart(frame: Frame, robots: Collection[int], count: int, unheard: Collection[int]) -> Frame:
    """Return what is left of a frame without ties of some robots to any of so many, and without all by others or of them."""
    return without_robots(without_ties(frame, robots, count), unheard)


def anywhere(log: Log, frame: Frame, robots: Collection[int]) -> Frame:
    """Return a frame at which some robots can be anywhere in the arena, however they got there, and look anywhere."""
    if not robots:
        return frame
    if None in (*log.arena[0], *log.arena[1]):
        raise Broken("robots that are anywhere, where the arena is open")
    (left, low), (right, high) = (tuple(Fraction(each or 0) for each in corner) for corner in log.arena)
    place = Within([(left, low), (right, low), (right, high), (left, high)])
    return replace(frame, changes=[*frame.changes, *((robot, Start(place, ANYWHERE)) for robot in sorted(robots))])


def everybody(frames: Iterable[Frame], robots: int) -> set[Wrong]:
    """Return all that can be wrong, in what so many robots have said and been since some frame."""
    found = set[Wrong]()
    for frame in frames:
        there = set(range(robots)) - frame.away
        found |= {("past", robot, NOBODY) for robot in there} | {("sensor", robot, NOBODY) for robot in frame.places}
        for what, who, whom in frame.readings:
            if whom is None:
                found.add((what, who, NOBODY))
                continue
            found |= {("sensor", who, NOBODY), ("body", NOBODY, whom), ("sighting", who, whom)}
            others = set(range(robots)) - {who, whom} if whom < robots else set[int]()
            found |= {("exchange", min(whom, other), max(whom, other)) for other in others}
    return found
