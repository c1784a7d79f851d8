"""The minute as a log of version 2: what a conversion of its other forms has to give, to the last byte."""

from __future__ import annotations

import json
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from experiments.minute.measured import START
from experiments.minute.said import Distance, Minute, North, PoseSaid, Promised, Said, Seen
from experiments.own_data.driven import Pose, increment
from experiments.own_data.units import SECOND
from experiments.show.output import write_whole

ORDER = ("odometry", "compass", "uwb", "detections", "truth")  # at one stamp of one robot


def write_log(path: Path, minute: Minute) -> None:
    """Write the log.

    Raises:
        OSError: It cannot be written.
    """
    robots = list(minute.starts)
    said = sorted(minute.said, key=lambda each: (each.stamp, robots.index(each.robot), ORDER.index(each.stream)))
    records = [_header(minute), *_initial(minute), *_records(said, minute)]
    write_whole(path, "".join(json.dumps(record, allow_nan=False) + "\n" for record in records))


def _header(minute: Minute) -> dict[str, Any]:
    return {
        "record": "header",
        "format": "corral-log",
        "version": 2,
        "robots": list(minute.starts),
        "landmarks": dict(minute.landmarks),
        "arena": minute.arena,
        "speed_limit": minute.speed_limit,
        "turn_rate_limit": minute.turn_rate_limit,
        "start": float(START),
        "rate": None,
    }


def _initial(minute: Minute) -> Iterator[dict[str, Any]]:
    for robot, (_, heading) in minute.starts.items():
        (x, y), (right, top) = minute.box(robot)
        vertices = [[x, y], [right, y], [right, top], [x, top]]
        interval = {"centre": heading, "bound": minute.bounds.start_heading}
        yield {"record": "initial", "robot": robot, "vertices": vertices, "heading": interval}


def _records(said: Sequence[Said], minute: Minute) -> Iterator[dict[str, Any]]:
    before: dict[str, tuple[int, Pose]] = {}
    for each in said:
        head = {"time": each.stamp / SECOND, "robot": each.robot}
        match each.value:
            case PoseSaid() as pose if each.stream == "odometry":
                place = Pose(pose.x, pose.y, pose.turned.heading)
                if each.robot in before:
                    yield _odometry(each, before[each.robot], place, minute.bounds)
                before[each.robot] = each.stamp, place
            case PoseSaid() as pose:
                yield {"record": "truth", **head, "position": [pose.x, pose.y], "heading": pose.turned.heading}
            case North(turned):
                yield {"record": "compass", **head, "heading": turned.heading, "bound": minute.bounds.compass}
            case Distance(target, distance):
                yield _range(head, target, distance, list(minute.bounds.uwb), minute)
            case Seen(targets):
                for name, (distance, bearing) in targets.items():
                    about = {**head, _key(name, minute): name}
                    yield {"record": "bearing", **about, "bearing": bearing, "bound": minute.bounds.bearing}
                    yield _range(head, name, distance, minute.bounds.detection, minute)


def _odometry(said: Said, before: tuple[int, Pose], place: Pose, bounds: Promised) -> dict[str, Any]:
    start, first = before
    moved = increment(first, place)
    return {
        "record": "odometry",
        "start": start / SECOND,
        "time": said.stamp / SECOND,
        "robot": said.robot,
        "distance": moved.forward,
        "distance_bound": bounds.distance,
        "turn": moved.turn,
        "turn_bound": bounds.turn,
        "direction_bound": bounds.direction,
        "slip_bound": bounds.slip + abs(moved.aside),
    }


def _range(head: dict[str, Any], name: str, distance: float, bound: Any, minute: Minute) -> dict[str, Any]:
    return {"record": "range", **head, _key(name, minute): name, "range": distance, "bound": bound, "relative_bound": 0.0}


def _key(name: str, minute: Minute) -> str:
    return "target" if name in minute.starts else "landmark"
