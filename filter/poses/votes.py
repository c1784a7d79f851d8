"""Votes on where each robot is: what is known of its pose although one of them may be wrong.

A vote on a robot is what it measures of one body for a while, or one mate of it. Slices that agree with every vote are AGREED.
When a vote begins, the agreed slices are copied; the copies do without that vote, but not without others. So the truth is in
an agreed slice if no vote of a window is wrong, and in one of all slices if at most one is: the relaxed intersection (Jaulin,
Robust set-membership state estimation, Automatica 2009) by recursion.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Frozen, Integers, Mask, places
from filter.geometry.angles import AngularIntervals
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.poses.branch import Tree
from filter.poses.cells import START_EDGES, ByCases, Most, Told, as_sets, sets_of
from filter.poses.slices import AGREED, EARLIER, Slices, regrouped
from filter.poses.turns import Outcome, Sets, Starts, in_turn
from filter.sensing.readings import Readings

OF_A_WINDOW = 0.1  # of a window at most a vote lasts; what follows is another one


@dataclass(frozen=True, eq=False)
class Ballots(Frozen):
    """Which votes there were on n robots: in column c by its sightings of body c; in the last n by those of each robot of it.

    Attributes:
        since: (n,) when the window began in which they count [s]; -inf before the first one.
        opened: (n, c) when the last vote began [s]; -inf where there was none in this window.
    """

    since: Array
    opened: Array

    @classmethod
    def none(cls, robots: int, bodies: int) -> Ballots:
        """Return that there were none."""
        return cls(np.full(robots, -np.inf), np.full((robots, bodies + robots), -np.inf))

    def sightings(self, robot: int, labels: Sequence[int]) -> list[tuple[int, int]]:
        """Return who saw whom in the votes that slices of some labels do without; for EARLIER in any vote of the window."""
        columns = set(labels) - {AGREED, EARLIER}
        if EARLIER in labels:
            columns |= set(np.flatnonzero(self.opened[robot] > -np.inf).tolist())
        bodies = self.opened.shape[1] - len(self.opened)
        return [(robot, column) if column < bodies else (column - bodies, robot) for column in sorted(columns)]


class Case(NamedTuple):
    """Cases of who is wrong: of k robots' poses, each without one vote.

    Attributes:
        robot: (k,) whose poses.
        vote: (k,) what is left out, AGREED or EARLIER for nothing.
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


class Cast(NamedTuple):
    """What votes left of slices.

    Attributes:
        idle: (s) slices that nothing was said of.
        before: The others, before,
        case: of k cases,
        found: and what was found of these.
    """

    idle: Slices
    before: Slices
    case: Case
    found: Outcome

    @property
    def slices(self) -> Slices:
        """What is left, in order of robots and votes."""
        found, case = self.found, self.case
        left = found.slices[np.arange(found.slices.shape[1]) < found.kept[:, None]]
        whose, without = np.repeat(case.robot, found.kept), np.repeat(case.vote, found.kept)
        return _in_order([self.idle, Slices.of_table(whose, left, without)])


