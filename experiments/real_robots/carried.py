"""The same frames with bounds for a filter that carries a heading along: quick jitter apart from slow drift.

A robot's heading is within `jitter` of a *carried* heading that turns as commanded, but for a slow drift. The records here are
about the carried heading: odometry has the drift alone, bearings and directions of motion have the jitter in their bounds. So
chained records add up no jitter, which short ones would otherwise do (see `experiments.real_robots.motion`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from experiments.following.frozen import keep_within
from experiments.following.scenarios import Scenario
from experiments.logs import InitialSet
from experiments.real_robots.bounds import DEGREE
from experiments.real_robots.motion import Motions
from filter import Array, Bearing, Floats, Frame, Measurement, Odometry, Range

FAR = 1e7  # before and after all commands [s]
ROUNDING = 1e-12  # by which sums of bounds are larger [rad]


@dataclass(frozen=True)
class CarriedBounds:
    """Bounds for all robots and runs. Where they come from is in docs/real-robots.md.

    Attributes:
        bearing: Of the camera [rad].
        jitter: Of the heading around the carried one [rad].
        range: Absolute part of the bound of a range, with the position's own jitter [m].
        shortest: A measured range is short of the true one by at most this share, ...
        longest: ... and beyond it by at most this one.
        command_lag: A command is obeyed so long after its stamp [s].
        speed_scale: Driven path over commanded path.
        turn_scale: Turn over commanded turn.
        turn_share: The turn's error is at most this share of all that was turned, to either side, ...
        turn_drift: ... and so much besides [rad/s].
        distance_share: The path's error is at most this share of it, ...
        distance_drift: ... and so much besides [m/s].
        slip: Across the robot's axis [m/s].

    Raises:
        InvalidInput: A value is not finite or out of its range.
    """

    bearing: float = 4.0 * DEGREE
    jitter: float = 2.5 * DEGREE
    range: float = 0.03
    shortest: float = 0.14
    longest: float = 0.09
    command_lag: float = 0.2
    speed_scale: float = 0.93
    turn_scale: float = 0.96
    turn_share: float = 0.15
    turn_drift: float = 0.5 * DEGREE
    distance_share: float = 0.3
    distance_drift: float = 0.004
    slip: float = 0.005

    def __post_init__(self) -> None:
        keep_within(self, **dict.fromkeys(vars(self), (0, np.inf)) | {"shortest": (0, 0.999)})

    def seen(self, record: Measurement) -> Measurement:
        """Return a record with these bounds.

        A range r with r <= (1 + longest) t + range and r >= (1 - shortest) t - range for the true one t: measured on a scale on
        which both shares are the same.
        """
        if isinstance(record, Bearing):
            bound = self.bearing + self.jitter
            return Bearing(record.time, record.robot, record.target, record.bearing, np.full(len(record.robot), bound))
        if isinstance(record, Range):
            scale = 2 / (2 + self.longest - self.shortest)
            absolute, relative = self.range * scale, (self.longest + self.shortest) / 2 * scale
            ones = np.ones(len(record.robot))
            return Range(record.time, record.robot, record.target, record.range * scale, absolute * ones, relative * ones)
        return record


class Carried:
    """Turns frames into frames about carried headings."""

    def __init__(self, motions: Motions, bounds: CarriedBounds | None = None) -> None:
        """Prepare the integrals of all commands."""
        self.bounds = bounds or CarriedBounds()
        tables = [_with_silence(table, motions.bounds.hold) for table in motions.commands]
        self._stamps = [table[:, 0] + self.bounds.command_lag for table in tables]
        self._integrals = [_integrals(table) for table in tables]

    def frame(self, frame: Frame) -> Frame:
        """Return a frame with its motion and its bounds made anew; the rest is the same.

        A robot whose commands have stopped is left out of the odometry: nothing is known of its motion.
        """
        records = tuple(self.bounds.seen(record) for record in frame.measurements)
        odometry = None if frame.odometry is None else self._odometry(frame.odometry.start, frame.odometry.time)
        return Frame(frame.time, odometry, records, frame.truth)

    def scenario(self, scenario: Scenario) -> Scenario:
        """Return a scenario with its frames made anew, and its initial headings as those of the carried ones."""
        initial = tuple(InitialSet(known.vertices, self._heading(known), known.there) for known in scenario.initial)
        return replace(scenario, initial=initial, frames=map(self.frame, scenario.frames))

    def _heading(self, known: InitialSet) -> tuple[float, float] | None:
        if known.heading is None:
            return None
        centre, bound = known.heading
        return centre, min(bound + self.bounds.jitter + ROUNDING, np.pi)

    def moved(self, robot: int, start: Floats, time: Floats) -> Array:
        """Return (..., 5) what a robot was told from one time to another [s], numbers or arrays of one shape.

        Path and its absolute value [m], turn and its absolute value [rad], and for how long its commands had stopped [s].
        """
        stamps, integrals = self._stamps[robot], self._integrals[robot]
        ends = np.array([start, time])
        last = np.searchsorted(stamps, ends, side="right") - 1
        share = (ends - stamps[last]) / (stamps[last + 1] - stamps[last])
        at_ends = integrals[last] + share[..., None] * (integrals[last + 1] - integrals[last])
        return np.asarray(at_ends[1] - at_ends[0])

    def _odometry(self, start: float, time: float) -> Odometry:
        moved = np.array([self.moved(robot, start, time) for robot in range(len(self._stamps))])
        robot = np.flatnonzero(moved[:, 4] == 0)
        distance, path, turn, turned = moved[robot, :4].T
        bounds, duration = self.bounds, time - start
        return Odometry(
            start=start,
            time=time,
            robot=robot,
            distance=bounds.speed_scale * distance,
            distance_bound=bounds.distance_share * bounds.speed_scale * path + bounds.distance_drift * duration,
            turn=bounds.turn_scale * turn,
            turn_bound=bounds.turn_share * turned + bounds.turn_drift * duration,
            direction_bound=np.full(len(robot), bounds.jitter),
            slip_bound=np.full(len(robot), bounds.slip * duration),
        )


def _with_silence(table: Array, hold: float) -> Array:
    """Return commands (c, 4) with a column that is 1 where they have stopped, after a robot has held one for so long [s]."""
    ends = np.append(table[1:, 0], FAR)
    stops = table[ends - table[:, 0] > hold, 0] + hold
    standing, silent = np.zeros((len(table), 1)), np.zeros((len(stops), 4))
    silent[:, 0], silent[:, 3] = stops, 1.0
    unknown = float(not len(table))  # a robot stands before its first command, but not if nobody knows of any
    edges = np.array([[-FAR, 0.0, 0.0, unknown], [FAR, 0.0, 0.0, 0.0]])
    rows = np.concatenate([edges[:1], np.hstack([table, standing]), silent, edges[1:]])
    return rows[np.argsort(rows[:, 0], kind="stable")]


def _integrals(table: Array) -> Array:
    """Return (c, 5) integrals up to each command: of speed, |speed|, turn rate, |turn rate|, and the time of silence."""
    _, speed, rate, silent = table.T
    rates = np.stack([speed, np.abs(speed), rate, np.abs(rate), silent], axis=1)
    return np.concatenate([np.zeros((1, 5)), np.cumsum(rates[:-1] * np.diff(table[:, 0])[:, None], axis=0)])
