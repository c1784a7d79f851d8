"""Where sensors are mounted on robots: as settings say, for the log, and as static transforms say, which have no bounds."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from experiments.own_data.table import Table
from experiments.own_data.units import ANGLES, radians, yaw
from experiments.recorded import Input, Topic

TRANSFORMS, STATIC = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"), "static"
SHOWN = 3  # so many are told
PLACE, LEAST = "[forward, left] of the robot's centre [m]", "the largest error, a number from 0 on"
MOVING = "transforms that move are not read"


def read_sensors(team: Table) -> dict[str, dict[str, Any]]:
    """Return how sensors are mounted, by their names, as a log's header has it.

    Raises:
        InvalidInput: A key is unknown or missing, or what it holds is not as it should be.
    """
    tables = team.table_or_empty("sensors", "a table for each")
    return {name: _sensor(tables.table(name, "a table with position and angle, and their bounds")) for name in tables.names()}


def _sensor(table: Table) -> dict[str, Any]:
    unit, found = table.word("unit", ANGLES, "radians"), dict[str, Any]()
    if table.has("position"):
        found["position"] = table.numbers("position", PLACE, 2)
        found["position_bound"] = table.number("position_bound", f"{LEAST} [m]", least=0.0)
    if table.has("angle"):
        found["angle"] = radians(table.number("angle", f"an angle [{unit}]"), unit)
        found["angle_bound"] = radians(table.number("angle_bound", f"{LEAST} [{unit}]", least=0.0), unit)
        if abs(found["angle"]) > 2 * math.pi or found["angle_bound"] > math.pi:
            raise table.refuse("angle", f"within a turn, and its bound within half a one [{unit}]", found)
    if table.has("time_bound"):
        found["time_bound"] = table.number("time_bound", "how far off its stamps are at most, from 0 on [s]", least=0.0)
    table.end()
    return found


def mountings(data: Input, topic: Topic) -> str:
    """Return why transforms are left out, with what static ones say.

    Raises:
        InvalidInput: The recording is damaged.
    """
    if STATIC not in topic.name:
        return MOVING
    told = list(dict.fromkeys(_told(data, topic)))
    more = f" and {len(told) - SHOWN} more" if len(told) > SHOWN else ""
    return f"they have no bounds; say how sensors are mounted in [team.sensors]: {'; '.join(told[:SHOWN])}{more}"


def _told(data: Input, topic: Topic) -> Iterator[str]:
    for flow in data.flows([topic.name]):
        for message in flow:
            yield from map(_mounting, message.content.transforms)


def _mounting(transform: Any) -> str:
    moved, turned = transform.transform.translation, transform.transform.rotation
    angle = yaw(turned.x, turned.y, turned.z, turned.w)
    turn = "no rotation" if angle is None else f"yaw {angle:.3g} rad"
    return f"{transform.header.frame_id} to {transform.child_frame_id}: {moved.x:.3g}, {moved.y:.3g}, {moved.z:.3g} m, {turn}"
