"""Robots whose records come as they come: late, in any order, some at a time."""

import numpy as np
from helpers.driven import Driven

from filter import Polygon, SetMembershipFilter, Team

LANDMARKS = [[6.0, 0.0], [0.0, 5.0], [-5.0, -4.0]]


def world(seed, count=40):
    """Return robots whose errors are at their bounds, their filter, what is known at the start, and the frames after it."""
    rng = np.random.default_rng(seed)
    driven = Driven.of(rng, 2, steady=bool(seed % 2))
    ticks = np.cumsum(rng.integers(5, 60, count))
    filter_ = SetMembershipFilter.light(Team(2, LANDMARKS, speed_limit=0.5, turn_rate_limit=6.0, arena=[[-9, -9], [9, 9]]))
    frames = driven.frames(ticks)
    known = filter_.start(frames[0].time, [Polygon.box(place - 0.4, place + 0.4) for place in driven.positions[ticks[0]]])
    return rng, driven, filter_, known, frames


def records_of(frames):
    return [each for frame in frames for each in ([frame.odometry] if frame.odometry else []) + list(frame.measurements)]


def delayed(rng, records, by):
    """Return records in an order in which they come late by so much at most [s]."""
    when = [record.time + rng.uniform(0, by) for record in records]
    return [records[k] for k in np.argsort(when, kind="stable")]


def batches(rng, records):
    while records:
        size = int(rng.integers(1, 12))
        yield records[:size]
        records = records[size:]
