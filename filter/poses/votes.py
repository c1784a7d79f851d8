"""Votes on where each robot is: what is known of its pose although one of them may be wrong.

A vote on a robot is what it and one body measure of one another. Slices that agree with every vote are AGREED. When a body is
heard for the first time in a robot's window, the agreed slices are copied; the copies do without that vote, but not without
others. So the truth is in an agreed slice if no vote of the window is wrong, and in one of all slices if at most one is: the
relaxed intersection (Jaulin, Robust set-membership state estimation, Automatica 2009) by recursion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Frozen, Integers, Mask, places
from filter.linear.polytope import Polytope
from filter.poses.cells import START_EDGES, Most, Told, as_sets, sets_of
from filter.poses.slices import AGREED, Slices, regrouped
from filter.poses.turns import Outcome, Sets, Starts, in_turn


@dataclass(frozen=True, eq=False)
class Ballots(Frozen):
    """Which votes there were on n robots, by or of b bodies, robots first.

    Attributes:
        since: (n,) when the window began in which they count [s]; -inf before the first one.
        heard: (n, b) which bodies have had a vote on each robot since then.
    """

    since: Array
    heard: Mask

    @classmethod
    def none(cls, robots: int, bodies: int) -> Ballots:
        """Return that there were none."""
        return cls(np.full(robots, -np.inf), np.zeros((robots, bodies), dtype=bool))


class Case(NamedTuple):
    """Cases of who is wrong: of k robots' poses, each without one vote.

    Attributes:
        robot: (k,) whose poses.
        vote: (k,) what is left out, AGREED for nothing.
        first: (k + 1,) where the slices of each begin.
    """

    robot: Integers
    vote: Integers
    first: Integers

    @classmethod
    def of(cls, slices: Slices) -> Case:
        """Return the cases of slices that are in order of robots and votes."""
        begins = np.append(True, (np.diff(slices.robot) != 0) | (np.diff(slices.vote) != 0))[: len(slices)]
        first = np.flatnonzero(begins)
        return cls(slices.robot[first], slices.vote[first], np.append(first, len(slices)))


@dataclass(frozen=True, eq=False)
class Polling(Frozen):
    """What votes of one time are cast into.

    Attributes:
        known: Where robots can be.
        told: The votes: what robots are told.
        landmarks: (l, 2) [m].
        most: Into how many parts the poses of a robot are cut at most, in each case.
    """

    known: Polytope
    told: Told
    landmarks: Array
    most: Most

    @property
    def robots(self) -> Integers:
        """(k,) on whom there are votes."""
        return np.unique(self.told.robot)

    def opened(self, votes: Ballots | None, slices: Slices, time: float, window: float) -> tuple[Ballots, Slices]:
        """Return votes, and slices before those of a time [s]: where a window is over, one begins [s]; new votes have copies.

        Robots that are told something and have no slices begin one, with a slice of all that is known of their pose.
        """
        votes = votes or Ballots.none(len(self.known.lower), len(self.known.lower) + len(self.landmarks))
        now = np.zeros_like(votes.heard)
        now[self.told.robot, self.told.target] = True
        is_over = (time - votes.since[self.robots] >= window) | ~np.isin(self.robots, slices.robot)
        over = self.robots[is_over]
        since, heard = votes.since.copy(), votes.heard.copy()
        since[over], heard[over] = time, False
        anew = [self._begun(robot, slices) for robot in over.tolist()]
        begun = slices.replaced(over, Slices.concatenate([Slices.none(), *anew]))
        agreed = begun.select(begun.vote == AGREED)
        whose, body = np.nonzero(now & ~heard)
        some, begins = places(np.searchsorted(agreed.robot, np.arange(len(heard) + 1)), whose)
        copies = replace(agreed.select(some), vote=np.repeat(body, np.diff(begins)))
        return Ballots(since, heard | now), _in_order([begun, copies])

    def _begun(self, robot: int, slices: Slices) -> Slices:
        """Return the slices of a robot as its window begins: all of them agree with what was said before."""
        mine, headings = slices.of(robot), self.told.headings
        if not len(mine):
            return Slices.around(robot, self.known.of_robots(np.array([robot])).polygons[0], headings)
        if (mine.vote == AGREED).all():
            return mine
        leaves = np.arange(len(mine)), np.stack([mine.centre, mine.bound], axis=1), mine.reach
        heading = np.array([headings.centre[robot], headings.bound[robot]])
        table = regrouped(heading, leaves, len(mine), max(1, self.most.taken_along))
        return Slices.of_table(np.full(len(table), robot), table)

    def cast(self, slices: Slices) -> Slices:
        """Return what votes leave of slices, in order of robots and votes: each is cut by all but the one it does without.

        Mates are where they were known to be before, whoever comes first.
        """
        told, said = self._told_to(Case.of(slices))
        idle = np.repeat(said[:, 0] == said[:, 1], np.diff(Case.of(slices).first))
        if idle.all():
            return slices
        case, mine = Case.of(slices.select(~idle)), slices.select(~idle)
        starts, sets = self._starts(case, said[said[:, 0] < said[:, 1]], mine)
        room = Most(max(self.most.cells, 2 * int(np.diff(case.first).max())), max(1, self.most.slices))
        count, done, heard = len(case.robot), 0, told.heard(self.robots)
        found = Outcome.blank(count, room.cells, room.taken_along)
        while done < count:
            nowhere = in_turn((done, count), starts, heard, sets, found)
            done = count if nowhere < 0 else nowhere + 1
        left = found.slices[np.arange(found.slices.shape[1]) < found.kept[:, None]]
        whose, without = np.repeat(case.robot, found.kept), np.repeat(case.vote, found.kept)
        return _in_order([slices.select(idle), Slices.of_table(whose, left, without)])

    def _told_to(self, case: Case) -> tuple[Told, Integers]:
        """Return what is told in all cases, one after the other, and from where to where (k, 2) it is in each."""
        told = self.told
        rows, begins = places(np.searchsorted(told.robot, np.arange(len(self.known.lower) + 1)), case.robot)
        kept = told.target[rows] != np.repeat(case.vote, np.diff(begins))
        ends = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(kept)])[begins]
        return told.select(rows[kept]), np.stack([ends[:-1], ends[1:]], axis=1)

    def _starts(self, case: Case, said: Integers, slices: Slices) -> tuple[Starts, Sets]:
        """Return what poses are cut from in each case, and where those can be of whom something is told."""
        robots = np.unique(case.robot)
        polygons = as_sets(self.known, robots, START_EDGES)
        edges, begins = places(polygons.first, np.searchsorted(robots, case.robot))
        lines, roots = (polygons.normals[edges], polygons.offsets[edges]), (slices.centre, slices.bound, slices.reach)
        starts = Starts(case.robot, said, lines, polygons.vertices[edges], begins, roots, case.first, is_taken=False)
        return starts, sets_of(self.known, self.landmarks, self.told.target, polygons.margin)


def _in_order(parts: Sequence[Slices]) -> Slices:
    """Return slices in order of robots and votes; those of a case stay in theirs."""
    both = Slices.concatenate(parts)
    return both.select(np.lexsort((both.vote, both.robot)))
