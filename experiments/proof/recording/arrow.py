"""Arrow streams of one batch, as lists of Python's: what recordings hold. Standard library only.

Formats: arrow.apache.org (Columnar Format, IPC), flatbuffers.dev.
"""

import struct
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

from experiments.proof.reading import Broken

INT, FLOAT, BINARY, UTF8, BOOL, LIST, STRUCT, FIXED_BINARY, FIXED_LIST, DURATION = 2, 3, 4, 5, 6, 12, 13, 15, 16, 18
FLOATS, INTS = {0: "e", 1: "f", 2: "d"}, {8: "b", 16: "h", 32: "i", 64: "q"}


class Table:
    """A table of a flatbuffer; fields are asked for by number."""

    def __init__(self, data: bytes, at: int) -> None:
        self._data, self._at = data, at
        self._fields = at - self._number("i", at)

    def _number(self, form: str, at: int) -> int:
        return struct.unpack_from("<" + form, self._data, at)[0]

    def _place(self, field: int) -> int:
        """Return where a field is, or 0."""
        at = 4 + 2 * field
        off = self._number("H", self._fields + at) if at < self._number("H", self._fields) else 0
        return off and self._at + off

    def number(self, field: int, form: str) -> int:
        """Return a number; 0 where none is written."""
        place = self._place(field)
        return self._number(form, place) if place else 0

    def _behind(self, place: int) -> int:
        return place + self._number("I", place)

    def table(self, field: int) -> "Table":
        """Return a table."""
        return Table(self._data, self._behind(self._place(field)))

    def text(self, field: int) -> str:
        """Return a string."""
        at = self._behind(self._place(field)) if self._place(field) else 0
        return self._data[at + 4 : at + 4 + self._number("I", at)].decode() if at else ""

    def tables(self, field: int) -> "list[Table]":
        """Return a list of tables."""
        if not (place := self._place(field)):
            return []
        at = self._behind(place)
        return [Table(self._data, self._behind(at + 4 + 4 * k)) for k in range(self._number("I", at))]

    def pairs(self, field: int) -> list[tuple[int, int]]:
        """Return a list of structs of two whole numbers."""
        at = self._behind(self._place(field))
        return [struct.unpack_from("<qq", self._data, at + 4 + 16 * k) for k in range(self._number("I", at))]


class Stream:
    """A schema, and the batch of rows that follows it.

    Attributes:
        notes: What is noted of all.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        schema, self._next = self._message(0)
        self._fields = schema.tables(1)
        self.notes = {note.text(0): note.text(1) for note in schema.tables(2)}

    def _message(self, at: int) -> tuple[Table, int]:
        """Return the header of a message, and where its body is."""
        mark, size = struct.unpack_from("<Ii", self._data, at)
        if mark != 0xFFFFFFFF or len(self._data) < at + 8 + size:
            raise Broken("no Arrow stream")
        head = self._data[at + 8 : at + 8 + size]
        return Table(head, struct.unpack_from("<I", head)[0]).table(2), at + 8 + size

    def columns(self) -> dict[str, list[Any]]:
        """Return the columns of the batch."""
        batch, body = self._message(self._next)
        nodes, buffers = iter(batch.pairs(1)), iter(batch.pairs(2))
        left = Left(nodes, (self._data[body + begin : body + begin + size] for begin, size in buffers))
        return {field.text(0): _column(field, left) for field in self._fields}


@dataclass(frozen=True)
class Left:
    """What is left of a batch, column after column, each before its children.

    Attributes:
        nodes: How many values each has, and how many of them say nothing.
        parts: The bytes of each.
    """

    nodes: Iterator[tuple[int, int]]
    parts: Iterator[bytes]


def _column(field: Table, left: Left) -> list[Any]:
    """Return a column; a row that says nothing is None. Texts are bytes."""
    (count, _), valid = next(left.nodes), next(left.parts)
    values = _values(field, count, left)
    if len(values) != count:
        raise Broken(f"a column of {len(values)} values, where {count} are said to be")
    return [value if not valid or valid[k // 8] >> k % 8 & 1 else None for k, value in enumerate(values)]


def _values(field: Table, count: int, left: Left) -> list[Any]:
    kind, form, children = field.number(2, "B"), field.table(3), field.tables(5)
    if kind in (INT, FLOAT, DURATION):
        letter = FLOATS[form.number(0, "h")] if kind == FLOAT else INTS[form.number(0, "i")] if kind == INT else "q"
        return list(struct.unpack_from(f"<{count}{letter}", next(left.parts)))
    if kind == FIXED_BINARY:
        return [None] * (len(next(left.parts)) // max(form.number(0, "i"), 1))  # names of rows, of which nobody asks
    if kind == BOOL:
        bits = next(left.parts)
        return [bool(bits[k // 8] >> k % 8 & 1) for k in range(count)]
    if kind == STRUCT:
        return list(zip(*(_column(child, left) for child in children), strict=True))
    if kind == FIXED_LIST:
        size, inner = form.number(0, "i"), _column(children[0], left)
        return [inner[k : k + size] for k in range(0, len(inner), size)]
    if kind in (LIST, BINARY, UTF8):
        ends = struct.unpack_from(f"<{count + 1}i", next(left.parts)) if count else (0,)
        each: Any = _column(children[0], left) if kind == LIST else next(left.parts)
        if list(ends) != sorted(ends) or not 0 <= ends[0] <= ends[-1] <= len(each):
            raise Broken("lists that overlap, or are not there")
        return [each[ends[k] : ends[k + 1]] for k in range(count)]
    raise Broken(f"an Arrow type {kind} that is not known here")
