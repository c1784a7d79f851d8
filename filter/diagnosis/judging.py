"""The time of a doubt: hypotheses side by side, what is said of them together, and how it ends."""

from collections import Counter
from collections.abc import Sequence
from dataclasses import replace
from functools import reduce
from itertools import chain
from operator import and_

import numpy as np

from filter.arrays import Array
from filter.cameras.offsets import Offsets
from filter.diagnosis.cover import cover_of
from filter.diagnosis.evidence import EXCHANGED, FITS, is_enough, vouched_for
from filter.diagnosis.hypotheses import Found, Strict, as_told, merged, moved_on, right_again, says_who
from filter.diagnosis.replays import tried_again
from filter.diagnosis.starting_over import Wrong, assumption, more_is_wrong, new_trial, waiting
from filter.diagnosis.suspects import everybody, named_by
from filter.diagnosis.told import Records, signature, without, without_robots
from filter.errors import Inconsistent
from filter.linear.sources import Source
from filter.projection.fallback import Fallback
from filter.records.odometry import Odometry
from filter.sets.belief import Belief, Diagnosis, Event, Hypothesis, Moved, Tried
from filter.sets.suspect import Doubted, Judged, Passed, Suspect

RENEWED = 3  # for so many updates after a conflict the odometry of a robot may go on being wrong
NAMED_FIRST = ("sighting", "compass", "body", "exchange", "sensor", "past")  # of those who leave out the same this one is named


def in_doubt(strict: Strict, belief: Belief, records: Records, diagnosis: Diagnosis, conflict: tuple[Source, ...]) -> Belief:
    """Return what is known when a conflict is proved: whichever one of the suspects is wrong, since the oldest instant kept.

    Args:
        strict: What the strict filter does.
        belief: What was known, or predicted, before the measurements.
        records: These.
        diagnosis: With the last instants, this one among them.
        conflict: What is proved to exclude one another.
    """
    since = diagnosis.recent[0].before.time
    frames = [frame for each in diagnosis.recent for frame in each.frames]
    suspects = everybody(frames, set(range(strict.robots)) - belief.guarantee.away, strict.robots, since)
    alone = suspects if strict.each_alone else named_by(conflict, strict.robots, since)
    living, tried = _both(tried_again(strict, diagnosis.recent, suspects, alone))
    begun = replace(
        diagnosis,
        recent=(),
        hypotheses=living,
        conflict=conflict,
        since=since,
        metres=np.zeros(strict.robots),
        instants=0,
        by_proof=True,
        aside=tuple(new_trial(strict, trial.suspect, belief.time) for trial in diagnosis.aside),
        tried=tried,
    )
    if not living:
        if belief.time == frames[-1].time:
            return more_is_wrong(strict, belief, records, begun, Wrong(conflict))
        return more_is_wrong(strict, _elsewhere(strict, belief, frames[-1].time), (), begun, Wrong(conflict, everybody=True))
    return judged(strict, begun, (Doubted(living[0].belief.time, since, conflict, begun.suspects),))


def predicted(strict: Strict, belief: Belief, diagnosis: Diagnosis, time: float, odometry: Odometry | None) -> Belief:
    """Return what is known in a doubt at a later time [s]."""
    is_early = diagnosis.instants < RENEWED
    found = [moved_on(strict, each, time, odometry, is_early=is_early) for each in diagnosis.hypotheses]
    living = tuple(each for each in found if isinstance(each, Hypothesis))
    tried, metres = tuple(each for each in found if isinstance(each, Tried)), driven(diagnosis.metres, odometry, strict.robots)
    now = replace(diagnosis, hypotheses=living, metres=metres, tried=tried)
    if not living:
        later = _elsewhere(strict, belief, time)
        return more_is_wrong(strict, later, (), now, Wrong(diagnosis.suspects, everybody=True))
    cover = judged(strict, now, innocent(diagnosis, living, time), ends=False)
    return replace(cover, moved=Moved(replace(belief.alone, moved=None), odometry))


def updated(strict: Strict, belief: Belief, diagnosis: Diagnosis, records: Records) -> Belief:
    """Return what is known in a doubt after measurements of its time. Robots that start over are not listened to meanwhile."""
    heard = without_robots(waiting(diagnosis), records)
    is_early = diagnosis.instants < RENEWED
    found = chain.from_iterable(merged(strict, each, heard, belief, is_early=is_early) for each in diagnosis.hypotheses)
    living, tried = _both(tuple(found))
    now = replace(diagnosis, hypotheses=living, instants=diagnosis.instants + 1, tried=diagnosis.tried + tried)
    if not living:
        more: list[Suspect | Source] = [*diagnosis.suspects, *_conflicts(strict, diagnosis.hypotheses, heard)]
        return more_is_wrong(strict, belief, heard, now, Wrong(more))
    return judged(strict, now, innocent(diagnosis, living, belief.time), heard, cameras=belief.cameras)


