"""Records that come late, up to a fixed lag, are merged as if they had come in order. Any filter can."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import chain, pairwise
from typing import Any, Generic

import numpy as np

from filter.arrays import Frozen, checked, function, instance, number, several
from filter.errors import InvalidInput, OutOfOrder
from filter.follow import AS_LONG, AnyBelief, Filter, Step, a_filter, follow, time_of
from filter.motions import Motions
from filter.records.frame import Frame
from filter.records.measurements import Measurement
from filter.records.odometry import Odometry, Twist
from filter.records.presence import Change, Left, Placed
from filter.records.record import called
from filter.stream import ARRIVALS, Arrival
from filter.team import Team

Said = tuple[float, Sequence[Measurement], Sequence[Change]]  # at one time [s]


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
    makes no difference to it and every stamp is a step. Raises `InvalidInput` if an attribute is of another type, or lag, gap
    or every negative or not finite.

    A stamp after too long a gap is refused, too, as it may be wrong; what is refused is told each time. If the next merge, and
    all of it, goes on from a stamp farther off than the gap, ahead or back, the clock has jumped: `restart` says what is known.

    Attributes:
        inner: The filter that does the work.
        motion: Returns the robots' motion from one time to another, both not before the oldest step, or None where nothing is
            known. Without such a function, odometry and twists are merged as they come (see `Motions`).
        lag: How late a measurement may be, from 0 on [s].
        gap: How long nothing may come before stamps are doubted, from 0 on [s].
        restart: Returns the belief at the time [s] that a clock has jumped to, from the one before; None to go on refusing.
        every: So long a time is one step, for an inner filter that can `advance` [s]; 0 for a step at every stamp. The newest
            step goes on for so long: whatever comes for it in that time is merged with it, at a stamp of its own. A step that
            is over is done again for what was measured or driven in it; odometry that goes on after it counts from then on.
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
    every: float = field(default=0.0, metadata=checked(number, "every [s]", 0))

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.every:
            function("a filter with advance, for a time that is one step", getattr(self.inner, "advance", None))

    def begin(self, belief: AnyBelief) -> Lagged[AnyBelief]:
        """Return a belief of the inner filter to which nothing has happened yet; `InvalidInput` if it has no time."""
        motions = None if self.motion else Motions(instance("a filter's team", getattr(self.inner, "team", None), Team))
        return Lagged((Step(Frame(time_of(belief)), belief, belief, 0.0),), motions)

    def merge(self, lagged: Lagged[AnyBelief], records: Sequence[Arrival]) -> Lagged[AnyBelief]:
        """Return what is known after records of any times, in any order; what was known stays as it is.

        How late measurements are is counted from the newest that came before. Odometry tells of the time since the oldest step.
        A frame asks for a step at its time; what is measured and driven in it counts, its truth does not. Raises `InvalidInput`
        if something is no record, `OutOfOrder` for a twist from before the oldest step or odometry that ends one then, and
        what the inner filter and `Motions.merged` raise; nothing has changed then.
        """
        instance("what is known (see begin)", lagged, Lagged)
        told, instants = _apart(several("records", records, *ARRIVALS))
        known, first = self._driven(lagged, told)
        if instants:
            return self._measured(known, first, instants)
        return replace(known, steps=self._redone(known, first)) if told else lagged

    def _driven(self, lagged: Lagged[AnyBelief], told: Sequence[Odometry | Twist]) -> tuple[Lagged[AnyBelief], int]:
        """Return what is known with odometry, and the first of the steps that it reaches into: these are not done again yet."""
        steps = lagged.steps
        if not told:
            return lagged, len(steps)
        if lagged.motions is None:
            raise InvalidInput("measurements alone, as a function tells how robots move", called(type(told[0])))
        motions, oldest = lagged.motions, steps[0].belief.time
        for record in told:
            if len(steps) > 1 and motions.ends_before(record, oldest):
                begin = record.start if isinstance(record, Odometry) else record.time
                raise OutOfOrder(called(type(record)), begin, oldest)
            motions = motions.merged(record)
        # Of what goes on in the newest step only that counts, or each of its records would have the step before done again.
        over = steps[-2].belief.time if self.every and len(steps) > 1 else -np.inf
        first = min((_since(record, over) for record in told if _until(record) > oldest), default=np.inf)
        reached = 1 + sum(step.belief.time <= first for step in steps[1:])
        return replace(lagged, motions=motions.since(oldest)), reached

    def _measured(self, lagged: Lagged[AnyBelief], first: int, instants: Sequence[Frame]) -> Lagged[AnyBelief]:
        """Return what is known after measurements in order of time; steps from the first one on are done again anyway."""
        kept, newest = self._fitting(lagged, instants), lagged.belief.time
        strays = [frame for frame in instants if frame.time not in {each.time for each in kept}]
        anew = None if kept else self._restarted(lagged, first, strays[0].time)
        begin = anew or lagged
        steps = self._redone(begin, 1 if anew else first, strays if anew else kept)
        late = lagged.late + _count([frame for frame in kept if frame.time < newest])
        events = (Mistimed(newest, strays[0].time, _count(strays), anew is not None),) if strays else ()
        # The last one before the lag stays, too: a late one would begin with it.
        older = sum(step.belief.time < steps[-1].belief.time - self.lag for step in steps)
        steps = steps[max(0, older - 1) :]
        motions = begin.motions and begin.motions.since(steps[0].belief.time)
        refused, astray = (0, None) if anew else (_count(strays), None if kept else strays[-1].time)
        return Lagged(steps, motions, late, lagged.refused + refused, events, astray)

    def _fitting(self, lagged: Lagged[AnyBelief], instants: Sequence[Frame]) -> list[Frame]:
        """Return those of some instants, in order of time, that come neither too late nor after too long a gap."""
        latest = lagged.belief.time
        oldest = max(lagged.steps[0].belief.time, latest - self.lag)
        for frame in instants:
            latest = frame.time if latest < frame.time <= latest + self.gap else latest
        return [frame for frame in instants if oldest <= frame.time <= latest]

    def _restarted(self, lagged: Lagged[AnyBelief], first: int, stray: float) -> Lagged[AnyBelief] | None:
        """Return what to begin with if the clock has jumped to records astray, the first at this time [s]."""
        before, newest = lagged.astray, lagged.belief.time
        jumped = before is not None and abs(before - newest) > self.gap and 0 < stray - before <= self.gap
        if not (jumped and self.restart):
            return None
        known = self._redone(lagged, first)[-1].belief
        return self.begin(self.restart(known, stray))

    def _redone(self, known: Lagged[AnyBelief], first: int, more: Sequence[Frame] = ()) -> tuple[Step[AnyBelief], ...]:
        """Return the steps with more instants, in order of time, put in where they belong.

        All since then, and at least from the first one on, is done again.
        """
        steps = known.steps
        if more:
            first = min(first, max(1, sum(step.belief.time < more[0].time for step in steps)))
        elif first == len(steps):
            return steps
        if more and self._goes_on(steps, first, more[0].time):
            first -= 1
        at = _by_time(chain(chain.from_iterable(map(_said_by, steps[first:])), map(_said_in, more)))
        begin, frames = steps[first - 1].belief, list[Frame]()
        motion = self.motion or (known.motions.between if known.motions else None)
        for before, time in pairwise([begin.time, *sorted(at)]):
            measurements, changes = at[time]
            frames.append(Frame(time, motion(before, time) if motion and before < time else None, measurements, None, changes))
        return (*steps[:first], *follow(self.inner, begin, frames, every=self.every))

    def _goes_on(self, steps: Sequence[Step[AnyBelief]], first: int, time: float) -> bool:
        """Return whether what is new at a time [s] comes after the newest step, but so soon that it belongs to it."""
        if not self.every or first < len(steps) or len(steps) == 1:
            return False
        return time - steps[-2].belief.time < (1 - AS_LONG) * self.every


def _apart(records: Sequence[Arrival]) -> tuple[list[Odometry | Twist], list[Frame]]:
    """Return what was driven, and the instants in order of time, a frame for each record of them."""
    told, instants = list[Odometry | Twist](), list[Frame]()
    for record in records:
        if isinstance(record, Odometry | Twist):
            told.append(record)
            continue
        frame = record if isinstance(record, Frame) else _instant(record)
        told += [frame.odometry] if frame.odometry is not None else []
        instants.append(frame)
    return told, sorted(instants, key=time_of)


def _since(record: Odometry | Twist, over: float) -> float:
    """Return when a record begins; if it ends after a time that is over, that is early enough [s]."""
    begin = record.start if isinstance(record, Odometry) else record.time
    return max(begin, over) if _until(record) > over else begin


def _until(record: Odometry | Twist) -> float:
    """Return when a record ends, by itself [s]."""
    return record.time if isinstance(record, Odometry) else float((record.time + record.hold).max())


def _instant(record: Measurement | Change) -> Frame:
    """Return the instant of one record."""
    if isinstance(record, Placed | Left):
        return Frame(record.time, changes=(record,))
    return Frame(record.time, measurements=(record,))


def _said_by(step: Step[AnyBelief]) -> Iterator[Said]:
    """Yield what a step was given, each at its own stamp; the step's own time is one of them."""
    yield step.frame.time, (), ()
    yield from ((record.time, (record,), ()) for record in step.frame.measurements)
    yield from ((change.time, (), (change,)) for change in step.frame.changes)


def _said_in(frame: Frame) -> Said:
    return frame.time, frame.measurements, frame.changes


def _by_time(said: Iterable[Said]) -> dict[float, tuple[list[Measurement], list[Change]]]:
    """Return what was measured and who was placed or left, by the time."""
    found = dict[float, tuple[list[Measurement], list[Change]]]()
    for time, records, placed in said:
        measurements, changes = found.setdefault(time, ([], []))
        measurements += records
        changes += placed
    return found


def _count(instants: Sequence[Frame]) -> int:
    return sum(len(record.robot) for frame in instants for record in frame.measurements)
