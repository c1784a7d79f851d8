"""The lines of a log, read strictly, a field at a time: what is wrong with a line is said here. See docs/log.md."""

from __future__ import annotations

from collections.abc import Callable, Collection
from dataclasses import fields
from functools import partial
from typing import Any

import numpy as np

from experiments.logs.fields import Fields
from experiments.logs.records import ASIDE, FORMAT, VERSION, FrameEnd, Header, InitialSet, Record, TruthAt
from filter import Bearing, Compass, Integers, InvalidInput, Measurement, Odometry, Range, Team, Truth
from filter.arrays import read_only


def read_header(record: Fields) -> Header:
    """Return the header of a log.

    Raises:
        InvalidInput: It is another format or version, or a field is not as it should be.
    """
    record.expect("header")
    form, version = record.text("format"), record.whole("version")
    if (form, version) != (FORMAT, VERSION):
        raise InvalidInput(f'format "{FORMAT}", version {VERSION}', f'"{form}", version {version}')
    arena = record.points("arena", unknown=np.inf)
    arena[:1] = np.where(np.isinf(arena[:1]), -np.inf, arena[:1])
    team = Team(
        robots=record.whole("robots"),
        landmarks=record.points("landmarks"),
        speed_limit=record.number("speed_limit"),
        turn_rate_limit=record.number("turn_rate_limit"),
        arena=arena,
    )
    start, rate = record.number("start"), record.number_or_none("rate")
    record.end()
    if rate is not None and rate <= 0:
        raise InvalidInput("rate: a number above 0 [Hz], or null", repr(rate))
    return Header(team, start, rate)


def read_initial(record: Fields, team: Team, known: Collection[int]) -> tuple[int, InitialSet]:
    """Return a robot of the team and its initial set.

    Raises:
        InvalidInput: The robot's set is known already, or a field is not as it should be.
    """
    record.expect("initial")
    robot = record.whole("robot")
    if not 0 <= robot < team.robots:
        raise InvalidInput(f"robot: whole numbers from 0 to {team.robots - 1}", repr(robot))
    if robot in known:
        raise InvalidInput("one initial set a robot", f"robot {robot} again")
    vertices, interval = record.points_or_none("vertices"), record.object("heading")
    record.end()
    if interval is None:
        return robot, InitialSet(vertices)
    heading = interval.number("centre"), interval.number("bound")
    interval.end()
    return robot, InitialSet(vertices, heading)


def read_record(record: Fields, team: Team) -> Record:
    """Return what a line after the initial sets says.

    Raises:
        InvalidInput: Such a record is unknown, or a field is not as it should be.
    """
    reader = _READERS.get(record.kind)
    if reader is None:
        raise InvalidInput(f"a record among {', '.join(_READERS)}", f'"{record.kind}"')
    found = reader(record, team)
    record.end()
    return found


def _read_odometry(record: Fields, team: Team) -> Odometry:
    start, time, robots = record.number("start"), record.number("time"), record.robots(team.robots)
    names = [field.name for field in fields(Odometry)[3:] if field.name != ASIDE or record.has(ASIDE)]
    return Odometry(start, time, robots, **{name: record.numbers(name) for name in names})


def _read_measurement(kind: type[Compass | Bearing | Range], record: Fields, team: Team) -> Measurement:
    time = record.number("time")
    columns: dict[str, Any] = {"robot": record.robots(team.robots)}
    if kind is not Compass:
        columns["target"] = _read_targets(record, team)
    columns |= {field.name: record.numbers(field.name) for field in fields(kind) if field.name not in ("time", *columns)}
    return kind(time, **columns)


def _read_targets(record: Fields, team: Team) -> Integers:
    """Return the targets, numbered as in `Team`, of the columns `target` (robots) and `landmark`."""
    counts = {"target": team.robots, "landmark": len(team.landmarks)}
    found = {name: record.bodies(name, count) for name, count in counts.items() if record.has(name)}
    if not found:
        raise InvalidInput('a field "target" or "landmark"', "neither")
    mates = found.get("target", [None] * len(found.get("landmark", [])))
    marks = found.get("landmark", [None] * len(mates))
    if len(mates) != len(marks) or any((mate is None) == (mark is None) for mate, mark in zip(mates, marks, strict=False)):
        raise InvalidInput("either a target or a landmark in every place", f"target {mates}, landmark {marks}")
    targets = [mate if mark is None else mark + team.robots for mate, mark in zip(mates, marks, strict=True)]
    return np.array(targets, dtype=np.int64)


def _read_truth(record: Fields, team: Team) -> TruthAt:
    time, positions, headings = record.number("time"), record.points("positions"), record.numbers("headings")
    if positions.shape != (team.robots, 2) or headings.shape != (team.robots,):
        raise InvalidInput(f"truth of {team.robots} robots", f"{len(positions)} positions, {headings.size} headings")
    return TruthAt(time, Truth(read_only(positions), read_only(headings)))


def _read_frame(record: Fields, _: Team) -> FrameEnd:
    return FrameEnd(record.number("time"))


_READERS: dict[str, Callable[[Fields, Team], Record]] = {
    "odometry": _read_odometry,
    "compass": partial(_read_measurement, Compass),
    "bearing": partial(_read_measurement, Bearing),
    "range": partial(_read_measurement, Range),
    "truth": _read_truth,
    "frame": _read_frame,
}
