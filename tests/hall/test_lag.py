"""Late measurements: merged as if they had come in order, bit for bit, or refused and counted."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.worlds import World

from filter import FixedLag, Frame, InvalidInput, Odometry, Polygon, Range, RobustFilter, SetMembershipFilter, Team, follow


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
