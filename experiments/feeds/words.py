"""What is said while a run goes on: a line for each kind of thing, now and then, never a flood."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from time import monotonic

from experiments.show.terminal import tell

QUIET = 1.0  # from one line of a kind to the next [s]


class Words:
    """Says things on stderr."""

    def __init__(self, clock: Callable[[], float] = monotonic) -> None:
        self._clock, self._said, self._withheld = clock, dict[str, float](), Counter[str]()

    def say(self, kind: str, words: str) -> None:
        """Say something, or count it if something of its kind was just said."""
        now = self._clock()
        if now - self._said.get(kind, -QUIET) < QUIET:
            self._withheld[kind] += 1
            return
        more = self._withheld.pop(kind, 0)
        self._said[kind] = now
        tell(f"{kind}: {words}" + (f" (and {more} more since)" if more else ""))

    def end(self) -> None:
        """Say how much was not said."""
        for kind, more in self._withheld.items():
            tell(f"{kind}: {more} more, of which nothing was said")
        self._withheld.clear()
