"""Streams, drawn: 0.5 to 200 Hz, jittered, late, with gaps, mounted sensors, joins, leaves and lopsided errors."""

from collections.abc import Iterator
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from filter import (
    AngularIntervals,
    Arrival,
    Bearing,
    Compass,
    Frame,
    Left,
    Odometry,
    Placed,
    Polygon,
    Position,
    Range,
    Sensor,
    Team,
    Twist,
)

MARKS = np.array([[2.5, 0.5], [-1.0, 3.0]])
MOST = 20  # records of one sensor of one robot
SPARE = 1e-6  # wider than what the drawn drives and errors are rounded by
FINE = 1e-3  # as finely drives are integrated, in lengths of a stream


class Drive:
    """How a robot drives: never standing, faster and slower, turning to and fro; one in three goes sideways."""

    def __init__(self, rng: np.random.Generator, length: float) -> None:
        self.speed = rng.choice([-1, 1]) * rng.uniform(0.1, 0.8)
        self.change, self.turn, self.sway = rng.uniform(0, abs(self.speed)), rng.uniform(-1, 1), rng.uniform(0, 1)
        self.beat, self.swing, self.phase = rng.uniform(0.5, 8), rng.uniform(0.5, 8), rng.uniform(0, 2 * np.pi, 2)
        self.aside, self.first, self.looks = rng.choice([0.0, 0.0, 1.3]), rng.uniform(-2, 2, 2), rng.uniform(-4, 4)
        self.times = np.arange(0, 1 + 2 * FINE, FINE) * length
        way = self.heading(self.times) + self.aside
        velocity = self.velocity(self.times)[:, None] * np.stack([np.cos(way), np.sin(way)], axis=1)
        steps = (velocity[1:] + velocity[:-1]) / 2 * np.diff(self.times)[:, None]
        self.places = self.first + np.concatenate([np.zeros((1, 2)), np.cumsum(steps, axis=0)])
        self.carried: list[tuple[float, NDArray[np.float64]]] = []

    def velocity(self, time: NDArray[np.float64]) -> NDArray[np.float64]:
        return np.asarray(self.speed + self.change * np.sin(self.beat * time + self.phase[0]))

    def driven(self, time: float) -> float:
        """Return the length of the path since the beginning."""
        return float(
            self.speed * time - self.change / self.beat * (np.cos(self.beat * time + self.phase[0]) - np.cos(self.phase[0]))
        )

    def heading(self, time: NDArray[np.float64] | float) -> NDArray[np.float64]:
        swayed = np.cos(self.swing * time + self.phase[1]) - np.cos(self.phase[1])
        return np.asarray(self.looks + self.turn * time - self.sway / self.swing * swayed)

    def place(self, time: float) -> NDArray[np.float64]:
        there = np.array([np.interp(time, self.times, column) for column in self.places.T])
        return there + sum((by for since, by in self.carried if time >= since), np.zeros(2))

    @property
    def limits(self) -> tuple[float, float, float, float]:
        """Of speed, turn rate, acceleration and turn acceleration."""
        return (
            abs(self.speed) + self.change + SPARE,
            abs(self.turn) + self.sway + SPARE,
            self.change * self.beat + SPARE,
            self.sway * self.swing + SPARE,
        )


