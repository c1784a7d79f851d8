"""What sensors say: records with a value and a bound, one or many at a time.

A record holds the measurements of one kind taken at one instant: every field but the time is a number or a (k,) array, and
numbers are repeated to the length of the longest. All are copied: times become floats, columns read-only arrays of floats or of
whole numbers. Any real number will do (an int, a Fraction, a Decimal, one of numpy's); text will not. Every record raises
`InvalidInput` if a value is of another type, not finite, or out of its range, or if the columns differ in length.

Robots are numbered 0, 1, ..., n - 1; a target is a robot or, from n on, a landmark (see `Team`). The true error is within
+- bound, always: a bound is a promise, not a deviation.

A sensor is one of the team's, by its number: what it measures is as seen from where it is mounted. Whatever robot measures, its
sensor of that number did; of a tag it is the robot that was measured. -1 is at the robot's centre, and looks forward.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Self

import numpy as np

from filter.arrays import Array, Floats, Integers, checked, finite, instance, number, several, shown, whole_number
from filter.errors import InvalidInput
from filter.geometry.angles import ANGLE_ROUNDING
from filter.geometry.convex import EPSILON
from filter.geometry.north import heading_from_north
from filter.geometry.polygon import BY_HAND, Polygon
from filter.records.radians import bearing_in_radians, heading_in_radians
from filter.records.record import AT_THE_CENTRE, BELOW_1, CENTRE, ROBOT, SENSOR, TARGET, TIME, Record, Sighting, centre, place
from filter.records.relative import RelativeHeading


@dataclass(frozen=True, eq=False)
class Compass(Record):
    """Headings in the world frame, by compass. They may be of more than one turn, as a yaw that was never wrapped is.

    Those in degrees are made by `from_north`, or by `numpy.radians` of value and bound. Refused as degrees
    are bounds beyond pi, and those between pi/2 and pi of headings beyond two turns.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        heading: (k,) measured yaw of the sensor, counter-clockwise from +x [rad].
        bound: (k,) largest error, in [0, pi] [rad].
        sensor: (k,) which sensor of the robot measured.
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    heading: Array = field(metadata=checked(finite, "heading [rad]"))
    bound: Array = field(metadata=checked(finite, "compass bound [rad]", 0, np.pi))
    sensor: Integers = field(default_factory=centre, metadata=SENSOR)

    if TYPE_CHECKING:  # numbers and sequences are taken, arrays are kept

        def __init__(self, time: float, robot: Floats, heading: Floats, bound: Floats, sensor: Floats = ...) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        heading_in_radians(self.heading, self.bound)

    @classmethod
    def from_north(
        cls, time: float, robot: Floats, degrees: Floats, bound: Floats, declination: Floats = 0.0, sensor: Floats = CENTRE
    ) -> Self:
        """Return headings of compasses that say degrees, clockwise from north: x points east, y to true north.

        Args:
            time: When [s].
            robot: (k,) who measured.
            degrees: (k,) measured, clockwise from the north that the compass points to, of whatever turn [degrees].
            bound: (k,) largest error, in [0, 180] [degrees].
            declination: How far that north is east of true north, in [-180, 180] [degrees]; 0 if the compass has corrected it.
            sensor: (k,) which sensor of the robot measured.
        """
        measured, east = finite("heading [degrees]", degrees), finite("declination [degrees]", declination, -180, 180)
        rounding = ANGLE_ROUNDING * (2 + np.abs(np.radians(measured)).max(initial=0))
        widest = np.minimum(np.radians(finite("compass bound [degrees]", bound, 0, 180)) + rounding, np.pi)
        return cls(time, robot, heading_from_north(np.radians(measured), np.radians(east)), widest, sensor)


@dataclass(frozen=True, eq=False)
class Bearing(Sighting):
    """Directions to targets in the measuring robot's, or sensor's, own frame.

    Refused as degrees are those of more than four turns, in either sense.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        target: (k,) robot or landmark that was seen, not itself.
        bearing: (k,) measured angle from the sensor's forward axis, counter-clockwise [rad].
        bound: (k,) largest error, in [0, pi] [rad]; one of pi says nothing.
        sensor: (k,) which sensor of the robot measured.
        target_sensor: (k,) which sensor, or tag, of a robot was seen.
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    target: Integers = field(metadata=TARGET)
    bearing: Array = field(metadata=checked(finite, "bearing [rad]"))
    bound: Array = field(metadata=checked(finite, "bearing bound [rad]", 0, np.pi))
    sensor: Integers = field(default_factory=centre, metadata=SENSOR)
    target_sensor: Integers = field(default_factory=centre, metadata=SENSOR)

    if TYPE_CHECKING:

        def __init__(
            self,
            time: float,
            robot: Floats,
            target: Floats,
            bearing: Floats,
            bound: Floats,
            sensor: Floats = ...,
            target_sensor: Floats = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        bearing_in_radians(self.bearing)


@dataclass(frozen=True, eq=False)
class Range(Sighting):
    """Distances to targets; the true distance d gives a value within d (1 +- relative_bound) +- bound.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        target: (k,) robot or landmark that was seen, not itself.
        range: (k,) measured distance, from 0 on [m].
        bound: (k,) largest absolute error, from 0 on [m].
        relative_bound: (k,) largest relative error, in [0, 1).
        sensor: (k,) which sensor of the robot measured.
        target_sensor: (k,) which sensor, or tag, of a robot was measured.
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    target: Integers = field(metadata=TARGET)
    range: Array = field(metadata=checked(finite, "range [m]", 0))
    bound: Array = field(metadata=checked(finite, "range bound [m]", 0))
    relative_bound: Array = field(metadata=checked(finite, "relative range bound", 0, BELOW_1))
    sensor: Integers = field(default_factory=centre, metadata=SENSOR)
    target_sensor: Integers = field(default_factory=centre, metadata=SENSOR)

    if TYPE_CHECKING:

        def __init__(
            self,
            time: float,
            robot: Floats,
            target: Floats,
            range: Floats,
            bound: Floats,
            relative_bound: Floats,
            sensor: Floats = ...,
            target_sensor: Floats = ...,
        ) -> None: ...

    def interval(self) -> tuple[Array, Array]:
        """Return the (k,) least and greatest true distances [m]; a lower end below 0 is 0."""
        return interval_of_measured(self.range, self.bound, self.relative_bound, lowest=0.0)


