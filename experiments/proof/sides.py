"""Directions of targets, as far as they are proved, and the headings that follow. Exact arithmetic, standard library only.

A side is a line of certificates that puts a target wholly to one side of a line through the robot: half a circle of directions.
Two of them leave an arc; a bearing to the target then says where the robot looks, and a range how near the target is. Where
sensors are mounted, what is meant is the place of one sensor, as seen from another.
"""

from collections.abc import Iterator, Sequence
from copy import copy
from fractions import Fraction

from experiments.proof.arms import Two, beyond
from experiments.proof.edges import WORLD, plane
from experiments.proof.exact import Arc, Vector, are_apart, below, half_circle, in_common
from experiments.proof.given.frame import MATES, Frame
from experiments.proof.given.sensors import CENTRE, Mounts
from experiments.proof.reading import Broken, Record, exact, shown

CENTRES = (CENTRE, CENTRE)
# What robots see of mates' headings is followed in so many laps at most, besides one for each robot, as in the filter. What
# makes an arc narrower by less than this is left out [rad]: a wider arc is right, too. The filter leaves out more than that.
LAPS, GAIN = 1000, below(Fraction(1, 10**13))


class Sides:
    """What is proved of directions at one time."""

    def __init__(self, robots: int, landmarks: Sequence[Vector], mounts: Mounts | None = None) -> None:
        self._robots, self._landmarks, self._mounts = robots, landmarks, mounts or Mounts({})
        self._arcs: dict[tuple[int, int, int, int], Arc] = {}  # of both bodies, and of spots on them

    def copy(self) -> "Sides":
        """Return the same, to be added to."""
        other = copy(self)
        other._arcs = dict(self._arcs)
        return other

    def add(self, line: Record, offset: Fraction | None, looks: Sequence[Arc] = ()) -> None:
        """Take in a line, and the offset that it proves, None if another process proves it.

        Its `side` is the robot or landmark that it is about, robots first.
        If it has `sensors`, on its robots or on its robot and the landmark, their places are meant; robots look so.

        Raises:
            Broken: The target may be on the line, where the robot may be, too, or beyond it.
        """
        (x, y), claimed, target, past = plane(line["normal"]), exact(line["offset"]), line["side"], Fraction(0)
        pair = (line["from"], line["robot"])
        if line["from"] == WORLD and type(target) is int and target >= self._robots:
            mark, pair = self._landmarks[target - self._robots], (line["robot"], target)
            x, y, past = -x, -y, x * mark[0] + y * mark[1]
        elif line["from"] == WORLD or target != line["from"]:
            raise Broken(f"a side of {shown(target)}, of which the line does not speak")
        first, last = mounts = self._mounts.pair(line["sensors"]) if "sensors" in line else CENTRES
        if offset is not None:
            past -= beyond(mounts, pair, looks, (-x, -y)) if mounts != CENTRES else 0
            if claimed > past or offset >= past:  # of what is in one place with the robot, bearings say nothing
                raise Broken(f"a side that the target may be {float(max(claimed, offset) - past):.3g} m beyond")
        half, key = half_circle((x, y)), (*pair, first.spot, last.spot)
        self._arcs[key] = in_common(self._arcs.get(key, half), [half])

    def arc(self, robot: int, target: int, mounts: Two = CENTRES) -> Arc | None:
        """Return where a target is, as seen from a robot, or its sensor from another; None where nothing is proved of that."""
        own, other = (mount.spot for mount in mounts)
        if target < self._robots and robot > target:
            arc = self._arcs.get((target, robot, other, own))
            return None if arc is None else arc.opposite
        return self._arcs.get((robot, target, own, other))

    def looking(self, frame: Frame, looks: Sequence[Arc]) -> list[Arc]:
        """Return how robots that look so can look by compasses, bearings, and what they see of each other's headings."""
        told = [[*compasses(frame, robot), *self.headings(frame, robot)] for robot in range(len(looks))]
        return tied(frame, [in_common(*each) for each in zip(looks, told, strict=True)])

    def are_torn(self, frame: Frame, looks: Sequence[Arc]) -> bool:
        """Return whether robots that look so have, for sure, one whose heading nothing is left of by all of that."""
        left = self.looking(frame, looks)
        told = [(robot, [*compasses(frame, robot), *self.headings(frame, robot)]) for robot in range(len(left))]
        told += [(mate, [left[robot].widened(value, bound)]) for robot, mate, value, bound in _ties(frame)]
        return any(are_apart(left[robot], arc) for robot, arcs in told for arc in arcs)

    def headings(self, frame: Frame, robot: int) -> list[Arc]:
        """Return where a robot can look, by each of its bearings to a target whose direction is known."""
        found = []
        for kind, who, target in frame.readings:
            for one in frame.of(kind, who, target) if kind == "bearing" and who == robot and target is not None else ():
                arc = self.arc(robot, target, (one.own, one.other)) if target is not None else None
                found += [] if arc is None else [arc.widened(-one.value, one.bound)]
        return found


def compasses(frame: Frame, robot: int) -> list[Arc]:
    """Return where a robot can look, by each of its compass readings."""
    readings = frame.of("compass", robot)
    return [Arc.between(one.value - one.bound, one.value + one.bound) for one in readings]


def looking(frame: Frame, looks: Sequence[Arc]) -> list[Arc]:
    """Return how robots that look so can look by their compasses, and by what they see of each other's headings."""
    return tied(frame, [in_common(arc, compasses(frame, robot)) for robot, arc in enumerate(looks)])


def tied(frame: Frame, looks: Sequence[Arc]) -> list[Arc]:
    """Return how robots that look so can look by what they see of each other's headings, forth and back.

    In the filter's order: of two wide arcs that meet at both ends it matters which is cut from which.
    """
    found, ties = list(looks), sorted(_ties(frame))
    for _ in range(LAPS + len(found) if ties else 0):
        before = list(found)
        for robot, mate, value, bound in ties:
            found[mate] = _cut(found[mate], found[robot].widened(value, bound))
            found[robot] = _cut(found[robot], found[mate].widened(-value, bound))
        ties.reverse()
        if found == before:
            break
    return found


def _ties(frame: Frame) -> Iterator[tuple[int, int, Fraction, Fraction]]:
    """Yield which robot saw which mate head elsewhere than itself, by how much, and within which bound."""
    for (kind, robot, mate), readings in frame.readings.items():
        if kind == MATES and mate is not None:
            yield from ((robot, mate, one.value, one.bound) for one in readings)


def _cut(known: Arc, arc: Arc) -> Arc:
    """Return what two arcs have in common, or the first one where that is hardly narrower."""
    both = in_common(known, [arc])
    return both if known.width - both.width > GAIN else known
