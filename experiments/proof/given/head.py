"""How a log begins: the team, and what is known of each robot at the start. Standard library only."""

import re
from collections.abc import Iterator, Sequence
from collections.abc import Set as AbstractSet
from fractions import Fraction
from itertools import chain, product
from math import inf
from typing import Any

from experiments.proof.exact import Vector, arc_around
from experiments.proof.given.driven import Limits
from experiments.proof.given.frame import Start, Within
from experiments.proof.given.sensors import Mounts
from experiments.proof.reading import Broken, Record, body, located, number, shown

FIRST, SECOND = 1, 2  # versions of the format
HEADER = {"format", "version", "robots", "landmarks", "arena", "speed_limit", "turn_rate_limit", "start"}
ACCELERATIONS = ("acceleration_limit", "turn_acceleration_limit")
NAME = re.compile(r"\w[\w.-]{0,63}")  # they are parts of files' names


class Head:
    """What a log begins with.

    Attributes:
        version: Of the format.
        robots: How many.
        names: Of the robots, in their order.
        marks: Names of the landmarks, in their order.
        landmarks: Where they are [m].
        mounts: The sensors that are mounted somewhere.
        arena: Lower and upper corner, None for a coordinate without a limit [m].
        limits: Of each robot.
        start: When the initial sets hold [s].
        rate: Frames a second [Hz], or None.
        starts: What is known of each robot at the start; of one that is not there yet, a place that means nothing.
        away: Robots that are not there yet.
        rest: The lines that follow.
    """

    def __init__(self, lines: Iterator[tuple[str, Record]]) -> None:
        place, header = next(lines, ("log.jsonl", {}))
        with located(place):
            self._read_header(header)
        known: dict[int, Start] = {}
        self.rest = lines
        while len(known) < self.robots:
            place, record = next(lines, ("log.jsonl", {}))
            if self.version > FIRST and (record.get("record") != "initial" or "time" in record):
                self.rest = chain([(place, record)] if record else [], lines)
                break
            with located(place):
                robot, start = self.placed(record)
                if robot in known:
                    raise Broken(f"a second initial set of robot {robot}")
                known[robot] = start
        self.away = frozenset(range(self.robots)) - known.keys()
        self.starts = [known.get(robot, self._nowhere) for robot in range(self.robots)]

    def robot(self, value: Any) -> int:
        """Return the number of a robot; a name will do, from version 2 on."""
        return self._body(value, self.names)

    def target(self, mate: Any, mark: Any) -> int:
        """Return the number of a robot or a landmark that was seen; robots are counted first."""
        if (mate is None) == (mark is None):
            raise Broken("either a target or a landmark was expected")
        return self.robot(mate) if mark is None else self.robots + self._body(mark, self.marks)

    def _body(self, value: Any, names: Sequence[str]) -> int:
        if self.version > FIRST and isinstance(value, str) and value in names:
            return names.index(value)
        return body(value, len(names))

    def _read_header(self, header: Record) -> None:
        form, version = header.get("format"), header.get("version")
        if form != "corral-log" or type(version) is not int or version not in (FIRST, SECOND):
            raise Broken(f"a log of version 1 or 2 was expected, not {shown(form)}, version {shown(version)}")
        self.version: int = version
        later = {"rate", "sensors", *ACCELERATIONS} if self.version > FIRST else set()
        fields = fields_of(header, "header", HEADER | ({"rate"} - later), later)
        robots, marks = fields["robots"], fields["landmarks"]
        named = isinstance(robots, list) and self.version > FIRST
        self.names = _names(robots) if named else [f"r{k}" for k in range(body(robots, 10**6))]
        self.robots = len(self.names)
        named = isinstance(marks, dict) and self.version > FIRST
        self.marks = _names(marks) if named else [f"l{k}" for k in range(len(marks))]
        self.mounts = Mounts(fields.get("sensors", {}))
        self.landmarks = [point(place) for place in (marks.values() if named else marks)]
        if len({*self.names, *self.marks}) < len(self.names) + len(self.marks):
            raise Broken("names of robots and landmarks, no two alike, were expected")
        least, greatest = fields["arena"]
        self.arena = [[None if value is None else number(value) for value in (x, y)] for x, y in (least, greatest)]
        self.limits = [Limits(*each) for each in zip(*self._limits(fields), strict=True)]
        self.start, rate = number(fields["start"]), fields.get("rate")
        self.rate = None if rate is None else number(rate, 0)

    def _limits(self, fields: Record) -> Iterator[list[Any]]:
        """Yield each limit of every robot: one for all, or from version 2 on one for each by its name."""
        for name in ("speed_limit", "turn_rate_limit", *ACCELERATIONS):
            limit: Any = fields.get(name)
            may = name in ACCELERATIONS
            if isinstance(limit, dict) and self.version > FIRST and set(limit) != set(self.names):
                raise Broken(f"{name}: one for each of {self.robots} robots was expected")
            named = isinstance(limit, dict) and self.version > FIRST
            each = [limit[robot] for robot in self.names] if named else [limit] * self.robots
            yield [None if value is None and may else Fraction(number(value, 0)) for value in each]

    def placed(self, record: Record, *more: str) -> tuple[int, Start]:
        """Return which robot a record puts somewhere, and where; it may have to have some more fields."""
        fields = fields_of(record, "initial", {"robot", "vertices", "heading", *more})
        corners, heading = fields["vertices"], fields["heading"] or {"centre": 0.0, "bound": 4.0}
        if corners is None:
            corners = list(product(*zip(*self.arena, strict=True)))
        if not corners:
            raise Broken("an initial set without a point")
        arc = arc_around(number(heading["centre"]), number(heading["bound"], 0))
        return self.robot(fields["robot"]), Start(Within([point(corner) for corner in corners]), arc)

    @property
    def _nowhere(self) -> Start:
        """Where the filter keeps a robot that is not there yet: in a place of its arena, where nothing rests on it."""
        least, greatest = (
            [limit if value is None else value for value in ends] for ends, limit in zip(self.arena, (-inf, inf), strict=True)
        )
        x, y = (min(max(0.0, low), high) for low, high in zip(least, greatest, strict=True))
        return Start(Within([point((x, y))]), arc_around(0.0, 4.0))


def fields_of(record: Record, kind: str, names: AbstractSet[str], may: AbstractSet[str] = frozenset()) -> Record:
    """Return a record of a kind that has these fields, and of others only those that it may have."""
    came = set(record) - {"record"}
    if record.get("record") != kind or not names <= came <= names | may:
        raise Broken(f"a record {kind} of {sorted(names)} was expected, not {shown(sorted(record))}")
    return record


def point(value: Any) -> Vector:
    """Return a point."""
    x, y = value
    return Fraction(number(x)), Fraction(number(y))


def _names(values: Any) -> list[str]:
    names = list(values)
    for name in names:
        if not isinstance(name, str) or not NAME.fullmatch(name):
            raise Broken(f"a name was expected, not {shown(name)}")
    if not names and isinstance(values, list):
        raise Broken("at least one robot was expected")
    return names