@dataclass(frozen=True, eq=False)
class Position(Record):
    """Where robots are, in half-planes normal . x <= offset: a position fix, a room, a dock, one side of a line.

    All half-planes of one robot, or of one sensor of it, in one record are one measurement. As a rule made by `fix`, `disc`,
    `within` or `half_plane`.

    Attributes:
        time: When [s].
        robot: (k,) who is there.
        normal_x: (k,) outward normal, of length 1 to rounding.
        normal_y: (k,)
        offset: (k,) [m].
        sensor: (k,) which sensor of the robot, an antenna say, is there.
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    normal_x: Array = field(metadata=checked(finite, "normal", -2, 2))
    normal_y: Array = field(metadata=checked(finite, "normal", -2, 2))
    offset: Array = field(metadata=checked(finite, "offset [m]"))
    sensor: Integers = field(default_factory=centre, metadata=SENSOR)

    if TYPE_CHECKING:

        def __init__(
            self, time: float, robot: Floats, normal_x: Floats, normal_y: Floats, offset: Floats, sensor: Floats = ...
        ) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        if (np.abs(np.hypot(self.normal_x, self.normal_y) - 1) > BY_HAND).any():
            raise InvalidInput("normals of length 1 (see Position.half_plane)", shown(self.normals.tolist()))

    @property
    def normals(self) -> Array:
        """(k, 2) outward normals."""
        return np.stack([self.normal_x, self.normal_y], axis=1)

    @property
    def first(self) -> Integers:
        """(k,) where in the record the measurement begins that each half-plane is of."""
        _, first, which = np.unique(np.stack([self.robot, self.sensor]), axis=1, return_index=True, return_inverse=True)
        return np.asarray(first[which.ravel()])

    @classmethod
    def within(cls, time: float, robot: int, polygon: Polygon, sensor: int = AT_THE_CENTRE) -> Self:
        """Return that a robot, or a sensor of it, is in a polygon; raises `InvalidInput` if it is none."""
        edges = instance("a polygon", polygon, Polygon)
        return cls(time, robot, edges.normals[:, 0], edges.normals[:, 1], edges.offsets, sensor)

    @classmethod
    def fix(cls, time: float, robot: int, position: Floats, bound: Floats, sensor: int = AT_THE_CENTRE) -> Self:
        """Return that it is within +- bound, one number or one for each axis, of a position (2,) [m], in x and in y."""
        middle, half = place("position [m]", position), finite("bound of a position [m]", bound, 0)
        if half.shape not in ((), (2,)):
            raise InvalidInput("bound of a position [m]: one number, or one for x and one for y", shown(bound))
        lower, upper = (np.nextafter(middle + sign * half, sign * np.inf) for sign in (-1, 1))
        return cls.within(time, robot, Polygon.box(lower, upper), sensor)

    @classmethod
    def disc(cls, time: float, robot: int, centre: Floats, radius: float, sides: int = 32, sensor: int = AT_THE_CENTRE) -> Self:
        """Return that it is no farther from a place (2,) than a radius [m], by so many tangents, from 3 to 1000."""
        middle, reach = place("centre [m]", centre), number("radius [m]", radius, 0)
        angle = 2 * np.pi * np.arange(count := whole_number("sides", sides, 3, 1000)) / count
        x, y = np.cos(angle), np.sin(angle)
        rounding = 8 * EPSILON * (np.abs(middle).sum() + reach)
        return cls(time, robot, x, y, x * middle[0] + y * middle[1] + reach + rounding, sensor)

    @classmethod
    def half_plane(cls, time: float, robot: int, normal: Floats, offset: float, sensor: int = AT_THE_CENTRE) -> Self:
        """Return that normal . x <= offset of its position [m], for a normal (2,) of any length but 0."""
        across, beyond = place("normal", normal), number("offset [m]", offset)
        length = float(np.hypot(*across))
        if not length:
            raise InvalidInput("a normal with a direction", shown(normal))
        x, y = across / length
        return cls(time, robot, x, y, np.nextafter(beyond / length, np.inf), sensor)


Measurement = Compass | Bearing | Range | Position | RelativeHeading
MEASUREMENTS = (Compass, Bearing, Range, Position, RelativeHeading)


def measurements_of(records: Iterable[Measurement]) -> tuple[Measurement, ...]:
    """Return records of measurements, from whatever holds them; raises `InvalidInput` if something is none."""
    return several("records of compass, bearing, range, position or relative heading", records, *MEASUREMENTS)


def interval_of_measured(value: Array, bound: Array, relative_bound: Array, lowest: float = -np.inf) -> tuple[Array, Array]:
    """Return the least and greatest true values t with |value - t| <= bound + relative_bound |t|.

    From t (1 + e) >= value - bound for a positive t; never value (1 +- e), which cuts off the truth.
    """
    low, high = value - bound, value + bound
    least = np.where(low >= 0, low / (1 + relative_bound), low / (1 - relative_bound))
    greatest = np.where(high >= 0, high / (1 - relative_bound), high / (1 + relative_bound))
    return np.maximum(least, lowest), np.maximum(greatest, lowest)
