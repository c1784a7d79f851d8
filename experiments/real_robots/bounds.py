"""The bounds declared for real robots: of their cameras, their clocks, and of how well they obey."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.following.frozen import keep_within
from filter import Array, Floats, InvalidInput

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
        heading_jitter: A belief follows a heading within so much of the true one [rad]: 0, but for `chained` bounds.
        position_jitter: And a position within so much of the true one [m].

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
    heading_jitter: float = 0.0
    position_jitter: float = 0.0

    def __post_init__(self) -> None:
        some = ("range", "measurement_delay", "command_lag", "speed_scale", "hold", "heading_jitter", "position_jitter")
        keep_within(self, **dict.fromkeys(some, (0, np.inf)))
        keep_within(self, bearing=(0, np.nextafter(np.pi / 2, 0)), relative_range=(0, np.nextafter(1.0, 0)))
        for name in ("distance", "turn", "slip", "reach", "swing"):
            _check_knots(name, getattr(self, name))

    def chained(self, length: float = 1.0) -> Bounds:
        """Return bounds for a filter that chains short records: motion drifts in each as it does over `length` [s].

        Such a filter follows a smoothed pose, never farther from the true one than the jitters. The bounds of measurements
        are then those of what the smoothed pose would measure; they stay as they are, as they are broken just as often
        (docs/real-robots.md).

        Algorithm:
            Let e(t) be the error of a turn summed up since the start, |e(t) - e(s)| <= 2 jitter + drift |t - s| for all s
            and t. Then f(t) = min over s of (e(s) + drift |t - s|) + jitter is within the jitter of e(t), and
            |f(t) - f(s)| <= drift |t - s| (McShane's extension). The same for the two coordinates of the position, where e is
            how far the true one is from the commanded path along the true headings; that both are smoothed costs a factor of
            sqrt(2), which the drifts of path and slip together have in hand (measured).
        """
        distance, turn, slip, reach = (
            float(bound_over(knots, length)) / length for knots in (self.distance, self.turn, self.slip, self.reach)
        )
        return replace(
            self,
            distance=((1.0, distance),),
            turn=((1.0, turn),),
            slip=((1.0, slip),),
            reach=((1.0, reach),),
            heading_jitter=_above(self.turn, turn) / 2,
            position_jitter=float(np.sqrt(0.5)) * (_above(self.distance, distance) + _above(self.slip, slip)),
        )

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
    given = np.array(knots, dtype=float)
    if given.ndim != 2 or given.shape[1] != 2 or not np.isfinite(given).all():
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


def _above(knots: Knots, slope: float) -> float:
    """Return how far the function through the knots is above a straight line from (0, 0) at most."""
    return max([0.0, *(bound - slope * length for length, bound in knots)])
