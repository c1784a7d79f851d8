"""From a message to records of motion: increments of odometry, and twists."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import NamedTuple

from experiments.own_data.channels import Channel
from experiments.own_data.facts import Facts
from experiments.own_data.reading import Reading, Record, Unmeasured, placed
from experiments.own_data.units import SECOND, metres, radians, seconds, wrapped
from experiments.recorded import LeftOut, Message


class Pose(NamedTuple):
    """Where odometry says that a robot is.

    Attributes:
        x: To the east [m].
        y: To the north [m].
        heading: Counter-clockwise from +x [rad].
    """

    x: float
    y: float
    heading: float


class Increment(NamedTuple):
    """How a robot moved between two poses.

    Attributes:
        forward: Along the line of its first heading and half of its turn [m].
        aside: To the left of that line [m].
        turn: Counter-clockwise, in (-pi, pi] [rad].
    """

    forward: float
    aside: float
    turn: float


def increment(first: Pose, last: Pose) -> Increment:
    """Return how a robot moved from one pose to another."""
    turn = wrapped(last.heading - first.heading)
    way = first.heading + turn / 2
    x, y, cos, sin = last.x - first.x, last.y - first.y, math.cos(way), math.sin(way)
    return Increment(x * cos + y * sin, y * cos - x * sin, turn)


def relative(bound: float, share: float, value: float) -> float:
    """Return the largest error of a value, given that it is at most bound + share * true value."""
    return bound + share * (abs(value) + bound) / (1 - share)


class OdometryReading(Reading):
    """How a robot moved from each message to the next: between their poses, or as each message says.

    A robot that cannot drive to its side has not: what its poses say of that is added to the bound on slip. That of one which
    can is a direction, `aside`, unless it hardly moved; then nobody knows it, and it is slip, too.
    """

    def __init__(self, channel: Channel, facts: Facts, left_out: LeftOut) -> None:
        super().__init__(channel, facts, left_out)
        self._stamp: int | None = None
        self._pose: Pose | None = None

    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield one record, none for the first message, see `Reading`."""
        increments = "distance" in self.channel.fields
        pose = None if increments else self._pose_of(message)
        if self._stamp is not None and stamp <= self._stamp:
            raise Unmeasured("its stamp is not after that of the message before")
        start, self._stamp, first, self._pose = self._stamp, stamp, self._pose, pose
        if start is None:
            return
        if stamp - start > self.stream.longest * SECOND:
            raise Unmeasured(f"more than {self.stream.longest:g} s after the message before; the bounds are for less")
        moved = increment(first, pose) if first is not None and pose is not None else self._increment_of(message)
        yield self._record(seconds(start), seconds(stamp), moved)

    def _pose_of(self, message: Message) -> Pose:
        x, y = self.door.place(self.value(message, "x"), self.value(message, "y"))
        return Pose(x, y, self.heading(message))

    def _increment_of(self, message: Message) -> Increment:
        distance, turn = self.value(message, "distance"), self.value(message, "turn")
        with placed(message.place):
            self.door.plain_angle(turn)
        return Increment(self.door.distance(distance), 0.0, self.door.turn(turn))

    def _record(self, start: float, time: float, moved: Increment) -> Record:
        bounds = self.stream.bounds
        distance, aside, slip = shared(moved, self.bound("distance_bound"), sideways=self.stream.sideways)
        share, turn_share = self.bound("distance_relative_bound"), self.bound("turn_relative_bound")
        record = {
            "record": "odometry",
            "start": start,
            "time": time,
            "robot": self.stream.robot,
            "distance": distance,
            "distance_bound": relative(self.bound("distance_bound"), share, distance),
            "turn": moved.turn,
            "turn_bound": relative(self.bound("turn_bound"), turn_share, moved.turn),
            "direction_bound": bounds["direction_bound"],
            "slip_bound": self.bound("slip_bound") + slip,
        }
        return record | ({"aside": aside} if self.stream.sideways else {})


def shared(moved: Increment, least: float, *, sideways: bool) -> tuple[float, float, float]:
    """Return distance, direction from the line, and what goes to the bound on slip, of an increment or of speeds.

    Args:
        moved: How the robot moved.
        least: What a distance has to exceed for its direction to be known.
        sideways: Whether the robot can drive to its side.
    """
    length = math.hypot(moved.forward, moved.aside)
    if sideways and length > least:
        return length, math.atan2(moved.aside, moved.forward), 0.0
    return moved.forward, 0.0, abs(moved.aside)


class TwistReading(Reading):
    """Speeds and turn rates, of commands or measured."""

    def records(self, message: Message, stamp: int) -> Iterator[Record]:
        """Yield one record, see `Reading`."""
        forward = self.door.distance(self.value(message, "speed"))
        aside = self.door.aside(self.value(message, "speed_aside")) if "speed_aside" in self.channel.fields else 0.0
        turn_rate = self.door.turn(self.value(message, "turn_rate"))
        speed_bound, turn_rate_bound = self._bounds(message)
        moved = Increment(forward, aside, turn_rate)
        speed, direction, slip = shared(moved, speed_bound, sideways=self.stream.sideways)
        record = self.head("twist", stamp) | {
            "speed": speed,
            "speed_bound": speed_bound,
            "turn_rate": turn_rate,
            "turn_rate_bound": turn_rate_bound,
            "direction_bound": self.stream.bounds["direction_bound"],
            "slip_rate": self.bound("slip_rate") + slip,
        }
        yield record | ({"aside": direction} if self.stream.sideways else {}) | {"hold": self.stream.hold}

    def _bounds(self, message: Message) -> tuple[float, float]:
        if not self.stream.k_sigma:
            return self.bound("speed_bound"), self.bound("turn_rate_bound")
        speed, turn_rate = (self.channel.fields[name](message.content) for name in ("speed_variance", "turn_rate_variance"))
        return (
            metres(self.deviations("speed_bound", speed, message.place), self.door.length),
            radians(self.deviations("turn_rate_bound", turn_rate, message.place), self.door.angle),
        )
