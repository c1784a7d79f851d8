"""Sensors that are mounted somewhere on their robots: names, places, angles and clocks, and how far off these can be."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from filter.arrays import Array, Floats, Frozen, Integers, Table, checked, instance, number, several, shown
from filter.errors import InvalidInput
from filter.records.record import place


@dataclass(frozen=True, eq=False)
class Sensor(Frozen):
    """A sensor, or a tag that others measure, and where it is on whatever robot carries it.

    Raises `InvalidInput` if a value is of another type or out of its range.

    Attributes:
        name: What it is called.
        position: (2,) how far forward of its robot's centre, and how far to the left [m].
        position_bound: How far from there it is at most, from 0 on [m].
        angle: Which way its own forward axis points, from the robot's, counter-clockwise, in [-2 pi, 2 pi] [rad].
        angle_bound: How far from there it points at most, in [0, pi] [rad].
        time_bound: How far from its stamp the instant is at most that it measured at, before or after, from 0 on [s]; of a tag
            that others measure it says nothing. Until then the robot, and a robot that is measured, can have driven and
            turned as far as their limits in `Team` allow. So with a sensor of this kind these limits hold always, also for
            robots with odometry, and around the instants at which robots are placed.
    """

    name: str = field(metadata=checked(instance, "name of a sensor", str))
    position: Array = field(default_factory=lambda: np.zeros(2), metadata=checked(place, "position of a sensor [m]"))
    position_bound: float = field(default=0.0, metadata=checked(number, "position bound of a sensor [m]", 0))
    angle: float = field(default=0.0, metadata=checked(number, "angle of a sensor [rad]", -2 * np.pi, 2 * np.pi))
    angle_bound: float = field(default=0.0, metadata=checked(number, "angle bound of a sensor [rad]", 0, np.pi))
    time_bound: float = field(default=0.0, metadata=checked(number, "time bound of a sensor [s]", 0))

    if TYPE_CHECKING:  # sequences are taken, arrays are kept

        def __init__(
            self,
            name: str,
            position: Floats = ...,
            position_bound: float = ...,
            angle: float = ...,
            angle_bound: float = ...,
            time_bound: float = ...,
        ) -> None: ...


@dataclass(frozen=True, eq=False)
class Mountings(Table):
    """How m sensors are mounted on n robots. The last entry, for `AT_THE_CENTRE`, is at the centre and looks forward.

    Attributes:
        position: (m + 1, 2) [m].
        position_bound: (m + 1,) [m].
        angle: (m + 1,) [rad].
        angle_bound: (m + 1,) [rad].
        time_bound: (m + 1,) [s].
        drift: (m + 1, n) how far a robot can be from where it was at the sensor's stamp when that measures [m].
        swing: (m + 1, n) how far its heading can be off then, up to pi [rad].
        spot: (m + 1,) a number for each place on a robot, 0 for the centre: where it is the same, so is the place, for sure.
    """

    position: Array
    position_bound: Array
    angle: Array
    angle_bound: Array
    time_bound: Array
    drift: Array
    swing: Array
    spot: Integers

    @classmethod
    def of(cls, sensors: Sequence[Sensor], speed_limit: Array, turn_rate_limit: Array) -> Mountings:
        """Return how some sensors are mounted on robots with limits (n,) [m/s] and (n,) [rad/s]."""
        every = (*sensors, Sensor("centre"))
        doubtful = [each.position_bound > 0 or each.time_bound > 0 for each in sensors]
        places = [(0.0, 0.0), *((*each.position.tolist(), *[k] * doubtful[k]) for k, each in enumerate(sensors))]
        spot = np.array([*map(places.index, places[1:]), 0])
        names = ("position", "position_bound", "angle", "angle_bound", "time_bound")
        columns = {name: np.array([getattr(each, name) for each in every]) for name in names}
        drift, swing = (np.outer(columns["time_bound"], limit) for limit in (speed_limit, turn_rate_limit))
        return cls(**columns, drift=drift, swing=np.minimum(swing, np.pi), spot=spot)

    def astray(self, clock: Integers, sensor: Integers, robot: Integers) -> Array:
        """Return how far (k,) sensors on robots can be from where they were at the stamps of others, their clocks, (k,) [m]."""
        length = np.hypot(self.position[sensor, 0], self.position[sensor, 1])
        return np.asarray(self.drift[clock, robot] + length * self.swing[clock, robot])

    def off(self, ends: tuple[Integers, Integers], sensors: tuple[Integers, Integers]) -> Array:
        """Return how far (k,) the ways from sensors to those of targets can be others than as mounted, at the stamps [m].

        Ends are robots and targets (k,), sensors those that measured and those that were measured (k,).
        """
        (robot, target), (sensor, tag) = ends, sensors
        off = self.position_bound[sensor] + self.position_bound[tag] + self.astray(sensor, sensor, robot)
        moving = np.flatnonzero(target < self.drift.shape[1])
        off[moving] += self.astray(sensor[moving], tag[moving], target[moving])
        return np.asarray(off)


def sensors_in(values: Iterable[Sensor]) -> tuple[Sensor, ...]:
    """Return sensors, from whatever holds them; raises `InvalidInput` if something is none, or has the name of another."""
    sensors = several("sensors", values, Sensor)
    names = [sensor.name for sensor in sensors]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InvalidInput("sensors with names, no two alike", f"{shown(twice)} twice")
    return sensors