@dataclass
class RandomStream:
    """A stream, and the truth that it is of."""

    rng: np.random.Generator

    def __post_init__(self) -> None:
        rng = self.rng
        self.robots, self.length = int(rng.integers(1, 4)), rng.uniform(0.2, 3)
        self.hold = rng.choice([0.05, 0.3, 1.0])
        self.drives = [Drive(rng, self.length) for _ in range(self.robots)]
        speed, turn, acceleration, spin = map(list, zip(*(drive.limits for drive in self.drives), strict=True))
        given = [self._mounting(str(name)) for name in "abc"]
        self.mounted = [true for _, true in given]
        more = {"acceleration_limit": acceleration, "turn_acceleration_limit": spin} if rng.uniform() < 0.7 else {}
        sensors = [sensor for sensor, _ in given]
        self.team = Team(self.robots, MARKS, speed, turn, [[-30, -30], [30, 30]], sensors=sensors, **more)
        self.away = self._gone()
        self.start = [self._around(drive.place(0.0), 0.4) for drive in self.drives]
        arcs = [
            (drive.looks + 0.1 * self.error(), 0.1 + SPARE) if rng.uniform() < 0.7 else (0.0, np.pi) for drive in self.drives
        ]
        self.headings = AngularIntervals(*np.array(arcs).T)

    def error(self) -> float:
        """Return an error from -1 to 1, often one of these."""
        return float(self.rng.choice([-1, 1, self.rng.uniform(-1, 1)]))

    def is_there(self, robot: int, time: float) -> bool:
        return not any(since <= time < until for since, until in self.away.get(robot, []))

    def arrivals(self) -> list[Arrival]:
        """Return the records in the order in which they come; regions are asked for at the end, too, when all are there."""
        told = [record for robot in range(self.robots) for record in self._of(robot)]
        records = [*self._changes(), *told, Frame(self.length)]
        due = [record.time + self.rng.uniform(0, 0.99 * self.hold) for record in records]
        return [records[k] for k in np.argsort(due, kind="stable")]

    def _mounting(self, name: str) -> tuple[Sensor, tuple[NDArray[np.float64], float, float]]:
        """Return a sensor as the team has it, and where it is, how it looks, and how late its clock is."""
        place, off = self.rng.uniform(-0.3, 0.3, 2), self.rng.choice([0, 0.02])
        angle, turned = self.rng.uniform(-3, 3), self.rng.choice([0, 0.03])
        clock = float(self.rng.choice([0, 0, 0.03]))
        way, bias = self.rng.uniform(-np.pi, np.pi), self.rng.choice([-1, 0, 1])
        true = place + off * np.array([np.cos(way), np.sin(way)])
        sensor = Sensor(name, place, off + SPARE, angle, turned + SPARE, clock)
        return sensor, (true, angle + bias * turned, clock)

    def _gone(self) -> dict[int, list[tuple[float, float]]]:
        """Have robots leave and be back elsewhere, or just be put down there; return from when till when they are away."""
        away = dict[int, list[tuple[float, float]]]()
        for robot, drive in enumerate(self.drives):
            if self.rng.uniform() < 0.3:
                since, until = np.sort(self.rng.uniform(0.1, 0.9, 2)) * self.length
                until = since if self.rng.uniform() < 0.3 else until
                drive.carried.append((until, self.rng.uniform(-2, 2, 2)))
                away[robot] = [(since, until)]
        if any(true[2] for true in self.mounted):  # of such clocks limits hold always, so nobody is carried
            away.clear()
            for drive in self.drives:
                drive.carried.clear()
        return away

    def _changes(self) -> Iterator[Arrival]:
        for robot, spans in self.away.items():
            for since, until in spans:
                if since < until:
                    yield Left(since, robot)
                heading = AngularIntervals(*np.array([[self.drives[robot].heading(until) + 0.1 * self.error()], [0.1 + SPARE]]))
                yield Placed(until, robot, self._around(self.drives[robot].place(until), 0.5), heading)

    def _around(self, place: NDArray[np.float64], size: float) -> Polygon:
        corners = size * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]])
        return Polygon.from_vertices(place + corners + 0.9 * size * np.array([self.error(), self.error()]))

    def _stamps(self) -> NDArray[np.float64]:
        """Return when a sensor measures: at its rate, with its phase and jitter, some missing."""
        period = 1 / 10 ** self.rng.uniform(np.log10(0.5), np.log10(200))
        count = min(MOST, int(self.length / period))
        jitter = self.rng.choice([0, 0.3]) * period
        stamps = self.rng.uniform(0, period) + period * np.arange(count) + jitter * self.rng.uniform(0, 1, count)
        return stamps[(self.rng.uniform(size=count) < 0.9) & (stamps < self.length)]

    def _of(self, robot: int) -> Iterator[Arrival]:
        """Yield what a robot's wheels or commands, and its sensors, say."""
        yield from self._commands(robot) if self.rng.uniform() < 0.2 else self._wheels(robot)
        for _ in range(self.rng.integers(1, 5)):
            kind, sensor = self.rng.integers(4), int(self.rng.choice([-1, -1, *range(len(self.mounted))]))
            for time in self._stamps().tolist():
                yield from self._measured(int(kind), time, robot, sensor)

    def _wheels(self, robot: int) -> Iterator[Odometry]:
        drive = self.drives[robot]
        for start, time in pairwise(self._stamps().tolist()):
            if self.rng.uniform() < 0.1:
                continue
            looks = drive.heading(np.linspace(start, time, 50))
            distance, turn = drive.driven(time) - drive.driven(start), float(looks[-1] - looks[0])
            bend = float(np.ptp(looks)) + 0.01
            if bend < 1.5:
                said = distance + 0.004 * self.error(), 0.004 + SPARE, turn + 0.01 * self.error(), 0.01 + SPARE
                yield Odometry(start, time, robot, *said, bend, 0.001, drive.aside)

    def _commands(self, robot: int) -> Iterator[Twist]:
        drive = self.drives[robot]
        for time in self._stamps().tolist():
            speed, rate = drive.change + SPARE, drive.sway + SPARE
            yield Twist(time, robot, drive.speed, speed, drive.turn, rate, 0.05, 0.001, 0.3, drive.aside)

    def _seen(self, robot: int, sensor: int, time: float) -> tuple[NDArray[np.float64], float]:
        """Return where a sensor is, and which way it looks."""
        place, heading = self.drives[robot].place(time), float(self.drives[robot].heading(time))
        if sensor < 0:
            return place, heading
        by, angle, _ = self.mounted[sensor]
        c, s = np.cos(heading), np.sin(heading)
        return place + np.array([c * by[0] - s * by[1], s * by[0] + c * by[1]]), heading + angle

    def _measured(self, kind: int, time: float, robot: int, sensor: int) -> Iterator[Arrival]:
        then = np.clip(time + (self.mounted[sensor][2] * self.error() if sensor >= 0 else 0), 0, self.length)
        target = int(self.rng.choice([body for body in range(self.robots + len(MARKS)) if body != robot]))
        if not self.is_there(robot, time) or (target < self.robots and not self.is_there(target, time)):
            return
        place, heading = self._seen(robot, sensor, float(then))
        away = (self.drives[target].place(float(then)) if target < self.robots else MARKS[target - self.robots]) - place
        low, high = np.sort(self.rng.choice([-1, 0, 1, 0.2], 2, replace=False)) * self.rng.choice([0.02, 0.1])
        off, bound = self.rng.choice([low, high, self.rng.uniform(low, high)]) - (low + high) / 2, (high - low) / 2 + SPARE
        if kind == 0:
            yield Compass(time, robot, heading + off, bound, sensor)
        elif kind == 1 and np.hypot(*away) > 0.1:
            yield Bearing(time, robot, target, np.arctan2(away[1], away[0]) - heading + off, bound, sensor)
        elif kind == 2:
            value = np.hypot(*away) * (1 + 0.01 * self.error()) + off
            yield Range(time, robot, target, max(0.0, value), bound, 0.0101, sensor)
        elif kind == 3:
            yield Position.fix(time, robot, place + off, bound, sensor)
