"""Which promises an episode breaks, found one number at a time from the truth: slow, and obvious."""

from __future__ import annotations

import math
from collections.abc import Iterator

from experiments.broken.episodes import Episode
from filter import Bearing, Compass, Frame, Odometry, Range

Broken = tuple[int, str, int, int]  # frame, kind of record, robot, target (-1 if there is none)
ROUNDING = 1e-7


def off(one: float, other: float) -> float:
    """Return the angle between two directions, from 0 to pi."""
    return abs(math.remainder(one - other, 2 * math.pi))


def broken_promises(episode: Episode) -> Iterator[Broken]:
    first = episode.frames[0].truth
    for robot, box in enumerate(episode.positions):
        if not box.contains(first.positions[robot]):
            yield 0, "start", robot, -1
    if episode.headings is not None:
        for robot, (middle, bound) in enumerate(zip(episode.headings.centre, episode.headings.bound, strict=True)):
            if off(middle, first.headings[robot]) > bound + ROUNDING:
                yield 0, "start", robot, -1
    before = None
    for number, frame in enumerate(episode.frames):
        if frame.odometry is not None:
            yield from of_motion(number, before, frame, frame.odometry)
        yield from of_sensors(number, frame, episode.team.landmarks)
        before = frame


def of_motion(number: int, before: Frame, after: Frame, told: Odometry) -> Iterator[Broken]:
    for k, robot in enumerate(told.robot.tolist()):
        x, y = after.truth.positions[robot] - before.truth.positions[robot]
        heading, turned = before.truth.headings[robot], after.truth.headings[robot] - before.truth.headings[robot]
        turned = math.remainder(turned, 2 * math.pi)
        holds = off(turned, told.turn[k]) <= told.turn_bound[k] + ROUNDING
        chord = math.sin(turned / 2) / (turned / 2) if abs(turned) > 1e-12 else 1.0
        low, high = told.distance[k] - told.distance_bound[k], told.distance[k] + told.distance_bound[k]
        length, slip = math.hypot(x, y), told.slip_bound[k] + ROUNDING
        holds &= low * chord - slip <= length <= high * chord + slip  # all drive forward
        aside = off(math.atan2(y, x), heading + turned / 2)
        holds &= aside <= told.direction_bound[k] + math.asin(min(1.0, slip / length))
        if not holds:
            yield number, "odometry", robot, -1


def of_sensors(number: int, frame: Frame, landmarks) -> Iterator[Broken]:
    places = [*frame.truth.positions.tolist(), *landmarks.tolist()]
    for record in frame.measurements:
        for k, robot in enumerate(record.robot.tolist()):
            heading = frame.truth.headings[robot]
            if isinstance(record, Compass):
                if off(record.heading[k], heading) > record.bound[k] + ROUNDING:
                    yield number, "compass", robot, -1
                continue
            target = int(record.target[k])
            x, y = places[target][0] - places[robot][0], places[target][1] - places[robot][1]
            if isinstance(record, Bearing):
                holds = off(math.atan2(y, x), heading + record.bearing[k]) <= record.bound[k] + ROUNDING
            if isinstance(record, Range):
                away = math.hypot(x, y)
                holds = abs(record.range[k] - away) <= record.bound[k] + record.relative_bound[k] * away + ROUNDING
            if not holds:
                yield number, "sighting", robot, target
