"""Where sensors are mounted on robots, as static transforms say; a log cannot hold that yet."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from experiments.own_data.units import yaw
from experiments.recorded import Input, Topic

TRANSFORMS, STATIC = ("tf2_msgs/msg/TFMessage", "tf/msg/tfMessage"), "static"
SHOWN = 3  # so many are told
MOVING = "transforms that move are not read"


def mountings(data: Input, topic: Topic) -> str:
    """Return why transforms are left out, with what static ones say.

    Raises:
        InvalidInput: The recording is damaged.
    """
    if STATIC not in topic.name:
        return MOVING
    told = list(dict.fromkeys(_told(data, topic)))
    more = f" and {len(told) - SHOWN} more" if len(told) > SHOWN else ""
    return f"a log cannot hold how sensors are mounted yet: {'; '.join(told[:SHOWN])}{more}"


def _told(data: Input, topic: Topic) -> Iterator[str]:
    for flow in data.flows([topic.name]):
        for message in flow:
            yield from map(_mounting, message.content.transforms)


def _mounting(transform: Any) -> str:
    moved, turned = transform.transform.translation, transform.transform.rotation
    angle = yaw(turned.x, turned.y, turned.z, turned.w)
    turn = "no rotation" if angle is None else f"yaw {angle:.3g} rad"
    return f"{transform.header.frame_id} to {transform.child_frame_id}: {moved.x:.3g}, {moved.y:.3g}, {moved.z:.3g} m, {turn}"
