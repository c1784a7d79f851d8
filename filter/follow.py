"""The loop: a filter follows frames, one after the other. Every filter with start, predict and update can."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass
from typing import Generic, Protocol, TypeVar, runtime_checkable

from filter.arrays import function, instance, number, one_by_one
from filter.frame import Frame
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.measurements import Measurement, Odometry


class Timed(Protocol):
    """A belief of one time."""

    @property
    def time(self) -> float:
        """When [s]."""


AnyBelief = TypeVar("AnyBelief", bound=Timed)


@runtime_checkable
class Filter(Protocol[AnyBelief]):
    """What every filter can do: a belief goes in and a new belief comes out."""

    def start(self, time: float, positions: Sequence[Polygon], headings: AngularIntervals | None = None) -> AnyBelief:
        """Return the belief before any measurement.

        Args:
            time: When [s].
            positions: (n) a polygon around each robot.
            headings: (n) arcs around the headings, or None when nothing is known.
        """

    def predict(self, belief: AnyBelief, time: float, odometry: Odometry | None = None) -> AnyBelief:
        """Return the belief at a later time [s]."""

    def update(self, belief: AnyBelief, measurements: Sequence[Measurement] = ()) -> AnyBelief:
        """Return the belief after measurements of its time."""


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

    A frame at the belief's own time, as the first one often is, needs no prediction.

    Args:
        filter_: Any filter.
        belief: What it knows before the first frame.
        frames: In order of time; each is taken when its step is asked for.
        clock: What tells the time, such as `time.perf_counter`, as there is no clock in here.

    Raises:
        InvalidInput: Something is no filter, no belief, no frame or no clock.
        CorralError: What the filter raises, such as `OutOfOrder` for a frame that is earlier than the belief.
    """
    check_filter(filter_)
    check_time(belief)
    now = _no_clock if clock is None else clock
    function("clock", now)
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


def check_filter(filter_: object) -> None:
    """Raise `InvalidInput` when it is no filter, as a class of filters is none."""
    for name in ("predict", "update"):
        function(f"a filter with {name}", None if isinstance(filter_, type) else getattr(filter_, name, None))


def check_time(belief: object) -> None:
    """Raise `InvalidInput` when it is no belief: it has no time."""
    number("time of a belief [s]", getattr(belief, "time", None))


def _no_clock() -> float:
    return 0.0
