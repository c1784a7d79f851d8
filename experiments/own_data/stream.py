"""One stream of one robot: where it is, what its numbers are in, and what they are bounded by."""

from __future__ import annotations

import math
import re
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, cast

from experiments.own_data.kinds import ANGLE, COLUMNS, LENGTH, PLAIN, STREAM_KINDS, StreamKind, fields_of
from experiments.own_data.table import Bound, Table, texts
from experiments.own_data.units import ANGLES, CONVENTIONS, LENGTHS, STAMPS, Convention, Door, radians
from experiments.recorded.words import nearest
from filter import InvalidInput

PLACEHOLDERS = ("robot", "target")
RIGHT_ANGLE = math.nextafter(math.pi / 2, 0)
AT_ONE = ("compass", "position", "range_difference")  # kinds of what one sensor measures by itself
LARGEST_ERROR = "the largest error that there ever is"
# What bounds on angles and their rates do not exceed; half a circle where nothing is said [rad, rad/s].
LARGEST = {
    ("odometry", "direction_bound"): RIGHT_ANGLE,
    ("twist", "direction_bound"): RIGHT_ANGLE,
    ("twist", "turn_rate_bound"): math.inf,
}


@dataclass(frozen=True)
class Clock:
    """Where a stamp is, and what is to be added to it.

    Attributes:
        stamp: "header", "received", or a field or column.
        unit: Of a stamp that is a number: "s", "ms", "us" or "ns"; "" if nobody said so.
        offset: What makes a stamp the team's time [s].
    """

    stamp: str
    unit: str
    offset: float

    @classmethod
    def read(cls, table: Table, otherwise: Clock) -> Clock:
        """Take the keys of a clock; those that are not there are another clock's."""
        stamp = table.text_or("stamp", '"header", "received", or where the stamp is', otherwise.stamp)
        unit = table.word("stamp_unit", list(STAMPS), otherwise.unit)
        return cls(stamp, unit, table.number_or("clock_offset", "a number [s]", otherwise.offset))


@dataclass(frozen=True, eq=False)
class Stream:
    """One stream of one robot, as the settings say.

    Attributes:
        kind: One of `STREAM_KINDS`.
        robot: Whose it is.
        place: Where in the settings, for errors.
        source: Name of the topic or file, in which {robot} and {target} stand for a name.
        key: "topic" or "file", as the settings have it.
        target: Who is measured, if the settings say it; "" if not.
        ids: What this stream calls robots and landmarks, if it differs.
        only: Fields and what they have to hold for a message to count.
        fields: Where values are, as far as the settings say it.
        clock: Of its stamps.
        door: Of its units and conventions.
        bounds: By name, in the log's units; those that a covariance gives are missing.
        k_sigma: So many standard deviations are a bound; 0 for a bound that is declared.
        radius: Whether the bound of a position is the radius of a disc.
        longest: The longest time that a declared bound of odometry is for [s].
        hold: How long a twist holds, if no other comes [s].
        sideways: Whether the robot can drive to its side.
        sensor: Which of the team's sensors measures; "" for one at the robot's centre that looks forward.
        target_sensor: Which one it measures, on robots, likewise.
        landmarks: The two that a range difference is between, if the settings say it.
    """

    kind: str
    robot: str
    place: str
    source: str
    key: str
    target: str
    ids: Mapping[str, str]
    only: Mapping[str, str]
    fields: Mapping[str, str]
    clock: Clock
    door: Door
    bounds: Mapping[str, Bound]
    k_sigma: float
    radius: bool = False
    longest: float = math.inf
    hold: float = math.inf
    sideways: bool = False
    sensor: str = ""
    target_sensor: str = ""
    landmarks: tuple[str, ...] = ()

    @property
    def sensors(self) -> dict[str, str]:
        """What the settings name of the team's sensors, by their keys."""
        return {key: name for key in ("sensor", "target_sensor") if (name := getattr(self, key))}


def read_stream(kind: str, robot: str, table: Table, clock: Clock) -> Stream:
    """Return a stream, of the table that the settings have of it.

    Raises:
        InvalidInput: A key is unknown or missing, or what it holds is not as it should be.
    """
    what = STREAM_KINDS[kind]
    door = _door(kind, what, table)
    radius, k_sigma = kind == "position" and table.has("radius"), _k_sigma(what, table)
    fields = {name: table.text(name, "a field or column") for name in what.fields if table.has(name)}
    stream = Stream(
        kind=kind,
        robot=robot,
        place=table.place,
        **_source(table),
        target=table.text_or("target", "who is measured", "") if "id" in what.fields else "",
        ids=texts(table, "ids", "a name for each id"),
        only=texts(table, "only", "what fields have to hold"),
        fields=fields,
        clock=Clock.read(table, clock),
        door=door,
        bounds=_bounds(kind, table, door, k_sigma, fields),
        k_sigma=k_sigma,
        radius=radius,
        **_further(kind, table),
        **_mounted(what, kind, table),
    )
    table.end()
    return stream


def _source(table: Table) -> dict[str, Any]:
    keys = [key for key in ("topic", "file") if table.has(key)]
    if len(keys) != 1:
        raise InvalidInput(f'{table.place}: either "topic", of a bag, or "file", of a folder', " and ".join(keys) or "neither")
    source = table.text(keys[0], "a name")
    for placeholder in re.findall(r"\{(.*?)\}", source):
        if placeholder not in PLACEHOLDERS:
            expected = f"{table.place}: {keys[0]}: {{robot}} or {{target}}: {nearest(placeholder, PLACEHOLDERS)}"
            raise InvalidInput(expected, f"{{{placeholder}}}")
    return {"source": source, "key": keys[0]}


