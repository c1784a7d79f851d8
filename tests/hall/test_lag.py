"""Late measurements: merged as if they had come in order, bit for bit, or refused and counted."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.worlds import World

from filter import (
    AngularIntervals,
    Compass,
    ExtendedKalmanFilter,
    FixedLag,
    Frame,
    InvalidInput,
    Odometry,
    Polygon,
    Range,
    RobustFilter,
    SetMembershipFilter,
    Team,
    follow,
)

HALL = Team(1, [[3.0, 0.0]], 0.5, 1.5, [[-5, -5], [5, 5]])
START = [Polygon.box([-1, -1], [1, 1])]


def motion(start, time):
    """All robots stand, as far as is known."""
    steady = {"distance": 0.0, "distance_bound": 0.05 * (time - start), "turn": 0.0, "turn_bound": 0.01}
    return Odometry(start=start, time=time, robot=[0, 1], direction_bound=0.02, slip_bound=0.001, **steady)


def records_and_filter(kind, seed=0, count=10):
    world = World(np.random.default_rng(seed), robots=2, landmarks=3, sight=99.0)
    filter_ = kind(world.team)
    begin = filter_.start(0.0, world.initial_sets(1.0), world.initial_headings())
    records = []
    for k in range(1, count):
        world.time = 0.2 * k
        records.append(world.measure())
    return filter_, begin, records


def figures(belief):
    columns = [(region.outer.normals, region.outer.offsets, region.outer.vertices) for region in belief.regions]
    return [array.tobytes() for region in columns for array in region] + [belief.headings.centre.tobytes()]


def in_order(filter_, belief, records):
    times = [belief.time, *(said[0].time for said in records)]
    frames = [Frame(time, motion(before, time), said) for (before, time), said in zip(pairwise(times), records, strict=True)]
    *_, step = follow(filter_, belief, frames)
    return step.belief


def test_a_time_that_was_asked_for_stays_a_step_when_something_late_comes_before_it():
    lag = FixedLag(SetMembershipFilter(HALL))
    known = lag.merge(lag.begin(lag.inner.start(0.0, START)), [Frame(0.4)])
    known = lag.merge(known, [Compass(0.2, 0, 0.5, 0.1)])
    assert [step.belief.time for step in known.steps] == [0.0, 0.2, 0.4]


@pytest.mark.parametrize("kind", [RobustFilter, SetMembershipFilter])
@pytest.mark.parametrize("seed", range(2))
def test_late_measurements_give_the_belief_of_those_in_order(kind, seed):
    filter_, begin, records = records_and_filter(kind, seed)
    wanted = figures(in_order(filter_, begin, records))
    lag = FixedLag(filter_, motion, 1.0)
    lagged, rng = lag.begin(begin), np.random.default_rng(seed)
    delays = rng.uniform(0, 0.9, len(records))
    for k in np.argsort([said[0].time + delay for said, delay in zip(records, delays, strict=True)]):
        lagged = lag.merge(lagged, records[k])
    assert figures(lagged.belief) == wanted
    assert lagged.refused == 0 < lagged.late


def test_parts_of_an_instant_may_come_apart():
    filter_, begin, records = records_and_filter(RobustFilter)
    lag = FixedLag(filter_, motion, 1.0)
    lagged = lag.begin(begin)
    for k, said in enumerate(records):
        lagged = lag.merge(lagged, said[1:])
        lagged = lag.merge(lagged, [records[k - 1][0]]) if k else lagged
    lagged = lag.merge(lagged, records[-1][:1])
    assert figures(lagged.belief) == figures(in_order(filter_, begin, records))


def test_what_comes_too_late_is_refused_and_counted():
    filter_, begin, records = records_and_filter(RobustFilter)
    lag = FixedLag(filter_, motion, 0.5)
    lagged = lag.merge(lag.begin(begin), [record for said in records[1:] for record in said])
    after = lag.merge(lagged, records[0])
    assert after.refused == sum(len(record.robot) for record in records[0])
    assert figures(after.belief) == figures(lagged.belief)
    assert len(after.steps) <= 5
    assert lag.merge(after, []).belief is after.belief


def test_a_measurement_at_the_very_start_is_merged_there():
    def unknown(start, time):
        assert start < time, "nobody moves in no time"

    filter_ = RobustFilter(Team(1, [[2.0, 0.0]]))
    lag = FixedLag(filter_, unknown, 1.0)
    begun = lag.begin(filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])]))
    early = Range(0.0, 0, 1, 1.5, 0.1, 0.0)
    late = lag.merge(lag.merge(begun, [Range(0.5, 0, 1, 1.5, 0.6, 0.0)]), [early])
    once = lag.merge(begun, [Range(0.5, 0, 1, 1.5, 0.6, 0.0), early])
    assert late.belief.regions[0].outer.area == once.belief.regions[0].outer.area
    assert late.late == 1


def test_a_negative_lag_is_refused():
    with pytest.raises(InvalidInput):
        FixedLag(RobustFilter(Team(1)), motion, -1.0)


def compass(time):
    return [Compass(time, 0, 0.0, 0.1)]


def anywhere(belief, time):
    """Start over from anywhere in the hall."""
    return SetMembershipFilter(HALL).start(time, [Polygon.box(*HALL.arena)])


def follower(kind=SetMembershipFilter, **options):
    """Return a lag around a filter of one robot that has followed its compass for a second, from 10 s on."""
    filter_ = kind(HALL)
    lag = FixedLag(filter_, lambda start, time: None, **options)
    return merged(lag, lag.begin(filter_.start(10.0, START)), 10 + 0.1 * np.arange(10))


def merged(lag, lagged, times):
    for time in times:
        lagged = lag.merge(lagged, compass(time))
        assert all(str(event) for event in lagged.events)
    return lag, lagged


@pytest.mark.parametrize("kind", [SetMembershipFilter, RobustFilter, ExtendedKalmanFilter])
@pytest.mark.parametrize("by", [1e9, 90.0, -90.0, -1e9])
@pytest.mark.parametrize("restart", [None, anywhere])
def test_one_wrong_stamp_is_refused_and_told_and_changes_nothing(kind, by, restart):
    lag, before = follower(kind, restart=restart)
    after = lag.merge(before, compass(11.0 + by))
    assert (after.refused, after.belief.time, after.steps) == (1, before.belief.time, before.steps)
    (event,) = after.events
    assert (event.time, event.stamp, event.measurements, event.restarted) == (before.belief.time, 11.0 + by, 1, False)
    assert f"{11.0 + by:.3f} s" in str(event)
    assert "refused" in str(event)
    assert getattr(after.belief, "events", (event,)) == (event,)
    following = lag.merge(after, compass(11.1))
    assert (following.belief.time, following.events, following.refused) == (11.1, (), 1)
    assert getattr(following.belief, "events", ()) == ()


def test_a_wrong_stamp_among_good_ones_is_refused_alone():
    lag, lagged = follower()
    lagged = lag.merge(lagged, [*compass(1e6), *compass(11.0), *compass(-1e6)])
    assert (lagged.belief.time, lagged.refused, lagged.astray) == (11.0, 2, None)
    assert [(event.stamp, event.measurements) for event in lagged.events] == [(-1e6, 2)]


@pytest.mark.parametrize("begin", [0.0, -1e6, 90.0, 1e6])
def test_a_clock_that_goes_on_from_where_it_jumped_starts_the_filter_over(begin):
    times = begin + 0.1 * np.arange(10) + (begin > 0) * 10.9
    lag, lagged = follower(gap=5.0, restart=anywhere)
    first = lag.merge(lagged, compass(times[0]))
    second = lag.merge(first, compass(times[1]))
    assert (first.belief.time, second.belief.time, second.refused) == (lagged.belief.time, times[1], 1)
    assert [event.restarted for event in (*first.events, *second.events)] == [False, True]
    assert "starts over" in str(second.belief.events[-1])
    assert second.belief.regions[0].outer.area == pytest.approx(100, rel=1e-3)
    _, last = merged(lag, second, times[2:])
    assert (last.belief.time, last.refused, last.events) == (times[-1], 1, ())


def test_what_is_known_after_a_jump_is_what_restart_makes_of_what_was_known():
    told = []
    lag, lagged = follower(gap=5.0, restart=lambda belief, time: told.append((belief, time)) or lag.inner.predict(belief, time))
    _, after = merged(lag, lagged, [40.0, 40.1])
    assert told == [(lagged.belief, 40.1)]
    assert after.belief.time == 40.1
    assert after.belief.regions[0].outer.area == pytest.approx(100, rel=1e-3)


@pytest.mark.parametrize("begin", [0.0, 90.0])
def test_without_restart_a_jump_is_refused_and_told_each_time_for_as_long_as_it_lasts(begin):
    lag, lagged = follower(gap=5.0)
    for k in range(20):
        after = lag.merge(lagged, compass(begin + 0.1 * k))
        assert (after.belief.time, len(after.events), after.refused) == (lagged.belief.time, 1, lagged.refused + 1)
        lagged = after
    again = lag.merge(lag.begin(anywhere(None, begin + 2.0)), compass(begin + 2.1))
    assert again.belief.time == begin + 2.1, "it is for the caller to begin again"


@pytest.mark.parametrize("wrong", [[1e6, 1e6], [1e6, 2e6], [1e6, -1e6], [1e6, 1e6 - 0.1]])
def test_stamps_that_do_not_go_on_from_one_another_are_no_clock(wrong):
    lag, lagged = follower(gap=5.0, restart=anywhere)
    _, after = merged(lag, lagged, wrong)
    assert (after.belief.time, after.refused) == (lagged.belief.time, 2)
    assert lag.merge(after, compass(11.0)).belief.time == 11.0


def test_a_sensor_whose_clock_is_wrong_is_refused_each_time_between_those_that_are_right():
    lag, lagged = follower(gap=5.0, restart=anywhere)
    for k in range(1, 10):
        lagged = lag.merge(lag.merge(lagged, compass(1e6 + 0.1 * k)), compass(11 + 0.1 * k))
    assert (lagged.belief.time, lagged.refused) == (11.9, 9)


def test_what_is_late_by_less_than_the_gap_is_no_jump_however_often_it_comes():
    lag, lagged = follower(lag=0.2, gap=5.0, restart=anywhere)
    _, after = merged(lag, lagged, 9.0 + 0.1 * np.arange(10))
    assert (after.belief.time, after.refused) == (lagged.belief.time, 10)


def test_a_whole_log_may_come_at_once_as_long_as_nothing_in_it_is_farther_apart_than_the_gap():
    lag, lagged = follower(gap=5.0)
    times = 11 + 4.9 * np.arange(50)
    records = [record for time in times[::-1] for record in compass(time)]
    after = lag.merge(lagged, [*records, *compass(times[-1] + 5.1)])
    assert (after.belief.time, after.refused) == (times[-1], 1)


@pytest.mark.parametrize("gap", [-1.0, np.inf, "long"])
def test_a_gap_that_is_none_is_refused(gap):
    with pytest.raises(InvalidInput, match="gap"):
        FixedLag(RobustFilter(Team(1)), motion, gap=gap)


def test_a_restart_that_is_no_function_is_refused():
    with pytest.raises(InvalidInput, match="restart"):
        FixedLag(RobustFilter(Team(1)), motion, restart=AngularIntervals.circles(1))
