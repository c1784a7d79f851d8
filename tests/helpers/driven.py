"""Robots whose truth is known at any time, between the frames too, and whose records err by all that they may."""

from dataclasses import dataclass

import numpy as np

from experiments.logs import Trajectory
from experiments.watchdog.claimed import Claimed
from filter import (
    AngularIntervals,
    Array,
    Bearing,
    Compass,
    Frame,
    Odometry,
    Polygon,
    Range,
    SetMembershipFilter,
    Team,
    follow,
    wrap,
)

TICK = 0.001  # the truth is known so often [s]
DURATION = 8.0  # [s]
ANGLE, LENGTH = 0.05, 0.05  # the largest errors [rad] and [m]
LANDMARKS = np.array([[6.0, 0.0], [0.0, 5.0], [-5.0, -4.0]])


@dataclass(frozen=True, eq=False)
class Driven:
    """Robots that drive anyhow, known at every tick; every error of what they measure is at its bound.

    Attributes:
        speeds: (t, n) signed [m/s].
        headings: (t, n) [rad].
        positions: (t, n, 2) [m].
    """

    rng: np.random.Generator
    speeds: Array
    headings: Array
    positions: Array

    @classmethod
    def of(cls, rng, robots, steady):
        t = TICK * np.arange(round(DURATION / TICK) + 1)[:, None]
        pace, turning = rng.uniform(0.3, 12, (2, robots))
        speeds = np.full((len(t), robots), 0.5) if steady else 0.5 * np.cos(pace * t + rng.uniform(0, 6, robots))
        headings = rng.uniform(-3, 3, robots) + (0.0 if steady else 0.4) * np.sin(turning * t)
        steps = TICK * speeds[:-1, :, None] * np.stack([np.cos(headings[:-1]), np.sin(headings[:-1])], axis=2)
        begin = rng.uniform(-1, 1, (1, robots, 2))
        return cls(rng, speeds, headings, begin + np.concatenate([np.zeros((1, robots, 2)), np.cumsum(steps, axis=0)]))

    def frames(self, ticks):
        return [self._frame(before, now) for before, now in zip([None, *ticks[:-1].tolist()], ticks.tolist(), strict=True)]

    def _frame(self, before, now):
        who = np.arange(self.positions.shape[1])
        robot, target = np.repeat(who, 3), len(who) + np.tile(np.arange(3), len(who))
        apart = LANDMARKS[target - len(who)] - self.positions[now, robot]
        seen = np.arctan2(apart[:, 1], apart[:, 0]) - self.headings[now, robot] + self._error(ANGLE, len(robot))
        far = np.hypot(*apart.T) + self._error(LENGTH, len(robot))
        time, compass = now * TICK, wrap(self.headings[now] + self._error(ANGLE, len(who)))
        said = (Compass(time, who, compass, ANGLE), Bearing(time, robot, target, wrap(seen), ANGLE))
        moved = None if before is None else self._odometry(before, now, who)
        return Frame(time, moved, (*said, Range(time, robot, target, far, LENGTH, 0.0)))

    def _odometry(self, before, now, who):
        chord = self.positions[now] - self.positions[before]
        path, turn = TICK * self.speeds[before:now].sum(axis=0), self.headings[now] - self.headings[before]
        way, error = self.headings[before] + turn / 2, self._error(0.005, len(who))
        slip = np.hypot(*(chord - path[:, None] * np.stack([np.cos(way), np.sin(way)], axis=1)).T) + 1e-9
        times = before * TICK, now * TICK
        return Odometry(*times, who, path + error, 0.005, turn + self._error(0.01, len(who)), 0.01, 0.0, slip)

    def _error(self, bound, count):
        return bound * self.rng.choice([-1.0, 1.0], count)

    def poses(self, ticks, offset=0.0, tolerance=0.0, shift=(0.0, 0.0)):
        """Return the poses of all robots at some ticks, by a clock that is behind by an offset and wrong by a tolerance."""
        stamps = ticks * TICK - offset + self.rng.uniform(-tolerance, tolerance, len(ticks))
        order = np.argsort(stamps)
        robots = range(self.positions.shape[1])
        moved = self.positions[ticks[order]] + shift
        return Claimed.of("", {k: Trajectory(stamps[order], moved[:, k].copy()) for k in robots}, len(robots), offset)


def world(seed, robots=4, steady=False, limit=0.5):
    rng = np.random.default_rng(seed)
    driven = Driven.of(rng, robots, steady)
    most = max(2, round(TICK**-1 / rng.uniform(1, 20)))
    ticks = np.cumsum(np.append(0, rng.integers(most // 2, most + 1, round(DURATION / TICK / most * 2))))
    frames = driven.frames(ticks[ticks <= DURATION / TICK])
    team = Team(robots, LANDMARKS, limit, 10.0, [[-20, -20], [20, 20]])
    filter_ = SetMembershipFilter(team)
    start = filter_.start(0.0, [Polygon.box(x - 0.5, x + 0.5) for x in driven.positions[0]], AngularIntervals.circles(robots))
    return driven, team, list(follow(filter_, start, frames))


def outside(lengths, direction_bound, along, across):
    """Return how far points are from {s (cos d, sin d): s within the lengths, |d| <= bound}; s may be negative."""
    distances = []
    for sign in (1, -1):  # ahead and behind
        low, high = (np.sort(sign * np.stack(lengths), axis=0)[end] for end in (0, 1))
        x, y = sign * along, sign * across
        angle = np.clip(np.arctan2(y, x), -direction_bound, direction_bound)
        length = np.clip(x * np.cos(angle) + y * np.sin(angle), np.maximum(low, 0), np.maximum(high, 0))
        distance = np.hypot(x - length * np.cos(angle), y - length * np.sin(angle))
        distances.append(np.where(high >= 0, distance, np.inf))
    return np.minimum(*distances)
