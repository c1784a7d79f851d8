"""Strict reading of JSON objects, a field at a time: nothing missing, nothing unknown, nothing that is not a finite number."""

from __future__ import annotations

import json
from reprlib import repr as shortened
from typing import Any, NoReturn

import numpy as np

from filter import Array, Integers, InvalidInput
from filter.arrays import finite


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

    def points_or_none(self, name: str) -> Array | None:
        """Take a (k, 2) list of points, or null."""
        if self._fields.get(name, ()) is None:
            return self._take(name)
        return self.points(name)

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

    def bodies(self, name: str, count: int) -> list[int | None]:
        """Take a list of numbers of bodies below `count`, or one number; null where the list says nothing."""
        value = self._take(name)
        bodies = value if isinstance(value, list) else [value]
        expected = f"whole numbers from 0 to {count - 1}" if count else "nothing, as there is none"
        for body in bodies:
            if body is not None and (type(body) is not int or not 0 <= body < count):
                raise InvalidInput(f"{name}: {expected}", shortened(body))
        return bodies

    def robots(self, count: int) -> Integers:
        """Take the column `robot`."""
        robots = self.bodies("robot", count)
        if None in robots:
            raise InvalidInput(f"robot: whole numbers from 0 to {count - 1}", "null")
        return np.array(robots, dtype=np.int64)

    def object(self, name: str) -> Fields | None:
        """Take an object, or null."""
        value = self._take(name)
        if value is None:
            return None
        if not isinstance(value, dict):
            raise InvalidInput(f"{name}: an object or null", shortened(value))
        return Fields(name, value)

    def _take(self, name: str) -> Any:
        if name not in self._fields:
            raise InvalidInput(f'a field "{name}"', f"fields {sorted(self._fields)}")
        return self._fields.pop(name)

    def _coordinate(self, name: str, value: Any, unknown: float | None) -> float:
        return unknown if value is None and unknown is not None else self._numbers(name, value, 0).item()

    def _numbers(self, name: str, value: Any, depth: int) -> Array:
        numbers = value if depth else [value]
        for number in numbers:
            if type(number) not in (int, float):  # a bool is an int elsewhere, not here
                raise InvalidInput(f"{name}: {'numbers' if depth else 'a number'}", shortened(number))
        try:
            return finite(name, np.array(value, dtype=float))
        except OverflowError:
            raise InvalidInput(f"{name}: finite numbers", "a whole number that is too large") from None
