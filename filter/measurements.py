"""What sensors say: records with a value and a bound, one or many at a time; and what one instant gives, with the truth.

A record holds the measurements of one kind taken at one instant: every field but the time is a number or a (k,) array, and
numbers are repeated to the length of the longest. All are copied: times become floats, columns read-only arrays of floats or of
whole numbers. Any real number will do (an int, a Fraction, a Decimal, one of numpy's); text will not. Every record raises
`InvalidInput` if a value is of another type, not finite, or out of its range, or if the columns differ in length.

Robots are numbered 0, 1, ..., n - 1; a target is a robot or, from n on, a landmark (see `Team`). The true error is within
+- bound, always: a bound is a promise, not a deviation.
"""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, fields
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from filter.arrays import (
    Array,
    Floats,
    Frozen,
    Integers,
    checked,
    finite,
    floats,
    instance,
    number,
    read_only,
    settle,
    several,
    whole,
)
from filter.errors import InvalidInput

TIME, ROBOT, TARGET = checked(number, "time [s]"), checked(whole, "robot"), checked(whole, "target")
BELOW_1, BELOW_90_DEGREES = np.nextafter(1.0, 0), np.nextafter(np.pi / 2, 0)


class _Record(Frozen):
    """Base of records: all columns get the length of the longest."""

    def _passed(self) -> dict[str, Any]:
        kind, values = type(self).__name__, super()._passed()
        columns = {name: value for name, value in values.items() if isinstance(value, np.ndarray)}
        try:
            arrays = np.broadcast_arrays(*map(np.atleast_1d, columns.values()))
        except ValueError:
            lengths = {name: column.size for name, column in columns.items()}
            raise InvalidInput(f"{kind}: columns of one length", lengths) from None
        if arrays[0].ndim != 1:
            raise InvalidInput(f"{kind}: numbers or (k,) columns", f"shape {arrays[0].shape}")
        return values | dict(zip(columns, arrays, strict=True))

    @classmethod
    def of_checked(cls, time: float, columns: dict[str, np.ndarray]) -> Self:
        """Return a record of columns that were checked before, without a look."""
        record = object.__new__(cls)
        settle(record, time=time, **{name: read_only(column) for name, column in columns.items()})
        return record


class _Sighting(_Record):
    """Base of records of targets: none is the robot that measures."""

    robot: Integers
    target: Integers

    def __post_init__(self) -> None:
        super().__post_init__()
        itself = self.robot[self.robot == self.target]
        if len(itself):
            name = type(self).__name__.lower()
            raise InvalidInput(f"{name}: a target other than the robot that measures", f"robot {itself[0]} on itself")


@dataclass(frozen=True, eq=False)
class Compass(_Record):
    """Headings in the world frame, by compass.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        heading: (k,) measured yaw, counter-clockwise from +x [rad].
        bound: (k,) largest error, in [0, pi] [rad].
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    heading: Array = field(metadata=checked(finite, "heading [rad]"))
    bound: Array = field(metadata=checked(finite, "compass bound [rad]", 0, np.pi))

    if TYPE_CHECKING:  # numbers and sequences are taken, arrays are kept

        def __init__(self, time: float, robot: Floats, heading: Floats, bound: Floats) -> None: ...


@dataclass(frozen=True, eq=False)
class Bearing(_Sighting):
    """Directions to targets in the measuring robot's own frame.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        target: (k,) robot or landmark that was seen, not itself.
        bearing: (k,) measured angle from the robot's forward axis, counter-clockwise [rad].
        bound: (k,) largest error, in [0, pi/2) [rad].
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    target: Integers = field(metadata=TARGET)
    bearing: Array = field(metadata=checked(finite, "bearing [rad]"))
    bound: Array = field(metadata=checked(finite, "bearing bound [rad]", 0, BELOW_90_DEGREES))

    if TYPE_CHECKING:

        def __init__(self, time: float, robot: Floats, target: Floats, bearing: Floats, bound: Floats) -> None: ...


