"""How long a step may take: when time is up, regions that are not refined yet stay as they are known anyway."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from filter.arrays import function, number, settle

IsOver = Callable[[], bool]


def never() -> bool:
    """Return that there is time left."""
    return False


@dataclass(frozen=True)
class Budget:
    """How long an update may take. With a budget, results depend on the machine.

    It is looked at between one region and the next, or in windows after every 64 on each thread, so an update takes
    that much longer than the budget.

    Attributes:
        seconds: From 0 on [s].
        clock: What tells the time, such as `time.perf_counter`, as there is no clock in here.

    Raises:
        InvalidInput: The time is not finite or negative, or the clock is no function or tells no number.
    """

    seconds: float
    clock: Callable[[], float]

    def __post_init__(self) -> None:
        settle(self, seconds=number("time budget [s]", self.seconds, 0))
        function("clock", self.clock)

    def begin(self) -> IsOver:
        """Return what tells, from now on, whether time is up."""
        began = number("time by the clock [s]", self.clock())
        return lambda: number("time by the clock [s]", self.clock()) - began >= self.seconds
