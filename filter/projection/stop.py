"""When a projection is good enough, and how long a step may take."""

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Literal, get_args

from filter.arrays import Frozen, checked, function, number, whole_number

Reason = Literal["exact", "performance ratio", "area gap", "searches", "time", "solver"]
REASONS: tuple[Reason, ...] = get_args(Reason)

IsOver = Callable[[], bool]


def never() -> bool:
    """Return that there is time left."""
    return False


@dataclass(frozen=True)
class Stop(Frozen):
    """When a projection is good enough: at whichever comes first.

    A search ends there; an exact projection is simplified, outward, as far as that. Raises `InvalidInput` if a number is not
    finite or out of its range.

    Attributes:
        performance_ratio: Inner area over outer area (eq. 7), in [0, 1].
        area_gap: Outer area less inner area (eq. 6) [m2], from 0 on.
        searches: Number of searches, or of edges, from 4 on.
    """

    performance_ratio: float = field(default=0.999, metadata=checked(number, "performance ratio", 0, 1))
    area_gap: float = field(default=0.0, metadata=checked(number, "area gap [m2]", 0))
    searches: int = field(default=32, metadata=checked(whole_number, "searches", 4))

    def reason(self, inner_area: float, gap: float, searches: int) -> Reason | None:
        """Return why to end a search, or None to go on."""
        if inner_area >= self.performance_ratio * (inner_area + gap):
            return "performance ratio"
        if gap <= self.area_gap:
            return "area gap"
        return "searches" if searches >= self.searches else None

    @property
    def goal(self) -> tuple[float, float, int]:
        """Performance ratio, area gap [m2] and greatest number of edges, as compiled functions take them."""
        return self.performance_ratio, self.area_gap, self.searches


@dataclass(frozen=True)
class Budget(Frozen):
    """How long an update may take. With a budget, results depend on the machine.

    It is looked at between one region and the next, in windows after every 64 on each thread, and in a search from the fourth
    direction on, so an update takes that much longer than the budget. When time is up, regions that are not refined yet stay
    as they are known anyway. Raises `InvalidInput` if the time is not finite or negative, the clock no function or
    without a number.

    Attributes:
        seconds: From 0 on [s].
        clock: What tells the time, such as `time.perf_counter`, as there is no clock in here.
    """

    seconds: float = field(metadata=checked(number, "time budget [s]", 0))
    clock: Callable[[], float] = field(metadata=checked(function, "clock"))

    def begin(self) -> IsOver:
        """Return what tells, from now on, whether time is up."""
        began = number("time by the clock [s]", self.clock())
        return lambda: number("time by the clock [s]", self.clock()) - began >= self.seconds
