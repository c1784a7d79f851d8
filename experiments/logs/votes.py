"""Votes on the poses of a robot, as a certificate: which there are, and what is left without each of them.

A record has the robot; the slices that a window begins with, if one begins now; which votes are over, with the slices in which
one of these is wrong, and which are new; for each case the vote that is left out, the slices that it begins from, and what
these became; how far all slices reach then, and an arc around theirs; and the slices that are left of all if the window ends.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from experiments.logs.cases import case_record, slice_records
from experiments.logs.exactly import hexadecimal
from filter.poses.slices import AGREED, EARLIER
from filter.poses.votes import Polled

NAMES = {AGREED: "agreed", EARLIER: "earlier"}
SHARED, OWN = ("robot", "rows", "sources", "lower", "upper", "spacing"), ("roots", "pieces", "heading", "slices")  # of cases
Pair = tuple[int, int]


def vote_records(polled: Polled) -> Iterator[dict[str, Any]]:
    """Yield the certificate of each robot on which there are votes."""
    for robot in polled.polling.robots.tolist():
        cases = [(vote, case_record(case, polled.readings, {})) for vote, case in polled.cases(robot)]
        shared = {name: cases[0][1][name] for name in SHARED}
        arcs, (reach,) = polled.headings[np.array([robot])], polled.cast.slices.hulls(np.array([robot]))[1]
        around = {"heading": hexadecimal(np.append(arcs.centre, arcs.bound)), "reach": hexadecimal(reach)}
        own = [_case(polled, robot, *case) for case in cases]
        is_over = robot in polled.cast.slices.contradicted()
        ended = {"ended": slice_records(polled.left.of(robot)) if is_over else None}
        yield {**shared, **_votes(polled, robot), **around, **ended, "cases": own}


def _case(polled: Polled, robot: int, vote: int, record: dict[str, Any]) -> dict[str, Any]:
    """Return the record of a case, in which what its vote has said is left out."""
    left_out = _pair(polled, robot, vote)
    said = [source for source in record["said"] if (source["robot"], source["target"]) != left_out]
    return {"vote": NAMES.get(vote, left_out), "said": said, **{name: record[name] for name in OWN}}


def _votes(polled: Polled, robot: int) -> dict[str, Any]:
    """Return which votes on a robot are over, and which are new, in which window."""
    time, votes, before, now = polled.readings.ranges.time, polled.votes, polled.earlier.of(robot), polled.begun(robot)
    over, new = np.setdiff1d(before.vote[before.vote >= 0], now.vote), np.flatnonzero(votes.opened[robot] == time)
    is_over = len(over) or np.isin(new, before.vote).any()
    return {
        "begun": slice_records(now.select(now.vote == AGREED)) if votes.since[robot] == time else None,
        "earlier": slice_records(now.select(now.vote == EARLIER)) if is_over else None,
        "over": [_pair(polled, robot, vote) for vote in over.tolist()],
        "new": [_pair(polled, robot, vote) for vote in new.tolist()],
    }


def _pair(polled: Polled, robot: int, vote: int) -> Pair | None:
    """Return who saw whom in a vote; None if that is none."""
    return polled.votes.sightings(robot, [vote])[0] if vote >= 0 else None
