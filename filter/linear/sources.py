"""What produced a constraint: the table that the rows' source numbers point into."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from filter.arrays import Array, Floats, Integers, Table
from filter.records.record import AT_THE_CENTRE
from filter.team import Team

Kind = Literal[
    "initial set", "compass", "bearing", "range", "position", "relative heading", "odometry", "heading", "region", "cells",
    "pair", "speed limit", "turn limit", "arena",
]  # fmt: skip
KINDS: tuple[Kind, ...] = get_args(Kind)
NOBODY = -1  # the target of what has none


@dataclass(frozen=True)
class Source:
    """What produced a constraint.

    Attributes:
        kind: A measurement ("compass", "bearing", "range", "position", "relative heading"), a motion ("odometry", or the "speed
            limit" or "turn limit" of a robot without), the "arena" that no robot leaves, or what was known before: an "initial
            set", a "heading", a "region", an earlier outer polygon, or rows on a "pair"; or "cells", all readings of one time
            that concern a robot, with what was known of its pose.
        time: When [s].
        robot: Who measured, or of whom it is said.
        target: What was measured, the other robot of a pair, or None.
        sensor: Which of the team's sensors measured; None for one at the robot's centre, and for what is no measurement.
    """

    kind: Kind
    time: float
    robot: int
    target: int | None = None
    sensor: int | None = None

    def __str__(self) -> str:
        return self._in_words(f"robot {self.robot}", self.target, None if self.sensor is None else f"sensor {self.sensor}")

    def named(self, team: Team) -> str:
        """Return it in words, with the names that a team has: "range of alice to gate by uwb at 0.100 s"."""
        target = None if self.target is None else team.name(self.target)
        return self._in_words(team.name(self.robot), target, None if self.sensor is None else team.sensors[self.sensor].name)

    def _in_words(self, robot: str, target: int | str | None, sensor: str | None) -> str:
        to, by = "" if target is None else f" to {target}", "" if sensor is None else f" by {sensor}"
        return f"{self.kind} of {robot}{to}{by} at {self.time:.3f} s"


def in_order(source: Source) -> tuple[float, str, int, int, int]:
    """Return by what sources are sorted where people read them."""
    return source.time, source.kind, source.robot, source.target or 0, AT_THE_CENTRE if source.sensor is None else source.sensor


def _none() -> Integers:
    return np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Sources(Table):
    """Sources as a table.

    Attributes:
        kind: (k,) index into KINDS.
        time: (k,) [s].
        robot: (k,) who.
        target: (k,) what, NOBODY for nothing.
        sensor: (k,) by which sensor, `AT_THE_CENTRE` for none.
    """

    kind: Integers = field(default_factory=_none)
    time: Array = field(default_factory=lambda: np.zeros(0))
    robot: Integers = field(default_factory=_none)
    target: Integers = field(default_factory=_none)
    sensor: Integers = field(default_factory=_none)

    def __getitem__(self, number: int) -> Source:
        kind, time, robot, target, sensor = (column[number].item() for column in self.columns)
        by = None if sensor == AT_THE_CENTRE else sensor
        return Source(KINDS[kind], time, robot, None if target == NOBODY else target, by)

    def extended(
        self, kind: Kind, time: Floats, robot: Floats, target: Floats = NOBODY, sensor: Floats = AT_THE_CENTRE
    ) -> tuple[Sources, Integers]:
        """Return the table with (k) more entries of one kind, and their numbers; what is one number is so of all of them."""
        who = [np.asarray(column, dtype=np.int64) for column in (robot, target, sensor)]
        before, more = len(self), next((column.size for column in who if column.size != 1), 1)
        columns = [np.empty(before + more, dtype=column.dtype) for column in self.columns]
        for column, known, new in zip(columns, self.columns, (KINDS.index(kind), time, *who), strict=True):
            column[:before], column[before:] = known, new
        return Sources(*columns), np.arange(before, before + more)