@dataclass(frozen=True, eq=False)
class Polling(Frozen):
    """What votes of one time are cast into.

    Attributes:
        known: Where robots can be.
        told: The votes: what robots are told.
        seer: (m,) who measured what is told.
        landmarks: (l, 2) [m].
        most: Into how many parts the poses of a robot are cut at most, in each case.
    """

    known: Polytope
    told: Told
    seer: Integers
    landmarks: Array
    most: Most

    @cached_property
    def robots(self) -> Integers:
        """(k,) on whom there are votes."""
        return np.unique(self.told.robot)

    @cached_property
    def vote(self) -> Integers:
        """(m,) of which vote what is told is, a column of `Ballots`."""
        bodies = len(self.known.lower) + len(self.landmarks)
        return np.where(self.seer == self.told.robot, self.told.target, bodies + self.told.target)

    def opened(self, votes: Ballots | None, slices: Slices, time: float, window: float) -> tuple[Ballots, Slices]:
        """Return votes, and slices before those of a time [s]: what is over ends, and votes that begin have copies of slices.

        Where a window [s] is over, one begins, and so for robots that have no slices, with all that is known of their pose.
        """
        robots = len(self.known.lower)
        votes = votes or Ballots.none(robots, robots + len(self.landmarks))
        is_over = (time - votes.since[self.robots] >= window) | ~np.isin(self.robots, slices.robot)
        since, opened, over = votes.since.copy(), votes.opened.copy(), self.robots[is_over]
        since[over], opened[over] = time, -np.inf
        known = slices.replaced(over, _joined([self._begun(slices.of(robot), robot) for robot in over.tolist()]))
        closed, cast = np.zeros((2, *opened.shape), dtype=bool)
        closed[self.robots] = time - opened[self.robots] >= OF_A_WINDOW * window
        known = self._without(known, closed)
        cast[self.told.robot, self.vote] = True
        whose, column = np.nonzero(cast & closed)
        opened[whose, column] = time
        agreed = known.select(known.vote == AGREED)
        some, begins = places(np.searchsorted(agreed.robot, np.arange(robots + 1)), whose)
        copies = replace(agreed.select(some), vote=np.repeat(column, np.diff(begins)))
        return Ballots(since, opened), _in_order([known, copies])

    def ended(self, votes: Ballots, slices: Slices, robots: Integers) -> tuple[Ballots, Slices]:
        """Return votes and slices where the windows of some robots (k,) are over: all that is left is agreed on."""
        since, others = votes.since.copy(), slices.without(robots)
        since[robots] = -np.inf
        return replace(votes, since=since), _in_order(
            [others, *(self._as_one(slices.of(robot), AGREED) for robot in robots.tolist())]
        )

    def _begun(self, mine: Slices, robot: int) -> Slices:
        """Return the slices of a robot as its window begins: all of them agree with what was said before."""
        if not len(mine):
            return Slices.around(robot, as_sets(self.known, np.array([robot]), START_EDGES)[0], self.told.headings)
        return mine if (mine.vote == AGREED).all() else self._as_one(mine, AGREED)

    def _without(self, slices: Slices, closed: Mask) -> Slices:
        """Return slices that do without no vote that is closed (n, c): those that did do without an earlier one."""
        is_closed = (slices.vote >= 0) & closed[slices.robot, slices.vote]
        robots = np.unique(slices.robot[is_closed])
        is_one = is_closed | ((slices.vote == EARLIER) & np.isin(slices.robot, robots))
        earlier = slices.select(is_one)
        return _in_order([slices.select(~is_one), *(self._as_one(earlier.of(robot), EARLIER) for robot in robots.tolist())])

    def _as_one(self, mine: Slices, vote: int) -> Slices:
        """Return some slices of a robot as ones that do without the same vote, no more than there may be."""
        robot, headings = mine.robot[0], self.told.headings
        leaves = np.arange(len(mine)), np.stack([mine.centre, mine.bound], axis=1), mine.reach
        heading = np.array([headings.centre[robot], headings.bound[robot]])
        table = regrouped(heading, leaves, len(mine), max(1, self.most.taken_along))
        return Slices.of_table(np.full(len(table), robot), table, vote)

    def cast(self, slices: Slices) -> Cast:
        """Return what votes leave of slices in order of robots and votes: each is cut by all but the one it does without.

        Mates are where they were known to be before, whoever comes first.
        """
        told, said = self._told_to(Case.of(slices))
        idle = np.repeat(said[:, 0] == said[:, 1], np.diff(Case.of(slices).first))
        case, mine = Case.of(slices.select(~idle)), slices.select(~idle)
        if not len(mine):
            return Cast(slices, mine, case, Outcome.blank(0, 0, 0))
        starts, sets = self._starts(case, said[said[:, 0] < said[:, 1]], mine)
        room = Most(max(self.most.cells, 2 * int(np.diff(case.first).max())), max(1, self.most.slices))
        count, done, heard = len(case.robot), 0, told.heard(self.robots)
        found = Outcome.blank(count, room.cells, room.taken_along)
        while done < count:
            nowhere = in_turn((done, count), starts, heard, sets, found)
            done = count if nowhere < 0 else nowhere + 1
        return Cast(slices.select(idle), mine, case, found)

    def _told_to(self, case: Case) -> tuple[Told, Integers]:
        """Return what is told in all cases, one after the other, and from where to where (k, 2) it is in each."""
        rows, begins = places(np.searchsorted(self.told.robot, np.arange(len(self.known.lower) + 1)), case.robot)
        which = np.repeat(np.arange(len(case.robot)), np.diff(begins))
        kept = self.vote[rows] != case.vote[which]
        ends = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(kept)])[begins]
        groups = np.stack([which, np.cumsum(self.told.begins)[rows]])[:, kept]
        anew = (np.diff(groups, prepend=-1) != 0).any(axis=0)
        return replace(self.told.select(rows[kept]), begins=anew), np.stack([ends[:-1], ends[1:]], axis=1)

    def _starts(self, case: Case, said: Integers, slices: Slices) -> tuple[Starts, Sets]:
        """Return what poses are cut from in each case, and where those can be of whom something is told."""
        robots = np.unique(case.robot)
        polygons = as_sets(self.known, robots, START_EDGES)
        edges, begins = places(polygons.first, np.searchsorted(robots, case.robot))
        lines, roots = (polygons.normals[edges], polygons.offsets[edges]), (slices.centre, slices.bound, slices.reach)
        starts = Starts(case.robot, said, lines, polygons.vertices[edges], begins, roots, case.first, is_taken=False)
        return starts, sets_of(self.known, self.landmarks, self.told.target, polygons.margin)


