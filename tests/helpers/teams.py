"""Small teams for the filter's tests, also as logs, and what is compared of their beliefs."""

import dataclasses

import numpy as np
from helpers.worlds import World, escapes

from experiments.following.scenarios import CORNERS
from experiments.logs import Header, InitialSet, LogWriter
from filter import Frame, Odometry, Truth
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.polygon import Polygon
from filter.team import Team

BOX = Polygon.box([0, 0], [1, 1])
TEAM = Team(2, landmarks=[[5.0, 5.0]])


def odometry(start=0.0, time=1.0, robot=0, distance=0.0, **bounds):
    values = {"distance_bound": 0.0, "turn": 0.0, "turn_bound": 0.0, "direction_bound": 0.0, "slip_bound": 0.0, **bounds}
    return Odometry(start=start, time=time, robot=robot, distance=distance, **values)


def estimator(team=TEAM, **options):
    return SetMembershipFilter(team, **options)


def started(team=TEAM, sets=None, headings=None, time=0.0):
    return estimator(team).start(time, sets or [BOX, Polygon.box([2, 0], [3, 1])], headings)


def begun(filter_, world):
    """Return the belief of a world's start."""
    return filter_.start(0.0, world.initial_sets(), world.initial_headings())


def beliefs(filter_, world, count=6):
    """Yield the belief after a first update, and after each of so many steps; nobody escapes on the way."""
    belief = filter_.update(begun(filter_, world), world.measure())
    assert escapes(belief, world.positions, world.headings) == []
    yield belief
    for motion, records in world.steps(count):
        predicted = filter_.predict(belief, motion.time, motion)
        assert escapes(predicted, world.positions, world.headings) == []
        belief = filter_.update(predicted, records)
        assert escapes(belief, world.positions, world.headings) == []
        yield belief


def snapshot(thing):
    """Return everything in a belief as nested lists, to compare bit by bit."""
    if isinstance(thing, np.ndarray):
        return thing.tobytes(), thing.shape
    if isinstance(thing, tuple | list):
        return [snapshot(part) for part in thing]
    if dataclasses.is_dataclass(thing):
        return [snapshot(getattr(thing, column.name)) for column in dataclasses.fields(thing)]
    return thing


def write_log(path, *, seed=0, robots=2, steps=8, truth=True, change=lambda k, records: records):
    """Write a log of robots that drive and measure within their bounds, but for what `change` makes of step k's records."""
    world = World(np.random.default_rng(seed), robots=robots, landmarks=2)
    centres, arcs = [set_.vertices.mean(axis=0) for set_ in world.initial_sets()], world.initial_headings()
    known = zip(centres, arcs.centre.tolist(), arcs.bound.tolist(), strict=True)
    initial = [InitialSet(centre + 0.6 * CORNERS, (heading, bound)) for centre, heading, bound in known]
    with LogWriter(path, Header(world.team, 0.0, None), initial) as log:
        for k in range(steps):
            driven = world.move() if k else None
            told = Truth(world.positions, world.headings) if truth else None
            log.write(Frame(world.time, driven, tuple(change(k, world.measure())), told))
    return path
