"""Records at stamps of their own: frames that say the same, in whatever order they come."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.worlds import World, escapes

from filter import (
    Bearing,
    Compass,
    FixedLag,
    Frame,
    InvalidInput,
    Motions,
    Odometry,
    OutOfOrder,
    Polygon,
    SetMembershipFilter,
    Team,
    Truth,
    Twist,
    follow,
    frames_of,
)
from filter.records.record import field_names

TEAM = Team(2, [[3.0, 0.0]], speed_limit=0.5, turn_rate_limit=2.0)


def driven(start, time, robot=0, distance=0.0):
    return Odometry(start, time, robot, distance, 0.001, 0.0, 0.002, 0.01, 0.001)


def columns(record):
    return None if record is None else (record.time, *(getattr(record, name).tolist() for name in field_names(record)))


def shown(frames):
    return [(frame.time, columns(frame.odometry), sorted(map(str, map(columns, frame.measurements)))) for frame in frames]


def stream(rng, length=2.0):
    """Return records of two robots, each sensor at its own rate, in order of time."""
    records = []
    for robot in range(2):
        stamps = np.cumsum(np.concatenate([[0.0], rng.uniform(0.01, 0.06, int(length / 0.035))]))
        records += [driven(*span, robot, rng.uniform(-0.01, 0.01)) for span in pairwise(stamps)]
        records += [Compass(time, robot, 0.1, 0.2) for time in np.cumsum(rng.uniform(0.03, 0.1, 25)) if time < length]
        records += [Bearing(time, robot, 2, 0.2, 0.3) for time in np.cumsum(rng.uniform(0.1, 0.2, 15)) if time < length]
    return sorted(records, key=lambda record: record.time)


def test_frames_in_lock_step_stay_as_they_are():
    world = World(np.random.default_rng(0))
    given = [Frame(world.time, motion, said) for motion, said in world.steps(5)]
    flat = [each for frame in given for each in (frame.odometry, *frame.measurements, Frame(frame.time))]
    for arrivals in (given, flat):
        assert shown(frames_of(world.team, 0.0, arrivals)) == shown(given)


@pytest.mark.parametrize("seed", range(3))
def test_the_order_in_which_records_come_makes_no_difference(seed):
    rng = np.random.default_rng(seed)
    records = stream(rng)
    delayed = [records[k] for k in np.argsort([record.time + rng.uniform(0, 0.4) for record in records], kind="stable")]
    frames = list(frames_of(TEAM, 0.0, records))
    assert shown(frames_of(TEAM, 0.0, delayed, hold=0.5)) == shown(frames)
    assert [frame.time for frame in frames] == sorted({r.time for r in records if not isinstance(r, Odometry)})
    whole = [frame.odometry.distance.sum() for frame in frames if frame.odometry is not None]
    assert sum(whole) == pytest.approx(sum(r.distance[0] for r in records if isinstance(r, Odometry)), abs=0.05)


def test_a_frame_waits_no_longer_than_records_may_be_late():
    records, taken = stream(np.random.default_rng(1)), []
    for frame in frames_of(TEAM, 0.0, (taken.append(record) or record for record in records), hold=0.2):
        assert taken[-1].time > frame.time + 0.2 or taken[-1] is records[-1]


def test_what_comes_too_late_is_told():
    late = [Compass(1.0, 0, 0.0, 0.1), Compass(3.0, 0, 0.0, 0.1), Compass(0.5, 0, 0.0, 0.1)]
    with pytest.raises(OutOfOrder, match=r"compass at 0\.5 s"):
        list(frames_of(TEAM, 0.0, late))
    with pytest.raises(OutOfOrder):
        list(frames_of(TEAM, 2.0, late))
    with pytest.raises(InvalidInput, match="a record"):
        list(frames_of(TEAM, 0.0, ["compass"]))


def test_a_twist_that_ended_another_one_too_long_ago_is_told():
    """What was made of the other one in the meantime relied on that it held."""
    twists = [Twist(time, 0, 0.2, 0.01, 0.0, 0.02, 0.05, 0.0, 9.0) for time in (-1.0, 0.0, 0.5)]
    compasses = [Compass(time, 0, 0.0, 0.1) for time in (1.0, 4.0)]
    driven = Odometry(0.5, 4.5, 0, 0.1, 0.1, 0.0, 0.1, 0.0, 0.0)
    for record, said in ((twists[2], r"twist at 0\.5 s"), (driven, r"odometry at 0\.5 s")):
        assert len(list(frames_of(TEAM, 0.0, [*twists[:2], record, *compasses]))) == 2
        with pytest.raises(OutOfOrder, match=said):
            list(frames_of(TEAM, 0.0, [*twists[:2], *compasses, record]))
    assert len(list(frames_of(TEAM, 0.0, [*compasses, driven]))) == 2  # where no twist was, the limits were relied on
    lag = FixedLag(SetMembershipFilter(TEAM), lag=1.0)
    lagged = lag.begin(lag.inner.start(0.0, [Polygon.box([0, 0], [1, 1])] * 2))
    for record in [*twists[:2], *compasses]:
        lagged = lag.merge(lagged, [record])
    for record, said in ((twists[2], r"twist at 0\.5 s"), (driven, r"odometry at 0\.5 s")):
        with pytest.raises(OutOfOrder, match=said):
            lag.merge(lagged, [record])


def test_truth_comes_with_the_frame_of_its_time():
    truth = Truth([[0.0, 0.0], [1.0, 1.0]], [0.0, 0.0])
    (frame,) = frames_of(TEAM, 0.0, [Compass(1.0, 0, 0.0, 0.1), Frame(1.0, truth=truth)])
    assert (frame.truth, len(frame.measurements)) == (truth, 1)


@pytest.mark.parametrize("seed", range(3))
def test_a_lag_merges_everything_as_it_comes_and_ends_at_the_same(seed):
    rng = np.random.default_rng(seed)
    records = stream(rng, 0.6)
    filter_ = SetMembershipFilter(TEAM)
    begin = filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])] * 2)
    *_, last = follow(filter_, begin, frames_of(TEAM, 0.0, records))
    lag = FixedLag(filter_, lag=1.0)
    lagged = lag.begin(begin)
    for k in np.argsort([record.time + rng.uniform(0, 0.2) for record in records]):
        before, lagged = lagged, lag.merge(lagged, [records[k]])
        assert lagged.belief.time >= before.belief.time
    assert lagged.belief.time == last.belief.time
    assert lagged.belief.regions.outer.areas == pytest.approx(last.belief.regions.outer.areas)
    assert lagged.belief.headings.bound == pytest.approx(last.belief.headings.bound)


def test_before_its_odometry_has_come_a_robot_has_moved_within_its_limits():
    lag = FixedLag(SetMembershipFilter(TEAM))
    begin = lag.begin(lag.inner.start(0.0, [Polygon.box([0, 0], [1, 1])] * 2))
    early = lag.merge(begin, [Compass(1.0, 0, 0.0, 0.1)])
    later = lag.merge(early, [driven(0.0, 1.0), driven(0.0, 2.0, robot=1)])
    assert early.belief.regions[0].outer.area > 3
    assert later.belief.regions[0].outer.area < 1.1
    with pytest.raises(InvalidInput, match=r"odometry of r0 that begins at 1\.0 s or later"):
        lag.merge(later, [driven(0.5, 1.5)])


def test_a_twist_holds_until_the_next_one_and_no_longer_than_it_says():
    motions = Motions(TEAM).merged(Twist(0.0, 0, 0.2, 0.01, 0.1, 0.02, 0.05, 0.0, 1.0))
    whole = motions.between(0.0, 1.0)
    assert [*whole.distance, *whole.distance_bound, *whole.turn] == pytest.approx([0.2, 0.01, 0.1])
    half = motions.between(0.25, 0.75)
    assert [*half.distance, *half.distance_bound, *half.turn_bound] == pytest.approx([0.1, 0.005, 0.01])
    assert motions.between(1.0, 1.1) is None
    ended = motions.merged(Twist(0.5, 0, -0.2, 0.01, 0.0, 0.02, 0.05, 0.0, 1.0)).between(0.0, 1.5)
    assert abs(ended.distance[0]) + ended.distance_bound[0] + ended.slip_bound[0] >= 0.1
    with pytest.raises(InvalidInput, match="hold"):
        Twist(0.0, 0, 0.2, 0.01, 0.1, 0.02, 0.05, 0.0, 0.0)


@pytest.mark.parametrize("seed", range(3))
def test_a_clock_of_its_own_is_no_error(seed):
    """Odometry in steps of t += 0.1, measurements at k / 10: the same times but for rounding."""
    world = World(np.random.default_rng(seed), robots=2)
    filter_, time, arrivals = SetMembershipFilter(world.team), 0.0, []
    begin = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    for k in range(1, 30):
        motion = world.drive(np.full(2, 0.02), np.full(2, 0.02), 0.1)
        arrivals.append(Odometry(time, time + 0.1, motion.robot, *(getattr(motion, name) for name in field_names(motion)[1:])))
        time += 0.1
        world.time = k / 10
        arrivals += world.measure()
    *_, last = follow(filter_, begin, frames_of(world.team, 0.0, arrivals))
    assert escapes(last.belief, world.positions, world.headings) == []
