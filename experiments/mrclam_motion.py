"""What the commands of a run say about its robots' motion, for intervals of any length, and the bounds declared for it.

The logs have no wheel encoders, only the speeds that the robots were told, up to a second apart. So the motion between two
instants is the integral of the commands, a lag earlier, within bounds that depend on the length of the interval: an error of
the turn rate may be large for a tenth of a second (jitter), but it does not last (drift). **One record over a second is
therefore much better than ten over a tenth each**: chained, the records' jitters add up, 10 x 7.7 degrees instead of 22. A
filter that keeps what it knew of a robot some time ago should ask `Motions.motion` for the whole time since.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.mrclam_data import Run
from filter.arrays import Array, Floats, finite, number, read_only
from filter.errors import InvalidInput

DEGREE = np.pi / 180
Knots = tuple[tuple[float, float], ...]
ANY_DIRECTION = 1.55  # of a record's direction, whose bound must stay below a right angle [rad]


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


@dataclass(frozen=True, eq=False)
class Motion:
    """How robots moved in k intervals.

    Attributes:
        distance: (k,) driven path, its middle [m].
        distance_bound: (k,) [m].
        turn: (k,) change of heading [rad].
        turn_bound: (k,) [rad].
        direction: (k,) direction of the displacement less the heading at the start, its middle [rad].
        direction_bound: (k,) [rad]; `ANY_DIRECTION` says nothing is known.
        slip_bound: (k,) radius of a disc that is added [m].
    """

    distance: Array
    distance_bound: Array
    turn: Array
    turn_bound: Array
    direction: Array
    direction_bound: Array
    slip_bound: Array

    def __post_init__(self) -> None:
        for name, column in list(vars(self).items()):
            object.__setattr__(self, name, read_only(column))

    @classmethod
    def stacked(cls, motions: Sequence[Motion]) -> Motion:
        """Return the motion of n robots in the same k intervals as one, with columns (k, n)."""
        return cls(*(np.stack(columns, axis=1) for columns in zip(*(vars(each).values() for each in motions), strict=True)))

    def odometry_columns(self) -> dict[str, Array]:
        """Return the columns of an `Odometry` record by their names, of the same shape.

        A record takes the direction to be about half the turn; where it is not, the record's bound is the wider for it.
        """
        aside = np.abs(self.direction - self.turn / 2) + self.direction_bound - self.turn_bound / 2
        names = ("distance", "distance_bound", "turn", "turn_bound", "slip_bound")
        return {name: getattr(self, name) for name in names} | {"direction_bound": np.clip(aside, 0, ANY_DIRECTION)}


class Motions:
    """The motion of a run's robots in any interval, from their commands.

    Before its first command a robot stands; a command holds until the next one.
    """

    def __init__(self, run: Run, robots: Sequence[int], bounds: Bounds) -> None:
        """Prepare the integrals of the commands of some robots, by their numbers in the files, which become 0, 1, ..."""
        self.bounds = bounds
        self._commands = [_Commands(run.logs[robot].commands) for robot in robots]

    def motion(self, robot: int, start: Floats, time: Floats) -> Motion:
        """Return how one robot, by its number in the team, moved from `start` to `time`, both (k,) [s].

        The path is scaled and within its bound, but no longer than `reach`. The direction of the displacement is an average
        of the headings on the way, so it is between the least and the greatest turn on the way, plus minus the bound of the
        turn. A robot that drives backwards on the way, or whose commands have stopped, may go anywhere.

        Raises:
            InvalidInput: An interval ends before it starts.
        """
        start, time = np.atleast_1d(finite("start [s]", start)), np.atleast_1d(finite("time [s]", time))
        if (time < start).any():
            raise InvalidInput("intervals that end at their start or later", f"one of {float((time - start).min())} s")
        bounds, commands, length = self.bounds, self._commands[robot], time - start
        begin, end = start - bounds.command_lag, time - bounds.command_lag
        least, greatest = self._path(commands, begin, end, length)
        right, left = commands.turns_within(begin, end)
        turn, turn_bound = commands.turned(begin, end), bound_over(bounds.turn, length)
        anywhere = (commands.slowest_within(begin, end) < 0) | (commands.idle(begin, end) > bounds.hold)
        silent = commands.idle(begin, end) > bounds.hold
        reach, swing = bound_over(bounds.reach, length), bound_over(bounds.swing, length)
        return Motion(
            distance=np.where(silent, 0.0, (least + greatest) / 2),
            distance_bound=np.where(silent, reach, (greatest - least) / 2),
            turn=np.where(silent, 0.0, turn),
            turn_bound=np.where(silent, swing, turn_bound),
            direction=np.where(anywhere, 0.0, (right + left) / 2),
            direction_bound=np.where(anywhere, ANY_DIRECTION, np.minimum((left - right) / 2 + turn_bound, ANY_DIRECTION)),
            slip_bound=bound_over(bounds.slip, length),
        )

    def _path(self, commands: _Commands, begin: Array, end: Array, length: Array) -> tuple[Array, Array]:
        """Return (k,) the least and greatest paths; where a command is beyond reach, it does not shorten the path."""
        driven = self.bounds.speed_scale * commands.driven(begin, end)
        bound, reach = bound_over(self.bounds.distance, length), bound_over(self.bounds.reach, length)
        least, greatest = np.maximum(driven - bound, -reach), np.minimum(driven + bound, reach)
        return np.minimum(least, greatest), np.maximum(least, greatest)


class _Commands:
    """Integrals of one robot's commands, exact for commands that hold until the next one."""

    def __init__(self, commands: Array) -> None:
        standing = np.array([[-np.inf, 0.0, 0.0]])
        self._speed, self._rate = np.vstack([standing, commands])[:, 1:].T
        self._stamps = commands[:, 0]
        steps = np.diff(commands[:, 0])
        self._distance, self._turn = (
            np.concatenate([[0.0], np.cumsum(commands[:-1, column] * steps)])[: len(commands)] for column in (1, 2)
        )

    def driven(self, begin: Array, end: Array) -> Array:
        return self._integral(self._distance, self._speed, end) - self._integral(self._distance, self._speed, begin)

    def turned(self, begin: Array, end: Array) -> Array:
        return self._integral(self._turn, self._rate, end) - self._integral(self._turn, self._rate, begin)

    def turns_within(self, begin: Array, end: Array) -> tuple[Array, Array]:
        """Return (k,) the least and the greatest turn since `begin` on the way to `end`."""
        at_begin, at_end = (self._integral(self._turn, self._rate, time) for time in (begin, end))
        ends = np.minimum(at_begin, at_end), np.maximum(at_begin, at_end)
        least = np.minimum(ends[0], self._over(np.minimum, self._turn, begin, end, np.inf))
        greatest = np.maximum(ends[1], self._over(np.maximum, self._turn, begin, end, -np.inf))
        return least - at_begin, greatest - at_begin

    def slowest_within(self, begin: Array, end: Array) -> Array:
        """Return (k,) the lowest speed that was commanded between `begin` and `end`."""
        at_begin = self._speed[np.searchsorted(self._stamps, begin, side="right")]
        return np.minimum(at_begin, self._over(np.minimum, self._speed[1:], begin, end, np.inf))

    def idle(self, begin: Array, end: Array) -> Array:
        """Return (k,) the longest time between two commands, or since the last one, that reaches into the interval [s]."""
        if not len(self._stamps):
            return np.full(len(begin), np.inf)
        last = np.searchsorted(self._stamps, end, side="right") - 1
        since = np.where(last >= 0, end - self._stamps[last], 0.0)
        gaps = np.append(0.0, np.diff(self._stamps))
        return np.maximum(since, self._over(np.maximum, gaps, begin, end, 0.0))

    def _integral(self, at_stamps: Array, values: Array, time: Array) -> Array:
        after = np.searchsorted(self._stamps, time, side="right")
        last = np.maximum(after - 1, 0)
        if not len(self._stamps):
            return np.zeros(len(time))
        return np.where(after > 0, at_stamps[last] + values[after] * (time - self._stamps[last]), 0.0)

    def _over(self, least: np.ufunc, values: Array, begin: Array, end: Array, none: float) -> Array:
        """Return (k,) the minimum or maximum of the values at the stamps in (begin, end], `none` where there is no stamp."""
        first, last = (np.searchsorted(self._stamps, time, side="right") for time in (begin, end))
        found = np.full(len(begin), none)
        some = np.flatnonzero(first < last)
        if len(some):
            pairs = np.column_stack([first[some], last[some]]).ravel()
            found[some] = least.reduceat(np.append(values, none), pairs)[::2]
        return found
