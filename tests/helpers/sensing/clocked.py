"""Teams whose sensors have clocks that are off, for the tests: they measured at another instant than their stamps say."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import TypeVar

import numpy as np
from helpers.sensing.mounted import MountedWorld, turned

from filter import Bearing, Measurement, Position, Range, wrap

Record = TypeVar("Record", bound=Measurement)
WRONG = np.array([0.0, 0.02, 0.1, 0.5])  # how far clocks are off [s]


class ClockedWorld(MountedWorld):
    """A mounted world in which robots, at each stamp, are elsewhere than when sensors measured, as their limits allow."""

    def __post_init__(self) -> None:
        super().__post_init__()
        speed, rate = (self.rng.choice([0.0, 1.0], self.robots) * self.rng.uniform(0, 1.5, self.robots) for _ in range(2))
        sensors = [replace(sensor, time_bound=float(self.rng.choice(WRONG))) for sensor in self.team.sensors]
        self.team = replace(self.team, speed_limit=speed, turn_rate_limit=rate, sensors=sensors)

    def measure(self, time: float = 0.0, bearings: float = 0.7, ranges: float = 0.7, compass: float = 0.5) -> list[Measurement]:
        """Return some readings, each taken at a time of its own."""
        found, bodies = list[Measurement](), self.robots + self.landmarks
        for kind, share in ((Bearing, bearings), (Range, ranges)):
            for who, whom in np.argwhere(self.rng.random((self.robots, bodies)) < share):
                sensor, tag = self.rng.choice([-1, 0, 1], 2)
                sensors = np.array([sensor]), np.array([tag if whom < self.robots else -1])
                if who != whom:
                    found.append(self._late(sensor, partial(self.sighted, kind, time, (who[None], whom[None]), sensors)))
        some = np.argwhere(self.rng.random(self.robots) < compass)
        return [*found, *(self._late(2, partial(self.shown, time, who)) for who in some)]

    def placed(self, time: float = 0.0, share: float = 0.7) -> list[Position]:
        """Return where antennas are, each at a time of its own."""
        some = np.argwhere(self.rng.random((self.robots, 4)) < share) - [0, 1]
        return [self._late(sensor, partial(self._antenna, time, robot, sensor)) for robot, sensor in some.tolist()]

    def _antenna(self, time: float, robot: int, sensor: int) -> Position:
        return self._around(time, robot, sensor, self.places_of(np.array([robot]), np.array([sensor]))[0])

    def _late(self, sensor: int, measured: Callable[[], Record]) -> Record:
        """Return what is measured when the robots are elsewhere: where they can be while a sensor's clock is off."""
        here, off = (self.positions, self.headings), self.team.mountings.time_bound[sensor]
        way = self.rng.uniform(-np.pi, np.pi, self.robots)
        far = off * self.team.speed_limit * self.error(self.robots)
        self.positions = self.positions + turned(way, np.stack([far, np.zeros(self.robots)], axis=1))
        self.headings = wrap(self.headings + off * self.team.turn_rate_limit * self.error(self.robots))
        record = measured()
        self.positions, self.headings = here
        return record