def _both(found: Sequence[Found]) -> tuple[tuple[Hypothesis, ...], tuple[Tried, ...]]:
    """Return the hypotheses that can be, and what came of all."""
    return tuple(each for each, _ in found if each is not None), tuple(tried for _, tried in found)


def _conflicts(strict: Strict, hypotheses: Sequence[Hypothesis], records: Records) -> tuple[Source, ...]:
    """Return what excludes one another in any case that there was: what else is wrong now is among it."""
    found = dict[Source, None]()
    for each in hypotheses:
        cases = [records] if each.is_over else [without(suspect, records) for suspect in each.suspects]
        for left in {signature(some): some for some in cases}.values():
            try:
                strict.updated(each.belief, left)
            except Inconsistent as error:
                found |= dict.fromkeys(strict.named(each.belief, left, error).sources)
    return tuple(found)


def _elsewhere(strict: Strict, belief: Belief, time: float) -> Belief:
    """Return the belief at a later time [s] if every robot can be anywhere."""
    return strict.wander(belief, time, None, set(range(strict.robots)) - belief.guarantee.away)


def driven(before: Array | None, odometry: Odometry | None, robots: int) -> Array:
    """Return how far (n,) robots have driven [m]."""
    metres = np.zeros(robots) if before is None else before.copy()
    if odometry is not None:
        metres[odometry.robot] += np.abs(odometry.distance)
    return metres


def innocent(before: Diagnosis, living: Sequence[Hypothesis], time: float) -> tuple[Event, ...]:
    """Return that those are acquitted, by proof, who are no longer suspected."""
    left = {suspect for each in living for suspect in each.suspects}
    return tuple(Judged(time, suspect, "acquitted", "proof") for suspect in before.suspected if suspect not in left)


def judged(
    strict: Strict,
    diagnosis: Diagnosis,
    events: tuple[Event, ...],
    heard: Records = (),
    *,
    cameras: Offsets | None = None,
    ends: bool = True,
) -> Belief:
    """Return what is known in a doubt, or at the end of it if there is but one hypothesis left; by evidence, too."""
    found, freed = _acquitted(strict, diagnosis, heard, cameras) if ends else (diagnosis, ())
    living, time = found.hypotheses, found.hypotheses[0].belief.time
    events += tuple(Judged(time, suspect, "acquitted", "evidence") for suspect in freed)
    now = replace(found, by_proof=diagnosis.by_proof and not freed)
    if ends and len(living) == 1:
        return _settled(strict, now, events)
    cover = cover_of([each.belief for each in living])
    fallbacks = tuple(dict.fromkeys(event for each in living for event in each.belief.events if isinstance(event, Fallback)))
    guarantee = cover.guarantee.under(assumption(strict, now.since, now.suspects, now.aside))
    return replace(cover, guarantee=guarantee, events=events + fallbacks, diagnosis=now)


def _acquitted(
    strict: Strict, diagnosis: Diagnosis, heard: Records, cameras: Offsets | None = None
) -> tuple[Diagnosis, tuple[Suspect, ...]]:
    """Return a diagnosis, and who is acquitted, as another one has used what they say: they are listened to from now on.

    They can have been wrong when the doubt began: so what is known in that case stays, as one hypothesis of all who are right
    again. Where nothing would be left nobody is acquitted, as that is evidence against all.
    """
    metres = vouched_for(np.zeros(0) if diagnosis.metres is None else diagnosis.metres, cameras)
    freed = tuple(suspect for suspect in diagnosis.suspected if _agrees(suspect, diagnosis.hypotheses, metres))
    left, over, tried = list[Hypothesis](), [each for each in diagnosis.hypotheses if each.is_over], diagnosis.tried
    for each in diagnosis.hypotheses:
        if not each.is_over:
            right, wrong = ([one for one in each.suspects if (one in freed) == so] for so in (True, False))
            again, came = _both(right_again(strict, each, right, heard))
            over, tried = [*over, *again], tried + came
            left += [replace(each, suspects=tuple(wrong))] if wrong else []
    living = _left_alone(left, over) or (*left, *_joined(over))
    return (replace(diagnosis, hypotheses=living, tried=tried), freed) if living else (diagnosis, ())


