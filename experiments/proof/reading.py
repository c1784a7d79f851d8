"""Files as they may come, whole or damaged, honest or hostile: what cannot be read proves nothing. Standard library only."""

import gzip
import json
import struct
import zlib
from codecs import BOM_UTF8
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from fractions import Fraction
from functools import lru_cache
from itertools import count
from pathlib import Path
from typing import Any

Record = dict[str, Any]
VERSION = 3  # of the format that is read, of certificates, headings and regions
COMPRESSED = b"\x1f\x8b"  # what gzip begins with
LONGEST = 1 << 24  # bytes of a line
SAID = 300  # characters of an error, which can hold what is in the file
# What fields that are missing or of another type, and numbers that are none or too large, end in where they are used.
MISSHAPEN: tuple[type[Exception], ...] = (ArithmeticError, AttributeError, LookupError, TypeError, ValueError)
MISSHAPEN += (MemoryError, RuntimeError, StopIteration, struct.error)


class Broken(Exception):
    """Something is not proved."""


@contextmanager
def located(place: str) -> Iterator[None]:
    """Give what is broken, and what is misshapen, its place."""
    try:
        yield
    except Broken as error:
        raise Broken(f"{place}: {str(error)[:SAID]}") from None
    except MISSHAPEN as error:
        raise Broken(f"{place}: not as it should be: {type(error).__name__}: {str(error)[:SAID]}") from None


@lru_cache(1 << 16)
def exact(text: Any) -> Fraction:
    """Return the number that a C99 hexadecimal string says, without rounding."""
    return Fraction(float.fromhex(text))


def number(value: Any, least: float | None = None) -> float:
    """Return a finite number, not below the least.

    Raises:
        Broken: It is none.
    """
    if type(value) not in (int, float) or not abs(value) <= 1.7e308:
        raise Broken(f"a finite number was expected, not {shown(value)}")
    if least is not None and value < least:
        raise Broken(f"a number from {least:g} on was expected, not {shown(value)}")
    return float(value)


def body(value: Any, most: int) -> int:
    """Return the number of one of so many robots or landmarks.

    Raises:
        Broken: It is none.
    """
    if type(value) is not int or not 0 <= value < most:
        raise Broken(f"a whole number from 0 to {most - 1} was expected, not {shown(value)}")
    return value


def shown(value: Any) -> str:
    """Return a value as text of one short line."""
    text = repr(value) if not isinstance(value, int) or abs(value) < 10**30 else "a huge whole number"
    return text if len(text) <= 80 else text[:80] + "..."


def records(
    path: Path, on_read: Callable[[int], object] = lambda _: None, *, loose: bool = False
) -> Iterator[tuple[str, Record]]:
    """Yield the JSON objects of a file's lines, each with its place in words; a file named .gz is compressed.

    Args:
        path: The file.
        on_read: Told after each line how many bytes of the file have been read.
        loose: Whether it is a file as people have them: compressed whatever it is called, with a byte order mark, blank lines,
            a last line without its end.

    Raises:
        Broken: The file is damaged, or a line is no such object: repeated names, NaN and infinities are refused, too.
        OSError: There is no such file.
    """
    with path.open("rb") as raw:
        packed = path.suffix == ".gz" or (loose and raw.read(len(COMPRESSED)) == COMPRESSED)
        raw.seek(0)
        file = gzip.GzipFile(fileobj=raw) if packed else raw
        for line in count(1):
            place = f"{path.name}, line {line}"
            try:
                text = file.readline(LONGEST)
            except (EOFError, zlib.error, gzip.BadGzipFile) as error:
                raise Broken(f"{place}: the file is damaged: {error}") from None
            if not text:
                return
            if loose:
                text = _plain(text, first=line == 1)
            if loose and text.isspace():
                continue
            with located(place):
                record = parsed(text)
            yield place, record
            on_read(raw.tell())


def _plain(text: bytes, *, first: bool) -> bytes:
    """Return a line without a byte order mark, which the first one may have, and with its end."""
    plain = text.removeprefix(BOM_UTF8) if first else text
    return plain if plain.endswith(b"\n") or len(plain) == LONGEST else plain + b"\n"


def parsed(text: bytes) -> Record:
    """Return a JSON object.

    Raises:
        Broken: It is none, or a name stands twice in it, or a number is none.
        ValueError: It is no JSON.
    """
    if len(text) == LONGEST:
        raise Broken(f"a line of {LONGEST} bytes or more")
    if not text.endswith(b"\n"):
        raise Broken("the line is cut off")
    try:
        value = json.loads(text.decode(), object_pairs_hook=_object, parse_constant=_none_such)
    except RecursionError:
        raise Broken("nested too deep") from None
    if not isinstance(value, dict):
        raise Broken(f"an object was expected, not {shown(value)}")
    return value


def _object(pairs: list[tuple[str, Any]]) -> Record:
    names = dict(pairs)
    if len(names) < len(pairs):
        raise Broken("a name stands twice in one object")
    return names


def _none_such(text: str) -> None:
    raise Broken(f"{text} is no number")


class Feed:
    """The records of a file that come in the order of time, each with its `t`, of one version."""

    def __init__(self, path: Path, on_read: Callable[[int], object] = lambda _: None) -> None:
        self._name, self._records = path.name, records(path, on_read)
        self._waiting = next(self._records, None)

    def at(self, time: float, least: int = 1) -> list[tuple[str, Record]]:
        """Return the next records, as many as are of this time [s], with their places.

        Raises:
            Broken: There are too few, or one is of another version.
        """
        found = []
        while self._waiting is not None and self._time(*self._waiting) == time:
            found.append(self._waiting)
            self._waiting = next(self._records, None)
        if len(found) >= least:
            return found
        came = "the file ends" if self._waiting is None else f"{self._waiting[0]} is of another time"
        raise Broken(f"{self._name}: there is nothing for the log's frame at t = {time} s: {came}")

    def end(self) -> None:
        """Raise `Broken` if there is more."""
        if self._waiting is not None:
            raise Broken(f"{self._waiting[0]}: it is of none of the log's frames, or out of order")

    @staticmethod
    def _time(place: str, record: Record) -> float:
        with located(place):
            if record["version"] != VERSION:
                raise Broken(f"version {shown(record['version'])}, where version {VERSION} is read")
            return float(exact(record["t"]))
