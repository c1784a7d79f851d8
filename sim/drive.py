"""Wandering without touching: every robot drives between random places of its home zone and keeps clear of everything.

The driver knows the truth; it is not what is being estimated. It has to keep clear, as a bump breaks every bound on slip.

Algorithm: each robot weighs some directions. In each, its speed is limited by every obstacle near: the speed *towards* an
obstacle may be at most a share of the gap to it, so gaps shrink like exp(-t) and never close; between two robots each takes
half. The same limit holds along the robot's present heading and where it will be in a moment, whatever direction it chose, so
steering cannot break it. Turning on the spot is always allowed, as a robot is covered by a disc around its axle.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter import Array, Integers, Mask, wrap
from sim.geometry import distance_to_segment, distance_to_wall, meets_wall, near, near_walls, nearest_on_wall
from sim.kinematic import KinematicWorld
from sim.world import TIMESTEP, World

CONTROL_STEPS = 10  # timesteps between two decisions
SPEED_LIMIT = 0.4  # what no robot exceeds with the default way of driving, overshoot of the motors included [m/s]


@dataclass(frozen=True)
class Driving:
    """How robots drive.

    Attributes:
        speed: Greatest speed [m/s]; they never reverse.
        turn_rate: Greatest turn rate [rad/s].
        acceleration: Greatest change of speed when speeding up [m/s^2].
        braking: Greatest change of speed when slowing down [m/s^2].
        turn_acceleration: Greatest change of turn rate [rad/s^2].
        margin: Distance that is always kept between hulls and to walls [m].
        approach: Speed towards an obstacle for each metre of gap [1/s].
        steering: Turn rate for each radian off the direction [1/s].
        arrival: Distance at which a waypoint counts as reached [m].
        patience: How long a robot stands still before it wants to be elsewhere [s].
    """

    speed: float = 0.35
    turn_rate: float = 1.5
    acceleration: float = 0.6
    braking: float = 1.2
    turn_acceleration: float = 5.0
    margin: float = 0.07
    approach: float = 1.6
    steering: float = 2.5
    arrival: float = 0.3
    patience: float = 1.0


CANDIDATES = np.linspace(-np.pi, np.pi, 24, endpoint=False)  # directions to weigh, from the waypoint's [rad]
NEAREST = 8  # obstacles that count; no more fit around a robot
SOON = 0.2  # how far ahead in a turn the speed limit looks [s]
TRIES = 12  # places to draw for one waypoint
CORRIDOR = 0.2  # what must be free beside the straight line to a waypoint [m]
SLOW = 0.05  # below this a robot stands still [m/s]
TURN_COST = 0.12  # speed that a robot gives up rather than turn by half a circle [m/s]
KEEP_RIGHT = 0.02  # speed that a robot gives up to pass others on the right, so that two never dance [m/s]


class Driver:
    """Drives the robots of one world; asks them what to do every 50 ms and ramps the wheels every 5 ms."""

    def __init__(self, world: World | KinematicWorld, generator: np.random.Generator, driving: Driving | None = None) -> None:
        """Take the wheel.

        Args:
            world: The world to drive in, robots at rest.
            generator: Where waypoints are drawn from.
            driving: How to drive.
        """
        self._world, self._generator, self._driving = world, generator, driving or Driving()
        self._speed, self._rate = np.zeros(world.robots), np.zeros(world.robots)
        self._wanted_speed, self._wanted_rate = np.zeros(world.robots), np.zeros(world.robots)
        self._waypoints = world.positions()
        self._stood = np.zeros(world.robots)
        self._steps = 0

    def advance(self, steps: int) -> None:
        """Drive for `steps` timesteps; how they are split into calls makes no difference."""
        for _ in range(steps):
            if self._steps % CONTROL_STEPS == 0:
                self._decide()
            self._ramp()
            self._world.step()
            self._steps += 1

    def _ramp(self) -> None:
        driving, world = self._driving, self._world
        change = np.clip(self._wanted_speed - self._speed, -driving.braking * TIMESTEP, driving.acceleration * TIMESTEP)
        turn_change = driving.turn_acceleration * TIMESTEP
        self._speed = self._speed + change
        self._rate = self._rate + np.clip(self._wanted_rate - self._rate, -turn_change, turn_change)
        half_difference = self._rate * world.track / 2
        wheels = np.stack([self._speed - half_difference, self._speed + half_difference], axis=1)
        world.command(wheels / world.wheel_radius)

    def _decide(self) -> None:
        driving = self._driving
        positions, headings = self._world.positions(), self._world.headings()
        self._renew_waypoints(positions)
        to_goal = self._waypoints - positions
        goal = np.arctan2(to_goal[:, 1], to_goal[:, 0])
        soon = headings + self._rate * SOON
        directions = np.concatenate([headings[:, None], soon[:, None], goal[:, None] + CANDIDATES], axis=1)
        limits = self._speed_limits(positions, directions)
        best, speed = self._choose(directions[:, 2:], limits[:, 2:], goal, headings)
        off = wrap(best - headings)
        self._wanted_rate = np.clip(driving.steering * off, -driving.turn_rate, driving.turn_rate)
        along = speed * np.maximum(np.cos(off), 0) ** 2
        self._wanted_speed = np.minimum(along, limits[:, :2].min(axis=1))

    def _choose(self, directions: Array, limits: Array, goal: Array, headings: Array) -> tuple[Array, Array]:
        """Return each robot's (n,) best direction [rad] and the speed it allows [m/s]."""
        progress = limits * np.cos(directions - goal[:, None])
        turn = np.abs(wrap(directions - headings[:, None])) / np.pi
        rightwards = np.sin(goal[:, None] - directions)
        score = progress - TURN_COST * turn + KEEP_RIGHT * rightwards
        rows, best = np.arange(len(goal)), score.argmax(axis=1)
        return directions[rows, best], limits[rows, best]

    def _speed_limits(self, positions: Array, directions: Array) -> Array:
        """Return (n, d) greatest speeds in each of the (n, d) directions [m/s]."""
        towards, closing = self._obstacles(positions)
        units = np.stack([np.cos(directions), np.sin(directions)], axis=2)
        share = np.maximum(units @ towards.transpose(0, 2, 1), 1e-9)
        return np.clip((closing[:, None, :] / share).min(axis=2), 0, self._driving.speed)

    def _obstacles(self, positions: Array) -> tuple[Array, Array]:
        """Return (n, m, 2) unit vectors to each robot's nearest obstacles and (n, m) greatest speeds towards them [m/s].

        Obstacles so far away that they allow full speed are left out.
        """
        world, driving = self._world, self._driving
        covered, reach = world.robot_radius + driving.margin, driving.speed / driving.approach
        standing, offsets = self._to_standing(positions, covered + reach)
        robot, others = self._to_robots(positions, covered + world.robot_radius + 2 * reach)
        distances, apart = np.linalg.norm(offsets, axis=1), np.linalg.norm(others, axis=1)
        closing = (distances - covered) * driving.approach
        both_closing = (apart - covered - world.robot_radius) * driving.approach / 2
        return self._nearest(
            np.concatenate([robot, standing]),
            np.concatenate([others, offsets]),
            np.concatenate([apart, distances]),
            np.concatenate([both_closing, closing]),
        )

    def _to_robots(self, positions: Array, reach: float) -> tuple[Integers, Array]:
        """Return which robots (k,) have another one within reach, and where from there (k, 2) [m]."""
        one, other = near(positions, positions, np.full(len(positions), reach))
        one, other = one[one != other], other[one != other]
        return one, positions[other] - positions[one]

    def _to_standing(self, positions: Array, reach: float) -> tuple[Integers, Array]:
        """Return which robots (k,) have a beacon or a wall within reach, and where from there (k, 2) [m]."""
        world = self._world
        beacon, robot = near(positions, world.landmarks, np.full(len(world.landmarks), reach))
        to_beacons = world.landmarks[beacon] - positions[robot]
        beside, wall = near_walls(positions, world.walls, np.full(len(positions), reach))
        to_walls = nearest_on_wall(positions[beside], world.walls[wall]) - positions[beside]
        return np.concatenate([robot, beside]), np.concatenate([to_beacons, to_walls])

    def _nearest(self, robot: Integers, offsets: Array, distances: Array, closing: Array) -> tuple[Array, Array]:
        """Return unit vectors and speeds of the obstacles of each robot that allow the least; where it has fewer, no limit."""
        order = np.lexsort([closing, robot])
        robot, offsets, distances, closing = robot[order], offsets[order], distances[order], closing[order]
        place = np.arange(len(robot)) - np.searchsorted(robot, robot)
        kept = place < NEAREST
        at = robot[kept], place[kept]
        towards, limits = np.zeros((self._world.robots, NEAREST, 2)), np.full((self._world.robots, NEAREST), np.inf)
        towards[at] = offsets[kept] / np.maximum(distances[kept], 1e-9)[:, None]
        limits[at] = np.maximum(closing[kept], 0)
        return towards, limits

    def _renew_waypoints(self, positions: Array) -> None:
        stands = (self._speed < SLOW) & (np.abs(self._rate) < SLOW)
        self._stood = np.where(stands, self._stood + CONTROL_STEPS * TIMESTEP, 0)
        arrived = np.linalg.norm(self._waypoints - positions, axis=1) < self._driving.arrival
        renew = np.flatnonzero(arrived | (self._stood > self._driving.patience))
        if len(renew):
            self._waypoints[renew] = self._draw_waypoints(positions, renew)
            self._stood[renew] = 0

    def _draw_waypoints(self, positions: Array, robots: Integers) -> Array:
        """Return (k, 2), the first of some drawn places that each robot can drive straight to; else where it is."""
        homes = self._world.homes[robots]
        places = self._generator.uniform(homes[:, None, :2], homes[:, None, 2:], (len(robots), TRIES, 2))
        starts = np.repeat(positions[robots], TRIES, axis=0)
        free = self._reachable(starts, places.reshape(-1, 2)).reshape(len(robots), TRIES)
        chosen = places[np.arange(len(robots)), free.argmax(axis=1)]
        return np.where(np.any(free, axis=1, keepdims=True), chosen, positions[robots])

    def _reachable(self, starts: Array, ends: Array) -> Mask:
        """Return (k,), whether nothing is in the corridor from start to end, and the end is clear of walls."""
        world = self._world
        middles, half = (starts + ends) / 2, np.linalg.norm(ends - starts, axis=1) / 2
        way, wall = near_walls(middles, world.walls, half + 2 * CORRIDOR)
        walls, first, last = world.walls[wall], starts[way], ends[way]
        # A robot may stand nearer to a wall than the corridor is wide, and still has to get away.
        corridor = np.minimum(CORRIDOR, distance_to_wall(first, walls) * 0.9)
        blocked = meets_wall(first, last, walls + corridor[:, None] * np.array([-1, -1, 1, 1]))
        blocked |= distance_to_wall(last, walls) < 2 * CORRIDOR
        past, beacon = near(world.landmarks, middles, half + CORRIDOR)
        bumps = distance_to_segment(world.landmarks[beacon], starts[past], ends[past]) <= CORRIDOR
        return np.bincount(np.concatenate([way[blocked], past[bumps]]), minlength=len(starts)) == 0
