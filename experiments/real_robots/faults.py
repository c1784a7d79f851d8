"""Faults that are put into a copy of a run's tables, to see who notices. Times are since the first stamp of any log [s]."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace

import numpy as np

from experiments.real_robots.bounds import DEGREE
from experiments.real_robots.data import RobotLog, Tables
from filter import Array, InvalidInput, wrap

Fault = Callable[[Tables, int], Tables]


def silent(tables: Tables, robot: int, start: float = 300.0, duration: float = 60.0) -> Tables:
    """Return the tables without the robot's commands and measurements for a while."""
    begin = _begin(tables) + start

    def heard(table: Array) -> Array:
        return table[(table[:, 0] < begin) | (table[:, 0] > begin + duration)]

    log = tables.logs[robot]
    return _with(tables, robot, replace(log, commands=heard(log.commands), measurements=heard(log.measurements)))


def biased(tables: Tables, robot: int, start: float = 300.0, bias: float = 20 * DEGREE) -> Tables:
    """Return the tables with a constant error of the robot's bearings [rad] from some time on: its camera was knocked."""
    log = tables.logs[robot]
    measurements = log.measurements.copy()
    late = measurements[:, 0] >= _begin(tables) + start
    measurements[late, 3] = wrap(measurements[late, 3] + bias)
    return _with(tables, robot, replace(log, measurements=measurements))


def biased_right(tables: Tables, robot: int, start: float = 300.0) -> Tables:
    """Return the tables with the robot's camera knocked to the other side."""
    return biased(tables, robot, start, -20 * DEGREE)


def swapped(tables: Tables, robot: int) -> Tables:
    """Return the tables with all barcodes of the robot and of the next one in the team swapped."""
    other = next_to(robot, sorted(tables.logs))
    names = {robot: other, other: robot}
    return replace(tables, barcodes={barcode: names.get(subject, subject) for barcode, subject in tables.barcodes.items()})


def exchanged(tables: Tables, robot: int, start: float = 300.0) -> Tables:
    """Return the tables with these barcodes swapped in the middle of the run: in all logs from some time on."""
    codes = {subject: barcode for barcode, subject in tables.barcodes.items()}
    one, other = codes[robot], codes[next_to(robot, sorted(tables.logs))]
    begin = _begin(tables) + start
    return replace(tables, logs={name: _exchanged(log, one, other, begin) for name, log in tables.logs.items()})


def duplicated(tables: Tables, robot: int) -> Tables:
    """Return the tables with the robot's log written twice, one after the other."""
    log = tables.logs[robot]
    commands, measurements = (np.concatenate([table, table]) for table in (log.commands, log.measurements))
    return _with(tables, robot, replace(log, commands=commands, measurements=measurements))


def shifted(tables: Tables, robot: int, by: float = 0.5) -> Tables:
    """Return the tables with the robot's clock wrong by so much [s]: all its stamps are late. The truth keeps its clock."""
    log = tables.logs[robot]
    return _with(tables, robot, replace(log, commands=_late(log.commands, by), measurements=_late(log.measurements, by)))


def shifted_camera(tables: Tables, robot: int, by: float = 0.5) -> Tables:
    """Return the tables with the clock of the robot's camera wrong by so much [s], and that of its commands right."""
    log = tables.logs[robot]
    return _with(tables, robot, replace(log, measurements=_late(log.measurements, by)))


EVERY = (silent, biased, biased_right, swapped, exchanged, duplicated, shifted, shifted_camera)
FAULTS: Mapping[str, Fault] = {fault.__name__: fault for fault in EVERY}
BEGINS = {"silent": 300.0, "biased": 300.0, "biased_right": 300.0, "exchanged": 300.0}  # the others are there all along [s]


def faulty(tables: Tables, fault: str, robot: int) -> Tables:
    """Return the tables with a fault of one robot, by its number in the files.

    Raises:
        InvalidInput: There is no such fault, or no such robot.
    """
    if fault not in FAULTS:
        raise InvalidInput(f"a fault among {', '.join(FAULTS)}", repr(fault))
    if robot not in tables.logs:
        raise InvalidInput(f"a robot among {sorted(tables.logs)}", robot)
    return FAULTS[fault](tables, robot)


def next_to(robot: int, robots: list[int]) -> int:
    """Return the robot that comes next in a team, by their numbers in the files."""
    return robots[(robots.index(robot) + 1) % len(robots)]


def _exchanged(log: RobotLog, one: int, other: int, start: float) -> RobotLog:
    """Return a log with two barcodes exchanged from some time on [s]."""
    measurements = log.measurements.copy()
    late, barcode = measurements[:, 0] >= start, log.measurements[:, 1]
    measurements[late & (barcode == one), 1], measurements[late & (barcode == other), 1] = other, one
    return replace(log, measurements=measurements)


def _late(table: Array, by: float) -> Array:
    return np.column_stack([table[:, 0] + by, table[:, 1:]])


def _begin(tables: Tables) -> float:
    stamped = [table for log in tables.logs.values() for table in (log.commands, log.measurements) if len(table)]
    return min((float(table[:, 0].min()) for table in stamped), default=0.0)


def _with(tables: Tables, robot: int, log: RobotLog) -> Tables:
    return replace(tables, logs={**tables.logs, robot: log})
