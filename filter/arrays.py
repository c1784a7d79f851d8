"""Array types, the base of records made of arrays, and the checks that every record shares."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from filter.errors import InvalidInput

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]
Floats = ArrayLike


def read_only(values: NDArray[Any]) -> NDArray[Any]:
    """Return the array itself, made read-only, or a read-only copy of a view."""
    owned = values if values.flags.owndata else values.copy()
    owned.flags.writeable = False
    return owned


class Frozen:
    """Base of frozen dataclasses: the arrays among their fields are made read-only."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __post_init__(self) -> None:
        for name in self.__dataclass_fields__:
            value = getattr(self, name)
            if isinstance(value, np.ndarray):
                object.__setattr__(self, name, read_only(value))


class Table(Frozen):
    """Base of frozen dataclasses whose fields are columns: arrays with one entry, or one row, for each of k things."""

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """The columns, in the order of the fields."""
        return tuple(getattr(self, name) for name in self.__dataclass_fields__)

    def __len__(self) -> int:
        return len(self.columns[0])

    def select(self, index: Integers | Mask) -> Self:
        """Return some of the entries, by index or mask."""
        return type(self)(*(column[index] for column in self.columns))

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """Return the entries of all parts, in their order."""
        return cls(*map(np.concatenate, zip(*(part.columns for part in parts), strict=True)))


# Beyond this a product of two lengths can overflow; nothing a robot measures is near it.
LARGEST = 1e100


def finite(name: str, values: Floats, low: float = -np.inf, high: float = np.inf) -> Array:
    """Return the values as floats, all finite and within [low, high].

    Raises:
        InvalidInput: A value is not a number, not finite, or outside.
    """
    limits = f" within [{low:g}, {high:g}]" if np.isfinite([low, high]).any() else ""
    expected = f"{name}: finite numbers{limits}"
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError, OverflowError):
        raise InvalidInput(expected, repr(values)) from None
    wrong = ~(np.abs(array) <= LARGEST) | (array < low) | (array > high)
    if wrong.any():
        raise InvalidInput(expected, array[wrong].flat[0].item())
    return array


def number(name: str, value: Any, low: float = -np.inf, high: float = np.inf) -> float:
    """Return one finite number within [low, high].

    Raises:
        InvalidInput: It is none.
    """
    array = finite(name, value, low, high)
    if array.ndim:
        raise InvalidInput(f"{name}: one number", repr(value))
    return float(array)


def whole(name: str, values: Any, low: int = 0) -> Integers:
    """Return the values as whole numbers from `low` on.

    Raises:
        InvalidInput: A value is smaller, too large for an index, or not a whole number.
    """
    expected = f"{name}: whole numbers from {low} on"
    try:
        array = np.asarray(values)
    except ValueError:  # rows of different lengths
        raise InvalidInput(expected, repr(values)) from None
    if array.dtype.kind not in "iu" and array.size:
        raise InvalidInput(expected, repr(values))
    wrong = (array < low) | (array > np.iinfo(np.int64).max)
    if wrong.any():
        raise InvalidInput(expected, array[wrong].flat[0].item())
    return np.array(array, dtype=np.int64)
