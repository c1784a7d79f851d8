"""What sensors say: records with a value and a bound, one or many at a time.

A record holds the measurements of one kind taken at one instant: every field but the time is a number or a (k,) array,
and numbers are repeated to the length of the longest. All are copied: times become floats, columns arrays of floats or of
whole numbers. Any real number will do (an int, a Fraction, a Decimal, one of numpy's); text will not.

Robots are numbered 0, 1, ..., n - 1; a target is a robot or, from n on, a landmark (see `Team`). The true error is within
+- bound, always: a bound is a promise, not a deviation.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields
from typing import TYPE_CHECKING, Any

import numpy as np

from filter.arrays import Array, Floats, Integers, finite, number, read_only, settle, several, whole
from filter.errors import InvalidInput


def _columns(record: Any, **columns: Any) -> None:
    """Set the record's fields to read-only (k,) arrays of one length."""
    try:
        arrays = np.broadcast_arrays(*(np.atleast_1d(column) for column in columns.values()))
    except ValueError:
        lengths = {name: np.size(column) for name, column in columns.items()}
        raise InvalidInput(f"{type(record).__name__}: columns of one length", lengths) from None
    if arrays[0].ndim != 1:
        raise InvalidInput(f"{type(record).__name__}: numbers or (k,) columns", f"shape {arrays[0].shape}")
    settle(record, **dict(zip(columns, map(read_only, arrays), strict=True)))


def _not_itself(record: Bearing | Range) -> None:
    itself = record.robot == record.target
    if itself.any():
        name = type(record).__name__.lower()
        raise InvalidInput(f"{name}: a target other than the robot that measures", f"robot {record.robot[itself][0]} on itself")


@dataclass(frozen=True, eq=False)
class Compass:
    """Headings in the world frame, by compass.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        heading: (k,) measured yaw, counter-clockwise from +x [rad].
        bound: (k,) largest error, in [0, pi] [rad].

    Raises:
        InvalidInput: A value is not finite or out of its range.
    """

    time: float
    robot: Integers
    heading: Array
    bound: Array

    if TYPE_CHECKING:  # numbers and sequences are taken, arrays are kept

        def __init__(self, time: float, robot: Floats, heading: Floats, bound: Floats) -> None: ...

    def __post_init__(self) -> None:
        settle(self, time=number("time [s]", self.time))
        _columns(
            self,
            robot=whole("robot", self.robot),
            heading=finite("heading [rad]", self.heading),
            bound=finite("compass bound [rad]", self.bound, 0, np.pi),
        )


@dataclass(frozen=True, eq=False)
class Bearing:
    """Directions to targets in the measuring robot's own frame.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        target: (k,) robot or landmark that was seen.
        bearing: (k,) measured angle from the robot's forward axis, counter-clockwise [rad].
        bound: (k,) largest error, in [0, pi/2) [rad].

    Raises:
        InvalidInput: A value is not finite or out of its range, or a robot measures itself.
    """

    time: float
    robot: Integers
    target: Integers
    bearing: Array
    bound: Array

    if TYPE_CHECKING:  # numbers and sequences are taken, arrays are kept

        def __init__(self, time: float, robot: Floats, target: Floats, bearing: Floats, bound: Floats) -> None: ...

    def __post_init__(self) -> None:
        settle(self, time=number("time [s]", self.time))
        _columns(
            self,
            robot=whole("robot", self.robot),
            target=whole("target", self.target),
            bearing=finite("bearing [rad]", self.bearing),
            bound=finite("bearing bound [rad]", self.bound, 0, np.nextafter(np.pi / 2, 0)),
        )
        _not_itself(self)


@dataclass(frozen=True, eq=False)
class Range:
    """Distances to targets; the true distance d gives a value within d (1 +- relative_bound) +- bound.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        target: (k,) robot or landmark that was seen.
        range: (k,) measured distance, from 0 on [m].
        bound: (k,) largest absolute error, from 0 on [m].
        relative_bound: (k,) largest relative error, in [0, 1).

    Raises:
        InvalidInput: A value is not finite or out of its range, or a robot measures itself.
    """

    time: float
    robot: Integers
    target: Integers
    range: Array
    bound: Array
    relative_bound: Array

    if TYPE_CHECKING:  # numbers and sequences are taken, arrays are kept

        def __init__(
            self, time: float, robot: Floats, target: Floats, range: Floats, bound: Floats, relative_bound: Floats
        ) -> None: ...

    def __post_init__(self) -> None:
        settle(self, time=number("time [s]", self.time))
        _columns(
            self,
            robot=whole("robot", self.robot),
            target=whole("target", self.target),
            range=finite("range [m]", self.range, 0),
            bound=finite("range bound [m]", self.bound, 0),
            relative_bound=finite("relative range bound", self.relative_bound, 0, np.nextafter(1.0, 0)),
        )
        _not_itself(self)

    def interval(self) -> tuple[Array, Array]:
        """Return the (k,) least and greatest true distances [m]; a lower end below 0 is 0."""
        return interval_of_measured(self.range, self.bound, self.relative_bound, lowest=0.0)


