"""Array types, the base of records made of arrays, and the checks of everything that is handed in.

A check raises `InvalidInput`, with what was expected and what came, unless a value is what its docstring says.
"""

from collections.abc import Callable, Iterator, Sequence
from decimal import Decimal
from fractions import Fraction
from functools import cache, cached_property
from typing import Any, ClassVar, Self

import numpy as np
from numpy.typing import ArrayLike, NDArray

from filter.errors import InvalidInput, OutOfRange

Array = NDArray[np.float64]
Integers = NDArray[np.int64]
Mask = NDArray[np.bool_]
Floats = ArrayLike

LARGEST = 1e100  # beyond this a product of two lengths can overflow; nothing a robot measures is near it
MOST_ROBOTS = 1_000_000  # no team has more: a larger number is a slip, and would fill the memory
MAX_INDEX = np.iinfo(np.int64).max
SHOWN = 120  # so many characters of what came are shown
REAL = (int, float, Fraction, Decimal, np.integer, np.floating)
NOT_REAL = (bool, np.timedelta64)  # though they are integers to Python and to numpy


def read_only(values: NDArray[Any]) -> NDArray[Any]:
    """Return the array itself, made read-only, or a read-only copy of a view; for arrays that no caller may still write to."""
    if not isinstance(values, np.ndarray):
        raise InvalidInput("a numpy array", shown(values))
    flags = values.flags
    if flags.owndata and not flags.writeable:
        return values
    owned = values if flags.owndata else values.copy()
    owned.setflags(write=False)
    return owned


def settle(record: object, **checked: Any) -> None:
    """Set fields of a frozen record to their checked values."""
    vars(record).update(checked)


class Frozen:
    """Base of frozen dataclasses: fields become what the checks in their metadata make of them, and arrays read-only."""

    __dataclass_fields__: ClassVar[dict[str, Any]]

    def __post_init__(self) -> None:
        kind: Any = type(self)
        given = self.__dict__
        if _checks(kind):
            given |= self._passed()
        for name, value in given.items():
            if isinstance(value, np.ndarray):
                given[name] = read_only(value)

    def _passed(self) -> dict[str, Any]:
        """Return what the checks make of fields that have one."""
        kind: Any = type(self)
        return {name: check(self.__dict__[name]) for name, check in _checks(kind)}


@cache
def _checks(kind: type[Any]) -> list[tuple[str, Callable[[Any], Any]]]:
    """Return the fields that have to pass a check, and that."""
    return [(name, field.metadata["check"]) for name, field in kind.__dataclass_fields__.items() if "check" in field.metadata]


def checked(check: Callable[..., Any], name: str, *limits: Any, optional: bool = False) -> dict[str, Any]:
    """Return a field's metadata: the check below that it has to pass, its name and limits, and whether None will do, too."""
    return {"check": lambda value: None if optional and value is None else check(name, value, *limits)}


class Table(Frozen):
    """Base of frozen dataclasses whose fields are columns: arrays with one entry, or one row, for each of k things."""

    @property
    def columns(self) -> tuple[NDArray[Any], ...]:
        """The columns, in the order of the fields."""
        return tuple(getattr(self, name) for name in self.__dataclass_fields__)

    def __len__(self) -> int:
        return len(self.__dict__[next(iter(self.__dataclass_fields__))])

    def select(self, index: Integers | Mask) -> Self:
        """Return some of the entries, by index or mask."""
        return type(self)(*(column[index] for column in self.columns))

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """Return the entries of all parts, in their order."""
        some = _not_empty(parts)
        return some[0] if len(some) == 1 else cls(*map(np.concatenate, zip(*(part.columns for part in some), strict=True)))


def places(first: Integers, index: Integers) -> tuple[Integers, Integers]:
    """Return the places of what some of n lists, by (k,) index, hold, one after the other, and where each then begins.

    The lists lie end to end; `first`, (n + 1,), is where they begin.
    """
    counts = first[index + 1] - first[index]
    begins = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(counts)])
    return np.repeat(first[index] - begins[:-1], counts) + np.arange(begins[-1]), begins


