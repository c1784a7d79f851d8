"""Votes on the poses of a robot, one of which may be wrong in a window. Exact arithmetic, standard library only.

A vote is a pair: who has seen whom for a while; the robot is one of them. Its pose is in a slice that all agree on if no vote
of the window is wrong; in one without a vote if that one is; in an earlier one if that is a vote that is over.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, NamedTuple

from experiments.proof.cases.cells import check_cases, places_in
from experiments.proof.cases.slices import Slice, TakenAlong, are_around, are_within, slices_in
from experiments.proof.exact import KEPT, Arc, are_apart, below, claimed, in_common
from experiments.proof.measured import Instant
from experiments.proof.reading import Broken, Record, exact, shown
from experiments.proof.sides import looking

AGREED, EARLIER, ENDED = "agreed", "earlier", "ended"
Vote = tuple[int, int]
NOTHING = TakenAlong({}, 0)
Now = Callable[[TakenAlong], Sequence[Slice]]  # slices as they are now


@dataclass(frozen=True)
class Poll:
    """What is claimed of a robot's pose in a window in which one vote on it may be wrong.

    Attributes:
        since: When the window began [s].
        opened: When each vote began that is not over [s].
        told: The slices without each vote, if all agree, and if the wrong one is over.
    """

    since: float
    opened: Mapping[Vote, float]
    told: Mapping[Vote | str, TakenAlong]

    @classmethod
    def of(cls, since: float, told: TakenAlong) -> Poll:
        """Return one in which all agree."""
        return cls(since, {}, {AGREED: told, EARLIER: NOTHING})


class Polls(NamedTuple):
    """What is claimed of a robot's pose before votes, in their window, as they begin, as they are cast, and afterwards."""

    before: Poll | None
    window: Poll
    begun: Poll
    cast: Poll
    left: Poll

    @classmethod
    def of(cls, line: Record, before: Poll | None, time: float, frame: int) -> Polls:
        """Return what a line claims at a frame, by its time [s] and number.

        Raises:
            Broken: There is no window, or nothing is claimed of votes that are over.
        """
        window = before
        if line["begun"] is not None:
            window = Poll.of(time, TakenAlong(line, frame, "begun"))
        if window is None:
            raise Broken("no first window begins")
        told, opened = dict(window.told), dict(window.opened)
        for vote in _ended(line):
            opened.pop(vote, None)
            if not told.pop(vote, NOTHING).is_empty and line[EARLIER] is None:
                raise Broken(f"a vote that is over, and no earlier slices: {shown(vote)}")
        if line[EARLIER] is not None:
            told[EARLIER] = TakenAlong(line, frame, EARLIER)
        for vote in _votes(line["new"], line["robot"]):
            told[vote], opened[vote] = told[AGREED], time
        begun = Poll(window.since, opened, told)
        cut = {_label(case, line["robot"]): TakenAlong(case, frame) for case in line["cases"]}
        cast = replace(begun, told={**told, **cut})
        ended = Poll.of(window.since, TakenAlong(line, frame, ENDED))
        return cls(before, window, begun, cast, cast if line[ENDED] is None else ended)


@dataclass
class Windows:
    """How long windows were in which one vote may be wrong, and how long votes: what is said holds under that condition.

    Attributes:
        count: How many windows there were, of all robots.
        longest: The longest of them so far [s].
        longest_vote: The longest time between two sightings of one vote [s].
    """

    count: int = 0
    longest: float = 0.0
    longest_vote: float = 0.0

    def add(self, line: Record, poll: Poll, time: float) -> None:
        """Take in the votes of a line at a time [s]."""
        spoken = {(one["robot"], one["target"]) for case in line["cases"] for one in case["said"]}
        self.count += poll.since == time
        self.longest = max(self.longest, time - poll.since)
        self.longest_vote = max(self.longest_vote, *(time - poll.opened.get(vote, time) for vote in spoken), 0.0)

    def __str__(self) -> str:
        window, vote = (f"{each:.6g} s at most" for each in (self.longest, self.longest_vote))
        return f"that in a window, of {window}, no more than one vote on its robot is wrong, each of {vote}"