def _agrees(suspect: Suspect, hypotheses: Sequence[Hypothesis], metres: Array) -> bool:
    """Return whether some hypothesis has used for long enough what a suspect says, and has tolerated no lie meanwhile.

    Besides, what it says has to fit what is known without it. One of an exchange may have used it as another's: then, too,
    whoever measured was right, though it does not fit. No other exchange is.
    """
    others = [each for each in hypotheses if each.agreed and (each.is_over or suspect not in each.suspects)]
    if suspect.kind == "exchange":
        return any(is_enough(suspect, as_told(each), metres) for each in others)
    if any(is_enough(suspect, each.used, metres, weight=EXCHANGED) for each in others if says_who(each)):
        return True
    fits = all(each.fits >= FITS for each in hypotheses if suspect in each.suspects and not each.is_over)
    return fits and any(is_enough(suspect, each.used, metres) for each in others)


def _joined(over: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Return one hypothesis of all who are right again; none of none."""
    if len(over) <= 1:
        return tuple(over)
    used = reduce(and_, (Counter(each.used) for each in over))
    suspects = tuple(chain.from_iterable(each.suspects for each in over))
    around, agreed = cover_of([each.belief for each in over]), all(each.agreed for each in over)
    names = tuple(each.name for each in over)
    return (Hypothesis(suspects, around, used, is_over=True, agreed=agreed, name=f"{names[0]}+", unites=names),)


def _left_alone(left: Sequence[Hypothesis], over: Sequence[Hypothesis]) -> tuple[Hypothesis, ...]:
    """Return all hypotheses as one, without what a sighting says, if that alone can be wrong still; else none.

    To go without it holds in each of them. In doubt it would stay for long, as one robot says little of one body.
    """
    suspects, some = [suspect for each in left for suspect in each.suspects], (*left, *over)
    if not over or [suspect.kind for suspect in suspects] != ["sighting"]:
        return ()
    around, names = cover_of([each.belief for each in some]), tuple(each.name for each in some)
    return (replace(left[0], belief=around, name=f"{names[0]}-", unites=names),)


def _settled(strict: Strict, diagnosis: Diagnosis, events: tuple[Event, ...]) -> Belief:
    """Return what is known when one hypothesis is left; who is guilty is put aside, if it can go on being wrong."""
    (last,) = diagnosis.hypotheses
    if last.is_over:
        guarantee = last.belief.guarantee.under(assumption(strict, 0.0, (), diagnosis.aside))
        end = Passed(last.belief.time, diagnosis.since, diagnosis.suspects)
        now = Diagnosis(aside=diagnosis.aside, suspended=diagnosis.suspended, tried=diagnosis.tried, left=last)
        return replace(last.belief, guarantee=guarantee, events=(*events, end, *last.belief.events), diagnosis=now)
    culprit = min(last.suspects, key=lambda suspect: (NAMED_FIRST.index(suspect.kind), suspect.who))
    culprit, implied = _by_all(culprit, [trial.suspect for trial in diagnosis.aside])
    verdict = Judged(last.belief.time, culprit, "guilty", "proof" if diagnosis.by_proof else "evidence")
    aside = tuple(trial for trial in diagnosis.aside if trial.suspect not in implied)
    if culprit.kind != "past":
        aside += (new_trial(strict, culprit, last.belief.time),)
    guarantee = last.belief.guarantee.under(assumption(strict, diagnosis.since, (), aside))
    now = Diagnosis(aside=aside, suspended=diagnosis.suspended, tried=diagnosis.tried, left=last)
    return replace(last.belief, guarantee=guarantee, events=(*events, verdict, *last.belief.events), diagnosis=now)


def _by_all(culprit: Suspect, aside: Sequence[Suspect]) -> tuple[Suspect, list[Suspect]]:
    """Return who else explains a wrong sighting and those before, of the same body or by the same robot; and these."""
    if culprit.kind == "sighting":
        of_body = [each for each in aside if each.kind == "sighting" and each.target == culprit.target]
        by_robot = [each for each in aside if each.kind == "sighting" and each.robot == culprit.robot]
        if of_body:
            return Suspect("body", None, culprit.target, min(each.since for each in (culprit, *of_body))), of_body
        if by_robot:
            return Suspect("sensor", culprit.robot, None, min(each.since for each in (culprit, *by_robot))), by_robot
    return culprit, []
