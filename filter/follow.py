"""Filters follow what comes: frames, one after the other, and late measurements, up to a fixed lag. Any filter can."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

from filter.arrays import Frozen, checked, function, instance, number, one_by_one
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.records.frame import Frame
from filter.records.measurements import Measurement, measurements_of
from filter.records.odometry import Odometry


class Timed(Protocol):
    """A belief of one time."""

    @property
    def time(self) -> float:
        """When [s]."""


AnyBelief = TypeVar("AnyBelief", bound=Timed)


@runtime_checkable
class Filter(Protocol[AnyBelief]):
    """What every filter can do: a belief goes in, stays as it is, and a new one comes out; its `guarantee` says what holds."""

    def start(self, time: float, positions: Sequence[Polygon | None], headings: AngularIntervals | None = None) -> AnyBelief:
        """Return the belief before any measurement.

        Args:
            time: When [s].
            positions: (n) a polygon around each robot; a point anchors it, None stands for the team's arena.
            headings: (n) arcs around the headings, or None when nothing is known.

        Raises:
            InvalidInput: Something is no polygon or no arc, the numbers of sets and robots differ, or a set is empty.
        """

    def predict(self, belief: AnyBelief, time: float, odometry: Odometry | None = None) -> AnyBelief:
        """Return the belief at a later time [s], after the robots have moved, those without odometry within the team's limits.

        Raises `OutOfOrder` if `time` is earlier than the belief's or the odometry starts at another time, and `InvalidInput`
        if it ends at another time or names an unknown robot.
        """

    def update(self, belief: AnyBelief, measurements: Sequence[Measurement] = ()) -> AnyBelief:
        """Return the belief after measurements of its time.

        Raises `OutOfOrder` if a record is of another time, and `InvalidInput` if it names an unknown robot or landmark.
        """


@dataclass(frozen=True, eq=False)
class Step(Generic[AnyBelief]):
    """One step of a filter.

    Attributes:
        frame: What the filter was given.
        predicted: What it knew before it saw the frame's measurements.
        belief: What it knows now.
        seconds: How long predict and update took together; 0 without a clock [s].
    """

    frame: Frame
    predicted: AnyBelief
    belief: AnyBelief
    seconds: float


def follow(
    filter_: Filter[AnyBelief], belief: AnyBelief, frames: Iterable[Frame], clock: Callable[[], float] | None = None
) -> Iterator[Step[AnyBelief]]:
    """Yield the filter's step at every frame: predict with its odometry, then update with its measurements.

    A frame at the belief's own time, as the first one often is, needs no prediction. Raises `InvalidInput` if something is no
    filter, no belief, no frame or no clock, and what the filter raises, such as `OutOfOrder` for a frame that is too early.

    Args:
        filter_: Any filter.
        belief: What it knows before the first frame.
        frames: In order of time; each is taken when its step is asked for.
        clock: What tells the time, such as `time.perf_counter`, as there is no clock in here.
    """
    _filter("a filter", filter_)
    _time_of(belief)
    now = (lambda: 0.0) if clock is None else function("clock", clock)
    return _steps(filter_, belief, one_by_one("a sequence of frames", frames), now)


def _steps(
    filter_: Filter[AnyBelief], belief: AnyBelief, frames: Iterator[Frame], now: Callable[[], float]
) -> Iterator[Step[AnyBelief]]:
    for frame in frames:
        instance("a frame", frame, Frame)
        began = now()
        moved = frame.time != belief.time or frame.odometry is not None
        predicted = filter_.predict(belief, frame.time, frame.odometry) if moved else belief
        belief = filter_.update(predicted, frame.measurements)
        yield Step(frame, predicted, belief, now() - began)


def _filter(name: str, value: Any) -> Any:
    """Return a filter: no class of filters is one."""
    for can in ("predict", "update"):
        function(f"{name} with {can}", None if isinstance(value, type) else getattr(value, can, None))
    return value


def _time_of(what: object) -> float:
    return number("time of a belief [s]", getattr(what, "time", None))


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
        late: How many measurements came after newer ones and were merged all the same.
        refused: How many came too late, or too far ahead.
        events: What the last merge found mistimed.
        astray: Newest stamp of the last merge if it was refused as a whole [s].
    """

    steps: tuple[Step[AnyBelief], ...]
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
    """Merges measurements that are late by at most a fixed lag as if they had come in order; later ones are refused.

    The result is that of the inner filter with the same measurements in order, bit for bit, if their order within one instant
    makes no difference to it. Raises `InvalidInput` if an attribute is of another type, or lag or gap negative or not finite.

    A stamp after too long a gap is refused, too, as it may be wrong; what is refused is told each time. If the next merge, and
    all of it, goes on from a stamp farther off than the gap, ahead or back, the clock has jumped: `restart` says what is known.

    Attributes:
        inner: The filter that does the work.
        motion: The robots' motion from one time to another, both not before the oldest step; None where nothing is known.
        lag: How late a measurement may be, from 0 on [s].
        gap: How long nothing may come before stamps are doubted, from 0 on [s].
        restart: Returns the belief at the time [s] that a clock has jumped to, from the one before; None to go on refusing.
    """

    inner: Filter[AnyBelief] = field(metadata=checked(_filter, "a filter"))
    motion: Callable[[float, float], Odometry | None] = field(metadata=checked(function, "motion"))
    lag: float = field(default=1.0, metadata=checked(number, "lag [s]", 0))
    gap: float = field(default=60.0, metadata=checked(number, "gap [s]", 0))
    restart: Callable[[AnyBelief, float], AnyBelief] | None = field(
        default=None, metadata=checked(function, "restart", optional=True)
    )

    def begin(self, belief: AnyBelief) -> Lagged[AnyBelief]:
        """Return a belief of the inner filter to which nothing has happened yet; `InvalidInput` if it has no time."""
        return Lagged((Step(Frame(_time_of(belief)), belief, belief, 0.0),))

    def merge(self, lagged: Lagged[AnyBelief], measurements: Sequence[Measurement]) -> Lagged[AnyBelief]:
        """Return what is known after measurements of any times, in any order; what was known stays as it is.

        How late they are is counted from the newest that came before. Raises `InvalidInput` if something is no record, and what
        the inner filter raises; nothing has changed then.
        """
        instance("what is known (see begin)", lagged, Lagged)
        records = sorted(measurements_of(measurements), key=_time_of)
        if not records:
            return lagged
        kept, newest = self._fitting(lagged, records), lagged.belief.time
        strays = [record for record in records if record.time not in {each.time for each in kept}]
        anew = None if kept else self._restarted(lagged, strays[0].time)
        steps = self._redone(anew or lagged.steps, strays if anew else kept)
        late = lagged.late + _count([record for record in kept if record.time < newest])
        events = (Mistimed(newest, strays[0].time, _count(strays), anew is not None),) if strays else ()
        # The last one before the lag stays, too: a late one would begin with it.
        older = sum(step.belief.time < steps[-1].belief.time - self.lag for step in steps)
        refused, astray = (0, None) if anew else (_count(strays), None if kept else strays[-1].time)
        return Lagged(steps[max(0, older - 1) :], late, lagged.refused + refused, events, astray)

    def _fitting(self, lagged: Lagged[AnyBelief], records: list[Measurement]) -> list[Measurement]:
        """Return those of some records, in order of time, that come neither too late nor after too long a gap."""
        latest = lagged.belief.time
        oldest = max(lagged.steps[0].belief.time, latest - self.lag)
        for record in records:
            latest = record.time if latest < record.time <= latest + self.gap else latest
        return [record for record in records if oldest <= record.time <= latest]

    def _restarted(self, lagged: Lagged[AnyBelief], first: float) -> tuple[Step[AnyBelief], ...] | None:
        """Return what to begin with if the clock has jumped to records astray, the first at this time [s]."""
        before, known = lagged.astray, lagged.steps[-1].belief
        jumped = before is not None and abs(before - known.time) > self.gap and 0 < first - before <= self.gap
        return self.begin(self.restart(known, first)).steps if jumped and self.restart else None

    def _redone(self, steps: tuple[Step[AnyBelief], ...], records: list[Measurement]) -> tuple[Step[AnyBelief], ...]:
        """Return the steps with records, in order of time, put in where they belong, and everything since then done again."""
        if not records:
            return steps
        first = max(1, sum(step.belief.time < records[0].time for step in steps))
        at = {step.belief.time: step.frame.measurements for step in steps[first:]}
        for record in records:
            at[record.time] = (*at.get(record.time, ()), record)
        begin, frames = steps[first - 1].belief, []
        for before, time in pairwise([begin.time, *sorted(at)]):
            frames.append(Frame(time, self.motion(before, time) if before < time else None, at[time]))
        return (*steps[:first], *follow(self.inner, begin, frames))


def _count(records: Sequence[Measurement]) -> int:
    return sum(len(record.robot) for record in records)
