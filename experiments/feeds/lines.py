"""Bytes as they come become lines; one without end costs no memory."""

from __future__ import annotations

from collections.abc import Iterator

MOST = 1 << 20  # bytes of a line


class Lines:
    """Cuts what comes into lines, wherever it was split on its way."""

    def __init__(self, most: int = MOST) -> None:
        """Prepare for lines of at most so many bytes."""
        self._most, self._kept, self._is_too_long = most, bytearray(), False

    def of(self, data: bytes) -> Iterator[bytes | None]:
        """Yield each line that ends in what has come, with its end; None for one that is too long."""
        *whole, rest = data.split(b"\n")
        for part in whole:
            self._keep(part)
            yield self._taken(b"\n")
        self._keep(rest)

    def end(self) -> Iterator[bytes | None]:
        """Yield what has come since the last line, as nothing more comes."""
        if self._kept or self._is_too_long:
            yield self._taken(b"")

    def _keep(self, part: bytes) -> None:
        if self._is_too_long or len(self._kept) + len(part) > self._most:
            self._kept, self._is_too_long = bytearray(), True
            return
        self._kept += part

    def _taken(self, end: bytes) -> bytes | None:
        line = None if self._is_too_long else bytes(self._kept) + end
        self._kept, self._is_too_long = bytearray(), False
        return line
