"""What one instant gives: odometry since the last one, measurements, and the truth to judge by."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from filter.arrays import Array, Floats, floats, instance, number, read_only, settle
from filter.errors import InvalidInput
from filter.measurements import Measurement, Odometry, measurements_of


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the robots are.

    Attributes:
        positions: (n, 2) [m]; NaN where nobody knows.
        headings: (n,) yaw in (-pi, pi] [rad].

    Raises:
        InvalidInput: They are no numbers, or not as many.
    """

    positions: Array
    headings: Array

    if TYPE_CHECKING:  # sequences are taken, arrays are kept

        def __init__(self, positions: Floats, headings: Floats) -> None: ...

    def __post_init__(self) -> None:
        positions, headings = floats("positions [m]", self.positions), floats("headings [rad]", self.headings)
        if headings.ndim != 1 or positions.shape != (len(headings), 2):
            raise InvalidInput("positions (n, 2) and headings (n,)", f"shapes {positions.shape} and {headings.shape}")
        settle(self, positions=read_only(positions), headings=read_only(headings))


@dataclass(frozen=True, eq=False)
class Frame:
    """One instant of an episode or a log.

    Attributes:
        time: When [s].
        odometry: The motion since the previous frame, or None in the first one and where nothing is known of it.
        measurements: What was measured at this instant.
        truth: Where the robots are, or None where nobody knows.

    Raises:
        InvalidInput: The time is no number, or something is of another type.
    """

    time: float
    odometry: Odometry | None = None
    measurements: tuple[Measurement, ...] = ()
    truth: Truth | None = None

    if TYPE_CHECKING:  # whatever holds records is taken, a tuple is kept

        def __init__(
            self,
            time: float,
            odometry: Odometry | None = ...,
            measurements: Iterable[Measurement] = ...,
            truth: Truth | None = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        instance("odometry", self.odometry, Odometry, type(None))
        instance("truth", self.truth, Truth, type(None))
        settle(self, time=number("time [s]", self.time), measurements=measurements_of(self.measurements))
