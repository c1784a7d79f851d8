"""Times as robots' middleware has them: whole nanoseconds since the run's zero."""

from __future__ import annotations

from fractions import Fraction

from filter import InvalidInput

SECOND = 10**9  # [ns]
LATEST = 2**31  # the seconds of a ROS stamp have 32 bits, one of them for the sign [s]


def nanoseconds(time: float) -> int:
    """Return a time [s] to the nearest nanosecond, without further rounding.

    Raises:
        InvalidInput: It is negative, or beyond what a ROS stamp holds.
    """
    if not 0 <= time < LATEST:
        raise InvalidInput(f"times from 0 to {LATEST} s for MCAP", f"{time!r} s")
    return round(Fraction(time) * SECOND)
