"""What one instant gives: odometry since the last one, measurements, and the truth to judge by."""

from __future__ import annotations

from dataclasses import dataclass

from filter.arrays import Array
from filter.measurements import Measurement, Odometry


@dataclass(frozen=True, eq=False)
class Truth:
    """Where the robots are.

    Attributes:
        positions: (n, 2) [m].
        headings: (n,) yaw in (-pi, pi] [rad].
    """

    positions: Array
    headings: Array


@dataclass(frozen=True, eq=False)
class Frame:
    """One instant of an episode or a log.

    Attributes:
        time: When [s].
        odometry: The motion since the previous frame, or None in the first one and where nothing is known of it.
        measurements: What was measured at this instant.
        truth: Where the robots are, or None where nobody knows.
    """

    time: float
    odometry: Odometry | None = None
    measurements: tuple[Measurement, ...] = ()
    truth: Truth | None = None
