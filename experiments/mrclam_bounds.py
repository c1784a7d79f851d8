"""The bounds declared for real robots: of their cameras, their clocks, and of how well they obey."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Floats, finite, number
from filter.errors import InvalidInput

DEGREE = np.pi / 180
Knots = tuple[tuple[float, float], ...]


@dataclass(frozen=True)
class Bounds:
    """The bounds declared for a run: one set for all robots and runs.

    The defaults are what three runs together show, rounded outward (docs/real-robots.md). A bound by knots is the greatest
    error over an interval as a concave function of its length: straight from (0, 0) through the knots (length [s], bound),
    and on with the last slope. As such a function is nowhere steeper than before, chained records are never tighter than one.

    Attributes:
        range: A measured range is off by less than this [m] ...
        relative_range: ... or by less than this share of the true range, whichever is more.
        bearing: [rad].
        measurement_delay: A measurement was made so long before its stamp [s].
        command_lag: A command is obeyed so long after its stamp [s].
        speed_scale: Driven path over commanded path.
        distance: Knots of the error of the driven path [s], [m].
        turn: Knots of the error of the turn [s], [rad].
        slip: Knots of the displacement that is none of the path: across the robot's axis, or back and forth [s], [m].
        reach: The longest path that is possible at all, whatever was commanded: knots [s], [m].
        hold: A command is obeyed for so long if no other comes [s]; then nothing is known but `reach` and `swing`.
        swing: The largest turn that is possible at all: knots [s], [rad].

    Raises:
        InvalidInput: A value is out of its range, or knots are not those of a concave function.
    """

    range: float = 0.20
    relative_range: float = 0.15
    bearing: float = 7.5 * DEGREE
    measurement_delay: float = 0.04
    command_lag: float = 0.18
    speed_scale: float = 0.93
    distance: Knots = ((0.1, 0.018), (1.0, 0.06))
    turn: Knots = ((0.1, 7.7 * DEGREE), (1.0, 22 * DEGREE), (10.0, 40 * DEGREE))
    slip: Knots = ((0.05, 0.01), (1.0, 0.03))
    reach: Knots = ((0.05, 0.015), (1.0, 0.11))
    hold: float = 2.0
    swing: Knots = ((0.1, 12 * DEGREE), (1.0, 60 * DEGREE))

    def __post_init__(self) -> None:
        for name in ("range", "measurement_delay", "command_lag", "speed_scale", "hold"):
            number(name, getattr(self, name), 0)
        number("bearing bound [rad]", self.bearing, 0, np.nextafter(np.pi / 2, 0))
        number("relative range bound", self.relative_range, 0, np.nextafter(1.0, 0))
        for name in ("distance", "turn", "slip", "reach", "swing"):
            _check_knots(name, getattr(self, name))

    def range_columns(self, measured: Floats) -> tuple[Array, Array]:
        """Return (k,) absolute and relative bounds of measured ranges (k,) for a `Range` record.

        A record's bounds add up; here the larger one counts. The true range is in the union of [r - a, r + a] and
        [r / (1 + e), r / (1 - e)]: for short ranges the first interval contains the other, for long ones the reverse; in
        between (1.1 to 1.5 m by default) an absolute bound takes both.
        """
        r = np.asarray(measured, dtype=float)
        below, above = r - r / (1 + self.relative_range), r / (1 - self.relative_range) - r
        long = below >= self.range
        return np.where(long, 0.0, np.maximum(self.range, above)), np.where(long, self.relative_range, 0.0)


def _check_knots(name: str, knots: Knots) -> None:
    expected = f"{name}: knots (length, bound) of a concave function that grows from (0, 0)"
    given = finite(name, knots)
    if given.ndim != 2 or given.shape[1] != 2:
        raise InvalidInput(expected, knots)
    points = np.vstack([np.zeros((1, 2)), given])
    steps = np.diff(points, axis=0)
    if (steps[:, 0] <= 0).any() or (steps[:, 1] < 0).any():
        raise InvalidInput(expected, knots)
    slopes = steps[:, 1] / steps[:, 0]
    if (np.diff(slopes) > 0).any():
        raise InvalidInput(expected, knots)


def bound_over(knots: Knots, length: Floats) -> Array:
    """Return the bounds of intervals of some lengths [s], any shape: the lowest of the straight lines through the knots."""
    points = np.vstack([np.zeros((1, 2)), np.array(knots)])
    slopes = np.diff(points[:, 1]) / np.diff(points[:, 0])
    lines = points[1:, 1] + slopes * (np.asarray(length, dtype=float)[..., None] - points[1:, 0])
    return np.asarray(lines.min(axis=-1))
