"""Late measurements, up to a fixed lag, are merged where they belong: around any filter."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Generic

import numpy as np

from filter.arrays import function, instance, number, settle
from filter.follow import AnyBelief, Filter, Step, check_filter, check_time, follow
from filter.frame import Frame
from filter.measurements import Measurement, Odometry, measurements_of

MotionBetween = Callable[[float, float], Odometry | None]  # from one time to another


@dataclass(frozen=True, eq=False)
class Lagged(Generic[AnyBelief]):
    """What is known now, and the steps of the last seconds that it came from.

    Attributes:
        steps: From the oldest that is kept to the newest; the frame of each has the measurements that have come so far.
        late: How many measurements came after newer ones and were merged all the same.
        refused: How many came too late.
    """

    steps: tuple[Step[AnyBelief], ...]
    late: int = 0
    refused: int = 0

    @property
    def belief(self) -> AnyBelief:
        """What is known now."""
        return self.steps[-1].belief


@dataclass(frozen=True, eq=False)
class FixedLag(Generic[AnyBelief]):
    """Merges measurements that are late by at most a fixed lag as if they had come in order; later ones are refused.

    The result is that of the inner filter with the same measurements in order, bit for bit, if their order within one instant
    makes no difference to it.

    Attributes:
        inner: The filter that does the work.
        motion: The robots' motion from one time to another, both not before the oldest step; None where nothing is known.
        lag: How late a measurement may be, from 0 on [s].

    Raises:
        InvalidInput: The lag is negative or not finite, the inner filter is none, or the motion is no function.
    """

    inner: Filter[AnyBelief]
    motion: MotionBetween
    lag: float = 1.0

    def __post_init__(self) -> None:
        settle(self, lag=number("lag [s]", self.lag, 0))
        check_filter(self.inner)
        function("motion", self.motion)

    def begin(self, belief: AnyBelief) -> Lagged[AnyBelief]:
        """Return a belief of the inner filter to which nothing has happened yet.

        Raises:
            InvalidInput: It is no belief: it has no time.
        """
        check_time(belief)
        return Lagged((Step(Frame(belief.time), belief, belief, 0.0),))

    def merge(self, lagged: Lagged[AnyBelief], measurements: Sequence[Measurement]) -> Lagged[AnyBelief]:
        """Return what is known after measurements of any times, in any order.

        Args:
            lagged: Stays as it is.
            measurements: Records; how late they are is counted from the newest that came before.

        Raises:
            InvalidInput: Something is no record.
            CorralError: What the inner filter raises; nothing has changed then.
        """
        instance("what is known (see begin)", lagged, Lagged)
        newest, records = lagged.belief.time, measurements_of(measurements)
        oldest = max(lagged.steps[0].belief.time, newest - self.lag)
        kept = [record for record in records if record.time >= oldest]
        refused = _count(records) - _count(kept)
        late = _count([record for record in kept if record.time < newest])
        steps = self._redone(lagged.steps, kept) if kept else lagged.steps
        return replace(lagged, steps=self._recent(steps), late=lagged.late + late, refused=lagged.refused + refused)

    def _redone(self, steps: tuple[Step[AnyBelief], ...], records: list[Measurement]) -> tuple[Step[AnyBelief], ...]:
        """Return the steps with records put in where they belong, and everything since then done again."""
        times = np.array([step.belief.time for step in steps])
        first = max(1, int(np.searchsorted(times, min(record.time for record in records), side="left")))
        at = {step.belief.time: step.frame.measurements for step in steps[first:]}
        for record in records:
            at[record.time] = (*at.get(record.time, ()), record)
        begin = steps[first - 1].belief
        frames = [Frame(time, self._moved(before, time), at[time]) for before, time in pairwise([begin.time, *sorted(at)])]
        return (*steps[:first], *follow(self.inner, begin, frames))

    def _moved(self, before: float, time: float) -> Odometry | None:
        return self.motion(before, time) if before < time else None

    def _recent(self, steps: tuple[Step[AnyBelief], ...]) -> tuple[Step[AnyBelief], ...]:
        """Return the steps within the lag, and the last one before them, which a late one would begin with."""
        since = steps[-1].belief.time - self.lag
        older = sum(step.belief.time < since for step in steps)
        return steps[max(0, older - 1) :]


def _count(records: Sequence[Measurement]) -> int:
    return sum(len(record.robot) for record in records)
