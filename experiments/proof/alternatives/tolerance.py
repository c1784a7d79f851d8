"""What a summary says is tolerated: its words are the condition under which regions are proved. Standard library only."""

from __future__ import annotations

import re
from fractions import Fraction
from typing import NamedTuple

from experiments.proof.reading import Broken, shown

# That of each robot one vote may be wrong: the verdict says how long windows really were.
VOTES = re.compile(
    r"if for each robot at most one of these is wrong within any \S+ s: "
    r"what it measures of one body, or one mate of it, within \S+ s"
)
KINDS = {
    "what a robot takes for a target": "sighting",
    "place or marker of a target": "body",
    "sensor of a robot": "sensor",
    "compass of a robot": "compass",
}
ANY, LONG = ("is wrong", "are wrong"), ("measures ranges that are too long", "measure ranges that are too long")
CASES = re.compile(
    rf"if at most (?P<most>[1-9]\d?) of these (?P<lies>{'|'.join(ANY + LONG)}) within any (?P<window>[\d.e+-]+) s: (?P<who>.+)"
)


class Tolerance(NamedTuple):
    """At most so many of some kinds of suspects lie within any window.

    Attributes:
        words: What says so.
        most: How many.
        window: How long it is at most [s].
        kinds: Of suspects (see `wrong`).
        is_long: Whether only ranges are ever wrong, and these only too long.
    """

    words: str
    most: int
    window: Fraction
    kinds: frozenset[str]
    is_long: bool

    @classmethod
    def of(cls, words: str) -> Tolerance:
        """Return it from a summary's words.

        Raises:
            Broken: They say something else, of which there is no proof.
        """
        told = CASES.fullmatch(words)
        who = told["who"].split(" or ") if told else []
        kinds = [KINDS.get(" or ".join(some)) for some in _grouped(who)]
        if told is None or not kinds or None in kinds:
            raise Broken(f"what can be tolerated, if it is to be proved, was expected, not {shown(words)}")
        return cls(words, int(told["most"]), Fraction(told["window"]), frozenset(filter(None, kinds)), told["lies"] in LONG)


def _grouped(words: list[str]) -> list[list[str]]:
    """Return what is told between two "or", but for the one that is within a name."""
    found = list[list[str]]()
    for word in words:
        if found and " or ".join([*found[-1], word]) in KINDS:
            found[-1].append(word)
        else:
            found.append([word])
    return found
