"""Directions of targets, as far as they are proved, and the headings that follow. Exact arithmetic, standard library only.

A side is a line of certificates that puts a target wholly to one side of a line through the robot: half a circle of directions.
Two of them leave an arc; a bearing to the target then says where the robot looks, and a range how near the target is.
"""

from collections.abc import Sequence
from fractions import Fraction

from experiments.proof.edges import WORLD, plane
from experiments.proof.exact import Arc, Vector, half_circle, in_common
from experiments.proof.given.frame import Frame
from experiments.proof.reading import Broken, Record, exact, shown


class Sides:
    """What is proved of directions at one time."""

    def __init__(self, robots: int, landmarks: Sequence[Vector]) -> None:
        self._robots, self._landmarks = robots, landmarks
        self._arcs: dict[tuple[int, int], Arc] = {}

    def add(self, line: Record, offset: Fraction) -> None:
        """Take in a line, and the offset that it proves; its `side` is the robot or landmark that it is about, robots first.

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
        if claimed > past or offset >= past:  # of what is in one place with the robot, bearings say nothing
            raise Broken(f"a side that the target may be {float(max(claimed, offset) - past):.3g} m beyond")
        half = half_circle((x, y))
        self._arcs[pair] = in_common(self._arcs.get(pair, half), [half])

    def arc(self, robot: int, target: int) -> Arc | None:
        """Return where a target is, as seen from a robot; None where nothing is proved of that."""
        if target < self._robots and robot > target:
            arc = self._arcs.get((target, robot))
            return None if arc is None else arc.opposite
        return self._arcs.get((robot, target))

    def headings(self, frame: Frame, robot: int) -> list[Arc]:
        """Return where a robot can look, by each of its bearings to a target whose direction is known."""
        found = []
        for kind, who, target in frame.readings:
            arc = self.arc(robot, target) if kind == "bearing" and who == robot and target is not None else None
            if arc is not None:
                found += [arc.widened(-one["bearing"], one["bound"]) for one in frame.of(kind, robot, target)]
        return found


def compasses(frame: Frame, robot: int) -> list[Arc]:
    """Return where a robot can look, by each of its compass readings."""
    readings = frame.of("compass", robot)
    return [Arc(one["heading"] - one["bound"], one["heading"] + one["bound"]) for one in readings]
