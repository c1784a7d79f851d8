"""Where nothing is in doubt: the strict filter's steps, what is kept of them, and trials of those who are not listened to."""

from dataclasses import replace

from filter.diagnosis.evidence import AGAIN, counted, is_enough, put_to_test
from filter.diagnosis.hypotheses import Strict
from filter.diagnosis.judging import driven, in_doubt
from filter.diagnosis.starting_over import assumption, confirmed, merged_apart, new_trial, waiting
from filter.diagnosis.told import Records, in_one_order, signature, without, without_all, without_robots
from filter.errors import Inconsistent
from filter.records.frame import Frame
from filter.records.odometry import Odometry
from filter.sets.belief import Belief, Diagnosis, Event, Recent, Trial
from filter.sets.suspect import Judged
from filter.sets.worth import are_smaller

MEMORY = 5  # so many instants are tried again after a conflict


def remembered(diagnosis: Diagnosis, before: Belief, frames: tuple[Frame, ...]) -> Diagnosis:
    """Return a diagnosis with what came at an instant, or at several at once, after what was known before."""
    last = Recent(replace(before.alone, moved=None), frames)
    return replace(diagnosis, recent=(*diagnosis.recent, last)[-MEMORY:], tried=(), left=None)


def _heard(diagnosis: Diagnosis, belief: Belief, records: Records) -> Diagnosis:
    """Return a diagnosis with what was measured at a belief's time: it belongs to the motion just before, if there was one."""
    if belief.moved is None or not diagnosis.recent:
        return remembered(diagnosis, belief, (Frame(belief.time, None, records),))
    last = diagnosis.recent[-1]
    return replace(
        diagnosis, recent=(*diagnosis.recent[:-1], replace(last, frames=(replace(last.frames[0], measurements=records),)))
    )


def predicted(
    strict: Strict, belief: Belief, diagnosis: Diagnosis, time: float, odometry: Odometry | None, *, raises: bool
) -> Belief:
    """Return the belief at a later time [s], and what may be in doubt then."""
    now = remembered(diagnosis, belief, (Frame(time, odometry),))
    try:
        later = strict.predict(belief.alone, time, odometry)
    except Inconsistent as error:
        if raises:
            raise
        return in_doubt(strict, belief, (), now, error.sources)
    aside = tuple(_moved(strict, trial, time, odometry) for trial in now.aside)
    suspended = tuple(replace(each, metres=driven(each.metres, odometry, strict.robots)) for each in now.suspended)
    return replace(later, diagnosis=replace(now, aside=aside, suspended=suspended))


def _moved(strict: Strict, trial: Trial, time: float, odometry: Odometry | None) -> Trial:
    driven_since = driven(trial.metres, odometry, strict.robots)
    try:
        later = trial.belief and strict.predicted(trial.belief, time, odometry)
    except Inconsistent:
        return new_trial(strict, trial.suspect, time)
    return replace(trial, belief=later, metres=driven_since)


def updated(strict: Strict, belief: Belief, diagnosis: Diagnosis, records: Records, *, raises: bool) -> Belief:
    """Return the belief after measurements of its time, and what may be in doubt then."""
    kept = without_all([trial.suspect for trial in diagnosis.aside], records)
    try:
        found, now, heard = merged_apart(strict, belief.alone, kept, diagnosis)
    except Inconsistent as error:
        ordered = without_robots(waiting(diagnosis), in_one_order(belief.time, kept))
        named = strict.named(belief.alone, ordered, error)
        if raises:
            raise named from None
        return in_doubt(strict, belief, ordered, _heard(diagnosis, belief, ordered), named.sources)
    now = _heard(now, belief, heard)
    if not (now.aside or now.suspended):
        return replace(found, diagnosis=now)
    return _looked_after(strict, (belief.alone, found), now, records)


def _looked_after(strict: Strict, beliefs: tuple[Belief, Belief], diagnosis: Diagnosis, records: Records) -> Belief:
    """Return what is known with those trusted again, and robots in force again, with whom all has agreed for long enough.

    Of the beliefs one is that before the records, the other that after those that are listened to.
    """
    before, found = beliefs
    belief, now, events = confirmed(found, diagnosis)
    left, trusted = list[Trial](), list[Event]()
    for trial in now.aside:
        others = [other.suspect for other in now.aside if other is not trial]
        tried = _tried(strict, (before, belief), trial, without_all(others, records))
        if is_enough(tried.suspect, tried.used, tried.metres, AGAIN):
            trusted.append(Judged(belief.time, trial.suspect, "trusted again", "evidence"))
        else:
            left.append(tried)
    guarantee = belief.guarantee.under(assumption(strict, 0.0, (), left))
    now = replace(now, aside=tuple(left))
    return replace(belief, guarantee=guarantee, events=(*events, *trusted, *belief.events), diagnosis=now)


def _tried(strict: Strict, beliefs: tuple[Belief, Belief], trial: Trial, records: Records) -> Trial:
    """Return a trial after measurements, its suspect's among them; where they do not agree it begins anew.

    It has a belief of its own only as long as that says more than what is known: from when its suspect speaks on.
    """
    before, belief = beliefs
    used = counted(trial.used, records, put_to_test(records, belief))
    if trial.belief is None and signature(without(trial.suspect, records)) == signature(records):
        return replace(trial, used=used)
    try:
        found = strict.updated(trial.belief or before, records)
    except Inconsistent:
        return new_trial(strict, trial.suspect, belief.time)
    if not found.agrees:
        return new_trial(strict, trial.suspect, belief.time)
    says_more = are_smaller(found.regions.outer.areas, belief.regions.outer.areas)
    return replace(trial, belief=found if says_more else None, used=used)
