"""What is known now: of what was measured, and of how the robots have moved since."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from filter import Arrival, Belief, FixedLag, Frame, Lagged, Motions, Odometry, SetMembershipFilter, Twist

Change = tuple[float, int]  # time [s] and robot of one who comes or goes

AHEAD = 0.1  # so far odometry alone is followed from what was measured; beyond it is merged [s]


class Now:
    """Merges records as they come, and tells what is known at the newest stamp, be it of odometry.

    To move regions along costs a tenth of what it costs to find them again. So odometry that comes alone does just that; with
    the next measurement it is merged at its own stamps.

    Attributes:
        lagged: What is known of what was measured.
        belief: What is known at the newest stamp.
        motions: All that odometry has told since the oldest step.
    """

    def __init__(self, lag: FixedLag[Belief], filter_: SetMembershipFilter, known: Belief) -> None:
        self._lag, self._filter, self.belief = lag, filter_, known
        self.lagged: Lagged[Belief] = lag.begin(known)
        self.motions = self.lagged.motions or Motions(filter_.team)
        self._told, self._latest = list[Arrival](), known.time

    def take(self, records: Sequence[Arrival]) -> None:
        """Merge some records.

        Raises:
            InvalidInput: One of them cannot be merged, and so none is.
            OutOfOrder: A twist is from before the oldest step; none is merged.
            Inconsistent: What was measured is proved to disagree.
        """
        told = [record for record in records if isinstance(record, Odometry | Twist)]
        latest = max([self._latest, *(record.time for record in told)])
        if len(told) == len(records) and self._are_soon(told, latest):
            self._follow(told)
        else:
            asked = [Frame(latest)] if len(told) == len(records) else []
            self._merge([*records, *asked])
        now = self.lagged.belief
        self._latest = latest if latest <= now.time + AHEAD else now.time
        self.belief = self._moved(now, self._latest) if self._latest > now.time else now

    @property
    def changes(self) -> set[Change]:
        """Who has come or gone in the steps that are kept, and when."""
        return {(change.time, change.robot) for step in self.lagged.steps for change in step.frame.changes}

    def _are_soon(self, told: Sequence[Odometry | Twist], latest: float) -> bool:
        """Return whether odometry goes on from what is known, and not too far."""
        oldest = self.lagged.steps[0].belief.time
        return latest <= self.lagged.belief.time + AHEAD and all(record.time >= oldest for record in told)

    def _follow(self, told: Sequence[Odometry | Twist]) -> None:
        motions = self.motions
        for record in told:
            motions = motions.merged(record)
        self.motions, self._told = motions, [*self._told, *told]

    def _merge(self, records: Sequence[Arrival]) -> None:
        self.lagged = self._lag.merge(self.lagged, [*self._told, *records])
        self.motions, self._told = self.lagged.motions or self.motions, []

    def _moved(self, known: Belief, time: float) -> Belief:
        return self._filter.predict(known, time, self.motions.between(known.time, time))


def gone_on(filter_: SetMembershipFilter, belief: Belief, time: float) -> Belief:
    """Return what is known after stamps have jumped to a time [s].

    Ahead, after a pause, say, the robots have moved within their limits. Back, nobody knows how long it took: they are anywhere
    in the arena.

    Raises:
        InvalidInput: It is back, and the arena is open.
    """
    if time >= belief.time:
        return filter_.predict(belief, time)
    anywhere = filter_.start(time, np.full(filter_.team.robots, None).tolist())
    return replace(anywhere, guarantee=belief.guarantee)
