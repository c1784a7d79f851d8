"""Small worlds for the tests: robots that move and measure within their bounds, drawn from a generator, without MuJoCo."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np

from filter.angles import AngularIntervals, wrap
from filter.arrays import Array
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.polygon import Polygon
from filter.team import Team


@dataclass
class World:
    """A team whose every error is drawn by `error`: `uniform` over the bound, or `extreme`, at plus or minus the bound."""

    rng: np.random.Generator
    robots: int = 4
    landmarks: int = 1
    size: float = 6.0
    errors: str = "uniform"
    compass: float = np.radians(3)
    bearing: float = np.radians(3)
    range: float = 0.05
    sight: float = 4.0
    origin: Array = field(default_factory=lambda: np.zeros(2))
    time: float = 0.0

    def __post_init__(self) -> None:
        self.positions = self.origin + self.rng.uniform(0, self.size, (self.robots, 2))
        self.headings = self.rng.uniform(-np.pi, np.pi, self.robots)
        marks = self.origin + self.rng.uniform(0, self.size, (self.landmarks, 2))
        self.team = Team(self.robots, marks, speed_limit=0.5, turn_rate_limit=2.0)

    def error(self, size: int | tuple[int, ...]) -> Array:
        if self.errors == "extreme":
            return self.rng.choice([-1.0, 1.0], size)
        return self.rng.uniform(-1, 1, size)

    def initial_sets(self, reach: float = 0.5) -> list[Polygon]:
        centres = self.positions + reach * self.error((self.robots, 2))
        return [Polygon.box(centre - reach - 1e-9, centre + reach + 1e-9) for centre in centres]

    def initial_headings(self, bound: float = 0.2) -> AngularIntervals:
        return AngularIntervals(self.headings + bound * self.error(self.robots), np.full(self.robots, bound + 1e-9))

    def move(self, duration: float = 0.1, backwards: bool = False) -> Odometry:
        """Drive arcs with slip; the record's bounds hold, some of them just so."""
        n, start = self.robots, self.time
        speed = self.rng.uniform(-0.5 if backwards else 0, 0.5, n)
        distance, turn = speed * duration, self.rng.uniform(-2, 2, n) * duration
        distance_bound, turn_bound, slip = 0.02 * np.abs(distance) + 1e-4, np.full(n, 0.01), np.full(n, 0.002)
        direction_bound = np.full(n, 0.02)
        way = self.headings + turn / 2 + direction_bound * self.error(n)
        chord = distance * np.sinc(turn / 2 / np.pi)
        slipped = self.rng.uniform(-np.pi, np.pi, n)
        self.positions = self.positions + (
            chord[:, None] * np.stack([np.cos(way), np.sin(way)], 1) + slip[:, None] * np.stack([np.cos(slipped), np.sin(slipped)], 1)
        )
        self.headings, self.time = wrap(self.headings + turn), start + duration
        return Odometry(
            start=start,
            time=self.time,
            robot=np.arange(n),
            distance=distance + distance_bound * self.error(n),
            distance_bound=distance_bound + 1e-12,
            turn=turn + turn_bound * self.error(n),
            turn_bound=turn_bound + 1e-12,
            direction_bound=direction_bound + 1e-12,
            slip_bound=slip + 1e-12,
        )

    def measure(self, compasses: bool = True) -> list[Measurement]:
        bodies = np.concatenate([self.positions, self.team.landmarks])
        robot, target = np.divmod(np.arange(self.robots * len(bodies)), len(bodies))
        difference = bodies[target] - self.positions[robot]
        distance = np.hypot(*difference.T)
        seen = (robot != target) & (distance < self.sight)
        robot, target, difference, distance = robot[seen], target[seen], difference[seen], distance[seen]
        way = np.arctan2(difference[:, 1], difference[:, 0]) - self.headings[robot]
        records: list[Measurement] = []
        if compasses:
            shown = self.headings + self.compass * self.error(self.robots)
            records.append(Compass(self.time, np.arange(self.robots), shown, self.compass + 1e-12))
        if len(robot):
            bearing = way + self.bearing * self.error(len(robot))
            records.append(Bearing(self.time, robot, target, bearing, self.bearing + 1e-12))
            measured = distance * (1 + self.range * self.error(len(robot)))
            records.append(Range(self.time, robot, target, measured, 1e-9, self.range))
        return records

    def steps(self, count: int, **options: bool) -> Iterator[tuple[Odometry, list[Measurement]]]:
        for _ in range(count):
            yield self.move(**options), self.measure()
