"""Filters follow what comes: frames, one after the other. Any filter can."""

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from math import inf
from typing import Any, Generic, Protocol, TypeVar, runtime_checkable

from filter.arrays import function, instance, number, one_by_one
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.records.frame import Frame
from filter.records.measurements import Measurement
from filter.records.odometry import Odometry
from filter.records.presence import Change

AS_LONG = 1e-9  # so much less than a time that frames are one step is that time, as stamps are rounded


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
        frame: What the filter was given. Of several instants it is the last one, with all that was measured in them.
        predicted: What it knew before it saw what was measured, but for who came and left; before all of that, of several
            instants.
        belief: What it knows now.
        seconds: How long predict and update took together; 0 without a clock [s].
    """

    frame: Frame
    predicted: AnyBelief
    belief: AnyBelief
    seconds: float


def follow(
    filter_: Filter[AnyBelief],
    belief: AnyBelief,
    frames: Iterable[Frame],
    clock: Callable[[], float] | None = None,
    every: float = 0.0,
) -> Iterator[Step[AnyBelief]]:
    """Yield the filter's step at every frame: predict with its odometry, place who comes, update with its measurements.

    A frame at the belief's own time, as the first one often is, needs no prediction. Raises `InvalidInput` if something is no
    filter, no belief, no frame or no clock, and what the filter raises, such as `OutOfOrder` for a frame that is too early.

    Args:
        filter_: Any filter.
        belief: What it knows before the first frame.
        frames: In order of time; each is taken when its step is asked for.
        clock: What tells the time, such as `time.perf_counter`, as there is no clock in here.
        every: Frames of so long a time are one step, for a filter that can `advance` [s]: that of the last of them, or of the
            last whose truth is known.
    """
    a_filter("a filter", filter_)
    time_of(belief)
    now = (lambda: 0.0) if clock is None else function("clock", clock)
    some = one_by_one("a sequence of frames", frames)
    if number("every [s]", every, 0):
        function("a filter with advance, for a time in which all frames are one step", getattr(filter_, "advance", None))
        return _together(filter_, belief, some, now, every)
    return _steps(filter_, belief, some, now)


def _together(
    filter_: Any, belief: AnyBelief, frames: Iterator[Frame], now: Callable[[], float], every: float
) -> Iterator[Step[AnyBelief]]:
    waiting = list[Frame]()

    def ended(time: float) -> Iterator[Step[AnyBelief]]:
        nonlocal belief, waiting
        while waiting and time - waiting[0].time >= (1 - AS_LONG) * every:
            last = max((place for place, frame in enumerate(waiting, 1) if frame.truth is not None), default=len(waiting))
            some, waiting = waiting[:last], waiting[last:]
            began, before = now(), belief
            belief = filter_.advance(belief, some)
            measured = [record for frame in some for record in frame.measurements]
            changes = [change for frame in some for change in frame.changes]
            yield Step(replace(some[-1], measurements=measured, changes=changes), before, belief, now() - began)

    fault, frame = None, next(frames, None)
    while frame is not None:
        yield from ended(instance("a frame", frame, Frame).time)
        waiting.append(frame)
        try:
            frame = next(frames, None)
        except InvalidInput as error:  # what came before it counts
            fault, frame = error, None
    yield from ended(inf)
    if fault:
        raise fault


def _steps(
    filter_: Filter[AnyBelief], belief: AnyBelief, frames: Iterator[Frame], now: Callable[[], float]
) -> Iterator[Step[AnyBelief]]:
    for frame in frames:
        instance("a frame", frame, Frame)
        began = now()
        moved = frame.time != belief.time or frame.odometry is not None
        predicted = filter_.predict(belief, frame.time, frame.odometry) if moved else belief
        predicted = changed(filter_, predicted, frame.changes)
        belief = filter_.update(predicted, frame.measurements)
        yield Step(frame, predicted, belief, now() - began)


def changed(filter_: Any, belief: AnyBelief, changes: Sequence[Change]) -> AnyBelief:
    """Return the belief after robots were placed or have left, in this order; `InvalidInput` if they cannot for this filter."""
    if changes and not callable(getattr(filter_, "changed", None)):
        raise InvalidInput("a filter that robots can join and leave, as SetMembershipFilter", type(filter_).__name__)
    for change in changes:
        belief = filter_.changed(belief, change)
    return belief


def a_filter(name: str, value: Any) -> Any:
    """Return a filter: no class of filters is one."""
    for can in ("predict", "update"):
        function(f"{name} with {can}", None if isinstance(value, type) else getattr(value, can, None))
    return value


def time_of(what: object) -> float:
    """Return when a belief or a record is of, as a float [s]."""
    return number("time of a belief [s]", getattr(what, "time", None))
