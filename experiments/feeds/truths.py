"""Truth that comes with a feed: the filter is not given it; what was answered is held against it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import replace
from typing import cast

import numpy as np

from experiments.feeds.now import Change, Now
from experiments.logs import TruthAt
from experiments.logs.gathering import arrival_of
from filter import Belief, Frame, SetMembershipFilter, Truth

AT_ONCE = 2  # so many instants are checked after a batch: what is measured comes first
KEPT = 64  # answers, and truths that wait


class Truths:
    """Checks truth against the last answer that is not after it, predicted to its stamp."""

    def __init__(self, filter_: SetMembershipFilter) -> None:
        self._filter = filter_
        self._waiting, self._answers = deque[Frame](), deque[tuple[Belief, set[Change]]](maxlen=KEPT)

    def add(self, record: TruthAt) -> None:
        """Take truth in; it waits until the filter has come to its stamp."""
        self._waiting.append(cast(Frame, arrival_of(record, self._filter.team.robots)))

    def due(self, now: Now) -> tuple[list[tuple[Belief, Frame]], int]:
        """Return truths that the filter has come to, the newest ones, each with what was known then; and how many are left out.

        Raises:
            Inconsistent: A robot has left the arena for sure.
        """
        self._answers.append((now.belief, now.changes))
        come = [frame for frame in self._waiting if frame.time <= now.belief.time]
        later = [frame for frame in self._waiting if frame.time > now.belief.time]
        self._waiting = deque(later[-KEPT:])
        found = [each for frame in come[-AT_ONCE:] for each in self._then(now, frame)]
        return found, len(come) - len(found) + max(0, len(later) - KEPT)

    @property
    def left(self) -> int:
        """How many truths wait for what the filter has not come to."""
        return len(self._waiting)

    def _then(self, now: Now, frame: Frame) -> Iterator[tuple[Belief, Frame]]:
        """Yield what was known of a frame's time, if anything: motion is known since the oldest step.

        The truth of who has come or gone until then, as is known only now, is left out: it may have been carried.
        """
        oldest = now.lagged.steps[0].belief.time
        before = [answer for answer in self._answers if oldest <= answer[0].time <= frame.time]
        if not before:
            return
        last, known = before[-1]
        carried = [robot for time, robot in now.changes - known if time <= frame.time]
        if last.time < frame.time:
            last = self._filter.predict(last, frame.time, now.motions.between(last.time, frame.time))
        yield last, replace(frame, truth=frame.truth and _without(frame.truth, carried))


def _without(truth: Truth, robots: Sequence[int]) -> Truth:
    positions, headings = truth.positions.copy(), truth.headings.copy()
    positions[robots], headings[robots] = np.nan, np.nan
    return Truth(positions, headings)
