"""Hypotheses: what is known without each suspect, from instant to instant. What is proved to be empty cannot be."""

from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass, replace

from filter.diagnosis.evidence import counted, put_to_test
from filter.diagnosis.told import Records, signature, without
from filter.errors import Inconsistent
from filter.records.odometry import Odometry
from filter.sets.belief import Belief, Hypothesis, Tried, Used
from filter.sets.suspect import Suspect

Found = tuple[Hypothesis | None, Tried]  # a hypothesis, None if it cannot be, and what came of it


@dataclass(frozen=True, eq=False)
class Strict:
    """What the strict filter does with a belief, and raises `Inconsistent` if that cannot be.

    Attributes:
        robots: How many there are.
        each_alone: Whether each suspect is tried alone in a conflict, so that there is a proof of each.
        words: Says something with the names of the team.
        anywhere: Returns the belief in which a robot is anywhere, with any heading.
        predict: Returns the belief at a later time [s]; an error names what is in conflict.
        predicted: The same, with an error that says little, in less time.
        updated: Returns the belief after measurements, likewise.
        briefly: The same in less time, with regions larger by little, for instants before the last.
        named: Returns the error that names what is in conflict, of an update that has raised one.
    """

    robots: int
    each_alone: bool
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


def moved_on(strict: Strict, each: Hypothesis, time: float, odometry: Odometry | None, *, is_early: bool) -> Hypothesis | Tried:
    """Return a hypothesis at a later time [s]; why not, if that cannot be."""
    (suspect, *_), each = each.suspects, replace(each, unites=(), anew=frozenset())
    try:
        return replace(each, belief=strict.predicted(each.belief, time, odometry))
    except Inconsistent as error:
        if not (is_early and suspect.kind == "past") or each.is_over:
            return Tried(each.name, each.name, each.suspects, (), end=(time, error.evidence))
    lost = frozenset({suspect.who[1]})
    return replace(each, belief=strict.wander(each.belief, time, odometry, lost), anew=lost)


def merged(strict: Strict, each: Hypothesis, records: Records, known: Belief, *, is_early: bool) -> list[Found]:
    """Return a hypothesis after measurements and what came of it, for each of its suspects that leave out others.

    What is known in all cases tells which of the measurements are tests.
    """
    groups, left = dict[object, list[Suspect]](), dict[object, Records]()
    for suspect in each.suspects:
        some = records if each.is_over else without(suspect, records)
        groups.setdefault(signature(some), []).append(suspect)
        left[signature(some)] = some
    found = list[Found]()
    for number, (case, suspects) in enumerate(groups.items(), 1):
        name = each.name if len(groups) == 1 else f"{each.name}.{number}"
        begun = Tried(name, each.name, tuple(suspects), (), each.anew)
        tried = _merged(strict, begun, each.belief, left[case], is_early=is_early and not each.is_over)
        used = used_by(each, suspects[0], left[case], known)
        fits = each.fits + 1 if _fits(strict, each, left[case], records) else 0
        found.append(_further(replace(each, fits=fits), tried, used))
    return found


def _fits(strict: Strict, each: Hypothesis, left: Records, records: Records) -> bool:
    """Return whether all records of an instant fit what a hypothesis knows, with those that it leaves out."""
    if says_who(each) or signature(left) == signature(records):
        return True
    try:
        strict.updated(each.belief, records)
    except Inconsistent:
        return False
    return True


def _further(each: Hypothesis, tried: Tried, used: Used) -> Found:
    """Return a hypothesis after what came of it, if it can be, and that."""
    if tried.end:
        return None, tried
    belief, *_ = (*tried.beliefs, each.belief)
    agreed = each.agreed and belief.agrees
    return Hypothesis(tried.suspects, belief, used, each.is_over, agreed, each.fits, tried.name), tried


def used_by(each: Hypothesis, suspect: Suspect, left: Records, known: Belief) -> Used:
    """Return who has said something that was merged, with what is left of one instant; exchanged markers are as they came."""
    if says_who(each):
        return counted(each.used, without(suspect, left), ())
    return counted(each.used, left, put_to_test(left, known))


def says_who(each: Hypothesis) -> bool:
    """Return whether a hypothesis says of two markers that each is the other."""
    return each.suspects[0].kind == "exchange" and not each.is_over


def as_told(each: Hypothesis) -> Used:
    """Return what a hypothesis has used of bodies by the names that were told: not what it took for another's."""
    if not says_who(each):
        return each.used
    (suspect, *_) = each.suspects
    return {who: count for who, count in each.used.items() if who[2] not in suspect.who[1:]}


def right_again(strict: Strict, each: Hypothesis, suspects: Sequence[Suspect], records: Records) -> list[Found]:
    """Return what is known if some of a hypothesis were wrong and are right by now, if that can be, and what came of it.

    Args:
        strict: What the strict filter does.
        each: The hypothesis, after the measurements that it has not left out.
        suspects: Who is right again; none, and nothing is.
        records: All measurements of its time.
    """
    if not suspects:
        return []
    # Those that are left of it have a name of their own, and are fewer each time.
    tried = Tried(f"{each.name}+{len(each.suspects)}", each.name, tuple(suspects), (), is_again=True)
    if signature(without(suspects[0], records)) != signature(records):
        tried = _merged(strict, tried, each.belief, records, is_early=False)
    return [_further(replace(each, is_over=True), tried, as_told(each))]


def _merged(strict: Strict, tried: Tried, belief: Belief, records: Records, *, is_early: bool) -> Tried:
    """Return what comes of records where a belief holds, if a past may be wrong still from that of a robot anywhere."""
    found, suspect = _after(strict, tried, belief, records), tried.suspects[0]
    if not (found.end and is_early and suspect.kind == "past"):
        return found
    lost = replace(tried, anew=frozenset({suspect.who[1]}))
    return _after(strict, lost, strict.anywhere(belief, suspect.who[1]), records)


def _after(strict: Strict, tried: Tried, belief: Belief, records: Records) -> Tried:
    try:
        return replace(tried, beliefs=(strict.updated(belief, records),))
    except Inconsistent as error:
        return replace(tried, end=(belief.time, error.evidence))
