"""The door: other people's units, conventions and frames become metres, radians and yaw counter-clockwise from +x."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from decimal import Decimal, InvalidOperation
from typing import Any, Literal

from experiments.own_data.table import Bound
from filter import InvalidInput, heading_from_north, place_from_north, wrap

Convention = Literal["enu", "ned"]
CONVENTIONS = ("enu", "ned")
LENGTHS = {"metres": 1, "centimetres": 100, "millimetres": 1000}  # so many are a metre
ANGLES = ("radians", "degrees")
STAMPS = {"s": 9, "ms": 6, "us": 3, "ns": 0}  # decimal places from a unit to nanoseconds
SECOND = 10**9  # [ns]
LARGEST_ANGLE = 2 * math.pi + 0.1  # what radians do not exceed unless they were never wrapped [rad]
UNIT_LENGTH = 0.1  # how far the length of a quaternion may be from 1


def seconds(nanoseconds: int) -> float:
    """Return a stamp [ns] in seconds, rounded once."""
    return nanoseconds / SECOND


def nanoseconds(stamp: Any, unit: str) -> int:
    """Return a stamp in nanoseconds: a message's time, a number or a text, exact as far as its decimals are.

    Raises:
        InvalidInput: It is no time.
    """
    if hasattr(stamp, "nanosec"):
        return int(stamp.sec) * SECOND + int(stamp.nanosec)
    try:
        return int(Decimal(str(stamp)).scaleb(STAMPS[unit]).to_integral_value())
    except (InvalidOperation, ValueError, OverflowError):
        raise InvalidInput(f"a stamp [{unit}]", repr(stamp)) from None


def yaw(x: float, y: float, z: float, w: float) -> float | None:
    """Return the yaw of a quaternion [rad], about the third axis, or None if its length is not that of a rotation."""
    if not abs(math.sqrt(x * x + y * y + z * z + w * w) - 1) <= UNIT_LENGTH:
        return None
    return math.atan2(2 * (w * z + x * y), w * w + x * x - y * y - z * z)


def radians(angle: float, unit: str) -> float:
    """Return an angle in radians."""
    return math.radians(angle) if unit == "degrees" else angle


def metres(length: float, unit: str) -> float:
    """Return a length in metres."""
    return length / LENGTHS[unit]


def wrapped(angle: float) -> float:
    """Return an angle in (-pi, pi] [rad]."""
    return angle if -math.pi < angle <= math.pi else float(wrap(angle))


def mirrored(bound: Bound) -> Bound:
    """Return a bound of the errors of a value whose sign is changed."""
    return (-bound[1], -bound[0]) if isinstance(bound, tuple) else bound


@dataclass(frozen=True)
class Door:
    """What the numbers of one stream are in, and how they become the log's.

    Attributes:
        angle: "radians" or "degrees".
        length: "metres", "centimetres" or "millimetres".
        declared: Whether the unit of angles was declared; if not, what can only be degrees is refused.
        convention: "enu": x east, y north, angles counter-clockwise; "ned": x north, y east, angles clockwise.
        declination: Of the magnetic north from the true one, to the east [rad].
    """

    angle: str = "radians"
    length: str = "metres"
    declared: bool = False
    convention: Convention = "enu"
    declination: float = 0.0

    def plain_angle(self, value: float) -> float:
        """Return an angle in radians.

        Raises:
            InvalidInput: The unit was not declared, and it can only be degrees.
        """
        if not self.declared and abs(value) > LARGEST_ANGLE:
            remedy = 'unit = "degrees" if these are degrees, unit = "radians" if they were never wrapped'
            raise InvalidInput(f"angles in radians; declare {remedy}", repr(value))
        return radians(value, self.angle)

    def heading(self, value: float) -> float:
        """Return a heading, as measured, as a yaw in (-pi, pi] counter-clockwise from +x [rad]."""
        return self.heading_of_yaw(self.plain_angle(value))

    def heading_of_yaw(self, yaw_: float) -> float:
        """Return a yaw in radians, which may be one from north, as a heading in (-pi, pi] [rad]."""
        if self.convention == "ned":
            return float(heading_from_north(yaw_, self.declination))
        return wrapped(yaw_ - self.declination)

    def turn(self, value: float) -> float:
        """Return an angle in the robot's own frame, or a rate of one, counter-clockwise [rad, rad/s]."""
        angle = radians(value, self.angle)
        return -angle if self.convention == "ned" else angle

    def bearing(self, value: float) -> float:
        """Return a bearing in (-pi, pi], counter-clockwise from the robot's forward axis [rad]."""
        angle = self.plain_angle(value)
        return wrapped(-angle if self.convention == "ned" else angle)

    def place(self, x: float, y: float) -> tuple[float, float]:
        """Return coordinates x to the east, y to the north [m]."""
        place = metres(x, self.length), metres(y, self.length)
        if self.convention == "ned":
            east, north = place_from_north(place).tolist()
            return east, north
        return place

    def distance(self, value: float) -> float:
        """Return a length, or a speed [m, m/s]."""
        return metres(value, self.length)

    def aside(self, value: float) -> float:
        """Return a speed to the side, positive to the robot's left [m/s]."""
        return -metres(value, self.length) if self.convention == "ned" else metres(value, self.length)

    def angle_bound(self, bound: Bound) -> Bound:
        """Return a bound of angles in radians, of measured less true in the log's sense."""
        if isinstance(bound, tuple):
            pair = radians(bound[0], self.angle), radians(bound[1], self.angle)
            return mirrored(pair) if self.convention == "ned" else pair
        return radians(bound, self.angle)

    def length_bound(self, bound: Bound) -> Bound:
        """Return a bound of lengths in metres."""
        if isinstance(bound, tuple):
            return metres(bound[0], self.length), metres(bound[1], self.length)
        return metres(bound, self.length)


def local_plane(latitude: float, longitude: float) -> Callable[[float, float], tuple[float, float]]:
    """Return a function from latitude and longitude [degrees] to x east, y north [m] of an origin.

    Distances and directions from the origin are those on the ellipsoid of WGS 84. At 10 km, lengths across are 4 mm in 10 km
    too long.

    Raises:
        InvalidInput: The package that knows the ellipsoid is not there.
    """
    try:
        from pyproj import Proj  # noqa: PLC0415 - an optional package, and slow to import
    except ImportError:
        raise InvalidInput("pyproj, to read latitudes: pip install 'corral[data]'", "no such package") from None
    plane = Proj(proj="aeqd", lat_0=latitude, lon_0=longitude, ellps="WGS84")

    def place(north: float, east: float) -> tuple[float, float]:
        x, y = plane(east, north)
        return float(x), float(y)

    return place
