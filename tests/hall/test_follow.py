"""The one loop: every filter follows by it, frame by frame, and nothing of a frame is passed over."""

import inspect
from itertools import count, islice

import numpy as np
import pytest
from helpers.worlds import World

from filter import (
    Compass,
    ExtendedKalmanFilter,
    Filter,
    Frame,
    GaussianBelief,
    Odometry,
    OutOfOrder,
    Polygon,
    RobustFilter,
    SetMembershipFilter,
    Team,
    follow,
)

KINDS = [SetMembershipFilter, RobustFilter, ExtendedKalmanFilter]


def started(kind, frames=4):
    """A filter, its first belief, and frames of which the first is at that belief's time."""
    world = World(np.random.default_rng(3), robots=2, landmarks=2, sight=99.0)
    filter_ = kind(world.team)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    seen = [Frame(0.0, None, tuple(world.measure()))]
    seen += [Frame(motion.time, motion, tuple(records)) for motion, records in world.steps(frames - 1)]
    return filter_, belief, seen


def figures(belief):
    if isinstance(belief, GaussianBelief):
        return belief.mean.tobytes() + belief.covariance.tobytes()
    outers = [region.outer for region in belief.regions]
    return b"".join(outer.vertices.tobytes() for outer in outers) + belief.headings.centre.tobytes()


@pytest.mark.parametrize("kind", KINDS)
def test_every_filter_satisfies_the_protocol(kind):
    assert isinstance(kind(Team(1)), Filter)
    for name in ("start", "predict", "update"):
        wanted, own = (inspect.signature(getattr(each, name)).parameters.values() for each in (Filter, kind))
        assert [(p.name, p.kind, p.default) for p in own] == [(p.name, p.kind, p.default) for p in wanted]
    assert isinstance(kind(Team(1)).start(2, [Polygon.box([0, 0], [1, 1])]).time, float)


@pytest.mark.parametrize("kind", KINDS)
def test_a_step_is_the_prediction_and_then_the_update(kind):
    filter_, belief, frames = started(kind)
    steps = list(follow(filter_, belief, frames))
    assert [step.frame for step in steps] == frames
    assert steps[0].predicted is belief  # the first frame is at its time
    for k, (frame, step) in enumerate(zip(frames, steps, strict=True)):
        predicted = filter_.predict(belief, frame.time, frame.odometry) if k else belief
        belief = filter_.update(predicted, frame.measurements)
        assert figures(step.predicted) == figures(predicted)
        assert figures(step.belief) == figures(belief)
        assert step.belief.time == frame.time


def test_a_frame_without_odometry_is_a_motion_within_the_limits():
    filter_ = SetMembershipFilter(Team(1, speed_limit=2.0))
    belief = filter_.start(0.0, [Polygon.box([0, 0], [1, 1])])
    (step,) = follow(filter_, belief, [Frame(0.5)])
    assert step.belief.regions[0].outer.bounds == pytest.approx(np.array([[-1, -1], [2, 2]]))


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(
    "frame",
    [
        Frame(-1.0),
        Frame(-1.0, None, (Compass(-1.0, 0, 0.0, 0.1),)),
        Frame(1.0, None, (Compass(2.0, 0, 0.0, 0.1),)),
        Frame(0.0, Odometry(-1.0, 0.0, 0, 0.1, 0.01, 0.0, 0.01, 0.01, 0.01)),
    ],
    ids=["an earlier frame", "an earlier frame that measures", "a record of another time", "odometry that was before"],
)
def test_a_frame_that_does_not_fit_is_refused(kind, frame):
    filter_, belief, _ = started(kind)
    with pytest.raises(OutOfOrder):
        next(follow(filter_, belief, [frame]))


def test_the_clock_is_the_callers():
    filter_, belief, frames = started(ExtendedKalmanFilter)
    ticks = count(0.0, 0.25)
    assert [step.seconds for step in follow(filter_, belief, frames, lambda: next(ticks))] == [0.25] * len(frames)
    assert [step.seconds for step in follow(filter_, belief, frames)] == [0.0] * len(frames)


def test_a_frame_is_taken_when_its_step_is_asked_for():
    filter_, belief, frames = started(ExtendedKalmanFilter)
    waiting = iter(frames)
    assert len(list(islice(follow(filter_, belief, waiting), 2))) == 2
    assert list(waiting) == frames[2:]
