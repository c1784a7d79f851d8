"""Strict reading of tables of settings, a key at a time: nothing missing, nothing unknown, and the nearest right word."""

from __future__ import annotations

import math
from collections.abc import Sequence
from reprlib import repr as shortened
from typing import Any

from experiments.recorded.words import nearest
from filter import InvalidInput

Bound = float | tuple[float, float]  # within +- bound, or measured - true within [low, high]


class Table:
    """A table of a TOML file; every method raises `InvalidInput` for what is not as it should be.

    Attributes:
        place: Where in which file it is, for errors.
    """

    def __init__(self, place: str, values: dict[str, Any]) -> None:
        self.place = place
        self._values = dict(values)
        self._asked: list[str] = []

    def has(self, name: str) -> bool:
        """Return whether there is such a key."""
        self._asked.append(name)
        return name in self._values

    def copy(self) -> Table:
        """Return a table of what nobody has taken yet."""
        return Table(self.place, self._values)

    def is_false(self, name: str) -> bool:
        """Return whether a key says false; it is taken then."""
        if self._values.get(name) is not False:
            return False
        return not self.flag(name)

    def is_table(self, name: str) -> bool:
        """Return whether there is a table of that name."""
        return isinstance(self._values.get(name), dict)

    def names(self) -> list[str]:
        """Return the keys that nobody has taken yet, in the file's order."""
        return list(self._values)

    def end(self) -> None:
        """Refuse keys that nobody took."""
        for name in self._values:
            raise InvalidInput(f"{self.place}: keys that are known: {nearest(name, self._asked)}", f'"{name}"')

    def take(self, name: str, what: str) -> Any:
        """Take a value of any kind; `what` says what it should be."""
        if not self.has(name):
            raise InvalidInput(f'{self.place}: a key "{name}", {what}', f"keys {', '.join(self._values) or 'none'}")
        return self._values.pop(name)

    def refuse(self, name: str, what: str, came: Any) -> InvalidInput:
        """Return the error that a value is not what it should be."""
        return InvalidInput(f"{self.place}: {name}: {what}", shortened(came))

    def text(self, name: str, what: str) -> str:
        """Take a string that is not empty."""
        value = self.take(name, what)
        if not isinstance(value, str) or not value:
            raise self.refuse(name, what, value)
        return value

    def text_or(self, name: str, what: str, otherwise: str) -> str:
        """Take a string, or return another one where there is none."""
        return self.text(name, what) if self.has(name) else otherwise

    def word(self, name: str, words: Sequence[str], otherwise: str) -> str:
        """Take one of some words, or return another one where there is none."""
        if not self.has(name):
            return otherwise
        value = self.text(name, f"one of {', '.join(words)}")
        if value not in words:
            raise self.refuse(name, f"one of {', '.join(words)}: {nearest(value, words)}", value)
        return value

    def flag(self, name: str) -> bool:
        """Take true or false; false where there is none."""
        value = self.take(name, "true or false") if self.has(name) else False
        if not isinstance(value, bool):
            raise self.refuse(name, "true or false", value)
        return value

    def number(self, name: str, what: str, least: float = -math.inf) -> float:
        """Take a finite number that is not below another one."""
        return self.checked(name, self.take(name, what), what, least)

    def number_or(self, name: str, what: str, otherwise: float, least: float = -math.inf) -> float:
        """Take a number, or return another one where there is none."""
        return self.number(name, what, least) if self.has(name) else otherwise

    def numbers(self, name: str, what: str, count: int, least: float = -math.inf) -> list[float]:
        """Take a list of so many numbers."""
        value = self.take(name, what)
        if not isinstance(value, list) or len(value) != count:
            raise self.refuse(name, what, value)
        return [self.checked(name, each, what, least) for each in value]

    def points(self, name: str, what: str, *, open_ends: bool = False) -> list[list[float]]:
        """Take a list of [x, y]; with `open_ends` a coordinate may be inf or -inf."""
        value = self.take(name, what)
        if not isinstance(value, list) or not all(isinstance(each, list) and len(each) == 2 for each in value):
            raise self.refuse(name, what, value)
        return [[self.checked(name, each, what, endless=open_ends) for each in point] for point in value]

    def bound(self, name: str, what: str, *, pairs: bool) -> Bound:
        """Take a bound: a number from 0 on or, where pairs are known, [low, high] of measured - true."""
        value = self.take(name, what)
        if not isinstance(value, list):
            return self.checked(name, value, what, 0.0)
        if not pairs or len(value) != 2:
            raise self.refuse(name, what, value)
        low, high = (self.checked(name, each, what) for each in value)
        if low > high:
            raise self.refuse(name, "[low, high] of measured - true, low first", value)
        return low, high

    def list_of_texts(self, name: str, what: str) -> list[str]:
        """Take a list of strings; an empty one where there is none."""
        value = self.take(name, what) if self.has(name) else []
        if not isinstance(value, list) or not all(isinstance(each, str) for each in value):
            raise self.refuse(name, what, value)
        return value

    def table(self, name: str, what: str) -> Table:
        """Take a table."""
        value = self.take(name, what)
        if not isinstance(value, dict):
            raise self.refuse(name, what, value)
        return Table(f"{self.place} {name}", value)

    def table_or_empty(self, name: str, what: str) -> Table:
        """Take a table, or return one without keys where there is none."""
        return self.table(name, what) if self.has(name) else Table(f"{self.place} {name}", {})

    def tables(self, name: str, what: str) -> list[Table]:
        """Take one table or a list of them; none where there is none."""
        if not self.has(name):
            return []
        value = self.take(name, what)
        several = value if isinstance(value, list) else [value]
        if not all(isinstance(each, dict) for each in several):
            raise self.refuse(name, what, value)
        numbers = [""] if len(several) == 1 else [f"[{k}]" for k in range(len(several))]
        return [Table(f"{self.place} {name}{number}", each) for number, each in zip(numbers, several, strict=True)]

    def checked(self, name: str, value: Any, what: str, least: float = -math.inf, *, endless: bool = False) -> float:
        """Return a number as a float, if it is one."""
        if isinstance(value, bool) or not isinstance(value, int | float) or math.isnan(value) or value < least:
            raise self.refuse(name, what, value)
        if math.isinf(value) and not endless:
            raise self.refuse(name, f"{what}, finite", value)
        return float(value)


def texts(table: Table, name: str, what: str) -> dict[str, str]:
    """Take a table of strings or whole numbers, as strings; an empty one where there is none."""
    inner = table.table_or_empty(name, what)
    found = {}
    for key in inner.names():
        value = inner.take(key, what)
        if isinstance(value, bool) or not isinstance(value, str | int):
            raise inner.refuse(key, what, value)
        found[key] = str(value)
    return found
