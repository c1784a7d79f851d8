"""When measurements disagree: which to drop, so that the rest agree again. Never silently: each one is an event."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from filter.errors import Inconsistent
from filter.linear.sources import Source
from filter.measurements import Compass, Measurement, field_names
from filter.sensing.readings import KIND_OF
from filter.sets.belief import Belief, Rejected

TRIES = 64  # so many sets of measurements are tried before the search for the fewest is given up
NOTHING_TO_DROP = "no measurement of this update is in the conflict, to be dropped"

Merge = Callable[[tuple[Measurement, ...]], Belief]
Reading = tuple[int, int]  # of which record, in which place of it
Dropped = dict[Reading, Rejected]


def agreeing(merge: Merge, measurements: Sequence[Measurement]) -> Belief:
    """Merge measurements of one time but those that have to go for the rest to agree; the belief's events say which, and why.

    From then on its guarantee is suspended: that what was dropped is at fault is a guess. It can be what is left, and then
    everything that follows from it is wrong, too.

    The later in the sequence counts as the newer. Raises `Inconsistent` if a conflict has none of them in it.

    Algorithm:
        At least one measurement of every conflict has to go. So, breadth first, each of a conflict's measurements is
        dropped in its turn, the newest first, then each of the next conflict's that this leaves, until none is left
        (the hitting sets of Reiter, A theory of diagnosis from first principles, 1987). What is found first is the
        fewest of those that the conflicts name. Where so much is wrong that this takes too long, the newest of each
        conflict goes until the rest agree; then each is put back that need not have gone.
    """
    readings = single(measurements)

    def tried(dropped: Dropped) -> Belief | Inconsistent:
        try:
            belief = merge(without(measurements, dropped))
        except Inconsistent as error:
            return error
        events = tuple(dropped[reading] for reading in sorted(dropped))
        guarantee = belief.guarantee.suspended(belief.time, str(events[0])) if events else belief.guarantee
        return replace(belief, events=events + belief.events, guarantee=guarantee)

    waiting: deque[Dropped] = deque([{}])
    seen: set[frozenset[Reading]] = set()
    for _ in range(TRIES):
        dropped = waiting.popleft()
        found = tried(dropped)
        if isinstance(found, Belief):
            return found
        for reading, event in _candidates(readings, found, dropped).items():
            more = dropped | {reading: event}
            if frozenset(more) not in seen:
                seen.add(frozenset(more))
                waiting.append(more)
        if not waiting:
            raise Inconsistent(NOTHING_TO_DROP, found.sources) from found
    return _newest_first(tried, readings)


def single(measurements: Sequence[Measurement]) -> dict[Reading, Source]:
    """Return every single measurement, in order, as a source."""
    found = {}
    for k, record in enumerate(measurements):
        targets = [None] * len(record.robot) if isinstance(record, Compass) else record.target.tolist()
        for place, (robot, target) in enumerate(zip(record.robot.tolist(), targets, strict=True)):
            found[k, place] = Source(KIND_OF[type(record)], record.time, robot, target)
    return found


def without(measurements: Sequence[Measurement], dropped: Dropped) -> tuple[Measurement, ...]:
    """Return the records with some single measurements left out."""
    left = []
    for k, record in enumerate(measurements):
        keep = np.array([(k, place) not in dropped for place in range(len(record.robot))], dtype=bool)
        left.append(replace(record, **{name: getattr(record, name)[keep] for name in field_names(record)}))
    return tuple(left)


def _newest_first(tried: Callable[[Dropped], Belief | Inconsistent], readings: dict[Reading, Source]) -> Belief:
    """Drop the newest of each conflict until the rest agree, then put each back that need not have gone."""
    dropped: Dropped = {}
    while not isinstance(found := tried(dropped), Belief):
        candidates = _candidates(readings, found, dropped)
        if not candidates:
            raise Inconsistent(NOTHING_TO_DROP, found.sources) from found
        newest = next(iter(candidates))
        dropped = dropped | {newest: candidates[newest]}
    for reading in sorted(dropped):
        fewer = {other: event for other, event in dropped.items() if other != reading}
        again = tried(fewer)
        if isinstance(again, Belief):
            found, dropped = again, fewer
    return found


def _candidates(readings: dict[Reading, Source], conflict: Inconsistent, dropped: Dropped) -> Dropped:
    """Return what is left of the conflict's measurements, the newest first, and of the compasses that they rest on."""
    left = {reading: source for reading, source in reversed(readings.items()) if reading not in dropped}
    named = {reading: source for reading, source in left.items() if source in conflict.sources}
    rest_on = {source.robot for source in named.values() if source.kind != "compass"}
    compasses = {each: source for each, source in left.items() if source.kind == "compass" and source.robot in rest_on}
    return {reading: Rejected(source, conflict.sources) for reading, source in (named | compasses).items()}
