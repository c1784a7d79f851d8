"""Robots whose votes, with odometry, take them out of the arena: a bound was broken before, and it is told."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from filter.arrays import Array
from filter.linear.sources import Source
from filter.robust.belief import Disagreement, Restarted, RobustBelief, RobustEvent
from filter.robust.hypotheses import AGREED, EARLIER, Hypotheses
from filter.robust.votes import Poll, Rules


def without_those_who_left(belief: RobustBelief, rules: Rules, cells: int, anywhere: Array) -> RobustBelief:
    """Return a belief in which something agrees with every vote on each robot, after its slices were cut by the arena.

    Where only slices are left that do without a vote, one of these is proved wrong, and a new window begins. Where nothing is
    left, the robot starts over.

    Args:
        belief: After a move; slices outside the arena are gone.
        rules: What is assumed of wrong votes.
        cells: How many slices a full circle of headings has.
        anywhere: Where a robot can be that starts over: supports (COUNT,) [m].
    """
    astray = [robot for robot, known in enumerate(belief.sets) if not (known.without == AGREED).any()]
    if not astray:
        return belief
    poll, events = Poll(belief.sets, belief.votes, belief.time, rules, cells), list[RobustEvent]()
    doubtful, suspended, disputed = (times.copy() for times in (belief.doubtful_since, belief.suspended, belief.disputed))
    for robot in astray:
        disputed[robot] = belief.time
        if len(belief.sets[robot]):
            events.append(Disagreement(belief.time, robot, _suspects(belief, robot)))
            poll.renew(robot, belief.sets[robot])
        else:
            since = min(float(doubtful[robot]), belief.time)
            events.append(Restarted(belief.time, robot, since, "as odometry says, it has left the arena"))
            poll.restart(robot, Hypotheses.agreed(anywhere))
            doubtful[robot], suspended[robot] = np.inf, belief.time
    after = replace(belief, sets=tuple(poll.sets), votes=poll.votes, events=(*belief.events, *events))
    return replace(after, doubtful_since=doubtful, suspended=suspended, disputed=disputed)


def _suspects(belief: RobustBelief, robot: int) -> tuple[Source, ...]:
    """Return the odometry, and the votes without which a robot would still be in the arena."""
    columns = np.unique(belief.sets[robot].without)
    votes = [belief.votes.source(belief.time, robot, column) for column in columns.tolist() if column != EARLIER]
    return (*votes, Source("odometry", belief.time, robot))
