"""Array types and the two checks that every record shares."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from filter.errors import InvalidInput

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]
Floats = ArrayLike


def read_only(values: NDArray[Any]) -> NDArray[Any]:
    """Return the array, or a copy of a view, that nobody can write to."""
    owned = values if values.flags.owndata else values.copy()
    owned.flags.writeable = False
    return owned


def finite(name: str, values: Floats, low: float = -np.inf, high: float = np.inf) -> Array:
    """Return the values as floats, all finite and within [low, high].

    Raises:
        InvalidInput: A value is not a number, not finite, or outside.
    """
    limits = f" within [{low:g}, {high:g}]" if np.isfinite([low, high]).any() else ""
    expected = f"{name}: finite numbers{limits}"
    try:
        array = np.array(values, dtype=float)
    except (TypeError, ValueError):
        raise InvalidInput(expected, repr(values)) from None
    wrong = ~np.isfinite(array) | (array < low) | (array > high)
    if wrong.any():
        raise InvalidInput(expected, array[wrong].flat[0].item())
    return array


def whole(name: str, values: Floats) -> Integers:
    """Return the values as whole numbers from 0 on.

    Raises:
        InvalidInput: A value is negative or not a whole number.
    """
    array = np.asarray(values)
    if array.dtype.kind not in "iu" and array.size:
        raise InvalidInput(f"{name}: whole numbers from 0 on", repr(values))
    if (array < 0).any():
        raise InvalidInput(f"{name}: whole numbers from 0 on", f"{array.min()}")
    return np.array(array, dtype=np.int64)
