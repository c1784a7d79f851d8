"""What sensors say: records with a value and a bound, one or many at a time; and what one instant gives, with the truth.

A record holds the measurements of one kind taken at one instant: every field but the time is a number or a (k,) array, and
numbers are repeated to the length of the longest. All are copied: times become floats, columns read-only arrays of floats or of
whole numbers. Any real number will do (an int, a Fraction, a Decimal, one of numpy's); text will not. Every record raises
`InvalidInput` if a value is of another type, not finite, or out of its range, or if the columns differ in length.

Robots are numbered 0, 1, ..., n - 1; a target is a robot or, from n on, a landmark (see `Team`). The true error is within
+- bound, always: a bound is a promise, not a deviation.
"""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from filter.arrays import Array, Floats, Integers, checked, finite, several
from filter.errors import InvalidInput
from filter.records.record import BELOW_1, BELOW_90_DEGREES, ROBOT, TARGET, TIME, Record


class _Sighting(Record):
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
class Compass(Record):
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


def interval_of_measured(value: Array, bound: Array, relative_bound: Array, lowest: float = -np.inf) -> tuple[Array, Array]:
    """Return the least and greatest true values t with |value - t| <= bound + relative_bound |t|.

    From t (1 + e) >= value - bound for a positive t; never value (1 +- e), which cuts off the truth.
    """
    low, high = value - bound, value + bound
    least = np.where(low >= 0, low / (1 + relative_bound), low / (1 - relative_bound))
    greatest = np.where(high >= 0, high / (1 - relative_bound), high / (1 + relative_bound))
    return np.maximum(least, lowest), np.maximum(greatest, lowest)
