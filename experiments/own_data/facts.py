"""What is known of a team: its robots and landmarks, how far anything can be, and where it starts."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from experiments.own_data.mountings import read_sensors
from experiments.own_data.table import Table, texts
from experiments.own_data.units import ANGLES, radians
from experiments.recorded.words import nearest
from filter import InvalidInput

FORMAT, VERSION = "corral-log", 2
OPEN = [[-math.inf, -math.inf], [math.inf, math.inf]]
A_SET = "a table with box, vertices, or position and bound"
LIMITS = {"speed_limit": "the greatest speed of a robot [m/s]", "turn_rate_limit": "how fast a robot can turn [rad/s]"}


@dataclass(frozen=True, eq=False)
class Initial:
    """What is known of a robot at the start: it is in the hull of some points, its heading in an interval.

    Attributes:
        vertices: Points [m], or None for anywhere in the arena.
        heading: Centre and bound [rad], or None.
    """

    vertices: list[list[float]] | None = None
    heading: tuple[float, float] | None = None


@dataclass(frozen=True, eq=False)
class Facts:
    """What is known of the team for good, and at the start.

    Attributes:
        robots: For each name what is known of it at the start, in the settings' order; landmarks that are known only within
            a set come last, as robots that never move.
        landmarks: For each name where it is [m].
        arena: Lower and upper corner [m], infinite where it is open.
        speed_limit: Of each robot [m/s].
        turn_rate_limit: Of each robot [rad/s].
        start: When the initial sets hold [s]; None for the first stamp.
        origin: Latitude and longitude of x = y = 0 [degrees], or None.
        ids: What the data call robots and landmarks besides their names.
        sensors: For each name how it is mounted, as the log's header has it.
        standing: Those of the robots that are landmarks.
    """

    robots: Mapping[str, Initial]
    landmarks: Mapping[str, list[float]]
    arena: list[list[float]]
    speed_limit: Mapping[str, float]
    turn_rate_limit: Mapping[str, float]
    start: float | None
    origin: tuple[float, float] | None
    ids: Mapping[str, str]
    sensors: Mapping[str, dict[str, Any]]
    standing: frozenset[str] = frozenset()

    def check(self, place: str) -> None:
        """Refuse robots of which nobody says where they are.

        Raises:
            InvalidInput: The arena has open ends, and a robot could be anywhere in it.
        """
        lost = [name for name, known in self.robots.items() if known.vertices is None]
        if lost and any(map(math.isinf, (*self.arena[0], *self.arena[1]))):
            expected = f'{place} an "arena" without open ends, or a "start" of every robot that says where it is'
            raise InvalidInput(expected, f"neither for {lost[0]}")

    def body(self, called: str, ids: Mapping[str, str]) -> dict[str, str] | None:
        """Return the field of a record that names who is measured, or None if nobody is called so."""
        name = ids.get(called) or self.ids.get(called) or called
        if name in self.robots:
            return {"target": name}
        return {"landmark": name} if name in self.landmarks else None

    def carries_tags(self, body: Mapping[str, str]) -> bool:
        """Return whether who is measured is a robot, which can have a tag; landmarks are where they are."""
        return "target" in body and body["target"] not in self.standing

    def header(self, start: float) -> dict[str, Any]:
        """Return the log's header."""
        return {
            "record": "header",
            "format": FORMAT,
            "version": VERSION,
            "robots": list(self.robots),
            "landmarks": dict(self.landmarks),
            "arena": [[None if math.isinf(value) else value for value in corner] for corner in self.arena],
            "speed_limit": _common(self.speed_limit),
            "turn_rate_limit": _common(self.turn_rate_limit),
            **({"sensors": dict(self.sensors)} if self.sensors else {}),
            "start": start,
            "rate": None,
        }

    def initial(self) -> list[dict[str, Any]]:
        """Return the records of the initial sets."""
        records = []
        for robot, known in self.robots.items():
            heading = None if known.heading is None else {"centre": known.heading[0], "bound": known.heading[1]}
            records.append({"record": "initial", "robot": robot, "vertices": known.vertices, "heading": heading})
        return records


