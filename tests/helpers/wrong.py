"""What a hostile user hands in, by kind of argument, and what of a belief must not change."""

import dataclasses
import datetime
from decimal import Decimal
from fractions import Fraction

import numpy as np


class Raises:
    """An object that numpy, or whoever asks for anything of it, gets an exception from."""

    __hash__ = None

    def __array__(self, *args, **kwargs):
        raise ZeroDivisionError("no array of me")

    def __repr__(self):
        raise RuntimeError("no text of me")

    def __eq__(self, other):
        raise RuntimeError("nothing is like me")

    def __iter__(self):
        raise RuntimeError("no way through me")

    def __index__(self):
        raise RuntimeError("no index of me")


class NoNumber:
    """As pandas.NA: neither true nor false."""

    def __bool__(self):
        raise TypeError("boolean value of NA is ambiguous")


class FloatLike:
    """It can be made a float, and is no number."""

    def __float__(self):
        return 0.5


def endless():
    """Return a list that holds itself."""
    loop = []
    loop.append(loop)
    return loop


# No finite real numbers, alone or in a column.
NO_NUMBERS = {
    "None": lambda: None,
    "text": lambda: "3",
    "bytes": lambda: b"3",
    "True": lambda: True,
    "numpy's True": lambda: np.True_,
    "complex": lambda: 1 + 0j,
    "complex of numpy": lambda: np.complex128(1),
    "NaN": lambda: np.nan,
    "infinite": lambda: -np.inf,
    "beyond any length": lambda: 1e101,
    "beyond any float": lambda: 10**400,
    "Decimal NaN": lambda: Decimal("sNaN"),
    "Fraction beyond any float": lambda: Fraction(10**400, 3),
    "long double beyond any float": lambda: np.longdouble("1e400"),
    "date": lambda: datetime.datetime(2020, 1, 1),
    "duration": lambda: np.timedelta64(3, "s"),
    "texts": lambda: np.array(["1", "2"]),
    "text among numbers": lambda: [1.0, "2"],
    "text in an object array": lambda: np.array([1, "2"], dtype=object),
    "truth in an object array": lambda: np.array([0.5, True], dtype=object),
    "nothing among numbers": lambda: [1.0, None],
    "truths": lambda: np.array([True, False]),
    "uneven rows": lambda: [[1.0], [1.0, 2.0]],
    "masked": lambda: np.ma.array([0.1, 0.2], mask=[0, 1]),
    "masked number": lambda: np.ma.array(0.1, mask=True),
    "masked without a mask": lambda: np.ma.array([0, 1]),
    "dictionary": lambda: {"a": 1},
    "generator": lambda: (k for k in range(2)),
    "function": lambda: len,
    "class": lambda: float,
    "raises": Raises,
    "raises in a list": lambda: [Raises()],
    "NA": NoNumber,
    "float-like": FloatLike,
    "holds itself": endless,
    "long": lambda: ["x" * 50] * 1000,
}
NO_NUMBER = {**NO_NUMBERS, "column of one": lambda: np.array([0.5]), "nothing": lambda: [], "pair": lambda: (0.5, 0.6)}
NO_WHOLE_NUMBERS = {
    **NO_NUMBERS,
    "float": lambda: 1.0,
    "float of numpy": lambda: np.float64(1),
    "Decimal": lambda: Decimal(1),
    "Fraction": lambda: Fraction(1),
    "below 0": lambda: -1,
    "below 0 in a column": lambda: [0, -1],
    "too large for an index": lambda: np.uint64(2**64 - 1),
}
NO_WHOLE_NUMBER = {**NO_WHOLE_NUMBERS, "column of one": lambda: np.array([1]), "nothing": lambda: [], "pair": lambda: (1, 2)}
# Neither of a type of ours, nor a sequence of such things, nor a function.
NOT_OURS = {
    "None": lambda: None,
    "number": lambda: 3,
    "text": lambda: "team",
    "0-d array": lambda: np.array(1.0),
    "array": lambda: np.zeros((2, 2)),
    "list": lambda: [(0.0, 0.1), (1.0, 0.1)],
    "dictionary": lambda: {"a": 1},
    "object": object,
    "raises": Raises,
}
# No points (k, 2).
NO_POINTS = {
    **{name: value for name, value in NO_NUMBERS.items() if name not in ("NaN", "infinite", "beyond any length")},
    "number": lambda: 1.0,
    "flat": lambda: [1.0, 2.0, 3.0],
    "spatial": lambda: np.zeros((2, 3)),
    "masked rows": lambda: [np.ma.array([0.1, 0.2], mask=[0, 1]), np.ma.array([0.1, 0.2], mask=[0, 0])],
}


def snapshot(thing):
    """Return all that a belief holds, as plain values; what is only remembered does not count."""
    if isinstance(thing, np.ndarray):
        return thing.dtype.str, thing.shape, thing.tobytes()
    if isinstance(thing, tuple | list):
        return [snapshot(part) for part in thing]
    if dataclasses.is_dataclass(thing):
        return [snapshot(getattr(thing, column.name)) for column in dataclasses.fields(thing)]
    return repr(thing)
