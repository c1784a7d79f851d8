"""Strict reading of JSON objects, a field at a time: nothing missing, nothing unknown, nothing that is not a finite number."""

from __future__ import annotations

import json
from reprlib import repr as shortened
from typing import Any, NoReturn

import numpy as np

from experiments.logs.checks import finite
from experiments.logs.reading.bodies import Bodies
from filter import Array, Integers, InvalidInput


def _no_number(text: str) -> NoReturn:
    raise InvalidInput("finite numbers (leave out what was not measured)", text)


def _object(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    fields = dict(pairs)
    if len(fields) < len(pairs):
        names = [name for name, _ in pairs]
        raise InvalidInput("each field once", f'"{next(name for name in names if names.count(name) > 1)}" twice')
    return fields


class Fields:
    """The fields of one record, taken out one by one; every method raises `InvalidInput` for what is not as it should be."""

    def __init__(self, kind: str, fields: dict[str, Any]) -> None:
        self.kind = kind
        self._fields = fields

    @classmethod
    def parse(cls, line: bytes) -> Fields:
        """Return the fields of a line of a log."""
        try:
            value = json.loads(line.decode(), parse_constant=_no_number, object_pairs_hook=_object)
        except InvalidInput:
            raise
        except (ValueError, RecursionError):
            came = shortened(line.decode(errors="replace").strip())
            if not line.endswith(b"\n"):  # a whole object ends with its brace, line end or not
                raise InvalidInput("a whole line", f"a truncated one: {came}") from None
            raise InvalidInput("a JSON object", came) from None
        if not isinstance(value, dict):
            raise InvalidInput("a JSON object", shortened(value))
        kind = value.pop("record", None)
        if not isinstance(kind, str):
            raise InvalidInput('a field "record" that names the kind', shortened(kind))
        return cls(kind, value)

    def expect(self, kind: str) -> None:
        """Refuse any other kind of record."""
        if self.kind != kind:
            raise InvalidInput(f'a record "{kind}"', f'"{self.kind}"')

    def end(self) -> None:
        """Refuse fields that nobody took."""
        if self._fields:
            raise InvalidInput(f"{self.kind}: no further field", f'"{min(self._fields)}"')

    def has(self, name: str) -> bool:
        """Return whether there is such a field."""
        return name in self._fields

    def is_a(self, kind: type, name: str) -> bool:
        """Return whether there is such a field, and of that type."""
        return isinstance(self._fields.get(name), kind)

    def lengths(self, besides: str = "") -> dict[str, int]:
        """Return how long the fields are that are lists."""
        return {name: len(value) for name, value in self._fields.items() if isinstance(value, list) and name != besides}

    def text(self, name: str) -> str:
        """Take a string."""
        value = self._take(name)
        if not isinstance(value, str):
            raise InvalidInput(f"{name}: a string", shortened(value))
        return value

    def number(self, name: str) -> float:
        """Take a number."""
        return self._numbers(name, self._take(name), 0).item()

    def numbers(self, name: str) -> Array:
        """Take a (k,) list of numbers, or one number."""
        value = self._take(name)
        return self._numbers(name, value, int(isinstance(value, list)))

    def number_or_none(self, name: str) -> float | None:
        """Take a number or null."""
        value = self._take(name)
        return None if value is None else self._numbers(name, value, 0).item()

    def number_or(self, name: str, missing: float) -> float:
        """Take a number, or null, for which another one stands."""
        number = self.number_or_none(name)
        return missing if number is None else number

    def numbers_or(self, name: str, missing: float) -> Array:
        """Take a (k,) list of numbers; another one stands for null."""
        value = self._take(name)
        if not isinstance(value, list):
            raise InvalidInput(f"{name}: a list of numbers", shortened(value))
        return np.array([self._coordinate(name, number, missing) for number in value], dtype=float)

    def bounds(self, name: str) -> list[float | tuple[float, float]]:
        """Take a list of numbers and of pairs of numbers, or one of them."""
        value = self._take(name)
        return [self._bound(name, bound) for bound in (value if isinstance(value, list) else [value])]

    def pair(self, name: str, expected: str = "[x, y]") -> tuple[float, float]:
        """Take two numbers."""
        return self._pair(name, self._take(name), expected)

    def points_or_none(self, name: str) -> Array | None:
        """Take a (k, 2) list of points, or null."""
        if self._fields.get(name, ()) is None:
            return self._take(name)
        return self.points(name)

    def places(self, name: str) -> Array:
        """Take a (k, 2) list of points; NaN for null."""
        value = self._take(name)
        if not isinstance(value, list):
            raise InvalidInput(f"{name}: a list of [x, y] points or null", shortened(value))
        return np.array([self._place(name, point) for point in value], dtype=float).reshape(-1, 2)

    def place(self, name: str) -> Array:
        """Take a (1, 2) point; NaN for null."""
        return np.array([self._place(name, self._take(name))])

    def points_by_name(self, name: str) -> dict[str, tuple[float, float]]:
        """Take an object of points."""
        return {key: self._pair(f"{name}: {key}", point, "[x, y]") for key, point in self._object(name).items()}

    def numbers_by_name(self, name: str, missing: float | None = None) -> float | dict[str, float]:
        """Take an object of numbers, or one number; another one stands for null, if it may be there."""
        if not self.is_a(dict, name):
            return self._coordinate(name, self._take(name), missing)
        return {key: self._coordinate(f"{name}: {key}", number, missing) for key, number in self._object(name).items()}

    def points(self, name: str, unknown: float | None = None) -> Array:
        """Take a (k, 2) list of points; with `unknown`, null stands for that coordinate."""
        value = self._take(name)
        if value == []:
            return np.zeros((0, 2))
        if not isinstance(value, list) or not all(isinstance(point, list) and len(point) == 2 for point in value):
            raise InvalidInput(f"{name}: [x, y] points", shortened(value))
        return np.array([[self._coordinate(name, number, unknown) for number in point] for point in value])

    def whole(self, name: str) -> int:
        """Take a whole number."""
        value = self._take(name)
        if type(value) is not int:
            raise InvalidInput(f"{name}: a whole number", shortened(value))
        return value

    def names(self, name: str) -> list[str]:
        """Take a list of strings."""
        value = self._take(name)
        wrong = [each for each in value if not isinstance(each, str)]
        if wrong:
            raise InvalidInput(f"{name}: names", shortened(wrong[0]))
        return value

    def bodies(self, name: str, known: Bodies) -> list[int | None]:
        """Take a list of bodies, or one; null where the list says nothing."""
        value = self._take(name)
        return [None if body is None else known.number(name, body) for body in (value if isinstance(value, list) else [value])]

    def body_or(self, name: str, known: Bodies, missing: int) -> int:
        """Take one body; another number stands for null."""
        value = self._take(name)
        return missing if value is None else known.number(name, value)

    def robots(self, known: Bodies, name: str = "robot") -> Integers:
        """Take a column of robots."""
        robots = self.bodies(name, known)
        if None in robots:
            raise InvalidInput(f"{name}: {known.expected}", "null")
        return np.array(robots, dtype=np.int64)

    def robot(self, known: Bodies) -> int:
        """Take one robot."""
        return known.number("robot", self._take("robot"))

    def object(self, name: str) -> Fields | None:
        """Take an object, or null."""
        if self._fields.get(name, ()) is None:
            return self._take(name)
        return Fields(name, self._object(name))

    def objects_by_name(self, name: str) -> dict[str, Fields]:
        """Take an object of objects."""
        inside = Fields(name, self._object(name))
        return {key: Fields(f"{name}: {key}", inside._object(key)) for key in list(inside._fields)}

    def _object(self, name: str) -> dict[str, Any]:
        value = self._take(name)
        if not isinstance(value, dict):
            raise InvalidInput(f"{name}: an object or null", shortened(value))
        return value

    def _take(self, name: str) -> Any:
        if name not in self._fields:
            raise InvalidInput(f'a field "{name}"', f"fields {sorted(self._fields)}")
        return self._fields.pop(name)

    def _coordinate(self, name: str, value: Any, unknown: float | None) -> float:
        return unknown if value is None and unknown is not None else self._numbers(name, value, 0).item()

    def _pair(self, name: str, value: Any, expected: str) -> tuple[float, float]:
        if not isinstance(value, list) or len(value) != 2:
            raise InvalidInput(f"{name}: {expected}", shortened(value))
        first, second = self._numbers(name, value, 1).tolist()
        return first, second

    def _place(self, name: str, point: Any) -> tuple[float, float]:
        return (np.nan, np.nan) if point is None else self._pair(name, point, "[x, y] or null")

    def _bound(self, name: str, value: Any) -> float | tuple[float, float]:
        if isinstance(value, list):
            return self._pair(name, value, "numbers or pairs [low, high]")
        return self._numbers(name, [value], 1).item()

    def _numbers(self, name: str, value: Any, depth: int) -> Array:
        numbers = value if depth else [value]
        for number in numbers:
            if type(number) not in (int, float):  # a bool is an int elsewhere, not here
                raise InvalidInput(f"{name}: {'numbers' if depth else 'a number'}", shortened(number))
        try:
            return finite(name, np.array(value, dtype=float))
        except OverflowError:
            raise InvalidInput(f"{name}: finite numbers", "a whole number that is too large") from None
