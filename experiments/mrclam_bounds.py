"""The bounds declared for real robots: of their cameras, their clocks, and of how well they obey."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array, Floats, finite, number
from filter.errors import InvalidInput

DEGREE = np.pi / 180
Knots = tuple[tuple[float, float], ...]
STEP = 1e-4  # of a length, to find a slope
NEAREST = 0.2  # a robot and what it sees are never nearer, middle to middle [m]
WIDEST_BEARING = float(np.nextafter(np.pi / 2, 0))  # what a record can say [rad]


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
        for name in ("range", "measurement_delay", "command_lag", "speed_scale", "hold", "heading_jitter", "position_jitter"):
            number(name, getattr(self, name), 0)
        number("bearing bound [rad]", self.bearing, 0, np.nextafter(np.pi / 2, 0))
        number("relative range bound", self.relative_range, 0, np.nextafter(1.0, 0))
        for name in ("distance", "turn", "slip", "reach", "swing"):
            _check_knots(name, getattr(self, name))

    def chained(self, length: float = 0.5) -> Bounds:
        """Return bounds for a filter that chains short records: quick jitter once, not in every record.

        Such a filter follows not the true pose but a smoothed one, never farther away than the jitters say. Measurements of it
        are widened by the jitters (`experiments.mrclam_frames`); so must be what the filter says of the true pose.

        Args:
            length: The jitter and the drift are those of the knots around this length [s].

        Algorithm:
            Let e(t) be the error summed up since the start, |e(t) - e(s)| <= jitter + drift |t - s| for all s and t. Then
            f(t) = min over s of (e(s) + drift |t - s|) + jitter / 2 is within jitter / 2 of e(t), and
            |f(t) - f(s)| <= drift |t - s| (McShane's extension). For a turn that is all. A position's error is what the true
            pose is away from the commanded path along the true headings; path and slip together bound it, and both
            coordinates are smoothed, which takes a factor of sqrt(2).
        """
        (turn, spin), (path, speed), (slip, slide) = (_line(knots, length) for knots in (self.turn, self.distance, self.slip))
        return replace(
            self,
            distance=((1.0, 0.0),),
            turn=((1.0, spin),),
            slip=((1.0, np.sqrt(2) * (speed + slide)),),
            heading_jitter=turn / 2,
            position_jitter=np.sqrt(2) * (path + slip) / 2,
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
        relative = np.where(long, self.relative_range, 0.0)
        return np.where(long, 0.0, np.maximum(self.range, above)) + 2 * self.position_jitter * (1 + relative), relative

    def bearing_column(self, measured: Floats) -> Array:
        """Return (k,) bounds of the bearings of targets at measured ranges (k,) [rad].

        Both ends may be away from where a belief has them by the jitter of positions, which turns the nearer target more.
        """
        r = np.asarray(measured, dtype=float)
        nearest = np.minimum(r - self.range, r / (1 + self.relative_range))
        aside = np.arcsin(np.clip(2 * self.position_jitter / np.maximum(nearest, NEAREST), 0, 1))
        return np.minimum(self.bearing + self.heading_jitter + aside, WIDEST_BEARING)


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


def _line(knots: Knots, length: float) -> tuple[float, float]:
    """Return height at 0 and slope of the straight line through the knots around a length [s]."""
    low, high = bound_over(knots, length * np.array([1 - STEP, 1 + STEP])).tolist()
    slope = (high - low) / (2 * STEP * length)
    return float(bound_over(knots, length)) - slope * length, slope
