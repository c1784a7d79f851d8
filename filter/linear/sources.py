"""What produced a constraint: the table that the rows' source numbers point into."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal, get_args

import numpy as np

from filter.arrays import Array, Floats, Integers, Table

Kind = Literal[
    "initial set", "compass", "bearing", "range", "position", "sighting", "odometry", "heading", "region", "cells",
    "pair", "speed limit", "turn limit", "arena",
]  # fmt: skip
KINDS: tuple[Kind, ...] = get_args(Kind)
NOBODY = -1  # the target of what has none


@dataclass(frozen=True)
class Source:
    """What produced a constraint.

    Attributes:
        kind: A measurement ("compass", "bearing", "range", "position", or "sighting" for a bearing with its range), a motion
            ("odometry", or the "speed limit" or "turn limit" of a robot without), the "arena" that no robot leaves, or what was
            known before: an "initial set", a "heading", a "region", an earlier outer polygon, or rows on a "pair"; or "cells",
            all readings of one time that concern a robot, with what was known of its pose.
        time: When [s].
        robot: Who measured, or of whom it is said.
        target: What was measured, the other robot of a pair, or None.
    """

    kind: Kind
    time: float
    robot: int
    target: int | None = None

    def __str__(self) -> str:
        who = f"robot {self.robot}" + (f" to {self.target}" if self.target is not None else "")
        return f"{self.kind} of {who} at {self.time:.3f} s"


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
    """

    kind: Integers = field(default_factory=_none)
    time: Array = field(default_factory=lambda: np.zeros(0))
    robot: Integers = field(default_factory=_none)
    target: Integers = field(default_factory=_none)

    def __getitem__(self, number: int) -> Source:
        kind, time, robot, target = (column[number].item() for column in self.columns)
        return Source(KINDS[kind], time, robot, None if target == NOBODY else target)

    def extended(self, kind: Kind, time: Floats, robot: Floats, target: Floats = NOBODY) -> tuple[Sources, Integers]:
        """Return the table with (k) more entries, and their numbers."""
        robots, targets = (np.atleast_1d(np.asarray(each, dtype=np.int64)) for each in (robot, target))
        count = len(robots) if len(targets) == 1 else len(targets)
        if not count:
            return self, _none()
        more = (np.full(count, each) for each in (robots, targets))
        table = Sources(np.full(count, KINDS.index(kind)), np.full(count, time, dtype=float), *more)
        return Sources.concatenate([self, table]), np.arange(len(self), len(self) + count)