@dataclass(frozen=True, eq=False)
class Polled(Frozen):
    """Votes of one time, and a proof of what they leave: that it is in none of the pieces that slices were split into.

    Attributes:
        polling: What they were cast into.
        readings: What they were.
        sources: What produced the polytope's rows.
        earlier: Slices before,
        votes: votes after those of this time began,
        cast: what was left then,
        left: and where all that are left agree as their window is over.
        headings: (n) afterwards [rad].
    """

    polling: Polling
    readings: Readings
    sources: Sources
    earlier: Slices
    votes: Ballots
    cast: Cast
    left: Slices
    headings: AngularIntervals

    def begun(self, robot: int) -> Slices:
        """Return the slices of a robot when votes of this time had begun."""
        return _in_order([self.cast.idle.of(robot), self.cast.before.of(robot)])

    def cases(self, robot: int) -> Iterator[tuple[int, ByCases]]:
        """Yield of each case of a robot of which anything was said the vote that is left out, and what was found."""
        (polling, cast), told = (self.polling, self.cast), self.polling.told
        for k in np.flatnonzero(cast.case.robot == robot).tolist():
            before, found = cast.before.select(np.arange(*cast.case.first[k : k + 2])), cast.found
            tree, left = Tree(*(column[k] for column in found.trees)), found.slices[k, : found.kept[k]]
            how = told.headings, robot, told.spacing, tree, np.zeros((0, 4)), found.heading[k]
            yield int(cast.case.vote[k]), ByCases(polling.known, self.sources, *how, before, left)


def _joined(parts: Sequence[Slices]) -> Slices:
    return Slices.concatenate([Slices.none(), *parts])


def _in_order(parts: Sequence[Slices]) -> Slices:
    """Return slices in order of robots and votes; those of a case stay in theirs."""
    both = _joined(parts)
    return both.select(np.lexsort((both.vote, both.robot)))
