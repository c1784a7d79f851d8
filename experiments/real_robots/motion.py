"""What the commands of a run say about its robots' motion, for intervals of any length.

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

from experiments.following.frozen import freeze
from experiments.real_robots.bounds import Bounds, bound_over
from experiments.real_robots.data import Run
from filter import Array, Floats, InvalidInput

ANY_DIRECTION = 1.55  # of a record's direction, whose bound must stay below a right angle [rad]


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
        freeze(self)

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

    Attributes:
        bounds: The declared bounds.
        commands: (n) tables (c, 3) of each robot's commands: time [s], speed [m/s], turn rate [rad/s].
    """

    def __init__(self, run: Run, robots: Sequence[int], bounds: Bounds) -> None:
        """Prepare the integrals of the commands of some robots, by their numbers in the files, which become 0, 1, ..."""
        self.bounds = bounds
        self.commands = tuple(run.logs[robot].commands for robot in robots)
        self._commands = [_Commands(table) for table in self.commands]

    def motion(self, robot: int, start: Floats, time: Floats) -> Motion:
        """Return how one robot, by its number in the team, moved from `start` to `time`, both (k,) [s].

        The path is scaled and within its bound, but no longer than `reach`. The displacement has the direction of an average
        of the headings on the way, as long as the robot drives forward (what it rolls back while it stands is slip), so it is
        between the least and the greatest turn on the way, plus minus the bound of the turn. A robot that is told to drive
        backwards on the way, or whose commands have stopped, may have gone in any direction.

        Raises:
            InvalidInput: An interval ends before it starts.
        """
        start, time = np.atleast_1d(np.asarray(start, dtype=float)), np.atleast_1d(np.asarray(time, dtype=float))
        commands, length = self._commands[robot], time - start
        if not (length >= 0).all():
            raise InvalidInput("intervals that end at their start or later", f"one of {float(length.min())} s")
        begin, end = start - self.bounds.command_lag, time - self.bounds.command_lag
        silent = commands.idle(begin, end) > self.bounds.hold
        obeying = vars(self._obeying(commands, begin, end, length))
        columns = {name: np.where(silent, column, obeying[name]) for name, column in vars(self._anything(length)).items()}
        return Motion(**columns)

    def _obeying(self, commands: _Commands, begin: Array, end: Array, length: Array) -> Motion:
        """Return the motion of a robot that obeys its commands of (k,) intervals."""
        least, greatest = self._path(commands, begin, end, length)
        right, left = commands.turns_within(begin, end)
        backwards = commands.slowest_within(begin, end) < 0
        turn_bound = bound_over(self.bounds.turn, length)
        aside = (left - right) / 2 + turn_bound + self.bounds.heading_jitter
        return Motion(
            distance=(least + greatest) / 2,
            distance_bound=(greatest - least) / 2,
            turn=commands.turned(begin, end),
            turn_bound=turn_bound,
            direction=(right + left) / 2,
            direction_bound=np.where(backwards, ANY_DIRECTION, np.minimum(aside, ANY_DIRECTION)),
            slip_bound=bound_over(self.bounds.slip, length),
        )

    def _anything(self, length: Array) -> Motion:
        """Return the motion of a robot that does what it likes."""
        nothing = np.zeros(len(length))
        return Motion(
            distance=nothing,
            distance_bound=bound_over(self.bounds.reach, length) + 2 * self.bounds.position_jitter,
            turn=nothing,
            turn_bound=bound_over(self.bounds.swing, length) + 2 * self.bounds.heading_jitter,
            direction=nothing,
            direction_bound=np.full(len(length), ANY_DIRECTION),
            slip_bound=bound_over(self.bounds.slip, length),
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
