"""Several instants merged at the last one: the truth is inside, and little more than what a step for each instant leaves."""

import numpy as np
import pytest
from helpers.worlds import World, escapes

from filter import (
    AngularIntervals,
    Compass,
    Frame,
    Inconsistent,
    Odometry,
    Polygon,
    Position,
    SetMembershipFilter,
    Team,
    follow,
)
from filter.geometry.angles import wrap

NOWHERE = Polygon.box([50, 50], [51, 51])


def frames_in(world, count):
    """Return what a world gives in so many instants, of all sensors or of some, and where its robots are then."""
    frames, poses = [], []
    for _ in range(count):
        driven = world.tour(float(world.rng.uniform(0.02, 0.1)))
        kept = [record for record in world.measure() if world.rng.random() < 0.6]
        for robot in np.flatnonzero(world.rng.random(world.robots) < 0.2).tolist():
            bound = world.rng.uniform(0.1, 0.5, 2)
            kept.append(Position.fix(world.time, robot, world.positions[robot] + bound * world.error(2), bound + 1e-12))
        frames.append(Frame(world.time, driven if world.rng.random() < 0.95 else None, kept))
        poses.append((world.positions, world.headings))
    return frames, poses


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("seed", range(2))
def test_the_truth_is_inside_after_several_instants_at_once(seed, errors):
    world = World(np.random.default_rng(seed), robots=3, errors=errors, landmarks=2)
    filter_ = SetMembershipFilter(world.team)
    belief, together = filter_.start(0.0, world.initial_sets(), world.initial_headings()), 0
    for _ in range(12):
        frames, poses = frames_in(world, int(world.rng.integers(1, 7)))
        together += filter_._together(belief, frames) is not None
        belief = filter_.advance(belief, frames)
        assert belief.time == world.time
        assert escapes(belief, *poses[-1]) == []
    assert together > 3


@pytest.mark.parametrize("seed", range(3))
def test_regions_are_hardly_larger_than_by_a_step_for_each_instant(seed):
    world = World(np.random.default_rng(seed), robots=2, landmarks=4, sight=9.0)
    filter_ = SetMembershipFilter(world.team)
    begin = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    frames = []
    for _ in range(80):
        driven = world.drive(np.full(2, 0.008), np.full(2, 0.004), 0.02)
        frames.append(Frame(world.time, driven, world.measure()[int(world.rng.integers(3)) :][:1]))
    each = {step.belief.time: step.belief.regions.outer.areas.mean() for step in follow(filter_, begin, frames)}
    some = {step.belief.time: step.belief.regions.outer.areas.mean() for step in follow(filter_, begin, frames, every=0.1)}
    assert 12 < len(some) < 20
    told = [step.frame for step in follow(filter_, begin, frames, every=0.1)]
    assert sum(len(frame.measurements) for frame in told) == sum(len(frame.measurements) for frame in frames)
    assert np.mean([area / each[time] for time, area in some.items() if time > 0.5]) < 1.1


def test_one_instant_is_a_step():
    world = World(np.random.default_rng(1))
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    driven, records = world.move(), world.measure()
    once = filter_.update(filter_.predict(belief, world.time, driven), records)
    assert (
        filter_.advance(belief, [Frame(world.time, driven, records)]).constraints.offset.tolist()
        == once.constraints.offset.tolist()
    )
    assert filter_.advance(belief, []) is belief


def test_a_conflict_is_that_of_the_instant_it_is_in():
    world = World(np.random.default_rng(2))
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    frames = [Frame(world.time, driven, records) for driven, records in world.steps(3)]
    wrong = Frame(frames[1].time, frames[1].odometry, [Position.within(frames[1].time, 0, NOWHERE)])
    with pytest.raises(Inconsistent) as caught:
        filter_.advance(belief, [frames[0], wrong, frames[2]])
    assert {source.kind for source in caught.value.sources} >= {"position"}
    assert all(source.time <= wrong.time for source in caught.value.sources)


def test_headings_are_followed_to_and_fro():
    """A compass at the end tells how a robot looked in the beginning, and so where it has driven."""
    team = Team(1, speed_limit=1.0, turn_rate_limit=0.5)
    filter_, x, time = SetMembershipFilter(team), np.zeros(2), 0.0
    belief, frames = filter_.start(0.0, [Polygon.box([-0.01, -0.01], [0.01, 0.01])], AngularIntervals.circles(1)), []
    for k in range(5):
        frames.append(Frame(time + 0.1, _straight(time), [Compass(time + 0.1, 0, 0.5, 0.01)] if k == 4 else []))
        time, x = time + 0.1, x + 0.1 * np.array([np.cos(0.5), np.sin(0.5)])
    after = filter_.advance(belief, frames)
    assert after.regions.contains(x[None]).all()
    assert after.regions[0].outer.area < 0.01
    assert abs(wrap(after.headings.centre[0] - 0.5)) < 0.02


def _straight(time):
    return Odometry(time, time + 0.1, 0, 0.1, 0.001, 0.0, 0.001, 0.01, 0.0)
