"""How a log is written: the JSON object of every record. See docs/log.md; files are in `experiments.logs.log`."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from experiments.logs.checks import AT_THE_CENTRE, called, field_names
from experiments.logs.records import FIRST, FORMAT, FrameEnd, Header, InitialSet, Joined, Record, TruthAt
from filter import Array, Frame, InvalidInput, Left, Measurement, Odometry, Placed, Position, RelativeHeading, Team, Twist

Object = dict[str, Any]
ASIDE = "aside"  # a column that is left out where all robots drive straight ahead


def header_object(header: Header) -> Object:
    """Return the header of a log."""
    team = header.team
    arena = [[value if np.isfinite(value) else None for value in corner] for corner in team.arena.tolist()]
    names = team.names[: team.robots]
    return {
        "record": "header",
        "format": FORMAT,
        "version": header.version,
        "robots": team.robots if names == Team(team.robots).names else names,
        "landmarks": _landmarks(team),
        "arena": arena,
        "speed_limit": _limit(names, team.speed_limit),
        "turn_rate_limit": _limit(names, team.turn_rate_limit),
        **_accelerations(team),
        **_sensors(team),
        "start": float(header.start),
        "rate": None if header.rate is None else float(header.rate),
    }


def _landmarks(team: Team) -> list[list[float]] | dict[str, list[float]]:
    names, places = team.names[team.robots :], team.landmarks.tolist()
    return places if names == Team(1, places).names[1:] else dict(zip(names, places, strict=True))


def _limit(names: Sequence[str], limits: Array) -> Any:
    """Return the limit that all robots have, or else each one's by its name; null where nobody knows."""
    known = [limit if np.isfinite(limit) else None for limit in limits.tolist()]
    return known[0] if known == known[:1] * len(known) else dict(zip(names, known, strict=True))


def _accelerations(team: Team) -> Object:
    limits = {name: getattr(team, name) for name in ("acceleration_limit", "turn_acceleration_limit")}
    return {name: _limit(team.names[: team.robots], limit) for name, limit in limits.items() if np.isfinite(limit).any()}


def _sensors(team: Team) -> Object:
    """Return how sensors are mounted, if there are any."""
    mounted = {
        each.name: {
            "position": each.position.tolist(),
            "position_bound": each.position_bound,
            "angle": each.angle,
            "angle_bound": each.angle_bound,
            **({"time_bound": each.time_bound} if each.time_bound else {}),
        }
        for each in team.sensors
    }
    return {"sensors": mounted} if mounted else {}


def initial_object(header: Header, robot: int, known: InitialSet) -> Object:
    """Return one robot's initial set."""
    heading = None if known.heading is None else {"centre": float(known.heading[0]), "bound": float(known.heading[1])}
    vertices = None if known.vertices is None else known.vertices.tolist()
    return {"record": "initial", "robot": _called(header, robot), "vertices": vertices, "heading": heading}


def frame_objects(header: Header, frame: Frame) -> list[Object]:
    """Return a frame's records: odometry, who came and left, measurements, truth, and the one that ends it.

    Raises:
        InvalidInput: The log's version has nothing for one of them.
    """
    records: list[Record] = [] if frame.odometry is None else [frame.odometry]
    records += [_joined(change) if isinstance(change, Placed) else change for change in frame.changes]
    records += frame.measurements
    if frame.truth is not None:
        records.append(TruthAt(frame.time, np.arange(header.team.robots), frame.truth))
    return [object_of(header, record) for record in (*records, FrameEnd(frame.time))]


def _joined(change: Placed) -> Joined:
    """Return a robot's set as a log has it, no smaller."""
    vertices, heading = None, None
    if change.polygon is not None:
        margin = change.polygon.margin * np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
        vertices = (change.polygon.vertices[:, None] + margin[: 4 if margin.any() else 1]).reshape(-1, 2)
    if change.heading is not None:
        heading = change.heading.centre.item(), change.heading.bound.item()
    return Joined(change.time, change.robot, InitialSet(vertices, heading))


