"""What a log begins with: the header and the initial sets, read strictly. See docs/log.md."""

from __future__ import annotations

from typing import Any

import numpy as np

from experiments.logs.reading.bodies import bodies_of
from experiments.logs.reading.fields import Fields
from experiments.logs.records import FIRST, FORMAT, SECOND, Header, InitialSet
from filter import Array, InvalidInput, Sensor, Team


def read_header(record: Fields) -> Header:
    """Return the header of a log.

    Raises:
        InvalidInput: It is another format or version, or a field is not as it should be.
    """
    record.expect("header")
    form, version = record.text("format"), record.whole("version")
    if form != FORMAT or version not in (FIRST, SECOND):
        raise InvalidInput(f'format "{FORMAT}", version {FIRST} or {SECOND}', f'"{form}", version {version}')
    team = Team(arena=_arena(record), **(_first(record) if version == FIRST else _second(record)))
    start, rate = record.number("start"), None
    if version == FIRST or record.has("rate"):
        rate = record.number_or_none("rate")
    record.end()
    if rate is not None and rate <= 0:
        raise InvalidInput("rate: a number above 0 [Hz], or null", repr(rate))
    return Header(team, start, rate, version)


def _arena(record: Fields) -> Array:
    arena = record.points("arena", unknown=np.inf)
    arena[:1] = np.where(np.isinf(arena[:1]), -np.inf, arena[:1])
    return arena


def _first(record: Fields) -> dict[str, Any]:
    """Return the fields of a team in version 1."""
    limits = {name: record.number(name) for name in ("speed_limit", "turn_rate_limit")}
    return {"robots": record.whole("robots"), "landmarks": record.points("landmarks"), **limits}


def _second(record: Fields) -> dict[str, Any]:
    """Return the fields of a team in version 2: with names, limits of single robots or of acceleration, or sensors."""
    robots = record.names("robots") if record.is_a(list, "robots") else record.whole("robots")
    marks = record.points_by_name("landmarks") if record.is_a(dict, "landmarks") else record.points("landmarks")
    limits = {name: record.numbers_by_name(name) for name in ("speed_limit", "turn_rate_limit")}
    known = [name for name in ("acceleration_limit", "turn_acceleration_limit") if record.has(name)]
    further = {name: record.numbers_by_name(name, np.inf) for name in known}
    sensors = record.objects_by_name("sensors") if record.has("sensors") else {}
    mounted = [_sensor(name, fields) for name, fields in sensors.items()]
    return {"robots": robots, "landmarks": marks, "sensors": mounted, **limits, **further}


def _sensor(name: str, fields: Fields) -> Sensor:
    """Return how a sensor is mounted; what is not said is 0."""
    place = fields.pair("position") if fields.has("position") else (0.0, 0.0)
    numbers = {key: fields.number(key) for key in ("position_bound", "angle", "angle_bound", "time_bound") if fields.has(key)}
    fields.end()
    return Sensor(name, place, **numbers)


class InitialSets:
    """Gathers the initial sets that follow a header; in version 2 a robot without one is not there yet."""

    def __init__(self, header: Header) -> None:
        self._header, (self._robots, _) = header, bodies_of(header)
        self._first, self._found = header.version == FIRST, dict[int, InitialSet]()

    @property
    def are_all_there(self) -> bool:
        """Whether each robot has one."""
        return len(self._found) == self._robots.count

    def take(self, record: Fields) -> bool:
        """Take in what follows; return whether it was one of them, or else they have ended before it.

        Raises:
            InvalidInput: The robot's set is known already, or a field is not as it should be.
        """
        if not self._first and (record.kind != "initial" or record.has("time")):
            return False
        record.expect("initial")
        robot = record.robot(self._robots)
        if robot in self._found:
            raise InvalidInput("one initial set a robot", f"{self._header.team.name(robot)} again")
        self._found[robot] = read_set(record)
        record.end()
        return True

    def sets(self) -> tuple[InitialSet, ...]:
        """Return one for each robot."""
        return tuple(self._found.get(robot, InitialSet(there=False)) for robot in range(self._robots.count))

    def missing(self) -> InvalidInput:
        """Return the error for a file that ends here."""
        return InvalidInput(f"{self._robots.count} initial sets", f"{len(self._found)}, then the end of the file")


def read_set(record: Fields) -> InitialSet:
    """Return the set that a robot is in.

    Raises:
        InvalidInput: A field is not as it should be.
    """
    vertices, interval = record.points_or_none("vertices"), record.object("heading")
    if interval is None:
        return InitialSet(vertices)
    heading = interval.number("centre"), interval.number("bound")
    interval.end()
    return InitialSet(vertices, heading)
