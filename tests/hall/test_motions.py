"""Odometry at stamps of its own, joined and cut: what a robot can have done in between is within what is said of it."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from filter import AngularIntervals, Motions, Odometry, Team
from filter.sensing.motion import displacements, turned_headings

TICK = 1e-3  # of the true motion [s]
LENGTH = 1.2  # of the true motion [s]
WAYS = np.linspace(-np.pi, np.pi, 181)
DIRECTIONS = np.stack([np.cos(WAYS), np.sin(WAYS)], axis=1)


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


def holds(team, odometry, drive, begin, end):
    """Check that what was said of the motion between two ticks contains it."""
    heading = AngularIntervals([0.3], [0.0])
    turned = turned_headings(odometry, heading, team, (end - begin) * TICK)
    assert turned.contains(np.array([0.3 + drive.heading[end] - drive.heading[begin]])).all()
    c, s = np.cos(0.3 - drive.heading[begin]), np.sin(0.3 - drive.heading[begin])
    moved = np.array([[c, -s], [s, c]]) @ (drive.place[end] - drive.place[begin])
    support = displacements(odometry, heading, team, (end - begin) * TICK).support(np.zeros(len(WAYS), dtype=int), DIRECTIONS)
    assert (DIRECTIONS @ moved <= support + 1e-9).all()


@pytest.mark.parametrize("kind", ["driving", "standing", "on the spot", "sideways"])
@settings(max_examples=16, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_what_is_said_of_any_interval_contains_what_was_done_in_it(kind, seed):
    rng = np.random.default_rng(seed)
    drive = Drive(rng, kind)
    team = Team(1, **drive.limits)
    motions, stamps = Motions(team), np.unique(rng.integers(0, len(drive.path), 12))
    spans = [span for span in pairwise(stamps) if span[1] - span[0] < 150 and rng.random() < 0.9]
    for begin, end in rng.permutation(np.array(spans, dtype=int).reshape(-1, 2)).tolist():
        motions = motions.merged(drive.record(begin, end))
    for _ in range(8):
        begin, end = np.sort(rng.integers(0, len(drive.path), 2)).tolist()
        if rng.random() < 0.3 and spans:
            begin, end = spans[rng.integers(len(spans))]
        if begin < end:
            holds(team, motions.between(begin * TICK, end * TICK), drive, begin, end)
