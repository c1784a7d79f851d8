"""Names of robots, landmarks and sensors: what can be one, what stands where there is none, and words with them."""

import re
from abc import abstractmethod
from collections.abc import Callable, Sequence
from difflib import get_close_matches
from typing import Any

from filter.arrays import several, shown
from filter.errors import InvalidInput

NAME = re.compile(r"\w[\w.-]{0,63}")  # they are parts of files' names and of paths in recordings


def numbered(letter: str, count: int) -> tuple[str, ...]:
    """Return the names of what has none: r0, r1, ... for robots, l0, l1, ... for landmarks."""
    return tuple(f"{letter}{number}" for number in range(count))


def names_in(what: str, values: Any, count: int | None = None) -> tuple[str, ...]:
    """Return names: words of letters, digits, "_", "-" and ".", no two alike, and so many; raises `InvalidInput`."""
    names = several(f"{what}: names", values, str)
    wrong = next((name for name in names if not NAME.fullmatch(name)), None)
    if wrong is not None:
        raise InvalidInput(f'{what}: names of letters, digits, "_", "-" and ".", 64 at most', shown(wrong))
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InvalidInput(f"{what}: names of robots and landmarks, no two alike", f"{shown(twice)} twice")
    if count is not None and len(names) != count:
        raise InvalidInput(what, f"{len(names)} names")
    return names


def place_of(what: str, name: str, names: Sequence[str]) -> int:
    """Return where among names one is; raises `InvalidInput` with the nearest for one that is not."""
    if name not in names:
        near = get_close_matches(str(name), names, 1)
        raise InvalidInput(f"a name of {what}{f', as {near[0]}' if near else ''}", shown(name))
    return names.index(name)


class InWords:
    """Base of what people read: robots have numbers as text, and names in the words of a team."""

    def __str__(self) -> str:
        return self._in_words(lambda what: f"robot {what}" if isinstance(what, int) else str(what))

    def named(self, team: Any) -> str:
        """Return it in words, with the names that a team has for robots, landmarks and sensors."""
        return self._in_words(team.words)

    @abstractmethod
    def _in_words(self, words: Callable[[Any], str]) -> str:
        """Return it in words, from those for robots, by their numbers, and for sources."""
