"""Votes on where robots are: merged if anything agrees with them, else rejected; at most one of a window may be wrong."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Literal

import numpy as np

from filter.arrays import Array, Frozen, Mask, checked, number, whole_number
from filter.linear.sources import Source
from filter.poses.slices import AGREED, EARLIER
from filter.robust.hypotheses import Cut, Hypotheses

# Merged with all others; or so that one of this window, this one or another, is proved wrong, and a new window begins; or not.
Verdict = Literal["agreed", "contradicted", "rejected"]


@dataclass(frozen=True)
class Rules(Frozen):
    """What is assumed of wrong measurements, and what is done when there are more. InvalidInput if a value is out of range.

    Attributes:
        tolerated: How many votes on a robot may be wrong in a window, unnoticed: 0 or 1.
        window: Its length [s]. It ends earlier when a wrong vote is proved.
        pause: A pair that has not seen each other for so long starts another vote [s].
        longest: A vote lasts no longer; what follows is another one [s].
        memory: How long ago votes count for the question who is lost [s].
        quorum: So many different votes rejected within the memory, and more than were accepted: the robot is lost.
    """

    tolerated: int = field(default=1, metadata=checked(whole_number, "tolerated votes", 0, 1))
    window: float = field(default=20.0, metadata=checked(number, "window [s]", 0))
    pause: float = field(default=1.5, metadata=checked(number, "pause [s]", 0))
    longest: float = field(default=4.0, metadata=checked(number, "longest [s]", 0))
    memory: float = field(default=8.0, metadata=checked(number, "memory [s]", 0))
    quorum: int = field(default=3, metadata=checked(whole_number, "quorum", 1))


@dataclass(frozen=True, eq=False)
class Votes(Frozen):
    """When there were votes on n robots. Column c of a robot is its sightings of body c; the last n, those by each robot of it.

    Attributes:
        opened: (n, c) when the vote that is open began [s], -inf where none is open.
        accepted: (n, c) when the last one was merged [s], -inf for never.
        rejected: (n, c) when the last one was rejected [s], -inf for never.
        believed: (n, c) when the last one was merged that rests on the identity which was read [s], -inf for never.
        renewed: (n,) when the window began [s].
    """

    opened: Array
    accepted: Array
    rejected: Array
    believed: Array
    renewed: Array

    def source(self, time: float, robot: int, column: int) -> Source:
        """Return what a vote on a robot at a time [s] was."""
        bodies = self.opened.shape[1] - len(self.opened)
        if column >= bodies:
            return Source("sighting", time, column - bodies, robot)
        return Source("compass", time, robot) if column == robot else Source("sighting", time, robot, column)

    @classmethod
    def none(cls, robots: int, bodies: int, time: float) -> Votes:
        """Return no votes yet."""
        never = np.full((robots, bodies + robots), -np.inf)
        return cls(never, never, never, never, np.full(robots, time))


class Poll:
    """Merges votes of one time, one after the other. It works on copies; `sets` and `votes` are the result."""

    def __init__(self, sets: tuple[Hypotheses, ...], votes: Votes, time: float, rules: Rules, cells: int) -> None:
        """Begin with what was known before, all of it of this time."""
        self.sets, self.time, self._rules, self._cells = list(sets), time, rules, cells
        self._opened, self._accepted, self._rejected, self._believed, self._renewed = map(np.copy, vars(votes).values())

    @property
    def votes(self) -> Votes:
        """The votes as they are now."""
        return Votes(*map(np.copy, (self._opened, self._accepted, self._rejected, self._believed, self._renewed)))

    def expire(self, robot: int) -> None:
        """Close the votes that are over, and the window if it is."""
        rules, time = self._rules, self.time
        over = (self._accepted[robot] < time - rules.pause) | (self._opened[robot] < time - rules.longest)
        over &= self._opened[robot] > -np.inf
        self._opened[robot, over] = -np.inf
        closed = np.isin(self.sets[robot].without, np.flatnonzero(over))
        if closed.any():
            self.sets[robot] = self.sets[robot].renamed(EARLIER, closed).cut_anew(self._cells)
        if time - self._renewed[robot] >= rules.window:
            self.renew(robot, self.sets[robot])

    def cast(self, robot: int, column: int, cut: Cut, whoever: bool = False) -> Verdict:
        """Merge a vote, a column of `Votes`; one that holds whoever was seen does not rest on the identity that was read."""
        known = self.sets[robot]
        bound = known.without != column
        merged = known.select(bound).cut(cut)
        if not len(merged):
            self._rejected[robot, column] = self.time
            return "rejected"
        if self._rules.tolerated:
            opens = self._opened[robot, column] == -np.inf
            spare = known.select(known.without == AGREED).renamed(column) if opens else known.select(~bound)
            self._opened[robot, column] = self.time if opens else self._opened[robot, column]
            merged = Hypotheses.concatenate([merged, spare])
        self._accepted[robot, column] = self.time
        if not whoever:
            self._believed[robot, column] = self.time
        if (merged.without == AGREED).any():
            self.sets[robot] = merged
            return "agreed"
        self.renew(robot, merged)
        return "contradicted"

    def agrees(self, robot: int, cut: Cut) -> bool:
        """Return whether a vote on a robot would be agreed with; nothing is merged."""
        known = self.sets[robot]
        return len(known.select(known.without == AGREED).cut(cut)) > 0

    def restart(self, robot: int, anywhere: Hypotheses) -> None:
        """Forget all that is known of a robot, and all votes on it."""
        self.renew(robot, anywhere)
        self._accepted[robot] = self._rejected[robot] = self._believed[robot] = -np.inf

    def renew(self, robot: int, known: Hypotheses) -> None:
        """Begin a new window: all that is known to be possible is agreed on."""
        self.sets[robot] = known.renamed(AGREED).cut_anew(self._cells)
        self._opened[robot] = -np.inf
        self._renewed[robot] = self.time

    def believed(self, sensor: str, body: int, bodies: int, since: float) -> Mask:
        """Return (n,) on whom a vote that rests on a camera, or on an identity, was merged after a time [s]."""
        recent = (self._accepted if sensor == "camera" else self._believed) > since
        own, others = (slice(bodies), bodies + body) if sensor == "camera" else (slice(bodies, None), body)
        misled = recent[:, others].copy()
        if body < len(misled):
            misled[body] = recent[body, own].any()
        return misled

    def contested(self) -> tuple[Array, Mask]:
        """Return (n,) since when several votes on a robot are being rejected [s], or inf, and whether it is lost by that.

        What counts is each column's last vote, if it is within the memory.
        """
        since = self.time - self._rules.memory
        accepted = (self._accepted > since) & (self._accepted > self._rejected)
        rejected = (self._rejected > since) & (self._rejected >= self._accepted)
        against = rejected.sum(axis=1)
        first = np.where(rejected, self._rejected, self.time).min(axis=1)
        lost = (against >= self._rules.quorum) & (against > accepted.sum(axis=1))
        return np.where(against >= 2, first, np.inf), lost