@dataclass(frozen=True, eq=False)
class Range(_Sighting):
    """Distances to targets; the true distance d gives a value within d (1 +- relative_bound) +- bound.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        target: (k,) robot or landmark that was seen, not itself.
        range: (k,) measured distance, from 0 on [m].
        bound: (k,) largest absolute error, from 0 on [m].
        relative_bound: (k,) largest relative error, in [0, 1).
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    target: Integers = field(metadata=TARGET)
    range: Array = field(metadata=checked(finite, "range [m]", 0))
    bound: Array = field(metadata=checked(finite, "range bound [m]", 0))
    relative_bound: Array = field(metadata=checked(finite, "relative range bound", 0, BELOW_1))

    if TYPE_CHECKING:

        def __init__(
            self, time: float, robot: Floats, target: Floats, range: Floats, bound: Floats, relative_bound: Floats
        ) -> None: ...

    def interval(self) -> tuple[Array, Array]:
        """Return the (k,) least and greatest true distances [m]; a lower end below 0 is 0."""
        return interval_of_measured(self.range, self.bound, self.relative_bound, lowest=0.0)


Measurement = Compass | Bearing | Range


def measurements_of(records: Iterable[Measurement]) -> tuple[Measurement, ...]:
    """Return records of compass, bearing or range, from whatever holds them; raises `InvalidInput` if something is none."""
    return several("records of compass, bearing or range", records, Compass, Bearing, Range)


@dataclass(frozen=True, eq=False)
class Odometry(_Record):
    """How robots moved between two instants, from wheel encoders or commands.

    The robot drove a path of signed length within `distance +- distance_bound` while it turned by `turn +- turn_bound`;
    its displacement is that path turned from the straight line along (first heading + turn / 2) by at most
    `direction_bound`, plus a slip of at most `slip_bound` in any direction.

    Attributes:
        start: Beginning of the motion [s].
        time: End of the motion, not before its start [s].
        robot: (k,) who moved; at most once each.
        distance: (k,) path length, negative when driving backwards [m].
        distance_bound: (k,) its largest error [m].
        turn: (k,) change of heading, counter-clockwise [rad].
        turn_bound: (k,) its largest error, from 0 on [rad].
        direction_bound: (k,) largest deviation of the motion's direction, in [0, pi/2) [rad].
        slip_bound: (k,) largest further displacement [m].
    """

    start: float = field(metadata=checked(number, "start [s]"))
    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    distance: Array = field(metadata=checked(finite, "distance [m]"))
    distance_bound: Array = field(metadata=checked(finite, "distance bound [m]", 0))
    turn: Array = field(metadata=checked(finite, "turn [rad]"))
    turn_bound: Array = field(metadata=checked(finite, "turn bound [rad]", 0))
    direction_bound: Array = field(metadata=checked(finite, "direction bound [rad]", 0, BELOW_90_DEGREES))
    slip_bound: Array = field(metadata=checked(finite, "slip bound [m]", 0))

    if TYPE_CHECKING:

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
        super().__post_init__()
        if self.time < self.start:
            raise InvalidInput(f"odometry that ends at its start or later, from {self.start!r} s on", f"{self.time!r} s")
        if len(np.unique(self.robot)) < len(self.robot):
            raise InvalidInput("odometry: each robot at most once", f"robots {self.robot.tolist()}")


@dataclass(frozen=True, eq=False)
class Truth(Frozen):
    """Where the robots are. Raises `InvalidInput` if these are no numbers, or not as many.

    Attributes:
        positions: (n, 2) [m]; NaN where nobody knows.
        headings: (n,) yaw in (-pi, pi] [rad].
    """

    positions: Array = field(metadata=checked(floats, "positions [m]"))
    headings: Array = field(metadata=checked(floats, "headings [rad]"))

    if TYPE_CHECKING:  # sequences are taken, arrays are kept

        def __init__(self, positions: Floats, headings: Floats) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        positions, headings = self.positions.shape, self.headings.shape
        if len(headings) != 1 or positions != (*headings, 2):
            raise InvalidInput("positions (n, 2) and headings (n,)", f"shapes {positions} and {headings}")


@dataclass(frozen=True, eq=False)
class Frame(Frozen):
    """One instant of an episode or a log. Raises `InvalidInput` if something is of another type.

    Attributes:
        time: When [s].
        odometry: The motion since the previous frame, or None in the first one and where nothing is known of it.
        measurements: What was measured at this instant; kept as a tuple.
        truth: Where the robots are, or None where nobody knows.
    """

    time: float = field(metadata=TIME)
    odometry: Odometry | None = field(default=None, metadata=checked(instance, "odometry", Odometry, type(None)))
    measurements: Sequence[Measurement] = field(default=(), metadata={"check": measurements_of})
    truth: Truth | None = field(default=None, metadata=checked(instance, "truth", Truth, type(None)))


def interval_of_measured(value: Array, bound: Array, relative_bound: Array, lowest: float = -np.inf) -> tuple[Array, Array]:
    """Return the least and greatest true values t with |value - t| <= bound + relative_bound |t|.

    From t (1 + e) >= value - bound for a positive t; never value (1 +- e), which cuts off the truth.
    """
    low, high = value - bound, value + bound
    least = np.where(low >= 0, low / (1 + relative_bound), low / (1 - relative_bound))
    greatest = np.where(high >= 0, high / (1 - relative_bound), high / (1 + relative_bound))
    return np.maximum(least, lowest), np.maximum(greatest, lowest)


def field_names(record: Any) -> list[str]:
    """Return the names of a record's columns, its times left out."""
    return [each.name for each in fields(record) if each.name not in ("start", "time")]