def check_votes(line: Record, then: Instant, polls: Polls, now: Now) -> None:
    """Check what a line claims of votes at an instant. Its boxes and rows have to be proved before.

    Raises:
        Broken: A case is missing, is left with less than can be, or uses what its vote has said; or nothing is left in any.
    """
    robot, looks = line["robot"], looking(then.frame, then.headings)[line["robot"]]

    def of(told: TakenAlong) -> list[Slice]:
        return [replace(each, arc=in_common(each.arc, [looks])) for each in now(told) if not are_apart(each.arc, looks)]

    if line["begun"] is not None:
        _look_at_window(
            line, looks, [each for told in polls.before.told.values() for each in of(told)] if polls.before else None
        )
    if line[EARLIER] is not None:
        over: list[Vote | str] = [EARLIER, *_ended(line)]
        _check_around([each for vote in over for each in of(polls.window.told.get(vote, NOTHING))], slices_in(line, EARLIER))
    for case in line["cases"]:
        _check_case({**line, **case, "claims": []}, then, polls.begun, of)
    heading, reach = claimed(*line["heading"]), [below(exact(far), KEPT) for far in line["reach"]]
    around = Slice(heading, reach)
    left = [each for told in polls.cast.told.values() for each in of(told)]
    if not left:
        raise Broken(f"nothing is left of the poses of robot {robot}: more than one vote on it is wrong")
    if line[ENDED] is not None:
        _check_around(left, slices_in(line, ENDED))
    if not all(around.holds(each) for each in left):
        raise Broken(f"robot {robot} can be elsewhere than what is claimed, in a slice without one of its votes")


def _look_at_window(line: Record, looks: Arc, before: Sequence[Slice] | None) -> None:
    """Raise `Broken` if a window begins with less than what was known before, or than all that is known if nothing was."""
    begun = slices_in(line, "begun")
    if before is not None:
        _check_around(before, begun)
    elif not are_around(begun, places_in(line)[line["robot"]], looks):
        raise Broken("a first window that begins with less than all that is known")


def _check_around(some: Sequence[Slice], slices: Sequence[Slice]) -> None:
    """Raise `Broken` if there are poses in some slices that are in none of others."""
    if not are_within(some, slices):
        raise Broken("slices that are less than those that were proved before, moved")


def _check_case(case: Record, then: Instant, begun: Poll, of: Now) -> None:
    """Check what is left in a case, which has to begin from all that is known, and not to use what its vote has said."""
    vote, roots = _label(case, case["robot"]), slices_in(case, "roots")
    if vote not in begun.told:
        raise Broken(f"a case without a vote that there is not: {shown(vote)}")
    for one in case["said"]:
        if (pair := (one["robot"], one["target"])) == vote or pair not in begun.opened:
            raise Broken(f"a case that uses what is left out in it, or what is said in no vote: {shown(pair)}")
    known = of(begun.told[vote])
    _check_around(known, roots)
    if known and check_cases(case, then, roots) is not None and not case["slices"]:
        raise Broken("no slices, where not every case is proved to be empty")


def _ended(line: Record) -> list[Vote]:
    """Return the votes that end, some of which begin again at once."""
    return [*_votes(line["over"], line["robot"]), *_votes(line["new"], line["robot"])]


def _label(case: Record, robot: int) -> Vote | str:
    """Return which vote a case does without, or that all agree in it, or that one is wrong that is over."""
    return case["vote"] if case["vote"] in (AGREED, EARLIER) else _votes([case["vote"]], robot)[0]


def _votes(told: Any, robot: int) -> list[Vote]:
    """Return votes on a robot, as a record says them."""
    pairs = told if isinstance(told, list) else [told]
    for pair in pairs:
        whole = isinstance(pair, list) and len(pair) == 2 and all(type(body) is int for body in pair)
        if not (whole and robot in pair):
            raise Broken(f"votes on robot {robot} were expected, pairs of who saw whom, not {shown(pair)}")
    return [(who, whom) for who, whom in pairs]
