"""Text files as people have them: compressed or not, with a byte order mark or without, from a disk or through a pipe."""

from __future__ import annotations

import errno
import gzip
import zlib
from codecs import BOM_UTF8, BOM_UTF16_BE, BOM_UTF16_LE
from collections.abc import Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path
from typing import IO, cast

COMPRESSED = b"\x1f\x8b"  # what gzip begins with, whatever the file is called
BLOCK = 1 << 16  # so many bytes are copied at a time


class TextFile:
    """A text file that can be read again and again.

    What cannot be opened twice, such as a pipe, is read to its end at once and kept.

    Raises:
        OSError: It cannot be read.
    """

    def __init__(self, path: Path) -> None:
        self._path = path
        self._kept = None if path.is_file() else path.read_bytes()

    def blocks(self) -> Iterator[bytes]:
        """Yield all its bytes as they are, those of compressed ones unpacked, some at a time.

        Raises:
            OSError: It cannot be read, or is compressed but not whole.
        """
        with self._plain() as file:
            while block := file.read(BLOCK):
                yield block

    def lines(self) -> Iterator[bytes]:
        """Yield each line with its end, from the first one on, without a byte order mark.

        Raises:
            OSError: It cannot be read, is compressed but not whole, or is no UTF-8.
        """
        with self._plain() as file:
            yield from _unmarked(file)

    @contextmanager
    def _plain(self) -> Iterator[IO[bytes]]:
        """Open it, unpacked; errors of what is compressed become `OSError`."""
        with self._path.open("rb") if self._kept is None else BytesIO(self._kept) as raw:
            compressed = raw.read(len(COMPRESSED)) == COMPRESSED
            raw.seek(0)
            try:
                yield cast(IO[bytes], gzip.GzipFile(fileobj=raw)) if compressed else raw
            except (EOFError, zlib.error, gzip.BadGzipFile) as error:
                raise OSError(errno.EIO, f"compressed by gzip, but cut off or damaged: {error}") from None


def _unmarked(file: Iterator[bytes]) -> Iterator[bytes]:
    first = next(file, b"")
    if first.startswith((BOM_UTF16_BE, BOM_UTF16_LE)):
        raise OSError(errno.EILSEQ, "UTF-16, where UTF-8 is read: save it as UTF-8")
    if first:
        yield first.removeprefix(BOM_UTF8)
    yield from file
