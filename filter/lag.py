"""Records that come late, up to a fixed lag, are merged as if they had come in order. Any filter can."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Generic

from filter.arrays import Frozen, checked, function, instance, number, several
from filter.errors import InvalidInput, OutOfOrder
from filter.follow import AnyBelief, Filter, Step, a_filter, follow, time_of
from filter.motions import Motions
from filter.records.frame import Frame
from filter.records.measurements import MEASUREMENTS, Measurement
from filter.records.odometry import Odometry, Twist
from filter.team import Team


@dataclass(frozen=True)
class Mistimed:
    """Measurements were stamped too late or too far ahead: they are refused, or the filter starts over with them.

    Attributes:
        time: Of the newest before [s].
        stamp: Of the first of them [s].
        measurements: How many they are.
        restarted: Whether the filter starts over.
    """

    time: float
    stamp: float
    measurements: int
    restarted: bool

    def __str__(self) -> str:
        done = "the clock has jumped, all starts over" if self.restarted else "refused"
        return f"{self.measurements} measurements from {self.stamp:.3f} s on, after {self.time:.3f} s: {done}"


@dataclass(frozen=True, eq=False)
class Lagged(Generic[AnyBelief]):
    """What is known now, and the steps of the last seconds that it came from.

    Attributes:
        steps: From the oldest that is kept to the newest; the frame of each has the measurements that have come so far.
        motions: What odometry has told of the time since the oldest; None where a function tells of it.
        late: How many measurements came after newer ones and were merged all the same.
        refused: How many came too late, or too far ahead.
        events: What the last merge found mistimed.
        astray: Newest stamp of the last merge if it was refused as a whole [s].
    """

    steps: tuple[Step[AnyBelief], ...]
    motions: Motions | None = None
    late: int = 0
    refused: int = 0
    events: tuple[Mistimed, ...] = ()
    astray: float | None = None

    @cached_property
    def belief(self) -> AnyBelief:
        """What is known now; where such beliefs have events, those of the last merge are among them."""
        known: Any = self.steps[-1].belief
        return replace(known, events=(*known.events, *self.events)) if self.events and hasattr(known, "events") else known


@dataclass(frozen=True, eq=False)
class FixedLag(Frozen, Generic[AnyBelief]):
    """Merges records that are late by at most a fixed lag as if they had come in order; later ones are refused.

    So every record can be merged as it comes, a measurement before the odometry around it, too: until that has come, the robots
    have moved within their limits; then what was found since is found again.

    The result is that of the inner filter with the same measurements in order, bit for bit, if their order within one instant
    makes no difference to it. Raises `InvalidInput` if an attribute is of another type, or lag or gap negative or not finite.

    A stamp after too long a gap is refused, too, as it may be wrong; what is refused is told each time. If the next merge, and
    all of it, goes on from a stamp farther off than the gap, ahead or back, the clock has jumped: `restart` says what is known.

    Attributes:
        inner: The filter that does the work.
        motion: Returns the robots' motion from one time to another, both not before the oldest step, or None where nothing is
            known. Without such a function, odometry and twists are merged as they come (see `Motions`).
        lag: How late a measurement may be, from 0 on [s].
        gap: How long nothing may come before stamps are doubted, from 0 on [s].
        restart: Returns the belief at the time [s] that a clock has jumped to, from the one before; None to go on refusing.
    """

    inner: Filter[AnyBelief] = field(metadata=checked(a_filter, "a filter"))
    motion: Callable[[float, float], Odometry | None] | None = field(
        default=None, metadata=checked(function, "motion", optional=True)
    )
    lag: float = field(default=1.0, metadata=checked(number, "lag [s]", 0))
    gap: float = field(default=60.0, metadata=checked(number, "gap [s]", 0))
    restart: Callable[[AnyBelief, float], AnyBelief] | None = field(
        default=None, metadata=checked(function, "restart", optional=True)
    )

    def begin(self, belief: AnyBelief) -> Lagged[AnyBelief]:
        """Return a belief of the inner filter to which nothing has happened yet; `InvalidInput` if it has no time."""
        motions = None if self.motion else Motions(instance("a filter's team", getattr(self.inner, "team", None), Team))
        return Lagged((Step(Frame(time_of(belief)), belief, belief, 0.0),), motions)

    def merge(self, lagged: Lagged[AnyBelief], records: Sequence[Measurement | Odometry | Twist]) -> Lagged[AnyBelief]:
        """Return what is known after records of any times, in any order; what was known stays as it is.

        How late measurements are is counted from the newest that came before. Odometry tells of the time since the oldest step.
        Raises `InvalidInput` if something is no record, `OutOfOrder` for a twist from before the oldest step, and what the
        inner filter and `Motions.merged` raise; nothing has changed then.
        """
        instance("what is known (see begin)", lagged, Lagged)
        some = several("records", records, *MEASUREMENTS, Odometry, Twist)
        known = self._driven(lagged, [record for record in some if isinstance(record, Odometry | Twist)])
        measured = sorted((record for record in some if isinstance(record, MEASUREMENTS)), key=time_of)
        return self._measured(known, measured) if measured else known

    def _driven(self, lagged: Lagged[AnyBelief], told: Sequence[Odometry | Twist]) -> Lagged[AnyBelief]:
        """Return what is known after odometry: the steps that it reaches into are done again."""
        if not told:
            return lagged
        if lagged.motions is None:
            raise InvalidInput("measurements alone, as a function tells how robots move", type(told[0]).__name__.lower())
        motions, oldest = lagged.motions, lagged.steps[0].belief.time
        for record in told:
            if isinstance(record, Twist) and record.time < oldest and len(lagged.steps) > 1:  # it ended one that was relied on
                raise OutOfOrder("twist", record.time, oldest)
            motions = motions.merged(record)
        known = replace(lagged, motions=motions.since(oldest))
        first = min(record.start if isinstance(record, Odometry) else record.time for record in told)
        reached = {step.frame.time: () for step in lagged.steps[1:] if step.frame.time > first}
        return replace(known, steps=self._redone(known, reached))

    def _measured(self, lagged: Lagged[AnyBelief], records: Sequence[Measurement]) -> Lagged[AnyBelief]:
        """Return what is known after measurements in order of time."""
        kept, newest = self._fitting(lagged, records), lagged.belief.time
        strays = [record for record in records if record.time not in {each.time for each in kept}]
        anew = None if kept else self._restarted(lagged, strays[0].time)
        begin = anew or lagged
        steps = self._redone(begin, _by_time(strays if anew else kept))
        late = lagged.late + _count([record for record in kept if record.time < newest])
        events = (Mistimed(newest, strays[0].time, _count(strays), anew is not None),) if strays else ()
        # The last one before the lag stays, too: a late one would begin with it.
        older = sum(step.belief.time < steps[-1].belief.time - self.lag for step in steps)
        steps = steps[max(0, older - 1) :]
        motions = begin.motions and begin.motions.since(steps[0].belief.time)
        refused, astray = (0, None) if anew else (_count(strays), None if kept else strays[-1].time)
        return Lagged(steps, motions, late, lagged.refused + refused, events, astray)

    def _fitting(self, lagged: Lagged[AnyBelief], records: Sequence[Measurement]) -> list[Measurement]:
        """Return those of some records, in order of time, that come neither too late nor after too long a gap."""
        latest = lagged.belief.time
        oldest = max(lagged.steps[0].belief.time, latest - self.lag)
        for record in records:
            latest = record.time if latest < record.time <= latest + self.gap else latest
        return [record for record in records if oldest <= record.time <= latest]

    def _restarted(self, lagged: Lagged[AnyBelief], first: float) -> Lagged[AnyBelief] | None:
        """Return what to begin with if the clock has jumped to records astray, the first at this time [s]."""
        before, known = lagged.astray, lagged.steps[-1].belief
        jumped = before is not None and abs(before - known.time) > self.gap and 0 < first - before <= self.gap
        return self.begin(self.restart(known, first)) if jumped and self.restart else None

    def _redone(self, known: Lagged[AnyBelief], more: Mapping[float, Sequence[Measurement]]) -> tuple[Step[AnyBelief], ...]:
        """Return the steps with more measurements, by time, put in where they belong, and everything since then done again."""
        steps = known.steps
        if not more:
            return steps
        first = max(1, sum(step.belief.time < min(more) for step in steps))
        at = {step.belief.time: step.frame.measurements for step in steps[first:]}
        for time, records in more.items():
            at[time] = (*at.get(time, ()), *records)
        begin, frames = steps[first - 1].belief, []
        motion = self.motion or (known.motions.between if known.motions else None)
        for before, time in pairwise([begin.time, *sorted(at)]):
            frames.append(Frame(time, motion(before, time) if motion and before < time else None, at[time]))
        return (*steps[:first], *follow(self.inner, begin, frames))


def _by_time(records: Sequence[Measurement]) -> dict[float, tuple[Measurement, ...]]:
    """Return records by their times."""
    found = dict[float, tuple[Measurement, ...]]()
    for record in records:
        found[record.time] = (*found.get(record.time, ()), record)
    return found


def _count(records: Sequence[Measurement]) -> int:
    return sum(len(record.robot) for record in records)
