"""The last instants, tried again without each suspect, or without many at once: most of them can be excluded together."""

from collections.abc import Collection, Iterable, Sequence
from dataclasses import replace

from filter.diagnosis.hypotheses import Found, Strict
from filter.diagnosis.told import Records, Who, signature, without, without_all
from filter.errors import Inconsistent
from filter.records.frame import Frame
from filter.sets.belief import Belief, Hypothesis, Recent, Tried
from filter.sets.suspect import Suspect

# Who leaves out more comes first.
TRIED_FIRST = ("past", "compass", "sensor", "body", "exchange", "sighting")
# Sightings are implied; and where there is no arena, robots that are anywhere one after the other get too far to count with.
ALONE = ("past", "sighting")


def tried_again(
    strict: Strict, recent: Sequence[Recent], suspects: Sequence[Suspect], alone: Collection[Suspect]
) -> tuple[Found, ...]:
    """Return what is known after the last instants if one of the suspects is wrong, in each case, and what came of it.

    Args:
        strict: What the strict filter does.
        recent: The last instants.
        suspects: Who can be wrong.
        alone: Whoever is tried alone: those who have a part in the conflict itself, as one of these it is, most often; or
            all, as of those who are tried together nothing is told.

    Algorithm:
        Whoever leaves out less than what leaves a contradiction leaves one, too: each of many who leave one together, and a
        sighting, of its sensor or its body. Those who leave out the same are one hypothesis.
    """
    before, frames = recent[0].before, [frame for each in recent for frame in each.frames]
    ordered = sorted(suspects, key=lambda each: (TRIED_FIRST.index(each.kind), each.who))
    others = [each for each in ordered if each not in alone and each.kind not in ALONE]
    dead = {each.who for each in others} - {each.who for each in _not_excluded(strict, before, frames, others)}
    cases, known = dict[object, list[Suspect]](), dict[object, Tried]()
    for suspect in ordered:
        if suspect.who in dead or _is_implied(suspect, dead):
            continue
        left = _leavings(suspect, frames)
        case = suspect.who if suspect.kind == "past" else tuple(map(signature, left))
        if case not in known:
            known[case] = _replayed(strict, before, frames, left, suspect.who[1] if suspect.kind == "past" else None)
        if known[case].end:
            dead.add(suspect.who)
        cases.setdefault(case, []).append(suspect)
    numbered = enumerate(cases.items(), 1)
    return tuple(_begun(replace(known[case], name=str(number), suspects=tuple(some))) for number, (case, some) in numbered)


def _begun(tried: Tried) -> Found:
    """Return the hypothesis after some instants, if it can be, and what came of it."""
    if tried.end:
        return None, tried
    belief = tried.beliefs[-1]
    return Hypothesis(tried.suspects, belief, agreed=belief.agrees, name=tried.name), tried


def _not_excluded(strict: Strict, before: Belief, frames: Sequence[Frame], suspects: Sequence[Suspect]) -> list[Suspect]:
    """Return those of some suspects who are not excluded with others: without all of them there is no contradiction."""
    if len(suspects) <= 1:
        return list(suspects)
    left = [_without_them(suspects, tuple(frame.measurements)) for frame in frames]
    if _replayed(strict, before, frames, left).end:
        return []
    half = len(suspects) // 2
    return [one for some in (suspects[:half], suspects[half:]) for one in _not_excluded(strict, before, frames, some)]


def _is_implied(suspect: Suspect, dead: Collection[Who]) -> bool:
    """Return whether a suspect leaves out less than one of those who leave a contradiction."""
    return suspect.kind == "sighting" and bool({("sensor", suspect.who[1], -1), ("body", -1, suspect.who[2])} & set(dead))


def _leavings(suspect: Suspect, frames: Sequence[Frame]) -> list[Records]:
    """Return what is left of the records of each instant; an exchange is there at the last one, and nobody knows since when."""
    *earlier, last = (tuple(frame.measurements) for frame in frames)
    return [*(_without_them([suspect], records) for records in earlier), without(suspect, last)]


def _without_them(suspects: Iterable[Suspect], records: Records) -> Records:
    """Return what is left without all that suspects have said, and without all that was read of those who are exchanged."""
    for suspect in suspects:
        both = [Suspect("body", None, robot) for robot in suspect.who[1:]]
        records = without_all(both if suspect.kind == "exchange" else [suspect], records)
    return records


def _replayed(
    strict: Strict, before: Belief, frames: Sequence[Frame], left: Sequence[Records], wandering: int | None = None
) -> Tried:
    """Return what comes of instants of which so much is left, with a robot anywhere in each."""
    belief, found = before, list[Belief]()
    for frame, records in zip(frames, left, strict=True):
        try:
            if wandering is not None:
                belief = strict.wander(belief, frame.time, frame.odometry, {wandering})
            elif frame.time != belief.time or frame.odometry is not None:
                belief = strict.predicted(belief, frame.time, frame.odometry)
            belief = (strict.updated if frame is frames[-1] else strict.briefly)(belief, records)
        except Inconsistent as error:
            return Tried("", "", (), tuple(found), end=(frame.time, error.evidence))
        found.append(belief)
    return Tried("", "", (), tuple(found))