def _door(kind: str, what: StreamKind, table: Table) -> Door:
    said = table.take("unit", "units") if table.has("unit") else []
    words = said if isinstance(said, list) else [said]
    sorts = set(what.bounds.values()) | ({ANGLE, LENGTH} if kind == "truth" else set())
    known = [*(ANGLES if ANGLE in sorts else ()), *(LENGTHS if LENGTH in sorts else ())]
    for word in words:
        if word not in known:
            raise table.refuse("unit", f"among {', '.join(known)}: {nearest(str(word), known)}", word)
    angles, lengths = [w for w in words if w in ANGLES], [w for w in words if w in LENGTHS]
    if len(angles) > 1 or len(lengths) > 1:
        raise table.refuse("unit", "one unit of angles and one of lengths", said)
    angle = angles[0] if angles else "radians"
    convention = table.word("convention", CONVENTIONS, "enu") if what.conventions else "enu"
    declination = table.number_or("declination", "an angle", 0.0) if kind == "compass" else 0.0
    length = lengths[0] if lengths else "metres"
    return Door(angle, length, bool(angles), cast(Convention, convention), radians(declination, angle))


def _k_sigma(what: StreamKind, table: Table) -> float:
    if not what.variances:
        return 0.0
    k_sigma = table.number_or("k_sigma", "a number above 0", 0.0, least=0.0)
    if k_sigma and (twice := [name for name in what.variances if table.has(name)]):
        raise InvalidInput(f'{table.place}: either "{twice[0]}" or "k_sigma"', "both")
    return k_sigma


def _bounds(kind: str, table: Table, door: Door, k_sigma: float, said: Mapping[str, str]) -> dict[str, Bound]:
    what, bounds = STREAM_KINDS[kind], dict[str, Bound]()
    read = fields_of(kind, dict.fromkeys(COLUMNS[kind], ""), said)
    for name, sort in what.bounds.items():
        if what.only_with.get(name, name) not in (name, *read):
            continue
        if sort == PLAIN:
            bounds[name] = _relative(table, name)
        elif k_sigma and name in what.variances:
            continue
        elif kind == "position":
            bounds[name] = _bound_of_position(table, door)
        else:
            bounds[name] = _declared(kind, name, table, door)
    return bounds


def _relative(table: Table, name: str) -> float:
    value = table.number_or(name, "a share of the true value, from 0 on, below 1", 0.0, least=0.0)
    if value >= 1:
        raise table.refuse(name, "a share of the true value, below 1", value)
    return value


def _bound_of_position(table: Table, door: Door) -> Bound:
    name = next((each for each in ("bound", "radius") if table.has(each)), None)
    if name is None:
        raise _unbounded(table, "bound", f'or a "radius", {LARGEST_ERROR} [{door.length}]', STREAM_KINDS["position"])
    value = table.take(name, LARGEST_ERROR)
    if not isinstance(value, list):
        return door.distance(table.checked(name, value, "a bound from 0 on", 0.0))
    if name == "radius" or len(value) != 2:
        raise table.refuse(name, "a number from 0 on; a bound may be [in x, in y]", value)
    x, y = (table.checked(name, each, "bounds from 0 on", 0.0) for each in value)
    return door.place(x, y)


def _unbounded(table: Table, name: str, what: str, kind: StreamKind) -> InvalidInput:
    others = ', or "k_sigma" to take so many standard deviations of what the message says' if name in kind.variances else ""
    return InvalidInput(f'{table.place}: a bound "{name}", {what}{others}', "none; without a bound there is no guarantee")


def _declared(kind: str, name: str, table: Table, door: Door) -> Bound:
    what = STREAM_KINDS[kind]
    is_angle = what.bounds[name] == ANGLE
    if not table.has(name):
        raise _unbounded(table, name, f"{LARGEST_ERROR} [{door.angle if is_angle else door.length}]", what)
    may_be_pair = what.pairs and name != "position_bound"
    pairs = " or [low, high] of measured - true" if may_be_pair else ""
    bound = table.bound(name, f"a bound from 0 on{pairs}", pairs=may_be_pair)
    if not is_angle:
        return door.length_bound(bound)
    found, largest = door.angle_bound(bound), LARGEST.get((kind, name), math.pi)
    if max(map(abs, found if isinstance(found, tuple) else (found,))) > largest:
        hint = "" if door.angle == "degrees" else '; unit = "degrees" if these are'
        raise table.refuse(name, f"an angle of {math.degrees(largest):.3g} degrees at most{hint}", bound)
    return found


def _mounted(what: StreamKind, kind: str, table: Table) -> dict[str, Any]:
    """Return the keys of what sensors measure."""
    keys = ["sensor", "target_sensor"] if "id" in what.fields else ["sensor"] if kind in AT_ONE else []
    return {key: table.text_or(key, "the name of one in [team.sensors]", "") for key in keys}


def _further(kind: str, table: Table) -> dict[str, Any]:
    if kind == "odometry":
        longest = table.number("longest", "the longest time between two messages that the bounds are for [s]", least=0.0)
        return {"longest": longest, "sideways": table.flag("sideways")}
    if kind == "twist":
        hold = table.number("hold", "how long it holds if no other comes [s]", least=0.0)
        return {"hold": hold, "sideways": table.flag("sideways")}
    if kind == "range_difference" and table.has("landmarks"):
        names = table.list_of_texts("landmarks", "the names of two [first, second]")
        if len(set(names)) != 2 or len(names) != 2:
            raise table.refuse("landmarks", "the names of two [first, second]", names)
        return {"landmarks": tuple(names)}
    return {}
