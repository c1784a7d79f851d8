"""Robots that speed up, turn and strafe as they like within their limits, and what odometry says of any part of it."""

import numpy as np

from filter import Odometry

TICK = 1e-3  # of the true motion [s]
LENGTH = 1.2  # of the true motion [s]


class Drive:
    """A robot that speeds up, turns and strafes as it likes, within its limits."""

    def __init__(self, rng, kind):
        self.rng, self.kind = rng, kind
        ticks = int(LENGTH / TICK)
        self.limits = {"speed_limit": 2.1, "turn_rate_limit": 3.0}  # of all its motion, slides included
        self.limits |= {"acceleration_limit": rng.uniform(0, 10), "turn_acceleration_limit": rng.uniform(0, 10)}
        start = 0.0 if kind == "standing" else rng.uniform(-1, 1)
        self.speed = self._within(start, 2.0, self.limits["acceleration_limit"], ticks) * (kind != "on the spot")
        self.rate = self._within(rng.uniform(-1, 1), 3.0, self.limits["turn_acceleration_limit"], ticks)
        self.aside = rng.uniform(-4, 4) if kind == "sideways" else 0.0
        self.swerve, self.slide = rng.uniform(0, 0.1), rng.uniform(0, 0.1)
        off = self.swerve * np.sin(rng.uniform(0, 50) * np.arange(ticks) * TICK)
        self.heading = np.concatenate([[0.0], np.cumsum(self.rate * TICK)])
        way = self.heading[:-1] + self.rate * TICK / 2 + self.aside + off
        slid = self.slide * np.array([np.cos(40 * np.arange(ticks) * TICK), np.sin(40 * np.arange(ticks) * TICK)])
        step = self.speed * np.array([np.cos(way), np.sin(way)]) + slid
        self.place = np.concatenate([np.zeros((1, 2)), np.cumsum(step.T * TICK, axis=0)])
        self.slipped = np.concatenate([np.zeros((1, 2)), np.cumsum(slid.T * TICK, axis=0)])
        self.path = np.concatenate([[0.0], np.cumsum(self.speed * TICK)])

    def _within(self, start, most, change, ticks):
        steps = change * TICK * self.rng.choice([-1.0, 0.0, 1.0], (ticks // 50 + 1)).repeat(50)[:ticks]
        values = [start]
        for step in steps[:-1]:
            values.append(float(np.clip(values[-1] + step, -most, most)))
        return np.array(values)

    def record(self, begin, end):
        """Return the odometry between two ticks; the bound of its direction is what any part of it needs."""
        rng, bounds = self.rng, {"distance_bound": self.rng.uniform(0, 0.02), "turn_bound": self.rng.uniform(0, 0.05)}
        size = rng.choice([1.0, rng.uniform()])
        said = self.path[end] - self.path[begin] + bounds["distance_bound"] * size * rng.choice([-1, 1])
        turn = self.heading[end] - self.heading[begin] + bounds["turn_bound"] * size * rng.choice([-1, 1])
        columns = {"distance": said, "turn": turn, "direction_bound": self._needed(begin, end), "aside": self.aside, **bounds}
        return Odometry(begin * TICK, end * TICK, 0, slip_bound=self.slide * (end - begin) * TICK, **columns)

    def _needed(self, begin, end):
        worst = 0.0
        for a in range(begin, end):
            rolled = (self.place - self.slipped)[a + 1 : end + 1] - (self.place - self.slipped)[a]
            along = (self.heading[a] + self.heading[a + 1 : end + 1]) / 2 + self.aside
            path = self.path[a + 1 : end + 1] - self.path[a]
            far = np.hypot(*rolled.T) > 1e-9
            off = np.angle(np.exp(1j * (np.arctan2(rolled[:, 1], rolled[:, 0]) - along + np.where(path < 0, np.pi, 0))))
            worst = max(worst, np.abs(off[far]).max(initial=0.0))
        return min(1.5, worst)
