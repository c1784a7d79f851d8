"""Hypotheses: what is known without each suspect, from instant to instant. What is proved to be empty cannot be."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from filter.diagnosis.told import Records, counted, signature, without
from filter.errors import Inconsistent
from filter.records.odometry import Odometry
from filter.sets.belief import Belief, Hypothesis, Used
from filter.sets.suspect import Suspect


@dataclass(frozen=True, eq=False)
class Strict:
    """What the strict filter does with a belief, and raises `Inconsistent` if that cannot be.

    Attributes:
        robots: How many there are.
        words: Says something with the names of the team.
        anywhere: Returns the belief in which a robot is anywhere, with any heading.
        predict: Returns the belief at a later time [s]; an error names what is in conflict.
        predicted: The same, with an error that says little, in less time.
        updated: Returns the belief after measurements, likewise.
        briefly: The same in less time, with regions larger by little, for instants before the last.
        named: Returns the error that names what is in conflict, of an update that has raised one.
    """

    robots: int
    words: Callable[[object], str]
    anywhere: Callable[[Belief, int], Belief]
    predict: Callable[[Belief, float, Odometry | None], Belief]
    predicted: Callable[[Belief, float, Odometry | None], Belief]
    updated: Callable[[Belief, Records], Belief]
    briefly: Callable[[Belief, Records], Belief]
    named: Callable[[Belief, Records, Inconsistent], Inconsistent]

    def wander(self, belief: Belief, time: float, odometry: Odometry | None, robots: Collection[int]) -> Belief:
        """Return the belief at a later time [s] if nothing is known of where some robots were, nor of how they moved."""
        others = odometry and odometry.without(set(robots))
        return self.elsewhere(self.predicted(self.elsewhere(belief, robots), time, others), robots)

    def elsewhere(self, belief: Belief, robots: Collection[int]) -> Belief:
        """Return the belief in which some robots are anywhere, with any heading."""
        for robot in sorted(robots):
            belief = self.anywhere(belief, robot)
        return belief


def moved_on(strict: Strict, each: Hypothesis, time: float, odometry: Odometry | None, *, is_early: bool) -> Hypothesis | None:
    """Return a hypothesis at a later time [s]; None if that cannot be."""
    try:
        return replace(each, belief=strict.predicted(each.belief, time, odometry))
    except Inconsistent:
        (suspect, *_) = each.suspects
        if not (is_early and suspect.kind == "past") or each.is_over:
            return None
    return replace(each, belief=strict.wander(each.belief, time, odometry, {suspect.who[1]}))


def merged(strict: Strict, each: Hypothesis, records: Records, *, is_early: bool) -> list[Hypothesis]:
    """Return a hypothesis after measurements of its time: one for each of its suspects that leave out others; none for none."""
    groups, left = dict[object, list[Suspect]](), dict[object, Records]()
    if each.is_over:
        belief = _merged(strict, each.belief, each.suspects[0], records, is_early=False)
        return [] if belief is None else [_further(each, belief, each.suspects, counted(each.used, records))]
    for suspect in each.suspects:
        some = without(suspect, records)
        groups.setdefault(signature(some), []).append(suspect)
        left[signature(some)] = some
    found = list[Hypothesis]()
    for case, suspects in groups.items():
        belief = _merged(strict, each.belief, suspects[0], left[case], is_early=is_early)
        if belief is not None:
            found.append(_further(each, belief, suspects, used_by(each.used, suspects[0], left[case])))
    return found


def _further(each: Hypothesis, belief: Belief, suspects: Sequence[Suspect], used: Used) -> Hypothesis:
    """Return a hypothesis after measurements, of those of its suspects that leave out the same."""
    return replace(each, suspects=tuple(suspects), belief=belief, used=used, agreed=each.agreed and belief.agrees)


def used_by(used: Used, suspect: Suspect, left: Records) -> Used:
    """Return who has said something that was merged, with what is left of one instant; exchanged markers are as they came."""
    return counted(used, without(suspect, left) if suspect.kind == "exchange" else left)


def as_told(each: Hypothesis) -> Used:
    """Return what a hypothesis has used of bodies by the names that were told: not what it took for another's."""
    (suspect, *_) = each.suspects
    if each.is_over or suspect.kind != "exchange":
        return each.used
    return {who: count for who, count in each.used.items() if who[2] not in suspect.who[1:]}


def right_again(strict: Strict, each: Hypothesis, suspects: Sequence[Suspect], records: Records) -> list[Hypothesis]:
    """Return what is known if some of a hypothesis were wrong and are right by now; none if what they say now leaves nothing.

    Args:
        strict: What the strict filter does.
        each: The hypothesis, after the measurements that it has not left out.
        suspects: Who is right again; none, and nothing is.
        records: All measurements of its time.
    """
    belief: Belief | None = each.belief
    if suspects and signature(without(suspects[0], records)) != signature(records):
        belief = _merged(strict, each.belief, suspects[0], records, is_early=False)
    if belief is None or not suspects:
        return []
    return [replace(_further(each, belief, suspects, as_told(each)), is_over=True)]


def _merged(strict: Strict, belief: Belief, suspect: Suspect, records: Records, *, is_early: bool) -> Belief | None:
    try:
        return strict.updated(belief, records)
    except Inconsistent:
        if not (is_early and suspect.kind == "past"):
            return None
    try:
        return strict.updated(strict.anywhere(belief, suspect.who[1]), records)
    except Inconsistent:
        return None
