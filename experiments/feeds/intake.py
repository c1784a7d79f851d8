"""Between what is heard and what is answered: a few lines that wait, each with the time of its arrival.

There is room for so many lines, those that are being answered among them. Who sends more has to wait: the source is not read
on. So memory does not grow, and no line that is let in waits for long.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from queue import Empty, SimpleQueue
from threading import Semaphore, Thread
from time import perf_counter
from typing import Protocol

from experiments.feeds.lines import Lines

ROOM = 8  # lines that wait or are being answered
LINGER = 0.0003  # how long a batch waits for the rest of what comes at once [s]


@dataclass(frozen=True)
class Line:
    """A line that has come.

    Attributes:
        number: From 1 on, of all lines of a run.
        text: With its end; None if it was too long.
        arrived: When it was let in, by the clock of the process [s].
    """

    number: int
    text: bytes | None
    arrived: float


@dataclass
class Batch:
    """What has come, together.

    Attributes:
        lines: In their order.
        words: What there is to say of the source.
        ended: Whether nothing more comes.
    """

    lines: list[Line] = field(default_factory=list)
    words: list[str] = field(default_factory=list)
    ended: bool = False


class Source(Protocol):
    """Where lines come from."""

    name: str

    def run(self, intake: Intake) -> None:
        """Hand over what comes, until nothing more does."""


class Intake:
    """Takes lines from a source, on a thread of its own, and hands them over in batches."""

    def __init__(self, room: int = ROOM, clock: Callable[[], float] = perf_counter) -> None:
        self._items: SimpleQueue[Line | str | None] = SimpleQueue()
        self._room, self._most, self._clock = Semaphore(room), room, clock
        self._lines, self._number = Lines(), 0

    def start(self, source: Source) -> None:
        """Begin to listen to a source."""
        Thread(target=self._run, args=(source,), daemon=True).start()

    def _run(self, source: Source) -> None:
        try:
            source.run(self)
        except OSError as error:
            self.say(f"{source.name}: {error.strerror or error}")
        finally:
            self._items.put(None)

    def heard(self, data: bytes) -> None:
        """Take bytes in; wait while there is no room."""
        for text in self._lines.of(data):
            self._let_in(text)

    def over(self) -> None:
        """Take in that nothing more comes of this connection: what is left of a line is one."""
        for text in self._lines.end():
            self._let_in(text)

    def say(self, words: str) -> None:
        """Have something said of the source."""
        self._items.put(words)

    def _let_in(self, text: bytes | None) -> None:
        self._room.acquire()
        self._number += 1
        self._items.put(Line(self._number, text, self._clock()))

    def batch(self, pause: float) -> Batch:
        """Return what waits, or else what comes next; an empty batch if nothing has come for so long [s]."""
        found, patience = Batch(), pause
        while not found.ended and len(found.lines) < self._most:
            try:
                item = self._items.get(timeout=patience)
            except Empty:
                break
            patience = LINGER
            if isinstance(item, Line):
                found.lines.append(item)
            elif item is None:
                found.ended = True
            else:
                found.words.append(item)
        return found

    def answered(self, lines: int) -> None:
        """Make room again for so many lines: as many are done with."""
        if lines:
            self._room.release(lines)
