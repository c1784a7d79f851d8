"""What a log begins with: the header and the initial sets, read strictly. See docs/log.md."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import numpy as np

from experiments.logs.reading.bodies import Bodies
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
    numbers = {key: fields.number(key) for key in ("position_bound", "angle", "angle_bound") if fields.has(key)}
    fields.end()
    return Sensor(name, place, **numbers)


def read_initial(record: Fields, robots: Bodies, known: Collection[int]) -> tuple[int, InitialSet]:
    """Return a robot of the team and its initial set.

    Raises:
        InvalidInput: The robot's set is known already, or a field is not as it should be.
    """
    record.expect("initial")
    robot = record.robot(robots)
    if robot in known:
        raise InvalidInput("one initial set a robot", f"robot {robot} again")
    found = read_set(record)
    record.end()
    return robot, found


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