def object_of(header: Header, record: Record) -> Object:
    """Return a record's object.

    Raises:
        InvalidInput: The log's version has nothing for such a record.
    """
    time = float(record.time)
    match record:
        case FrameEnd():
            return {"record": "frame", "time": time}
        case TruthAt():
            return {"record": "truth", "time": time, **_truth(header, record)}
        case Joined():
            _later(header, "a robot that joins")
            return {**initial_object(header, record.robot, record.known), "time": time}
        case Left():
            _later(header, "a robot that leaves")
            return {"record": "leave", "time": time, "robot": _called(header, record.robot)}
        case Odometry():
            return {"record": "odometry", "start": record.start, "time": time, **_columns(header, record)}
    if isinstance(record, Twist | Position | RelativeHeading):
        _later(header, type(record).__name__)
    return {"record": called(type(record)).replace(" ", "_"), "time": time, **_columns(header, record)}


def _later(header: Header, what: str) -> None:
    if header.version == FIRST:
        raise InvalidInput("a log of version 2, as of Header(..., version=2)", f"{what} for one of version 1")


def _truth(header: Header, record: TruthAt) -> Object:
    positions, headings = record.truth.positions, record.truth.headings
    if np.isnan(headings).any() or np.isnan(positions).any():
        _later(header, "truth that nobody knows")
    if (np.isnan(positions[:, 0]) != np.isnan(positions[:, 1])).any():
        raise InvalidInput("true positions known in x and in y, or not at all", positions.tolist())
    places = [None if np.isnan(place[0]) else place for place in positions.tolist()]
    ways = [None if np.isnan(heading) else heading for heading in headings.tolist()]
    if record.robot.tolist() == [*range(header.team.robots)]:
        return {"positions": places, "headings": ways}
    if len(places) != 1:
        raise InvalidInput("truth of all robots, in their order, or of one", f"of robots {record.robot.tolist()}")
    _later(header, "truth of one robot")
    return {"robot": _called(header, int(record.robot[0])), "position": places[0], "heading": ways[0]}


def _columns(header: Header, record: Measurement | Odometry | Twist) -> Object:
    columns: Object = {}
    for name in field_names(record):
        column = getattr(record, name).tolist()
        if name == ASIDE:
            columns |= _aside(header, column)
        elif name == "target":
            columns |= _targets(header, column)
        elif name in ("sensor", "target_sensor"):
            columns |= _mounted(header, name, column)
        else:
            columns[name] = [_called(header, robot) for robot in column] if name == "robot" else column
    return columns


def _aside(header: Header, column: list[float]) -> Object:
    if not any(column):
        return {}
    _later(header, "odometry with a robot that drives aside")
    return {ASIDE: column}


def _mounted(header: Header, name: str, column: list[int]) -> Object:
    """Return a column of sensors, null for the centre; one of nothing else is left out."""
    if all(number == AT_THE_CENTRE for number in column):
        return {}
    _later(header, "a sensor that is mounted somewhere")
    sensors = header.team.sensors
    if max(column) >= len(sensors):
        raise InvalidInput(f"a {name} among the header's {len(sensors)}", max(column))
    return {name: [None if number == AT_THE_CENTRE else sensors[number].name for number in column]}


def _targets(header: Header, targets: list[int]) -> Object:
    """Return the columns of robots and of landmarks; a column of nothing is left out."""
    robots = header.team.robots
    mates = [_called(header, body) if body < robots else None for body in targets]
    marks = [_called(header, body) if body >= robots else None for body in targets]
    columns = {"target": mates, "landmark": marks}
    return {name: column for name, column in columns.items() if any(body is not None for body in column)} or {"target": []}


def _called(header: Header, body: int) -> int | str:
    """Return a body's name, if the team has names, or else its number; landmarks are numbered from 0 on."""
    return header.team.names[body] if header.team.is_named else int(body) - header.team.robots * (body >= header.team.robots)