class Lists(Frozen):
    """Base of frozen dataclasses of n lists laid end to end.

    `first`, (n + 1,), is where each list begins. Other columns have one entry, or one row, for each item; those named in
    `of_lists` one for each list.
    """

    first: Integers
    of_lists: ClassVar[tuple[str, ...]] = ()

    def __len__(self) -> int:
        return len(self.first) - 1

    @cached_property
    def counts(self) -> Integers:
        """(n,) how many items each list has."""
        return read_only(self.first[1:] - self.first[:-1])

    def select(self, index: Integers) -> Self:
        """Return some of the lists, by (k,) index."""
        items, first = places(self.first, index)
        which = {name: index if name in self.of_lists else items for name in self._columns()}
        columns = {name: getattr(self, name)[some] for name, some in which.items()}
        return type(self)(**columns | {"first": first})

    @classmethod
    def concatenate(cls, parts: Sequence[Self]) -> Self:
        """Return the lists of all parts, in their order."""
        some = _not_empty(parts)
        if len(some) == 1:
            return some[0]
        counts = np.concatenate([np.zeros(1, dtype=np.int64), *(part.counts for part in some)])
        columns = {name: np.concatenate([getattr(part, name) for part in some]) for name in cls._columns()}
        return cls(**columns | {"first": np.cumsum(counts)})

    @classmethod
    def _columns(cls) -> list[str]:
        return [name for name in cls.__dataclass_fields__ if name != "first"]


def _not_empty(parts: Sequence[Any]) -> Sequence[Any]:
    """Return the parts that have something, or the first one if none has."""
    return [part for part in parts if len(part)] or parts[:1]


