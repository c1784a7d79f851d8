"""Windows: the sub-team of the robots near one, and its program, compiled.

Leaving rows out is sound: a region in a window contains the region in the whole team. What a window needs is what
a robot of a distributed team would hear over its radio from those it has measured, or that have measured it: their boxes
and their rows, and the rows between them.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers, settle, whole_number
from filter.compiled import compiled
from filter.geometry.convex import EPSILON
from filter.linear.constraints import WORLD, Columns, Constraints
from filter.projection.simplex import OUTWARD, Rows, spread

Boxes = tuple[Array, Array]  # lower and upper corners (n, 2) of all robots


@dataclass(frozen=True)
class Window:
    """How much of the team a robot's region is found from: what it would hear over a radio.

    Attributes:
        hops: How many measured pairs away the farthest robot may be, from 1 on.
        robots: How many robots a window may have, from 2 on; the nearest in hops come first.

    Raises:
        InvalidInput: A number is too small, or not whole.
    """

    hops: int = 1
    robots: int = 12

    def __post_init__(self) -> None:
        hops, robots = whole_number("hops of a window", self.hops, 1), whole_number("robots of a window", self.robots, 2)
        settle(self, hops=hops, robots=robots)


class Links(NamedTuple):
    """Who has rows with whom, as lists laid end to end: those of robot k are at first[k] to first[k + 1].

    Attributes:
        own: (r,) the rows on each robot alone.
        own_first: (n + 1,)
        pair: (q,) the rows on each pair.
        pair_first: (p + 1,)
        near: (2 p,) the robots that share a pair with each robot.
        near_pair: (2 p,) that pair.
        near_first: (n + 1,)
    """

    own: Integers
    own_first: Integers
    pair: Integers
    pair_first: Integers
    near: Integers
    near_pair: Integers
    near_first: Integers


def links(rows: Constraints, robots: int) -> Links:
    """Return who has rows with whom."""
    keys = (rows.i + 1) * robots + rows.j
    order = np.argsort(keys, kind="stable")
    alone = int(np.count_nonzero(rows.i == WORLD))
    own, pair = order[:alone], order[alone:]
    pairs, first = np.unique(keys[pair], return_index=True)
    i, j = pairs // robots - 1, pairs % robots
    one, other, which = np.concatenate([i, j]), np.concatenate([j, i]), np.tile(np.arange(len(pairs)), 2)
    nearby = np.lexsort((other, one))
    every = np.arange(robots + 1)
    return Links(
        own,
        np.searchsorted(rows.j[own], every),
        pair,
        np.append(first, len(pair)),
        other[nearby],
        which[nearby],
        np.searchsorted(one[nearby], every),
    )


@compiled
def members_of(i: int, j: int, hops: int, most: int, near: Integers, near_first: Integers, place: Integers) -> Integers:
    """Return robot j, robot i if it is not WORLD, and those at most so many pairs away from them, the nearest first.

    Args:
        i: The second member, or WORLD.
        j: The first member.
        hops: How far the window reaches.
        most: How many members it may have, from 2 on.
        near: As in `Links`.
        near_first: As in `Links`.
        place: (n,) scratch, all -1; afterwards the place of each member.
    """
    members = np.empty(most, dtype=np.int64)
    members[0], place[j], count, begin = j, 0, 1, 0
    if i >= 0:
        members[1], place[i], count = i, 1, 2
    for _ in range(hops):
        end = count
        for at in range(begin, end):
            for k in range(near_first[members[at]], near_first[members[at] + 1]):
                if place[near[k]] < 0 and count < most:
                    members[count], place[near[k]] = near[k], count
                    count += 1
        begin = end
    return members[:count].copy()


@compiled
def rows_on(i: int, j: int, who: Links) -> Integers:
    """Return the rows on robot j alone where i is WORLD, or those on the pair i, j."""
    if i < 0:
        return who.own[who.own_first[j] : who.own_first[j + 1]]
    for k in range(who.near_first[j], who.near_first[j + 1]):
        if who.near[k] == i:
            return who.pair[who.pair_first[who.near_pair[k]] : who.pair_first[who.near_pair[k] + 1]]
    return who.pair[:0]


@compiled
def box_around(i: int, j: int, box: Boxes) -> Boxes:
    """Return lower and upper corner (2,) of robot j's box, or of a box around x_j - x_i where i is not WORLD [m]."""
    lower, upper = box[0][j].copy(), box[1][j].copy()
    if i >= 0:
        for m in range(2):
            lower[m] = np.nextafter(lower[m] - box[1][i, m], -np.inf)
            upper[m] = np.nextafter(upper[m] - box[0][i, m], np.inf)
    return lower, upper


