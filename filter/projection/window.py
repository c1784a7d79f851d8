"""Windows: the sub-team of the robots near one, and its program, compiled. The whole team is the widest.

Leaving rows out is sound: a region in a window contains the region in the whole team. What a window needs is what a robot
would hear over a radio from those it has measured, or that have measured it: their boxes, their rows, and those between them.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Frozen, Integers, checked, whole_number
from filter.compiled import compiled
from filter.linear.certify import Boxes, members_at
from filter.linear.constraints import WORLD, Columns, Constraints
from filter.projection.simplex import OUTWARD, Rows, spread

EVERYBODY = 2**31  # more hops, and more robots, than any team has


@dataclass(frozen=True)
class Window(Frozen):
    """How much of the team a robot's region is found from: what it would hear over a radio.

    Raises `InvalidInput` if a number is too small, or not whole.

    Attributes:
        hops: How many measured pairs away the farthest robot may be, from 1 on.
        robots: How many robots a window may have, from 2 on; the nearest in hops come first.
    """

    hops: int = field(default=1, metadata=checked(whole_number, "hops of a window", 1))
    robots: int = field(default=12, metadata=checked(whole_number, "robots of a window", 2))

    @classmethod
    def everybody(cls) -> Window:
        """Return the window of all that has to do with a robot, however far away: nothing is left out."""
        return cls(EVERYBODY, EVERYBODY)

    @property
    def leaves_nobody_out(self) -> bool:
        """Whether it is the window of everybody."""
        return self.hops == EVERYBODY and self.robots == EVERYBODY


class Links(NamedTuple):
    """Which rows are on whom, and who has rows with whom, as lists laid end to end.

    Attributes:
        own_first: (n + 1,) where the rows on each robot alone begin.
        pair_first: (p + 1,) where the rows on each pair begin.
        near: (2 p,) the robots that share a pair with each robot.
        near_pair: (2 p,) that pair.
        near_first: (n + 1,) where those of each robot begin.
    """

    own_first: Integers
    pair_first: Integers
    near: Integers
    near_pair: Integers
    near_first: Integers


def links(rows: Constraints, robots: int) -> Links:
    """Return which rows are on whom."""
    i, j, first = rows.grouped()
    alone = int(np.searchsorted(i, WORLD, side="right"))
    own_first, near_first = np.empty(robots + 1, dtype=np.int64), np.zeros(robots + 1, dtype=np.int64)
    near, near_pair = np.empty((2, 2 * (len(i) - alone)), dtype=np.int64)
    _link((own_first, near, near_pair, near_first), i, j, first, alone)
    return Links(own_first, first[alone:].copy(), near, near_pair, near_first)


@compiled
def _link(lists: tuple[Integers, Integers, Integers, Integers], i: Integers, j: Integers, first: Integers, alone: int) -> None:
    """Write the lists of `Links`, from those who have rows, sorted, first those alone, and where these begin."""
    (own_first, near, near_pair, near_first), group = lists, 0
    for robot in range(len(own_first)):
        while group < alone and j[group] < robot:
            group += 1
        own_first[robot] = first[group]
    for pair in range(alone, len(i)):
        near_first[i[pair] + 1] += 1
        near_first[j[pair] + 1] += 1
    for robot in range(1, len(near_first)):
        near_first[robot] += near_first[robot - 1]
    at = near_first.copy()
    for one, other in ((j, i), (i, j)):  # the mates below a robot, in order, and then those above it
        for pair in range(alone, len(i)):
            near[at[one[pair]]], near_pair[at[one[pair]]] = other[pair], pair - alone
            at[one[pair]] += 1


@compiled
def members_of(i: int, j: int, hops: int, most: int, who: Links, place: Integers) -> Integers:
    """Return robot j, i if that is not WORLD, and those at most so many pairs away from them, the nearest first.

    There are at most so many, from 2 on. The place of each is written into (n,) scratch, all -1 before.
    """
    members = np.empty(min(most, len(place)), dtype=np.int64)
    members[0], place[j], count, begin = j, 0, 1, 0
    if i != WORLD:
        members[1], place[i], count = i, 1, 2
    for _ in range(hops):
        end = count
        for at in range(begin, end):
            for k in range(who.near_first[members[at]], who.near_first[members[at] + 1]):
                if place[who.near[k]] < 0 and count < len(members):
                    members[count], place[who.near[k]] = who.near[k], count
                    count += 1
        begin = end
        if end == count:
            break
    return members[:count].copy()


@compiled
def rows_in(members: Integers, place: Integers, who: Links) -> Integers:
    """Return the rows on the members alone and on pairs of members."""
    rows, count = np.empty(who.pair_first[-1], dtype=np.int64), 0
    for a in members:
        for row in range(who.own_first[a], who.own_first[a + 1]):
            rows[count] = row
            count += 1
        for k in range(who.near_first[a], who.near_first[a + 1]):
            if who.near[k] > a and place[who.near[k]] >= 0:
                for row in range(who.pair_first[who.near_pair[k]], who.pair_first[who.near_pair[k] + 1]):
                    rows[count] = row
                    count += 1
    return rows[:count].copy()


class WindowProgram(NamedTuple):
    """A window's program: maximise over z, every coordinate in the radius of its box, and every row of size 1.

    Attributes:
        rows: For the walk.
        number: (l,) which constraint each of the rows is that the box does not imply.
        size: (l,) what it was divided by.
        centre: (v,) [m].
        radius: (v,) [m].
    """

    rows: Rows
    number: Integers
    size: Array
    centre: Array
    radius: Array


@compiled
def program_of(members: Integers, place: Integers, number: Integers, team: Columns, box: Boxes) -> WindowProgram:
    """Return the program of constraints by number; its variables are the members' coordinates, in their places (n,)."""
    i, j, normal, offset = team
    variables = 2 * len(members)
    _, centre, radius = members_at(members, place, box)
    column, value = np.zeros((len(number) + 2 * variables, 4), dtype=np.int64), np.zeros((len(number) + 2 * variables, 4))
    limit, size, live, count = np.empty(len(number) + 2 * variables), np.empty(len(number)), np.empty_like(number), 0
    for row in number:
        slack, total = offset[row], 0.0
        for side in range(2):
            robot = j[row] if side == 0 else i[row]
            for m in range(2):
                at = 2 * side + m
                column[count, at], value[count, at] = 0, 0.0
                if robot != WORLD:
                    coefficient = normal[row, m] if side == 0 else -normal[row, m]
                    variable = 2 * place[robot] + m
                    slack -= coefficient * centre[variable]
                    column[count, at], value[count, at] = variable, coefficient * radius[variable]
                    total += abs(value[count, at])
        if slack < total and total > 0:
            for at in range(4):
                value[count, at] /= total
            limit[count] = slack / total + OUTWARD * (1 + spread(row))
            live[count], size[count] = row, total
            count += 1
    for k in range(2 * variables):
        for at in range(4):
            column[count + k, at], value[count + k, at] = 0, 0.0
        column[count + k, 0], value[count + k, 0] = k % variables, 1.0 if k < variables else -1.0
        limit[count + k] = 1.0 + OUTWARD * (1 + spread(k))
    end = count + 2 * variables
    rows = Rows(column[:end].copy(), value[:end].copy(), limit[:end].copy())
    return WindowProgram(rows, live[:count].copy(), size[:count].copy(), centre, radius)
