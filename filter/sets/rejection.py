"""When measurements disagree: which to drop, so that the rest agree again. Never silently: each one is an event."""

from collections import deque
from collections.abc import Callable, Sequence
from dataclasses import replace

from filter.errors import Inconsistent
from filter.records.measurements import Measurement
from filter.sets.belief import Belief, Rejected
from filter.sets.conflict import Conflict, Premises, Reading, conflict_of, single, without

CONFLICTS, SETS = 64, 4096  # after so many conflicts, or sets of measurements to drop, the search for the fewest is given up
NOTHING_TO_DROP = "no measurement of this update is in the conflict, to be dropped"

Merge = Callable[[tuple[Measurement, ...]], Belief]
Dropped = dict[Reading, Rejected]


def agreeing(merge: Merge, measurements: tuple[Measurement, ...], cases: Sequence[Premises]) -> Belief:
    """Merge measurements of one time but those that have to go for the rest to agree; the belief's events say which, and why.

    From then on its guarantee is suspended: that what was dropped is at fault is a guess. It can be what is left, and then
    everything that follows from it is wrong, too.

    The later in the sequence counts as the newer. Raises `Inconsistent` if a conflict has none of them in it.

    Algorithm:
        At least one measurement of every conflict has to go. So, breadth first, each of a conflict's measurements is
        dropped in its turn, the newest first, then each of the next conflict's that this leaves, until none is left
        (the hitting sets of Reiter, A theory of diagnosis from first principles, 1987). As no conflict names more than it
        needs, what is found first is the fewest. Where so much is wrong that this takes too long, the newest of each conflict
        goes until the rest agree; then each is put back that need not have gone.
    """
    readings, conflicts = single(measurements), list[Conflict]()

    def tried(dropped: Dropped) -> Belief | Conflict:
        for conflict in conflicts:
            if not conflict.readings & dropped.keys():
                return conflict
        try:
            belief = merge(without(measurements, dropped))
        except Inconsistent as error:
            conflicts.append(conflict_of(error, cases, dropped))
            if not conflicts[-1].readings:
                raise Inconsistent(NOTHING_TO_DROP, conflicts[-1].sources) from None
            return conflicts[-1]
        events = tuple(dropped[reading] for reading in sorted(dropped))
        guarantee = belief.guarantee.suspended(belief.time, cases[0].team.words(events[0])) if events else belief.guarantee
        return replace(belief, events=events + belief.events, guarantee=guarantee)

    def candidates(conflict: Conflict) -> Dropped:
        newest_first = sorted(conflict.readings, reverse=True)
        return {reading: Rejected(readings[reading], conflict.sources) for reading in newest_first}

    waiting: deque[Dropped] = deque([{}])
    seen: set[frozenset[Reading]] = set()
    while len(conflicts) < CONFLICTS and len(seen) < SETS:
        dropped = waiting.popleft()
        found = tried(dropped)
        if isinstance(found, Belief):
            return found
        for reading, event in candidates(found).items():
            more = dropped | {reading: event}
            if frozenset(more) not in seen:
                seen.add(frozenset(more))
                waiting.append(more)
    return _newest_first(tried, candidates)


def _newest_first(tried: Callable[[Dropped], Belief | Conflict], candidates: Callable[[Conflict], Dropped]) -> Belief:
    """Drop the newest of each conflict until the rest agree, then put each back that need not have gone."""
    dropped: Dropped = {}
    while not isinstance(found := tried(dropped), Belief):
        (newest, event), *_ = candidates(found).items()
        dropped = dropped | {newest: event}
    for reading in sorted(dropped):
        fewer = {other: event for other, event in dropped.items() if other != reading}
        again = tried(fewer)
        if isinstance(again, Belief):
            found, dropped = again, fewer
    return found
