"""Headings that are tied to one another: by what a robot sees of a mate's, and by how a robot turns between two instants.

A tie says that one heading is another one turned by so much, within a bound. So each of the two is within an arc around the
other, and what narrows one narrows the other, and whoever that one is tied to. It ends where no tie narrows anything any more.
"""

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.angles import intersection, turned
from filter.sensing.readings import RELATIVES, Readings

LEAST = 1e-12  # less than this is no gain, but rounding [rad]
# As many laps at most, besides one for each heading: these are enough where headings agree. Where none may be left, and nothing
# is proved by then, they are larger than need be.
LAPS = 1000


class Ties(NamedTuple):
    """What ties headings, of robots, or of these in the beginning and at each of several instants, one after the other.

    Attributes:
        first: (t,) which heading.
        last: (t,) which other one is that, turned
        turn: (t, 2) by so much, within a bound [rad].
    """

    first: Integers
    last: Integers
    turn: Array

    @classmethod
    def of(cls, readings: Readings, robots: int) -> "Ties":
        """Return those of relative headings among n robots, and of turns between instants, if there are several; in order."""
        relatives, since = readings.relatives, readings.since
        seen = np.stack([relatives.heading, relatives.bound], axis=1)
        if since is None:
            return cls(relatives.robot.copy(), relatives.target.copy(), seen)
        begin, turns = (readings.at[RELATIVES] + 1) * robots, since.turns.reshape(-1, 2)
        first = np.concatenate([np.arange(len(turns)), begin + relatives.robot])
        last = np.concatenate([np.arange(len(turns)) + robots, begin + relatives.target])
        order = np.argsort(last // robots, kind="stable")  # the turns on the way to an instant come before what is seen there
        return cls(first[order], last[order], np.concatenate([turns, seen])[order])


@compiled
def tie(arcs: Array, ties: Ties) -> int:
    """Narrow (2, k) centres and bounds of arcs in place, as far as ties do; return the first tie that leaves nothing, or -1."""
    count = len(ties.first)
    for lap in range(LAPS + arcs.shape[1]):
        narrowed = 0
        for k in range(count):
            which = k if lap % 2 == 0 else count - 1 - k  # forth, and back
            gain = _tied(arcs, ties.first[which], ties.last[which], ties.turn[which])
            if gain < 0:
                return which
            narrowed += gain
        if not narrowed:
            break
    return -1


@compiled
def _tied(arcs: Array, first: int, last: int, turn: Array) -> int:
    """Narrow two arcs in place, the last one being the first, turned; return how many became narrower, -1 for to nothing."""
    narrowed = 0
    for whose, other, by in ((last, first, turn[0]), (first, last, -turn[0])):
        centre, bound = turned(arcs[0, other], arcs[1, other], by, turn[1])
        centre, bound = intersection(arcs[0, whose], arcs[1, whose], centre, bound)
        if bound < arcs[1, whose] - LEAST:
            arcs[0, whose], arcs[1, whose] = centre, bound
            narrowed += 1
        if bound < 0:
            return -1
    return narrowed
