"""What is tolerated: at most so many of a class of suspects break a bound within any window of time."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Any, Literal, get_args

import numpy as np

from filter.arrays import Frozen, checked, positive, several, shown, whole_number
from filter.diagnosis.told import Records, Who, said, said_by, without
from filter.errors import InvalidInput
from filter.linear.sources import NOBODY
from filter.poses.votes import OF_A_WINDOW
from filter.records.measurements import Measurement, Range
from filter.records.record import field_names
from filter.sets.suspect import Suspect, SuspectKind

SuspectClass = Literal["pairs", "bodies", "cameras", "compasses", "identities"]
Lies = Literal["any", "long"]
# Of each class: its kind of suspects, and what one of them is.
CLASSES: dict[str, tuple[SuspectKind, str]] = {
    "pairs": ("sighting", "what a robot takes for a target"),
    "bodies": ("body", "place or marker of a target"),
    "cameras": ("sensor", "sensor of a robot"),
    "compasses": ("compass", "compass of a robot"),
    "identities": ("sighting", "what it measures of one body, or one mate of it"),
}
BY_VOTES: SuspectClass = "identities"
# What one of them does, and what several do.
LIES = {
    "any": ("is wrong", "are wrong"),
    "long": ("measures ranges that are too long", "measure ranges that are too long"),
}


def _classes(value: object) -> tuple[SuspectClass, ...]:
    """Return the classes that are named, each once, in one order."""
    names = (value,) if isinstance(value, str) else several(f"suspects among {', '.join(CLASSES)}", value, str)
    wrong = next((name for name in names if name not in CLASSES), None)
    if wrong is not None or not names:
        raise InvalidInput(f"suspects among {', '.join(CLASSES)}", shown(wrong if names else value))
    return tuple(each for each in get_args(SuspectClass) if each in names)


def _lies(value: object) -> Lies:
    known: tuple[Lies, ...] = get_args(Lies)
    if not isinstance(value, str) or value not in known:
        raise InvalidInput(f"lies among {', '.join(known)}", shown(value))
    return known[known.index(value)]


@dataclass(frozen=True)
class Tolerance(Frozen):
    """At most q of some suspects break a bound within any window of time: then the truth is inside all the same.

    What each class survives: "pairs" a robot that takes one body for another; "bodies" that, and a body that is not where it
    should be, whoever sees it; "cameras" a biased sensor, and that of no other robot; "compasses" a compass. Two markers that
    are exchanged are two bodies. Two that one robot takes for each other are two pairs, as is a path between mates that both
    measure.

    "identities" is for each robot by itself: of all that it measures of bodies, and mates of it, that of one is wrong, and for
    a tenth of the window, as barcodes are misread for some pictures in a row. So in all there may be as many as there are
    robots, and it takes a fraction of the time. But what is measured is then said of each robot's pose alone, not of pairs:
    with ranges alone that is much less. Relative headings are not used.

    Attributes:
        q: How many at most, from 1 on. It takes a belief for each choice of so many of those that are heard within a window. Of
            "identities" it is 1 for each robot; they go with no other class, and lie in any way.
        window: How long it is [s]; what can be the case is begun anew so often.
        suspects: A class, or several, of which at most q in all lie.
        lies: "any", or "long": only ranges are ever wrong, and these only too long, as those of radio without a line of sight.
    """

    q: int = field(default=1, metadata=checked(whole_number, "q, suspects that lie", 1))
    window: float = field(default=5.0, metadata=checked(positive, "window [s]"))
    suspects: tuple[SuspectClass, ...] | SuspectClass = field(default="pairs", metadata={"check": _classes})
    lies: Lies = field(default="any", metadata={"check": _lies})

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.lies == "long" and self.suspects == ("compasses",):
            raise InvalidInput("suspects that measure ranges, where these are too long", "compasses")
        if BY_VOTES in self.suspects and (self.q, len(self.suspects), self.lies) != (1, 1, "any"):
            raise InvalidInput(f"{BY_VOTES} alone, with q = 1 and any lies", f"{self.q}, {self.suspects}, {self.lies}")

    @property
    def is_by_votes(self) -> bool:
        """Whether each robot has suspects of its own, who vote on its pose; else there is a case of the team for each."""
        return self.suspects == (BY_VOTES,)

    def __str__(self) -> str:
        if self.is_by_votes:
            told = f"{CLASSES[BY_VOTES][1]}, within {OF_A_WINDOW * self.window:g} s"
            return f"if for each robot at most one of these is wrong within any {self.window:g} s: {told}"
        one = " or ".join(CLASSES[each][1] for each in self.suspects)
        return f"if at most {self.q} of these {LIES[self.lies][self.q > 1]} within any {self.window:g} s: {one}"

    def heard(self, instants: Iterable[Records], since: float) -> tuple[Suspect, ...]:
        """Return who speaks in the records of some instants and may lie, since a time [s], in an order of their own."""
        spoken, kinds = set[Who](), [CLASSES[each][0] for each in self.suspects]
        for records in instants:
            spoken |= said(records if self.lies == "any" else tuple(each for each in records if isinstance(each, Range)))
        known = sorted(who for who in spoken if who[0] in kinds and _is_there(who[0], who[2]))
        return tuple(Suspect.of(who, since) for who in known)

    def believed(self, lying: Iterable[Suspect], records: Records) -> Records:
        """Return what still holds of records if some suspects lie."""
        for suspect in lying:
            records = without(suspect, records) if self.lies == "any" else tuple(_not_short(suspect, each) for each in records)
        return records


def _is_there(kind: str, target: int) -> bool:
    """Return whether there is such a suspect: a position is of nobody."""
    return kind in ("sensor", "compass") or target != NOBODY


def _not_short(suspect: Suspect, record: Any) -> Measurement:
    """Return a record in which what a suspect measured of ranges says no more than that targets are no farther."""
    lies = said_by(suspect, record) if isinstance(record, Range) else np.zeros(len(record.robot), dtype=bool)
    if not lies.any():
        return record
    half = record.interval()[1] / 2
    columns = {name: getattr(record, name) for name in field_names(record)}
    columns["range"] = np.where(lies, half, record.range)
    columns["bound"] = np.where(lies, np.nextafter(half, np.inf), record.bound)
    columns["relative_bound"] = np.where(lies, 0.0, record.relative_bound)
    return Range.of_checked(record.time, columns)
