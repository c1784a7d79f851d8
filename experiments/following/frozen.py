"""What frozen dataclasses of the experiments have in common: numbers within limits, and arrays that nobody writes to."""

from __future__ import annotations

import numpy as np

from filter.arrays import number, read_only


def keep_within(record: object, **limits: tuple[float, float]) -> None:
    """Refuse fields that are not within their limits; None, where something is not given, is always within.

    Args:
        record: A command's options, or bounds.
        limits: The least and the greatest value of some of its fields; infinite where there is no limit.

    Raises:
        InvalidInput: A field is not a finite number within its limits.
    """
    for name, (low, high) in limits.items():
        value = getattr(record, name)
        if value is not None:
            number(name.replace("_", " "), value, low, high)


def freeze(record: object) -> None:
    """Make the arrays among a dataclass's fields read-only; those that are views become copies."""
    for name, value in vars(record).items():
        if isinstance(value, np.ndarray):
            object.__setattr__(record, name, read_only(value))