Measurement = Compass | Bearing | Range


def measurements_of(records: Iterable[Measurement]) -> tuple[Measurement, ...]:
    """Return records of compass, bearing or range, from whatever holds them.

    Raises:
        InvalidInput: Something is no such record.
    """
    return several("records of compass, bearing or range", records, Compass, Bearing, Range)


@dataclass(frozen=True, eq=False)
class Odometry:
    """How robots moved between two instants, from wheel encoders or commands.

    The robot drove a path of signed length within `distance +- distance_bound` while it turned by `turn +- turn_bound`;
    its displacement is that path turned from the straight line along (first heading + turn / 2) by at most
    `direction_bound`, plus a slip of at most `slip_bound` in any direction.

    Attributes:
        start: Beginning of the motion [s].
        time: End of the motion [s].
        robot: (k,) who moved; at most once each.
        distance: (k,) path length, negative when driving backwards [m].
        distance_bound: (k,) its largest error [m].
        turn: (k,) change of heading, counter-clockwise [rad].
        turn_bound: (k,) its largest error, from 0 on [rad].
        direction_bound: (k,) largest deviation of the motion's direction, in [0, pi/2) [rad].
        slip_bound: (k,) largest further displacement [m].

    Raises:
        InvalidInput: A value is not finite or out of its range, time runs backwards, or a robot comes twice.
    """

    start: float
    time: float
    robot: Integers
    distance: Array
    distance_bound: Array
    turn: Array
    turn_bound: Array
    direction_bound: Array
    slip_bound: Array

    if TYPE_CHECKING:  # numbers and sequences are taken, arrays are kept

        def __init__(
            self,
            start: float,
            time: float,
            robot: Floats,
            distance: Floats,
            distance_bound: Floats,
            turn: Floats,
            turn_bound: Floats,
            direction_bound: Floats,
            slip_bound: Floats,
        ) -> None: ...

    def __post_init__(self) -> None:
        settle(self, start=number("start [s]", self.start), time=number("time [s]", self.time))
        if self.time < self.start:
            raise InvalidInput(f"odometry that ends at its start or later, from {self.start!r} s on", f"{self.time!r} s")
        _columns(
            self,
            robot=whole("robot", self.robot),
            distance=finite("distance [m]", self.distance),
            distance_bound=finite("distance bound [m]", self.distance_bound, 0),
            turn=finite("turn [rad]", self.turn),
            turn_bound=finite("turn bound [rad]", self.turn_bound, 0),
            direction_bound=finite("direction bound [rad]", self.direction_bound, 0, np.nextafter(np.pi / 2, 0)),
            slip_bound=finite("slip bound [m]", self.slip_bound, 0),
        )
        if len(np.unique(self.robot)) < len(self.robot):
            raise InvalidInput("odometry: each robot at most once", f"robots {self.robot.tolist()}")


def interval_of_measured(value: Array, bound: Array, relative_bound: Array, lowest: float = -np.inf) -> tuple[Array, Array]:
    """Return the least and greatest true values t with |value - t| <= bound + relative_bound |t|.

    From t (1 + e) >= value - bound for a positive t; never value (1 +- e), which cuts off the truth.
    """
    low, high = value - bound, value + bound
    least = np.where(low >= 0, low / (1 + relative_bound), low / (1 - relative_bound))
    greatest = np.where(high >= 0, high / (1 - relative_bound), high / (1 + relative_bound))
    return np.maximum(least, lowest), np.maximum(greatest, lowest)


def field_names(record: Measurement | Odometry) -> list[str]:
    """Return the names of a record's columns, its times left out."""
    return [field.name for field in fields(record) if field.name not in ("start", "time")]
