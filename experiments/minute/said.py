"""What the sensors of the minute say, as numbers that every form of the data holds exactly."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from experiments.own_data.units import yaw


class Yaw(NamedTuple):
    """A heading as messages hold it: a quaternion about the vertical.

    Attributes:
        z: Sine of half the heading.
        w: Cosine of half the heading.
    """

    z: float
    w: float

    @classmethod
    def of(cls, heading: float) -> Yaw:
        """Return a heading [rad], rounded to what a quaternion holds."""
        return cls(math.sin(heading / 2), math.cos(heading / 2))

    @property
    def heading(self) -> float:
        """The heading that a reader finds in it [rad]."""
        found = yaw(0.0, 0.0, self.z, self.w)
        return math.nan if found is None else found


@dataclass(frozen=True)
class PoseSaid:
    """Of odometry, or the truth: place [m], heading, and speeds [m/s, rad/s], 0 for the truth."""

    x: float
    y: float
    turned: Yaw
    speed: float = 0.0
    turn_rate: float = 0.0


@dataclass(frozen=True)
class North:
    """Of a compass."""

    turned: Yaw


@dataclass(frozen=True)
class Seen:
    """Of a camera: for each name a range [m] and a bearing [rad]."""

    targets: Mapping[str, tuple[float, float]]


@dataclass(frozen=True)
class Distance:
    """Of a UWB radio: a range to somebody [m], a number that 32 bits hold."""

    target: str
    range: float


@dataclass(frozen=True)
class Said:
    """One message.

    Attributes:
        stamp: When it was measured [ns].
        received: When a recorder had it [ns].
        robot: Whose sensor.
        stream: "odometry", "compass", "detections", "uwb" or "truth".
        value: What it says.
    """

    stamp: int
    received: int
    robot: str
    stream: str
    value: PoseSaid | North | Seen | Distance


@dataclass(frozen=True)
class Promised:
    """The bounds that the sensors keep.

    Attributes:
        distance: Of the path between two messages of odometry [m].
        turn: Of the turn [rad].
        direction: Of the motion's direction from the line of heading and half turn [rad].
        slip: Of what else there is [m].
        compass: Of headings [rad].
        bearing: Of bearings [rad].
        detection: Of the camera's ranges [m].
        uwb: Least and greatest error of UWB ranges, which read long [m].
        start: Of the place at the start, in x and y [m].
        start_heading: Of the heading at the start [rad].
    """

    distance: float = 0.0002
    turn: float = 0.0005
    direction: float = 0.05
    slip: float = 0.0001
    compass: float = 0.05
    bearing: float = 0.05
    detection: float = 0.1
    uwb: tuple[float, float] = (0.0, 0.3)
    start: float = 0.5
    start_heading: float = 0.2


@dataclass(frozen=True, eq=False)
class Minute:
    """All of it.

    Attributes:
        said: In the order in which a recorder had it.
        landmarks: Names and places [m].
        arena: Two corners [m].
        speed_limit: [m/s].
        turn_rate_limit: [rad/s].
        starts: For each robot the middle of the box that it starts in [m], and of its heading's interval [rad].
        bounds: What all errors keep within.
    """

    said: Sequence[Said]
    landmarks: Mapping[str, list[float]]
    arena: list[list[float]]
    speed_limit: float
    turn_rate_limit: float
    starts: Mapping[str, tuple[list[float], float]]
    bounds: Promised

    def box(self, robot: str) -> list[list[float]]:
        """Return lower and upper corner of the box that a robot starts in [m]."""
        (x, y), _ = self.starts[robot]
        by = self.bounds.start
        return [[round(x - by, 3), round(y - by, 3)], [round(x + by, 3), round(y + by, 3)]]
