"""Recordings of Rerun, as far as a proof asks for them: rows of some columns, by entity and time. Standard library only.

A file is a head and messages; each chunk of rows is one, as an Arrow stream (a schema and a batch) in an LZ4 block (lz4.org,
Block Format), in an envelope of protocol buffers.
"""

import struct
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from experiments.proof.reading import Broken
from experiments.proof.recording.arrow import Stream

MAGIC, HEAD = b"RRF2", 12
END, CHUNK = 0, 2  # kinds of messages
LZ4, ARROW = 2, 1  # a compression and an encoding
ENTITY, STEP, TIME = "rerun:entity_path", "step", "t"
ALWAYS = -1  # the step of what is shown at all times
NUMBER, BYTES, FIXED = 0, 2, {1: 8, 5: 4}  # kinds of fields, and sizes
PEEK = 4096  # bytes of a chunk that its schema, and so its entity, is likely in


@dataclass(frozen=True)
class Recorded:
    """One row of a recording.

    Attributes:
        step: Its number, or ALWAYS.
        time: [s].
        values: By the names of columns.
    """

    step: int
    time: float
    values: dict[str, Any]


def recorded(path: Path, wanted: Callable[[str], bool]) -> dict[str, list[Recorded]]:
    """Return the names of all entities, and the rows, in the order of their steps, of those that are wanted.

    Raises:
        Broken: It is no such recording, or of another version.
        OSError: There is no such file.
    """
    found: dict[str, list[Recorded]] = {}
    for packed, size in chunks(path.read_bytes()):
        rows = found.setdefault(entity := Stream(unpacked(packed, PEEK)).notes[ENTITY], [])
        if wanted(entity):
            columns = Stream(unpacked(packed, size)).columns()
            for k in range(max(map(len, columns.values()), default=0)):
                values = {name: column[k] for name, column in columns.items()}
                rows.append(Recorded(values.get(STEP, ALWAYS), values.get(TIME, 0) / 1e9, values))
    return {name: sorted(rows, key=lambda row: row.step) for name, rows in found.items()}


def chunks(data: bytes) -> Iterator[tuple[bytes, int]]:
    """Yield the payload of each chunk, compressed, and its size before that."""
    if data[:4] != MAGIC:
        raise Broken("no recording of Rerun")
    at = HEAD
    while True:
        kind, length = struct.unpack_from("<QQ", data, at)
        body, at = data[at + 16 : at + 16 + length], at + 16 + length
        if at > len(data):
            raise Broken("the file is cut off")
        if kind == END:
            return
        if kind == CHUNK:
            fields = dict(_fields(body))
            if (fields[2], fields[4]) != (LZ4, ARROW):
                raise Broken("a recording of another version")
            yield fields[5], fields[3]


def _fields(body: bytes) -> Iterator[tuple[int, Any]]:
    """Yield numbers and values of the fields of a protocol buffer."""
    at = 0
    while at < len(body):
        tag, at = _varint(body, at)
        value, at = _varint(body, at) if tag & 7 in (NUMBER, BYTES) else (FIXED[tag & 7], at)
        if tag & 7 == NUMBER:
            yield tag >> 3, value
        else:
            yield tag >> 3, body[at : at + value]
            at += value


def _varint(body: bytes, at: int) -> tuple[int, int]:
    value = shift = 0
    while True:
        value |= (body[at] & 127) << shift
        shift, at = shift + 7, at + 1
        if body[at - 1] < 128:
            return value, at


def unpacked(packed: bytes, size: int) -> bytes:
    """Return the first bytes, at least so many if there are, of an LZ4 block."""
    out, at = bytearray(), 0
    while at < len(packed) and len(out) < size:
        token, at = packed[at], at + 1
        literals, at = _length(packed, at, token >> 4)
        out += packed[at : at + literals]
        at += literals
        if at >= len(packed):
            break
        back = packed[at] | packed[at + 1] << 8
        match, at = _length(packed, at + 2, token & 15)
        pattern, match = out[len(out) - back :][: match + 4], match + 4
        if not 0 < back <= len(out):
            raise Broken("a block that is no LZ4")
        out += (pattern * (match // len(pattern) + 1))[:match]  # it may reach into what it makes itself
    return bytes(out)


def _length(packed: bytes, at: int, short: int) -> tuple[int, int]:
    more = 255 if short == 15 else 0
    while more == 255:
        more, at = packed[at], at + 1
        short += more
    return short, at
