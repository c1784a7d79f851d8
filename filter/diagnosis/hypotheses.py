"""Hypotheses: the last instants, and all that come, tried without each suspect. What is proved to be empty cannot be."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

from filter.diagnosis.told import Records, Who, counted, signature, without
from filter.errors import Inconsistent
from filter.records.frame import Frame
from filter.records.odometry import Odometry
from filter.sets.belief import Belief, Hypothesis, Recent, Tried, Used
from filter.sets.suspect import Suspect

TRIED_FIRST = (
    "past",
    "compass",
    "sensor",
    "body",
    "exchange",
    "sighting",
)  # who leaves out more comes first
Found = tuple[Hypothesis | None, Tried]  # a hypothesis, None if it cannot be, and what came of it


@dataclass(frozen=True, eq=False)
class Strict:
    """What the strict filter does with a belief, and raises `Inconsistent` if that cannot be.

    Attributes:
        robots: How many there are.
        suspects_all: Whether everybody is suspected in a conflict.
        words: Says something with the names of the team.
        anywhere: Returns the belief in which a robot is anywhere, with any heading.
        predict: Returns the belief at a later time [s]; an error names what is in conflict.
        predicted: The same, with an error that says little, in less time.
        updated: Returns the belief after measurements, likewise.
        briefly: The same in less time, with regions larger by little, for instants before the last.
        named: Returns the error that names what is in conflict, of an update that has raised one.
    """

    robots: int
    suspects_all: bool
    words: Callable[[object], str]
    anywhere: Callable[[Belief, int], Belief]
    predict: Callable[[Belief, float, Odometry | None], Belief]
    predicted: Callable[[Belief, float, Odometry | None], Belief]
    updated: Callable[[Belief, Records], Belief]
    briefly: Callable[[Belief, Records], Belief]
    named: Callable[[Belief, Records, Inconsistent], Inconsistent]

    def wanders(self, belief: Belief, time: float, odometry: Odometry | None, robot: int) -> Belief:
        """Return the belief at a later time [s] if nothing is known of where a robot was, nor of how it moved."""
        others = odometry and odometry.without({robot})
        return self.anywhere(self.predicted(self.anywhere(belief, robot), time, others), robot)


def tried_again(strict: Strict, recent: Sequence[Recent], suspects: Sequence[Suspect]) -> tuple[Found, ...]:
    """Return what is known after the last instants if one of the suspects is wrong, in each case, and what came of it.

    Algorithm:
        Whoever leaves out less than somebody without whom there is a contradiction leaves one, too: a sighting less than its
        sensor and its body. So these come first. Those who leave out the same are one hypothesis.
    """
    frames = [frame for each in recent for frame in each.frames]
    cases, known = dict[object, list[Suspect]](), dict[object, Found]()
    dead = set[Who]()
    for suspect in sorted(suspects, key=lambda each: (TRIED_FIRST.index(each.kind), each.who)):
        if suspect.kind == "sighting" and dead & {("sensor", suspect.who[1], -1), ("body", -1, suspect.who[2])}:
            continue
        left = _leavings(suspect, [tuple(frame.measurements) for frame in frames])
        case = suspect.who if suspect.kind == "past" else tuple(map(signature, left))
        if case not in known:
            known[case] = _replayed(strict, recent[0].before, suspect, frames, left)
        if known[case][0] is None:
            dead.add(suspect.who)
        cases.setdefault(case, []).append(suspect)
    return tuple(_named(str(number), tuple(some), *known[case]) for number, (case, some) in enumerate(cases.items(), 1))


def _named(name: str, suspects: tuple[Suspect, ...], found: Hypothesis | None, tried: Tried) -> Found:
    return found and replace(found, name=name, suspects=suspects), replace(tried, name=name, suspects=suspects)


def _leavings(suspect: Suspect, instants: Sequence[Records]) -> list[Records]:
    """Return what is left of the records of each instant; an exchange is there at the last one, and nobody knows since when."""
    if suspect.kind != "exchange":
        return [without(suspect, records) for records in instants]
    *before, last = instants
    return [*(_without_both(suspect, records) for records in before), without(suspect, last)]


def _without_both(suspect: Suspect, records: Records) -> Records:
    """Return what is left without all that was read of either of two robots."""
    for robot in suspect.who[1:]:
        records = without(Suspect("body", None, robot), records)
    return records


def _replayed(strict: Strict, before: Belief, suspect: Suspect, frames: Sequence[Frame], left: Sequence[Records]) -> Found:
    """Return what is known after some instants without a suspect, if that can be, and what came of it."""
    belief, found, robot = before, list[Belief](), suspect.who[1]
    for frame, records in zip(frames, left, strict=True):
        try:
            if suspect.kind == "past":
                belief = strict.wanders(belief, frame.time, frame.odometry, robot)
            elif frame.time != belief.time or frame.odometry is not None:
                belief = strict.predicted(belief, frame.time, frame.odometry)
            belief = (strict.updated if frame is frames[-1] else strict.briefly)(belief, records)
        except Inconsistent as error:
            return None, Tried("", "", (suspect,), tuple(found), end=(frame.time, error.evidence))
        found.append(belief)
    return Hypothesis((suspect,), belief, _counted({}, suspect, left[-1])), Tried("", "", (suspect,), tuple(found))


def moved_on(strict: Strict, each: Hypothesis, time: float, odometry: Odometry | None, *, is_early: bool) -> Hypothesis | Tried:
    """Return a hypothesis at a later time [s]; why not, if that cannot be."""
    (suspect, *_), each = each.suspects, replace(each, unites=(), anew=frozenset())
    try:
        return replace(each, belief=strict.predicted(each.belief, time, odometry))
    except Inconsistent as error:
        if not (is_early and suspect.kind == "past") or each.is_over:
            return Tried(each.name, each.name, each.suspects, (), end=(time, error.evidence))
    robot = suspect.who[1]
    return replace(each, belief=strict.wanders(each.belief, time, odometry, robot), anew=frozenset({robot}))


def merged(strict: Strict, each: Hypothesis, records: Records, *, is_early: bool) -> list[Found]:
    """Return a hypothesis after measurements and what came of it, for each of its suspects that leave out others."""
    groups, left = dict[object, list[Suspect]](), dict[object, Records]()
    for suspect in each.suspects:
        some = records if each.is_over else without(suspect, records)
        groups.setdefault(signature(some), []).append(suspect)
        left[signature(some)] = some
    found = list[Found]()
    for number, (case, suspects) in enumerate(groups.items(), 1):
        one = replace(each, suspects=tuple(suspects), name=each.name if len(groups) == 1 else f"{each.name}.{number}")
        found.append(_merged(strict, each.name, one, left[case], is_early=is_early and not each.is_over))
    return found


def _counted(used: Used, suspect: Suspect, left: Records) -> Used:
    """Return who has said something that was merged as it was told, with what is left of one instant."""
    return counted(used, _without_both(suspect, left) if suspect.kind == "exchange" else left)


def _merged(strict: Strict, parent: str, each: Hypothesis, records: Records, *, is_early: bool) -> Found:
    """Return a hypothesis after records, if that can be, and what came of it."""
    suspect, tried = each.suspects[0], Tried(each.name, parent, each.suspects, (), each.anew)
    used = counted(each.used, records) if each.is_over else _counted(each.used, suspect, records)
    now = replace(each, used=used, unites=(), anew=frozenset())
    try:
        belief = strict.updated(each.belief, records)
        return replace(now, belief=belief), replace(tried, beliefs=(belief,))
    except Inconsistent as error:
        if not (is_early and suspect.kind == "past"):
            return None, replace(tried, end=(each.belief.time, error.evidence))
    tried = replace(tried, anew=frozenset({suspect.who[1]}))
    try:
        belief = strict.updated(strict.anywhere(each.belief, suspect.who[1]), records)
        return replace(now, belief=belief), replace(tried, beliefs=(belief,))
    except Inconsistent as error:
        return None, replace(tried, end=(each.belief.time, error.evidence))
