"""Rows that follow from one measurement in the log. Exact arithmetic, standard library only."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from fractions import Fraction

from experiments.proof.arms import beyond, of_centre
from experiments.proof.edges import WORLD, Edges
from experiments.proof.exact import ANYWHERE, Arc, Vector, in_common, length
from experiments.proof.given.frame import Frame, Reading
from experiments.proof.given.log import Log
from experiments.proof.reading import Record
from experiments.proof.sides import Sides, compasses

BEARING, FAR = "rows of bearings, from the log", "rows of ranges, far side, from the log"
PLACED = "rows of positions, from the log"
NEAR = "rows of ranges, near side, from the log"
DIRECTION = "rows of directions of ranges, which are proved"
NEAR_OF_SIDES = "rows of ranges, near side, over a narrower arc that is proved"


@dataclass
class Instant:
    """What is known at one frame.

    Attributes:
        log: What was given to the filter.
        frame: The frame.
        headings: The robots' headings, as far as they are proved.
        sides: Where targets are, likewise.
        edges: What is proved of robots, likewise.
    """

    log: Log
    frame: Frame
    headings: Sequence[Arc]
    sides: Sides
    edges: Edges = field(default_factory=dict)


def of_measurement(then: Instant, pair: tuple[int, int], source: Record, normal: Vector, offset: Fraction) -> str | None:
    """Return why a row holds at the time of its measurement, or None if it does not.

    Args:
        then: What was measured and known.
        pair: The robots that it is about.
        source: Who measured what.
        normal: The row's.
        offset: The row's, before anybody moved.
    """
    robot, target, (x, y), robots = source["robot"], source["target"], normal, then.log.robots
    if source["kind"] == "position":
        own = then.frame.places.get(robot, []) if pair == (WORLD, robot) else []
        looks = in_common(then.headings[robot], compasses(then.frame, robot))
        found = (of_centre(placed, looks, normal, then.edges.get(pair, {})) for placed in own)
        return PLACED if any(bound is not None and bound <= offset for bound in found) else None
    if pair[0] < 0 and target is not None and target >= robots and robot == pair[1]:
        mark = then.log.landmarks[target - robots]
        x, y, offset = -x, -y, offset - (x * mark[0] + y * mark[1])  # of the landmark, seen from the robot
    elif (target, robot) == pair:
        x, y = -x, -y
    elif (robot, target) != pair:
        return None
    for reading in then.frame.of(source["kind"], robot, target):
        left = offset - beyond((reading.own, reading.other), (robot, target), then.headings, (x, y))  # of the sensors' places
        if source["kind"] == "bearing":
            arc = then.headings[robot].widened(reading.value, reading.bound)
            if arc.narrow and arc.most((x, y)) <= 0 <= left:
                return BEARING
        elif link := _of_range(then, (robot, target), reading, (x, y), left):
            return link
    return None


def _of_range(then: Instant, who: tuple[int, int], reading: Reading, normal: Vector, offset: Fraction) -> str | None:
    least, greatest = between(reading)
    if offset >= greatest * length(normal):
        return FAR
    sights, proved = _sights(then, who, reading), then.sides.arc(*who, (reading.own, reading.other))
    arcs = [(arc, NEAR) for arc in (*sights, in_common(ANYWHERE, sights))]
    if proved is not None:
        arcs.append((in_common(proved, sights), NEAR_OF_SIDES))
    for arc, link in arcs:
        if arc.narrow and arc.most(normal) <= 0 and offset >= least * arc.most(normal):
            return link if offset < 0 else DIRECTION
    return None


def between(reading: Reading) -> tuple[Fraction, Fraction]:
    """Return the least and the greatest distance that a range leaves [m]."""
    value, bound, share = reading.value, reading.bound, reading.share
    return max(Fraction(0), (value - bound) / (1 + share)), (value + bound) / (1 - share)


def _sights(then: Instant, who: tuple[int, int], reading: Reading) -> list[Arc]:
    """Return where a target is, as seen from a robot, by each bearing of one to the other between the places of a reading."""
    (robot, target), spots = who, (reading.own.spot, reading.other.spot)
    own = [one for one in then.frame.of("bearing", robot, target) if (one.own.spot, one.other.spot) == spots]
    found = [then.headings[robot].widened(one.value, one.bound) for one in own]
    if target < then.log.robots:
        back = [one for one in then.frame.of("bearing", target, robot) if (one.other.spot, one.own.spot) == spots]
        found += [then.headings[target].widened(one.value, one.bound).opposite for one in back]
    return found
