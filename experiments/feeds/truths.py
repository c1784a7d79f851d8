"""Truth that comes with a feed: the filter is not given it; what was answered is held against it."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from typing import cast

from experiments.feeds.now import Now
from experiments.logs import TruthAt
from experiments.logs.gathering import arrival_of
from filter import Belief, Frame, SetMembershipFilter

AT_ONCE = 2  # so many instants are checked after a batch: what is measured comes first
KEPT = 64  # answers, and truths that wait


class Truths:
    """Checks truth against the last answer that is not after it, predicted to its stamp."""

    def __init__(self, filter_: SetMembershipFilter) -> None:
        self._filter = filter_
        self._waiting, self._answers = deque[Frame](), deque[Belief](maxlen=KEPT)

    def add(self, record: TruthAt) -> None:
        """Take truth in; it waits until the filter has come to its stamp."""
        self._waiting.append(cast(Frame, arrival_of(record, self._filter.team.robots)))

    def due(self, now: Now) -> tuple[list[tuple[Belief, Frame]], int]:
        """Return truths that the filter has come to, the newest ones, each with what was known then; and how many are left out.

        Raises:
            Inconsistent: A robot has left the arena for sure.
        """
        self._answers.append(now.belief)
        come = [frame for frame in self._waiting if frame.time <= now.belief.time]
        later = [frame for frame in self._waiting if frame.time > now.belief.time]
        self._waiting = deque(later[-KEPT:])
        found = [(belief, frame) for frame in come[-AT_ONCE:] for belief in self._then(now, frame.time)]
        return found, len(come) - len(found) + max(0, len(later) - KEPT)

    @property
    def left(self) -> int:
        """How many truths wait for what the filter has not come to."""
        return len(self._waiting)

    def _then(self, now: Now, time: float) -> Iterator[Belief]:
        """Yield what is known of a time, if anything: motion is known since the oldest step."""
        before = [belief for belief in self._answers if now.lagged.steps[0].belief.time <= belief.time <= time]
        if not before:
            return
        last = before[-1]
        if last.time == time:
            yield last
            return
        yield self._filter.predict(last, time, now.motions.between(last.time, time))
