"""The base of records: a time, and columns of numbers of one length."""

import re
from dataclasses import fields
from functools import cache, cached_property
from typing import Any, Self

import numpy as np

from filter.arrays import Array, Floats, Frozen, Integers, checked, finite, number, read_only, settle, shown, whole
from filter.errors import InvalidInput

UNNAMED = -1  # below every number
AT_THE_CENTRE = -1  # the number of a sensor that is at its robot's centre and looks forward
TIME, ROBOT, TARGET = checked(number, "time [s]"), checked(whole, "robot"), checked(whole, "target")
CENTRE = read_only(np.full(1, AT_THE_CENTRE))  # the column of sensors where nothing is said
BELOW_1, BELOW_90_DEGREES = np.nextafter(1.0, 0), np.nextafter(np.pi / 2, 0)
NAMING = ("robot", "target", "sensor", "target_sensor")  # the columns that name something by its number


def _greatest(numbers: Integers | None) -> int:
    if numbers is None:
        return UNNAMED
    return int(numbers.item() if len(numbers) == 1 else numbers.max(initial=UNNAMED))


def _numbers(name: str, values: Floats) -> Integers:
    # Few say which sensor measured: all others shall not pay for it.
    return CENTRE if values is CENTRE else whole(name, values, AT_THE_CENTRE)


SENSOR = checked(_numbers, "sensor")


def centre() -> Integers:
    """Return the column of sensors where nothing is said."""
    return CENTRE


def called(kind: type) -> str:
    """Return what a kind of records is called in words: "relative heading" for `RelativeHeading`."""
    return re.sub(r"(?<=[a-z])(?=[A-Z])", " ", kind.__name__).lower()


class Record(Frozen):
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

    @cached_property
    def greatest(self) -> tuple[int, ...]:
        """The greatest numbers of a robot, a target, a sensor and a target's sensor that are named; -1 where none is."""
        return tuple(map(_greatest, map(self.__dict__.get, NAMING)))

    @classmethod
    def of_checked(cls, time: float, columns: dict[str, np.ndarray], **times: float) -> Self:
        """Return a record of columns and times that were checked before, without a look."""
        record = object.__new__(cls)
        settle(record, time=time, **times, **{name: read_only(column) for name, column in columns.items()})
        return record


class Sighting(Record):
    """Base of records of targets: none is the robot that measures."""

    robot: Integers
    target: Integers

    def __post_init__(self) -> None:
        super().__post_init__()
        itself = self.robot[self.robot == self.target]
        if len(itself):
            raise InvalidInput(
                f"{called(type(self))}: a target other than the robot that measures", f"robot {itself[0]} on itself"
            )


def field_names(record: Any) -> list[str]:
    """Return the names of the columns of a record, or of a kind of records, its times left out."""
    return list(_columns_of(record if isinstance(record, type) else type(record)))


@cache
def _columns_of(kind: type[Any]) -> tuple[str, ...]:
    return tuple(each.name for each in fields(kind) if each.name not in ("start", "time"))


def place(name: str, values: Floats) -> Array:
    """Return two coordinates (2,), finite; raises `InvalidInput` unless they are."""
    coordinates = finite(name, values)
    if coordinates.shape != (2,):
        raise InvalidInput(f"{name}: two coordinates", shown(values))
    return coordinates
