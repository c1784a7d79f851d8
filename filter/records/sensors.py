"""Sensors that are mounted somewhere on their robots: their names, places and angles, and how far off these can be."""

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
    """

    name: str = field(metadata=checked(instance, "name of a sensor", str))
    position: Array = field(default_factory=lambda: np.zeros(2), metadata=checked(place, "position of a sensor [m]"))
    position_bound: float = field(default=0.0, metadata=checked(number, "position bound of a sensor [m]", 0))
    angle: float = field(default=0.0, metadata=checked(number, "angle of a sensor [rad]", -2 * np.pi, 2 * np.pi))
    angle_bound: float = field(default=0.0, metadata=checked(number, "angle bound of a sensor [rad]", 0, np.pi))

    if TYPE_CHECKING:  # sequences are taken, arrays are kept

        def __init__(
            self,
            name: str,
            position: Floats = ...,
            position_bound: float = ...,
            angle: float = ...,
            angle_bound: float = ...,
        ) -> None: ...


@dataclass(frozen=True, eq=False)
class Mountings(Table):
    """How m sensors are mounted. The last entry, for `AT_THE_CENTRE`, is at the centre and looks forward.

    Attributes:
        position: (m + 1, 2) [m].
        position_bound: (m + 1,) [m].
        angle: (m + 1,) [rad].
        angle_bound: (m + 1,) [rad].
        spot: (m + 1,) a number for each place on a robot, 0 for the centre: where it is the same, so is the place, for sure.
    """

    position: Array
    position_bound: Array
    angle: Array
    angle_bound: Array
    spot: Integers

    @classmethod
    def of(cls, sensors: Sequence[Sensor]) -> Mountings:
        """Return how some sensors are mounted."""
        every = (*sensors, Sensor("centre"))
        places = [(0.0, 0.0), *((*each.position.tolist(), *[k] * (each.position_bound > 0)) for k, each in enumerate(sensors))]
        spot = [*map(places.index, places[1:]), 0]
        names = ("position", "position_bound", "angle", "angle_bound")
        return cls(**{name: np.array([getattr(each, name) for each in every]) for name in names}, spot=np.array(spot))


def sensors_in(values: Iterable[Sensor]) -> tuple[Sensor, ...]:
    """Return sensors, from whatever holds them; raises `InvalidInput` if something is none, or has the name of another."""
    sensors = several("sensors", values, Sensor)
    names = [sensor.name for sensor in sensors]
    if len(set(names)) < len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise InvalidInput("sensors with names, no two alike", f"{shown(twice)} twice")
    return sensors
