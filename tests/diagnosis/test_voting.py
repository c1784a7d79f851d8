"""Votes on poses: while of each robot no more than one vote is wrong in any window, the truth is inside, in a slice, too."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from helpers.drawn.broken import going_on, outside, stepped
from helpers.drawn.lies import lied, pairs_that_lie
from helpers.drawn.tolerant import known
from helpers.worlds import World
from hypothesis import given, settings
from hypothesis import strategies as st

from filter import (
    Compass,
    Doubted,
    Frame,
    Inconsistent,
    InvalidInput,
    Polygon,
    Range,
    SetMembershipFilter,
    Suspect,
    Team,
    Tolerance,
    Tolerated,
    Truth,
    wrap,
)
from filter.poses.slices import AGREED, DIRECTIONS

WINDOW = 1.0  # [s]


def voting(team, window=WINDOW, **options):
    return SetMembershipFilter(team, tolerance=Tolerance(1, window, "identities"), **options)


def frames_in(world, count, compasses):
    """Return so many frames of a world, with what is known at its start."""
    known_before = world.initial_sets(), world.initial_headings(0.3)
    found = []
    for _ in range(count):
        odometry = world.tour()
        truth = Truth(world.positions, world.headings)
        found.append(Frame(world.time, odometry, tuple(world.measure(compasses=compasses)), truth))
    return found, known_before


def in_a_slice(belief, robot, truth):
    mine = belief.slices.of(robot)
    looks = mine.arcs.contains(np.full(len(mine), truth.headings[robot]))
    return not len(mine) or (looks & (DIRECTIONS @ truth.positions[robot] <= mine.reach).all(axis=1)).any()


@settings(max_examples=8)
@given(st.integers(0, 2**32 - 1))
def test_the_truth_is_inside_while_of_each_robot_one_body_is_wrong_in_any_window(seed):
    rng = np.random.default_rng(seed)
    robots, marks = int(rng.integers(1, 4)), int(rng.integers(1, 4))
    world = World(rng, robots, marks, 4.0, str(rng.choice(["uniform", "extreme"])), origin=rng.choice([0.0, 5e6], 2))
    frames, before = frames_in(world, 7, bool(rng.random() < 0.3))
    filter_ = voting(world.team, pairs=0, cells=int(rng.choice([0, 4, 64])), slices=int(rng.choice([0, 1, 12])))
    belief = filter_.start(0.0, *before)
    for frame in pairs_that_lie(frames, robots, robots + marks, WINDOW, rng):
        belief = stepped(filter_, belief, frame)
        assert not outside(belief, frame.truth).any()
        assert all(in_a_slice(belief, robot, frame.truth) for robot in range(robots))


@pytest.mark.parametrize("seed", range(3))
def test_every_pose_that_contradicts_one_body_at_most_is_inside(seed):
    rng = np.random.default_rng(seed)
    world = World(rng, 1, 4, sight=9.0)
    (box,), arcs = world.initial_sets(), world.initial_headings(0.5)
    bearings, ranges = records = world.measure(compasses=False)
    filter_ = voting(world.team)
    belief = filter_.update(filter_.start(0.0, [box], arcs), records)
    (lower, upper), count = box.bounds, 20_000
    places = rng.uniform(lower, upper, (count, 2))
    looks = arcs.centre + arcs.bound * rng.uniform(-1, 1, (count, 1))
    away = world.team.landmarks - places[:, None]
    least, greatest = ranges.interval()
    agrees = (np.hypot(away[..., 0], away[..., 1]) >= least) & (np.hypot(away[..., 0], away[..., 1]) <= greatest)
    agrees &= np.abs(wrap(np.arctan2(away[..., 1], away[..., 0]) - looks - bearings.bearing)) <= bearings.bound
    few = np.flatnonzero((~agrees).sum(axis=1) <= 1)
    assert len(few) > 20
    assert belief.regions[0].outer.contains(places[few]).all()
    assert belief.headings[np.zeros(len(few), dtype=int)].contains(looks[few, 0]).all()
    assert all(in_a_slice(belief, 0, Truth(places[[k]], looks[k])) for k in few[:50])


@pytest.mark.parametrize("seed", range(3))
def test_it_is_as_large_as_strict_filters_together_each_without_one_body(seed):
    """The slow and obvious version: a strict filter for each landmark, without what the robot measures of it."""
    world = World(np.random.default_rng(seed), 1, 4, sight=9.0)
    frames, before = frames_in(world, 5, compasses=False)
    filter_, strict = voting(world.team, window=99.0), SetMembershipFilter(world.team)
    belief, others = filter_.start(0.0, *before), [strict.start(0.0, *before)] * 5
    for frame in frames:
        belief = stepped(filter_, belief, frame)
        for body in range(5):
            left = Tolerance().believed([Suspect("sighting", 0, body)] if body else [], frame.measurements)
            others[body] = stepped(strict, others[body], replace(frame, measurements=left))
        around = Polygon.hull(np.concatenate([other.regions[0].outer.vertices for other in others]))
        assert belief.regions[0].outer.area < 1.1 * around.area


@pytest.mark.parametrize("compasses", [False, True])
def test_the_order_of_records_makes_no_difference_and_where_nobody_lies_everybody_agrees(compasses):
    world = World(np.random.default_rng(5), 3, 3, 5.0, sight=9.0)
    frames, before = frames_in(world, 5, compasses)
    filter_ = voting(world.team)
    belief = filter_.start(0.0, *before)
    for frame in frames:
        shuffled = replace(frame, measurements=tuple(map(_reversed, reversed(frame.measurements))))
        other = stepped(filter_, pickle.loads(pickle.dumps(belief)), shuffled)
        belief = stepped(filter_, belief, frame)
        assert known(belief) == known(other)
        assert belief.agrees
        assert not belief.suspects


def _reversed(record):
    return replace(record, **{name: value[::-1] for name, value in vars(record).items() if isinstance(value, np.ndarray)})


def test_a_lie_that_is_proved_is_told_and_a_new_window_begins():
    world = World(np.random.default_rng(3), 2, 5, 5.0, sight=9.0)
    frames, before = frames_in(world, 7, compasses=True)
    filter_, liar = voting(world.team, window=1.5), Suspect("sighting", 0, 3)
    belief, told = filter_.start(0.0, *before), []
    for k, frame in enumerate(frames):
        belief = stepped(filter_, belief, lied(frame, liar, np.random.default_rng(0), size=2.0) if k == 1 else frame)
        told += [event for event in belief.events if isinstance(event, Tolerated)]
        assert not outside(belief, frame.truth).any()
        assert belief.agrees == (k != 1)
    (event,) = told
    assert event.time == frames[1].time
    assert [case[0].who for case in event.cases] == [liar.who]
    words = "in force if for each robot at most one of these is wrong within any 1.5 s"
    assert str(belief.guarantee) == f"{words}: what it measures of one body, or one mate of it, within 0.15 s"


def test_one_more_lie_than_is_tolerated_is_a_conflict_or_a_doubt():
    world = World(np.random.default_rng(4), 1, 6, 5.0, sight=9.0)
    frames, before = frames_in(world, 4, compasses=True)
    for filter_ in (voting(world.team, 99.0), going_on(world.team, tolerance=Tolerance(1, 99.0, "identities"))):
        belief = filter_.start(0.0, *before)
        for frame in frames[:3]:
            belief = stepped(filter_, belief, frame)
        rng = np.random.default_rng(0)
        wrong = lied(lied(frames[3], Suspect("sighting", 0, 2), rng, size=2.0), Suspect("sighting", 0, 5), rng, size=3.0)
        if filter_.policy == "raise":
            with pytest.raises(Inconsistent) as error:
                stepped(filter_, belief, wrong)
            assert {source.target for source in error.value.sources if source.kind in ("range", "bearing")} >= {2, 5}
            continue
        belief = stepped(filter_, belief, wrong)
        assert any(isinstance(event, Doubted) for event in belief.events)
        assert not outside(belief, frames[3].truth).any()


def test_a_vote_that_lasts_as_its_window_ends_is_another_one_from_then_on():
    team = Team(1, [[3.0, 0.0], [0.0, 3.0], [-3.0, 0.0]], speed_limit=0.0, turn_rate_limit=0.0)
    filter_ = voting(team)
    belief = filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])])
    for time, lie in ((0.0, 0.0), (0.95, 0.0), (1.0, 0.3)):
        far = Range(time, 0, [1, 2, 3], [3.0, 3.0 + lie, 3.0], 0.1, 0.0)
        belief = filter_.update(filter_.predict(belief, time) if time else belief, [far])
        assert belief.regions[0].outer.contains([0.0, 0.0])


def test_robots_that_are_placed_or_gone_have_a_new_window():
    world = World(np.random.default_rng(6), 2, 4, 5.0, sight=9.0)
    frames, before = frames_in(world, 4, compasses=False)
    filter_ = voting(world.team, 99.0)
    belief = filter_.start(0.0, *before)
    for frame in frames[:3]:
        belief = stepped(filter_, belief, frame)
    assert (belief.slices.vote != AGREED).any()
    truth = frames[2].truth
    belief = filter_.placed(belief, 1, Polygon.box(truth.positions[1] - 0.3, truth.positions[1] + 0.3))
    liar = Suspect("sighting", 0, 3)
    belief = stepped(filter_, belief, lied(frames[3], liar, np.random.default_rng(1), size=0.3))
    assert not outside(belief, frames[3].truth).any()


def test_what_is_said_of_nobody_else_is_believed():
    team = Team(1)
    filter_ = voting(team)
    belief = filter_.update(filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])]), [Compass(0.0, 0, 0.5, 0.1)])
    assert belief.headings.bound[0] == pytest.approx(0.1)
    assert not len(belief.slices)


def test_identities_are_suspects_alone():
    for wrong in ({"q": 2}, {"suspects": ("identities", "pairs")}, {"lies": "long"}):
        with pytest.raises(InvalidInput, match="identities alone"):
            Tolerance(**{"suspects": "identities"} | wrong)