def shown(value: Any) -> str:
    """Return a value as one line of text that is not too long, whatever it is."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # a caller's own class can raise anything
        text = "what cannot be shown"
    return text if len(text) <= SHOWN else f"{text[:SHOWN]}... ({type(value).__name__})"


def _made(expected: str, values: Any, made_of: Callable[[NDArray[Any]], NDArray[Any] | None]) -> NDArray[Any]:
    """Return what can be made of a copy of the values as an array, unless that is None."""
    masked = _masked(values)
    try:
        made = None if masked else made_of(np.array(values))
    except Exception:  # numpy's errors, and whatever a caller's own class raises
        made = None
    if made is None:
        raise InvalidInput(expected + ", none of them masked (fill or drop those)" * masked, shown(values))
    return made


def _masked(values: Any, depth: int = 3) -> bool:
    """Return whether something is, or holds, an array whose mask would be lost."""
    if isinstance(values, list | tuple) and depth:
        return any(_masked(value, depth - 1) for value in values)
    return isinstance(values, np.ma.MaskedArray)


def _as_floats(array: NDArray[Any]) -> Array | None:
    kind = array.dtype.kind
    real = kind == "O" and all(isinstance(each, REAL) and not isinstance(each, NOT_REAL) for each in array.flat)
    return array.astype(np.float64, copy=False) if real or kind in "fiu" else None


def _as_whole(array: NDArray[Any]) -> NDArray[Any] | None:
    return array if array.dtype.kind in "iu" or (array.dtype.kind == "f" and not array.size) else None


def floats(name: str, values: Floats, expected: str = "numbers") -> Array:
    """Return a copy of real numbers as floats, infinite ones and NaN included, none of them masked.

    Ints, Fractions, Decimals and numpy's numbers are real numbers, alone, in arrays or in lists; text is none, nor is True.
    """
    return _made(f"{name}: {expected}", values, _as_floats)


def finite(name: str, values: Floats, low: float = -np.inf, high: float = np.inf) -> Array:
    """Return a copy of real numbers (see `floats`) as floats, all finite and within [low, high]."""
    least, most = max(low, -LARGEST), min(high, LARGEST)
    if type(values) is float and least <= values <= most:
        return np.array(values)
    if type(values) is np.ndarray and values.dtype == np.float64 and ((values >= least) & (values <= most)).all():
        return values.copy()
    expected = "finite numbers" + (f" within [{low:g}, {high:g}]" if low > -np.inf or high < np.inf else "")
    array = floats(name, values, expected)
    right = (array >= least) & (array <= most)
    if not right.all():
        wrong = array[~right].flat[0].item()
        largest = f", none beyond {LARGEST:g}" if LARGEST < abs(wrong) < np.inf else ""
        raise InvalidInput(f"{name}: {expected}{largest}", wrong)
    return array


def number(name: str, value: Any, low: float = -np.inf, high: float = np.inf) -> float:
    """Return one finite number within [low, high] as a float."""
    if type(value) is float and max(low, -LARGEST) <= value <= min(high, LARGEST):
        return value
    return float(_alone(f"{name}: one number", finite(name, value, low, high), value))


def positive(name: str, value: Any, high: float = np.inf) -> float:
    """Return one finite number above 0 and up to `high` as a float; what it divides stays finite."""
    return number(name, value, 1 / LARGEST, high)


def whole(name: str, values: Any, low: int = 0, high: int = MAX_INDEX) -> Integers:
    """Return a copy of whole numbers from `low` to `high`, none of them a float or masked."""
    if type(values) is int and low <= values <= high:
        return np.array(values)
    expected = f"{name}: whole numbers from {low} " + ("on" if high == MAX_INDEX else f"to {high}")
    array = _made(expected, values, _as_whole)
    right = (array >= low) & (array <= high)
    if not right.all():
        raise InvalidInput(expected, array[~right].flat[0].item())
    return array.astype(np.int64, copy=False)


def whole_number(name: str, value: Any, low: int = 0, high: int = MAX_INDEX) -> int:
    """Return one whole number from `low` to `high`."""
    if type(value) is int and low <= value <= high:
        return value
    return int(_alone(f"{name}: one whole number", whole(name, value, low, high), value))


def _alone(expected: str, array: NDArray[Any], came: Any) -> NDArray[Any]:
    if array.ndim:
        raise InvalidInput(expected, shown(came))
    return array


def one_by_one(expected: str, values: Any) -> Iterator[Any]:
    """Return what goes through a sequence, a generator or the like."""
    try:
        return iter(values)
    except Exception:  # of a caller's own class, too
        raise InvalidInput(expected, shown(values)) from None


def several(expected: str, values: Any, *kinds: type) -> tuple[Any, ...]:
    """Return what a sequence, a generator or the like holds: things of some types."""
    found = []
    for each in one_by_one(expected, values):
        if not isinstance(each, kinds):
            raise InvalidInput(expected, shown(each))
        found.append(each)
    return tuple(found)


def chosen(what: str, index: int | slice, among: int) -> int | range:
    """Return which of so many things an index or a slice means, as for a list; raises `OutOfRange` if it means none."""
    try:
        return range(among)[index]
    except Exception:  # of range, or of a caller's own class
        raise OutOfRange(f"{what} among 0 to {among - 1}", shown(index)) from None


def instance(name: str, value: Any, *kinds: type) -> Any:
    """Return a value that is of one of some types."""
    if not isinstance(value, kinds):
        raise InvalidInput(f"{name}: {' or '.join(map(_one, kinds))}", shown(value))
    return value


def _one(kind: type) -> str:
    """Return what to call a thing of a type."""
    if kind is type(None):
        return "None"
    return f"{'an' if kind.__name__[0] in 'AEIOU' else 'a'} {kind.__name__}"


def function(name: str, value: Any) -> Any:
    """Return a value that can be called."""
    if not callable(value):
        raise InvalidInput(f"{name}: a function", shown(value))
    return value