@compiled
def rows_in(members: Integers, place: Integers, who: Links) -> Integers:
    """Return the rows on the members alone and on pairs of members."""
    total = 0
    for a in members:
        total += who.own_first[a + 1] - who.own_first[a]
        for k in range(who.near_first[a], who.near_first[a + 1]):
            if who.near[k] > a and place[who.near[k]] >= 0:
                total += who.pair_first[who.near_pair[k] + 1] - who.pair_first[who.near_pair[k]]
    rows, at = np.empty(total, dtype=np.int64), 0
    for a in members:
        for q in range(who.own_first[a], who.own_first[a + 1]):
            rows[at] = who.own[q]
            at += 1
        for k in range(who.near_first[a], who.near_first[a + 1]):
            if who.near[k] > a and place[who.near[k]] >= 0:
                for q in range(who.pair_first[who.near_pair[k]], who.pair_first[who.near_pair[k] + 1]):
                    rows[at] = who.pair[q]
                    at += 1
    return rows


class Program(NamedTuple):
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
def middle_and_reach(low: float, high: float) -> tuple[float, float]:
    """Return the middle of an interval and how far it reaches from there, rounded up."""
    middle = (low + high) / 2
    reach = max(high - middle, middle - low)
    return middle, reach * (1 + 4 * EPSILON) if reach > 0 else 0.0


@compiled
def program_of(members: Integers, place: Integers, number: Integers, team: Columns, box: Boxes) -> Program:
    """Return the program of some rows on the members.

    Args:
        members: Whose coordinates are the variables.
        place: (n,) the place of each member among them.
        number: Which constraints.
        team: i, j, normal and offset of all constraints.
        box: Lower and upper corners (n, 2) of all robots.
    """
    i, j, normal, offset = team
    variables = 2 * len(members)
    centre, radius = np.empty(variables), np.empty(variables)
    for k in range(len(members)):
        for m in range(2):
            centre[2 * k + m], radius[2 * k + m] = middle_and_reach(box[0][members[k], m], box[1][members[k], m])
    column, value = np.zeros((len(number) + 2 * variables, 4), dtype=np.int64), np.zeros((len(number) + 2 * variables, 4))
    limit, size, live, count = np.empty(len(number) + 2 * variables), np.empty(len(number)), np.empty_like(number), 0
    for row in number:
        slack, total = offset[row], 0.0
        for side in range(2):
            robot = j[row] if side == 0 else i[row]
            for m in range(2):
                at = 2 * side + m
                column[count, at], value[count, at] = 0, 0.0
                if robot >= 0:
                    coefficient = normal[row, m] if side == 0 else -normal[row, m]
                    variable = 2 * place[robot] + m
                    slack -= coefficient * centre[variable]
                    column[count, at], value[count, at] = variable, coefficient * radius[variable]
                    total += abs(value[count, at])
        if slack < total and total > 0:
            value[count] /= total
            limit[count] = slack / total + OUTWARD * (1 + spread(row))
            live[count], size[count] = row, total
            count += 1
    for k in range(2 * variables):
        column[count + k, :], value[count + k, :] = 0, 0.0
        column[count + k, 0], value[count + k, 0] = k % variables, 1.0 if k < variables else -1.0
        limit[count + k] = 1.0 + OUTWARD * (1 + spread(k))
    end = count + 2 * variables
    return Program(
        Rows(column[:end].copy(), value[:end].copy(), limit[:end].copy()),
        live[:count].copy(),
        size[:count].copy(),
        centre,
        radius,
    )
