"""The kinematic world: robots that drive as their wheels say and slip as much as is declared; no physics, for large teams.

It stands in for the MuJoCo world wherever robots are driven and measured. There slip is what friction makes of it, far below
what `Sensors` declares; here it is drawn, up to the bounds.
"""

from __future__ import annotations

import numpy as np

from filter import Array, wrap
from sim.errors import ErrorKind, Errors
from sim.layout import Layout
from sim.sensors import Sensors
from sim.world import TIMESTEP, WALL_HEIGHT, robot_dimensions

LAG = 0.02  # time in which wheels come within 37 % of a new command [s]
# How much of each bound is drawn. The rest is for how a path bends within a step, which is no slip but is in no other bound:
# its chord is shorter than the path, and while speed or turn rate change, its direction is not the mean heading.
DISTANCE_SHARE = 0.6
DIRECTION_SHARE = 0.8
SLIP_SHARE = 0.6
TURN_SHARE = 1 - 1e-9  # a turn has nothing of the kind


class KinematicWorld:
    """Robots 0, 1, ..., n - 1 in an arena, at one instant.

    Attributes:
        robots: Number of robots n.
        arena: (2, 2) lower and upper corner of the box inside the outer walls [m].
        walls: (w, 4) lower x, lower y, upper x, upper y of each wall [m].
        wall_height: Height of the walls [m].
        landmarks: (l, 2) positions of the beacons [m].
        homes: (n, 4) lower x, lower y, upper x, upper y of each robot's home zone [m].
        track: Distance between a robot's two wheels [m].
        wheel_radius: Nominal radius of a wheel [m].
        robot_radius: Radius of the disc around the axle that covers a robot at any heading [m].
        mast_radius: Radius of what hides other robots at the height of the sensors [m].
        time: Time since the start [s].
    """

    def __init__(
        self,
        plan: Layout,
        positions: Array,
        headings: Array,
        *,
        sensors: Sensors,
        errors: ErrorKind,
        generator: np.random.Generator,
    ) -> None:
        """Put the robots down, at rest.

        Args:
            plan: Arena, walls, beacons and home zones.
            positions: (n, 2) where the robots start [m].
            headings: (n,) their yaws [rad].
            sensors: The bounds that slip keeps.
            errors: The kind of errors that slip is.
            generator: Where slip is drawn from.

        Raises:
            InvalidInput: There is no such kind of errors.
        """
        self.robots = len(positions)
        self.arena, self.walls, self.landmarks, self.homes = plan.arena, plan.walls, plan.beacons, plan.homes
        self.wall_height = WALL_HEIGHT
        self.track, self.wheel_radius, self.robot_radius, self.mast_radius = robot_dimensions()
        self._positions, self._headings = positions.copy(), headings.copy()
        self._angles, self._speeds, self._commands = (np.zeros((self.robots, 2)) for _ in range(3))
        self._sensors, self._generator = sensors, generator
        self._errors = Errors(errors, (self.robots, 4), generator)
        self._steps, self._steps_a_slip = 0, max(1, round(sensors.slip_step / TIMESTEP))

    @property
    def time(self) -> float:
        """Time since the start [s]."""
        return self._steps * TIMESTEP

    def positions(self) -> Array:
        """Return (n, 2) where the middles of the axles are [m]."""
        return self._positions.copy()

    def headings(self) -> Array:
        """Return (n,) yaws in (-pi, pi] [rad]."""
        return wrap(self._headings)

    def wheel_angles(self) -> Array:
        """Return (n, 2) angles that left and right wheel have turned since the start, not wrapped [rad]."""
        return self._angles.copy()

    def command(self, wheel_speeds: Array) -> None:
        """Set the (n, 2) speeds that left and right motors strive for [rad/s]."""
        self._commands = np.array(wheel_speeds)

    def step(self, steps: int = 1) -> None:
        """Advance by `steps` timesteps of 5 ms."""
        for _ in range(steps):
            if self._steps % self._steps_a_slip == 0:
                self._draw_slip()
            self._move()
            self._steps += 1

    def _draw_slip(self) -> None:
        """Draw how the robots slip from now on, until `slip_step` is over."""
        sensors, errors = self._sensors, self._errors.draw()
        self._stretch = 1 + DISTANCE_SHARE * sensors.distance_slip * errors[:, 0]
        self._aside = DIRECTION_SHARE * sensors.direction_slip * errors[:, 1]
        self._turning = TURN_SHARE * sensors.turn_slip / sensors.slip_step * errors[:, 2]
        way = self._generator.uniform(-np.pi, np.pi, self.robots)
        speed = SLIP_SHARE * sensors.slip_bound / sensors.slip_step * errors[:, 3]
        self._drift = speed[:, None] * np.stack([np.cos(way), np.sin(way)], axis=1)

    def _move(self) -> None:
        self._speeds += (self._commands - self._speeds) * (1 - np.exp(-TIMESTEP / LAG))
        self._angles += self._speeds * TIMESTEP
        arcs = self._speeds * TIMESTEP * self.wheel_radius
        turn = (arcs[:, 1] - arcs[:, 0]) / self.track + self._turning * TIMESTEP
        way, length = self._headings + turn / 2 + self._aside, arcs.mean(axis=1) * self._stretch
        self._positions += length[:, None] * np.stack([np.cos(way), np.sin(way)], axis=1) + self._drift * TIMESTEP
        self._headings += turn
