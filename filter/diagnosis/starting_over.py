"""Where more than one thing is wrong: robots start over from anywhere, and are not relied on until all has agreed for long."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from filter.diagnosis.evidence import counted, is_enough, put_to_test
from filter.diagnosis.hypotheses import Strict
from filter.diagnosis.told import Records, without_robots, without_ties
from filter.errors import Inconsistent
from filter.linear.sources import Source
from filter.sets.belief import Belief, Diagnosis, Event, Trial
from filter.sets.suspect import Confirmed, StartsOver, Suspect


class Wrong(NamedTuple):
    """More is wrong than one of some, suspects or parts of a conflict."""

    than: Sequence[Suspect | Source]
    everybody: bool = False

    def robots(self, count: int) -> set[int]:
        """Return the robots, of so many, that this can be of."""
        if self.everybody:
            return set(range(count))
        return {body for each in self.than for body in (each.robot, each.target) if body is not None and body < count}


def waiting(diagnosis: Diagnosis) -> frozenset[int]:
    """Return the robots that have started over and are not in force again."""
    return frozenset(trial.suspect.who[1] for trial in diagnosis.suspended)


def more_is_wrong(strict: Strict, belief: Belief, records: Records, diagnosis: Diagnosis, more: Wrong) -> Belief:
    """Return what is known if not one thing alone can be wrong: the robots that this can be of start over, if need be all.

    Robots that start over are apart from all others, also from one another: what ties them can be what is wrong, and a robot
    that can be anywhere has nothing to hold against it. To those that have started over before nobody listens just now.
    """
    there = set(range(strict.robots)) - belief.guarantee.away
    for some in (more.robots(strict.robots) & there or there, there):
        now = Diagnosis(aside=diagnosis.aside, suspended=_starting(strict, belief.time, diagnosis, some))
        apart = without_ties(waiting(now), strict.robots, records)
        for unheard in (waiting(diagnosis), waiting(now)):
            try:
                found = strict.updated(_without_pasts(strict, belief, some), without_robots(unheard, apart))
            except Inconsistent:
                continue
            event = StartsOver(belief.time, tuple(sorted(some)), tuple(more.than), tuple(sorted(unheard)))
            guarantee = found.guarantee.suspended(belief.time, event.because(strict.words), some)
            guarantee = guarantee.under(assumption(strict, 0.0, (), now.aside))
            return replace(found, guarantee=guarantee, events=(event, *found.events), diagnosis=now)
    raise Inconsistent(f"at {belief.time} s, without any measurement", ())


def _without_pasts(strict: Strict, belief: Belief, robots: set[int]) -> Belief:
    """Return a belief in which some robots are anywhere, from what it was predicted from, if that is known.

    In a doubt that is what was said last, which is proved in each case; of what is said of predictions nothing is.
    """
    if belief.moved is None:
        return strict.elsewhere(belief.alone, robots)
    return strict.wander(belief.moved.before, belief.time, belief.moved.odometry, robots)


def suspended(strict: Strict, belief: Belief, robots: Mapping[int, float], because: str) -> Belief:
    """Return a belief in which robots start over, each with its guarantee suspended since a time [s], for other reasons.

    That is outside a doubt, and what came before is not tried again, as these robots were believed in it.
    """
    before = belief.diagnosis or Diagnosis()
    aside = tuple(replace(trial, belief=None) for trial in before.aside)
    now = replace(before, recent=(), aside=aside, suspended=_starting(strict, belief.time, before, set(robots)))
    found = strict.elsewhere(belief.alone, robots)
    guarantee = found.guarantee
    for robot, since in robots.items():
        guarantee = guarantee.suspended(since, because, {robot})
    return replace(found, guarantee=guarantee, diagnosis=now)


def new_trial(strict: Strict, suspect: Suspect, time: float) -> Trial:
    """Return a trial that begins at a time [s]."""
    return Trial(suspect, time, None, {}, np.zeros(strict.robots))


def _starting(strict: Strict, time: float, diagnosis: Diagnosis, robots: set[int]) -> tuple[Trial, ...]:
    """Return the trials of all robots that start over, some of them now."""
    before = [trial for trial in diagnosis.suspended if trial.suspect.who[1] not in robots]
    return (*before, *(new_trial(strict, Suspect("past", robot, None, time), time) for robot in sorted(robots)))


def merged_apart(strict: Strict, belief: Belief, records: Records, diagnosis: Diagnosis) -> tuple[Belief, Diagnosis, Records]:
    """Return what is known after measurements, apart for robots that start over; how far these have got, and what was heard.

    If they are in conflict they start over once more, which is an event. Raises `Inconsistent` if the others are.
    """
    robots = waiting(diagnosis)
    if not robots:
        return strict.updated(belief, records), diagnosis, records
    heard = without_ties(robots, strict.robots, records)
    try:
        found = strict.updated(belief, heard)
        return found, _further(diagnosis, heard, belief) if found.agrees else _again(diagnosis, belief.time), heard
    except Inconsistent as error:
        conflict, heard = error.sources, without_robots(robots, heard)
    there = robots - belief.guarantee.away
    found = strict.updated(strict.elsewhere(belief.alone, there), heard)
    event = StartsOver(belief.time, tuple(sorted(there)), conflict, tuple(sorted(robots)))
    return replace(found, events=(event, *found.events)), _again(diagnosis, belief.time), heard


def _again(diagnosis: Diagnosis, time: float) -> Diagnosis:
    """Return a diagnosis in which all has to agree anew, from a time on [s]."""
    begun = tuple(replace(trial, since=time, used={}, metres=0 * trial.metres) for trial in diagnosis.suspended)
    return replace(diagnosis, suspended=begun)


def _further(diagnosis: Diagnosis, records: Records, known: Belief) -> Diagnosis:
    tests = put_to_test(records, known)
    trials = tuple(replace(trial, used=counted(trial.used, records, tests)) for trial in diagnosis.suspended)
    return replace(diagnosis, suspended=trials)


def confirmed(belief: Belief, diagnosis: Diagnosis) -> tuple[Belief, Diagnosis, tuple[Event, ...]]:
    """Return the same with those robots in force again that have agreed with all else for long enough, and which these are."""
    good = [trial for trial in diagnosis.suspended if is_enough(trial.suspect, trial.used, trial.metres)]
    guarantee = belief.guarantee
    for trial in good:
        guarantee = guarantee.restored(trial.suspect.who[1])
    waiting = tuple(trial for trial in diagnosis.suspended if trial not in good)
    events = tuple(Confirmed(belief.time, trial.suspect.who[1]) for trial in good)
    return replace(belief, guarantee=guarantee), replace(diagnosis, suspended=waiting), events


def assumption(strict: Strict, since: float, suspects: Sequence[Suspect], aside: Sequence[Trial]) -> str:
    """Return what is assumed while one of some suspects is wrong, and others are not listened to."""
    known, one = "; ".join(strict.words(trial.suspect) for trial in aside), "; ".join(map(strict.words, suspects))
    if not suspects:
        return f"if nothing is wrong but: {known}" if known else ""
    return f"if only one of these is wrong since {since:.3f} s: {one}" + (f"; besides: {known}" if known else "")