def read_facts(team: Table, robots: Mapping[str, Table]) -> Facts:
    """Return what is known of a team, of its own table and those of the robots.

    Raises:
        InvalidInput: A key is missing, or what it holds is not as it should be.
    """
    common = {name: team.number_or(name, "a number from 0 on", math.nan, least=0.0) for name in LIMITS}
    limits = {name: {robot: _limit(table, name, common[name]) for robot, table in robots.items()} for name in LIMITS}
    landmarks, standing = _landmarks(team, robots)
    known = {robot: _initial(table) for robot, table in robots.items()} | standing
    for limit in limits.values():
        limit.update(dict.fromkeys(standing, 0.0))
    arena = _box(team, "arena", open_ends=True) if team.has("arena") else OPEN
    start = team.number("start", "a time [s]") if team.has("start") else None
    ids = _ids(team, [*known, *landmarks])
    further = _origin(team), ids, read_sensors(team), frozenset(standing)
    return Facts(known, landmarks, arena, limits["speed_limit"], limits["turn_rate_limit"], start, *further)


def _limit(table: Table, name: str, common: float) -> float:
    value = table.number_or(name, "a number from 0 on", common, least=0.0)
    if math.isnan(value):
        raise InvalidInput(f'{table.place}: a key "{name}", here or in [team]: {LIMITS[name]}', "none")
    return value


def _initial(table: Table) -> Initial:
    if not table.has("start"):
        return Initial()
    start = table.table("start", "a table with box, vertices, or position and bound, and heading")
    initial = Initial(_vertices(start), _heading(start))
    start.end()
    return initial


def _heading(start: Table) -> tuple[float, float] | None:
    unit = start.word("unit", ANGLES, "radians")
    if not start.has("heading"):
        return None
    centre = radians(start.number("heading", f"an angle [{unit}]"), unit)
    bound = radians(start.number("heading_bound", f"an angle from 0 on [{unit}]", least=0.0), unit)
    if bound > math.pi or abs(centre) > 2 * math.pi:
        hint = "" if unit == "degrees" else '; unit = "degrees" if these are'
        raise start.refuse("heading", f"an angle within a turn, a bound within half of one{hint}", [centre, bound])
    return centre, bound


def _vertices(start: Table) -> list[list[float]] | None:
    forms = [name for name in ("box", "vertices", "position") if start.has(name)]
    if len(forms) > 1:
        raise InvalidInput(f"{start.place}: one of box, vertices and position", " and ".join(forms))
    if forms == ["vertices"]:
        return start.points("vertices", "a list of [x, y]")
    if forms == ["position"]:
        x, y = start.numbers("position", "[x, y]", 2)
        bound = start.number("bound", "a bound in x and y [m]", least=0.0)
        return _corners([x - bound, y - bound], [x + bound, y + bound])
    if forms == ["box"]:
        return _corners(*_box(start, "box"))
    return None


def _box(table: Table, name: str, *, open_ends: bool = False) -> list[list[float]]:
    corners = table.points(name, "two corners [[x, y], [x, y]], the lower one first", open_ends=open_ends)
    if len(corners) != 2 or corners[0][0] > corners[1][0] or corners[0][1] > corners[1][1]:
        raise table.refuse(name, "two corners [[x, y], [x, y]], the lower one first", corners)
    return corners


def _corners(low: list[float], high: list[float]) -> list[list[float]]:
    return [[low[0], low[1]], [high[0], low[1]], [high[0], high[1]], [low[0], high[1]]]


def _landmarks(team: Table, robots: Mapping[str, Table]) -> tuple[dict[str, list[float]], dict[str, Initial]]:
    """Return the landmarks whose places are known, and those that are known only within a set."""
    marks = team.table_or_empty("landmarks", "a name and [x, y] for each")
    if twice := sorted(set(marks.names()) & set(robots)):
        raise InvalidInput(f"{team.place}: each name for one robot or landmark", f'"{twice[0]}" for both')
    standing = {name: _standing(marks.table(name, "a table")) for name in marks.names() if marks.is_table(name)}
    return {name: marks.numbers(name, f"[x, y], or {A_SET}", 2) for name in marks.names()}, standing


def _standing(mark: Table) -> Initial:
    initial = Initial(_vertices(mark))
    mark.end()
    if initial.vertices is None:
        raise InvalidInput(f"{mark.place}: {A_SET}", "none of these")
    return initial


def _ids(team: Table, names: list[str]) -> dict[str, str]:
    ids = texts(team, "ids", "a name for each id")
    for name in ids.values():
        if name not in names:
            raise team.refuse("ids", f"names of robots and landmarks: {nearest(name, names)}", name)
    return ids


def _origin(team: Table) -> tuple[float, float] | None:
    if not team.has("origin"):
        return None
    latitude, longitude = team.numbers("origin", "[latitude, longitude] in degrees", 2)
    return latitude, longitude


def _common(limits: Mapping[str, float]) -> float | dict[str, float]:
    """Return the limit if all robots have the same one, or each robot's."""
    values = set(limits.values())
    return values.pop() if len(values) == 1 else dict(limits)
