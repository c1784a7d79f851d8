"""A run made harder, as other robots and other days may be: larger errors, worse clocks, more barcodes taken for others.

Bounds that hold on such runs, too, were not fitted to the one they were tried on.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from experiments.real_robots.bounds import DEGREE, Bounds
from experiments.real_robots.data import RobotLog, Run, Tables, run_of
from experiments.real_robots.frames import truth_at
from filter import Array, wrap

MISREAD = np.array([1.5, 15 * DEGREE])  # an error beyond one of these, [m] and [rad], is a barcode that was taken for another
BURST = 4  # pictures in which one is taken for another, at most
BLIND = 170.0  # the longest time in which a robot of three runs saw nothing [s]
GAP, GAP_EVERY = 1.4, 30.0  # the longest time without commands in three runs, and how often it is one here [s]


@dataclass(frozen=True)
class Harder:
    """How a run is made harder, for all its robots alike; the defaults leave it as it is.

    Attributes:
        errors: Errors of ranges and bearings are so many times as large, but for barcodes that were taken for others.
        ranges: Measured ranges are so many times as long.
        camera: All cameras are turned by so much [rad].
        measured: Measurements are stamped so much later [s].
        obeyed: Commands are stamped so much earlier, and so obeyed later [s].
        speed: Commanded speeds are so many times as large; the robots drive as before.
        turn: So are turn rates.
        misread: So large a share of the measurements has another barcode than it should, in bursts.
        gaps: Commands that are obeyed are missing every now and then, and each robot sees nothing for a while.
    """

    errors: float = 1.0
    ranges: float = 1.0
    camera: float = 0.0
    measured: float = 0.0
    obeyed: float = 0.0
    speed: float = 1.0
    turn: float = 1.0
    misread: float = 0.0
    gaps: bool = False

    def made_of(self, tables: Tables, generator: np.random.Generator) -> Tables:
        """Return a run's tables, made harder; chance decides which barcodes are misread, and when there are gaps."""
        run, logs = run_of(tables), {}
        end = max((float(log.commands[-1, 0]) for log in run.logs.values() if len(log.commands)), default=0.0)
        for robot, log in sorted(tables.logs.items()):
            seen = replace(log, measurements=self._measured(log.measurements, _true(tables, run, robot)))
            seen = _misread(seen, self.misread, np.array(sorted(tables.barcodes)), generator)
            told = seen.commands * [1, self.speed, self.turn] - np.array([self.obeyed, 0, 0])
            logs[robot] = replace(seen, commands=told)
            if self.gaps:
                logs[robot] = _with_gaps(logs[robot], run.epoch, end, generator)
        return replace(tables, logs=logs)

    def _measured(self, table: Array, true: Array) -> Array:
        """Return measurements (m, 4) with other errors; (m, 2) are the true ranges and bearings."""
        error = table[:, 2:] - true
        error[:, 1] = wrap(error[:, 1])
        plain = (np.abs(error) < MISREAD).all(axis=1, keepdims=True)  # False where there is no truth
        said = np.where(plain, true + self.errors * error, table[:, 2:])
        possible = table[:, 2] >= 0  # what is not stays as it is, to be dropped
        distance = np.where(possible, np.maximum(self.ranges * said[:, 0], 0.0), table[:, 2])
        bearing = wrap(said[:, 1] + self.camera)
        return np.column_stack([table[:, 0] + self.measured, table[:, 1], distance, bearing])


# Each is a step beyond what three runs show: their worst camera is 0.76 degrees off, ranges are 0.98 to 1.0035 times as long,
# measurements 0.02 to 0.10 s late, commands obeyed after 0.16 to 0.20 s, speeds 0.90 to 0.93 of the commanded ones, and 0.04 %
# of the barcodes misread.
HARDER: Mapping[str, Harder] = {
    "as_it_is": Harder(),
    "errors_1.2": Harder(errors=1.2),
    "errors_1.3": Harder(errors=1.3),
    "errors_1.5": Harder(errors=1.5),
    "errors_2": Harder(errors=2.0),
    "ranges_short": Harder(ranges=0.98),
    "ranges_long": Harder(ranges=1.02),
    "cameras_left": Harder(camera=0.8 * DEGREE),
    "cameras_right": Harder(camera=-0.8 * DEGREE),
    "measured_earlier": Harder(measured=-0.04),
    "measured_later": Harder(measured=0.06),
    "obeyed_earlier": Harder(obeyed=-0.08),
    "obeyed_later": Harder(obeyed=0.08),
    "slower": Harder(speed=1.05, turn=1.05),
    "faster": Harder(speed=0.95, turn=0.95),
    "misread": Harder(misread=0.0013),
    "gaps": Harder(gaps=True),
    "together": Harder(1.2, 0.99, 0.4 * DEGREE, 0.02, 0.03, 1.02, 1.02, 0.0004, gaps=True),
}


def _misread(log: RobotLog, share: float, codes: Array, generator: np.random.Generator) -> RobotLog:
    """Return a log in which bursts of measurements of one barcode, a picture after the other, have another."""
    measurements = log.measurements.copy()
    bursts = generator.poisson(2 * share * len(measurements) / (1 + BURST))
    for first in generator.choice(len(measurements), bursts).tolist():
        same = first + np.flatnonzero(measurements[first:, 1] == measurements[first, 1])
        measurements[same[: generator.integers(1, BURST + 1)], 1] = generator.choice(codes)
    return replace(log, measurements=measurements)


def _with_gaps(log: RobotLog, epoch: float, end: float, generator: np.random.Generator) -> RobotLog:
    """Return a log without some commands every half a minute, and without any measurement for a while."""
    blind = min(BLIND, end / 3)
    since = log.commands[:, :1] - epoch - np.arange(generator.uniform(0, GAP_EVERY), end, GAP_EVERY)
    lost = np.any((since >= 0) & (since < GAP), axis=1)
    after = log.measurements[:, 0] - epoch - generator.uniform(0, end - blind)
    return replace(log, commands=log.commands[~lost], measurements=log.measurements[(after < 0) | (after > blind)])


def _true(tables: Tables, run: Run, robot: int) -> Array:
    """Return (m, 2) true range and bearing of a robot's measurements, NaN where they are not known."""
    table, robots = tables.logs[robot].measurements, sorted(tables.logs)
    subjects = {subject: k for k, subject in enumerate([*robots, *tables.landmarks[:, 0].astype(int).tolist()])}
    named = np.array([subjects.get(tables.barcodes.get(int(barcode), robot), -1) for barcode in table[:, 1]], dtype=np.int64)
    truth, mine = truth_at(run, robots, table[:, 0] - run.epoch - Bounds().measurement_delay), robots.index(robot)
    landmarks = np.broadcast_to(tables.landmarks[:, 1:], (len(table), len(tables.landmarks), 2))
    bodies = np.concatenate([truth.positions, landmarks], axis=1)
    away = bodies[np.arange(len(table)), named] - truth.positions[:, mine]
    away[(named == mine) | (named < 0)] = np.nan
    return np.column_stack([np.hypot(*away.T), wrap(np.arctan2(away[:, 1], away[:, 0]) - truth.headings[:, mine])])
