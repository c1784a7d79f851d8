"""Teams whose sensors and tags are mounted somewhere on the robots, for the tests: measured from where they really are."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import numpy as np

from filter import (
    AngularIntervals,
    Array,
    Bearing,
    Belief,
    Compass,
    Frame,
    Integers,
    Measurement,
    Odometry,
    Polygon,
    Position,
    Range,
    RelativeHeading,
    Sensor,
    SetMembershipFilter,
    Team,
    wrap,
)


def turned(by: Array, vectors: Array) -> Array:
    """Return vectors (k, 2) turned by (k,) angles [rad]."""
    sine, cosine = np.sin(by), np.cos(by)
    return np.stack([cosine * vectors[:, 0] - sine * vectors[:, 1], sine * vectors[:, 0] + cosine * vectors[:, 1]], axis=1)


def rotation(angle: float) -> Array:
    """Return the (2, 2) matrix that turns by an angle [rad]."""
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@dataclass
class MountedWorld:
    """A team that stands, with every error at its bound or within it.

    Attributes:
        rng: What draws.
        robots: How many.
        landmarks: How many.
        reach: How far sensors are from the centre at most [m].
        bound: How far they are off at most, in places [m] and in angles [rad].
        sloppy: Bounds of readings, in angles [rad] and of ranges [m].
    """

    rng: np.random.Generator
    robots: int = 2
    landmarks: int = 3
    reach: float = 0.5
    bound: float = 0.01
    sloppy: float = 0.03

    def __post_init__(self) -> None:
        rng = self.rng
        self.positions = rng.uniform(-3, 3, (self.robots, 2))
        self.headings = wrap(rng.choice([0.0, np.pi, -np.pi / 2, 2.0], self.robots) + rng.uniform(-0.1, 0.1, self.robots))
        marks = rng.uniform(-4, 4, (self.landmarks, 2))
        sensors = [self._sensor(name) for name in ("camera", "tag", "compass")]
        self.team = Team(self.robots, marks, arena=[[-9, -9], [9, 9]], sensors=sensors)
        off = rng.uniform(-np.pi, np.pi, 3)
        way = np.array([sensor.position_bound for sensor in sensors])[:, None] * np.stack([np.cos(off), np.sin(off)], axis=1)
        places = np.array([sensor.position for sensor in sensors]) + way * self.error(3)[:, None]
        angles = [sensor.angle + sensor.angle_bound * error for sensor, error in zip(sensors, self.error(3), strict=True)]
        self.places, self.angles = np.vstack([places, np.zeros(2)]), np.append(angles, 0.0)

    def _sensor(self, name: str) -> Sensor:
        way, far = self.rng.uniform(-np.pi, np.pi), self.rng.choice([0.0, 1.0, self.rng.uniform()])
        place, angle = self.reach * far * np.array([np.cos(way), np.sin(way)]), self.rng.choice([0.0, self.rng.uniform(-6, 6)])
        return Sensor(name, place, self.bound * self.rng.choice([0.0, 1.0]), angle, self.bound * self.rng.choice([0.0, 1.0]))

    def error(self, size: int) -> Array:
        """Return errors in [-1, 1], some of them at an end."""
        drawn = self.rng.uniform(-1, 1, size)
        return np.where(self.rng.random(size) < 0.3, np.sign(drawn), drawn)

    def initial(self, reach: float, bound: float) -> tuple[list[Polygon], AngularIntervals]:
        """Return sets around the robots and their headings, so large [m], [rad]."""
        middle = self.positions + reach * np.stack([self.error(self.robots), self.error(self.robots)], axis=1)
        boxes = [Polygon.box(each - reach - 1e-9, each + reach + 1e-9) for each in middle]
        return boxes, AngularIntervals(self.headings + bound * self.error(self.robots), np.full(self.robots, bound + 1e-9))

    def drive(self, start: float, time: float) -> Odometry:
        """Drive straight on and then turn, by up to a radian; within the record's bounds."""
        distance, turn = self.rng.uniform(-0.1, 0.3, self.robots), self.rng.uniform(-1, 1, self.robots)
        self.positions = self.positions + turned(self.headings, np.stack([distance, np.zeros(self.robots)], axis=1))
        self.headings = wrap(self.headings + turn)
        told = distance + 0.01 * self.error(self.robots), turn + 0.01 * self.error(self.robots)
        robots, half = np.arange(self.robots), 0.01 + 1e-9  # it was not a steady curve: off by half the turn
        return Odometry(start, time, robots, told[0], half, told[1], half, np.abs(told[1]) / 2 + half, 1e-9)

    def places_of(self, body: Integers, sensor: Integers) -> Array:
        """Return where sensors (k,) of robots, or landmarks, (k,) really are, (k, 2) [m]."""
        bodies, headings = np.vstack([self.positions, self.team.landmarks]), np.append(self.headings, [0.0] * self.landmarks)
        return bodies[body] + turned(headings[body], self.places[sensor])

    def placed(self, time: float = 0.0, share: float = 0.7) -> list[Position]:
        """Return where a share of the antennas are: in a box, in a disc, or on one side of a line."""
        robots, sensors = np.divmod(np.arange(4 * self.robots), 4)
        places = self.places_of(robots, sensors - 1)
        every = zip(robots.tolist(), sensors - 1, places, strict=True)
        return [self._around(time, *each) for each in every if self.rng.random() < share]

    def _around(self, time: float, robot: int, sensor: int, place: Array) -> Position:
        half, way, form = self.rng.uniform(0, 0.3, 2), self.rng.uniform(-np.pi, np.pi), self.rng.integers(3)
        if form == 0:
            return Position.fix(time, robot, place + half * self.error(2), half, sensor)
        normal = np.array([np.cos(way), np.sin(way)])
        near = place - half[0] * np.abs(self.error(1)) * normal
        if form == 1:
            return Position.disc(time, robot, near, half[0] + 1e-9, 16, sensor)
        return Position.half_plane(time, robot, -3 * normal, -3 * (normal @ near), sensor)

    def measure(self, time: float = 0.0, bearings: float = 0.7, ranges: float = 0.7, compass: float = 0.5) -> list[Measurement]:
        """Return what a share of all sensors measures."""
        rng, bodies = self.rng, self.robots + self.landmarks
        robot, target = np.divmod(np.arange(self.robots * bodies), bodies)
        robot, target = robot[robot != target], target[robot != target]
        found: list[Measurement] = []
        for kind, share in ((Bearing, bearings), (Range, ranges)):
            some = rng.random(len(robot)) < share
            who, whom = robot[some], target[some]
            sensor = rng.choice([-1, 0, 1], len(who), p=[0.2, 0.5, 0.3])
            tag = np.where(whom < self.robots, rng.choice([-1, 0, 1], len(who), p=[0.2, 0.5, 0.3]), -1)
            found.append(self.sighted(kind, time, (who, whom), (sensor, tag)))
        return [*found, self.shown(time, np.flatnonzero(rng.random(self.robots) < compass))]

    def sighted(
        self, kind: type[Bearing | Range], time: float, bodies: tuple[Integers, Integers], sensors: tuple[Integers, Integers]
    ) -> Bearing | Range:
        """Return what robots, by their sensors (k,), measure of bodies, or of sensors of these (k,)."""
        (who, whom), (sensor, tag) = bodies, sensors
        away = self.places_of(whom, tag) - self.places_of(who, sensor)
        error, half = self.sloppy * self.error(len(who)), self.sloppy + 1e-9
        if kind is Bearing:
            value = np.arctan2(away[:, 1], away[:, 0]) - self.headings[who] - self.angles[sensor] + error
            return Bearing(time, who, whom, value, half, sensor, tag)
        return Range(time, who, whom, np.maximum(np.hypot(*away.T) + error, 0.0), half, 0.0, sensor, tag)

    def shown(self, time: float, who: Integers) -> Compass:
        """Return what compasses of robots (k,) show."""
        shown = wrap(self.headings[who] + self.angles[2] + self.sloppy * self.error(len(who)))
        return Compass(time, who, shown, self.sloppy + 1e-9, 2)

    def mates(self, time: float = 0.0, share: float = 0.5) -> RelativeHeading:
        """Return what a share of robots see of others' headings, by any sensor of any other one."""
        who = np.flatnonzero(self.rng.random(self.robots) < share)
        whom, count = (who + self.rng.integers(1, self.robots, len(who))) % self.robots, len(who)
        sensor, tag = self.rng.integers(-1, 3, (2, count))
        seen = self.headings[whom] + self.angles[tag] - self.headings[who] - self.angles[sensor]
        return RelativeHeading(time, who, whom, wrap(seen + self.sloppy * self.error(count)), self.sloppy + 1e-9, sensor, tag)

    def excluded_by(self, belief: Belief) -> tuple[list[int], list[int]]:
        """Return the robots of which a belief excludes the true place, and those of which it excludes the true heading."""
        places, ways = belief.regions.contains(self.positions), belief.headings.contains(self.headings)
        return np.flatnonzero(~places).tolist(), np.flatnonzero(~ways).tolist()

    def through_instants(
        self, filter_: SetMembershipFilter, belief: Belief, measured: Callable[[float], Sequence[Measurement]]
    ) -> Iterator[Belief]:
        """Yield what a filter knows after one instant, after three more at once, and after four, by what each measures."""
        for count in (1, 3, 4):
            frames, time = list[Frame](), belief.time
            for _ in range(count):
                motion, time = self.drive(time, time + 0.1), time + 0.1
                frames.append(Frame(time, motion, measured(time)))
            together = filter_._together(belief, frames)
            belief = filter_.advance(belief, frames)
            yield from (together or belief, belief)
