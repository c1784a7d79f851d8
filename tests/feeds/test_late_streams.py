"""Records of any kind, as they come, in any order: merged where they belong, one by one or a time at once."""

import numpy as np
import pytest
from helpers.driven import TICK
from helpers.feeds.late import batches, delayed, records_of, world
from helpers.teams import snapshot
from helpers.worlds import escapes

from filter import (
    ExtendedKalmanFilter,
    FixedLag,
    Frame,
    InvalidInput,
    Odometry,
    SetMembershipFilter,
    Team,
    follow,
    frames_of,
)


def outside(driven, belief):
    tick = round(belief.time / TICK)
    return escapes(belief, driven.positions[tick], driven.headings[tick])


@pytest.mark.parametrize("every", [0.0, 0.03, 0.2, 5.0])
@pytest.mark.parametrize("seed", range(4))
def test_the_truth_is_inside_after_each_merge_whatever_comes_when(seed, every):
    rng, driven, filter_, known, frames = world(seed)
    lag = FixedLag(filter_, lag=1.0, every=every)
    lagged = lag.begin(known)
    for batch in batches(rng, delayed(rng, records_of(frames), 0.4 * (seed % 3))):
        lagged = lag.merge(lagged, batch)
        assert outside(driven, lagged.belief) == []
        assert all(outside(driven, step.belief) == [] for step in lagged.steps)
    assert (lagged.belief.time, lagged.refused) == (frames[-1].time, 0)
    assert (np.diff([step.belief.time for step in lagged.steps]) > 0).all()


@pytest.mark.parametrize("seed", range(2))
def test_without_every_it_is_what_the_records_in_order_give_bit_for_bit(seed):
    rng, _, filter_, known, frames = world(seed, 20)
    records = [*records_of(frames), Frame(frames[-1].time + 0.01), Frame(frames[3].time + 0.001)]
    lag = FixedLag(filter_, lag=10.0)
    lagged = lag.begin(known)
    for batch in batches(rng, delayed(rng, records, 0.5)):
        lagged = lag.merge(lagged, batch)
    *_, last = follow(filter_, known, frames_of(filter_.team, known.time, records, hold=10.0))
    assert snapshot(lagged.belief.polytope) == snapshot(last.belief.polytope)
    assert snapshot(lagged.belief.headings) == snapshot(last.belief.headings)


def test_so_long_a_time_is_one_step_and_is_done_again_as_long_as_it_goes_on():
    _, _, filter_, known, frames = world(0)
    lag, calls = FixedLag(filter_, lag=0.5, every=0.2), []
    lagged = lag.begin(known)
    for frame in frames:
        before = lagged.steps
        lagged = lag.merge(lagged, [frame])
        calls.append(sum(step not in before for step in lagged.steps))
    assert max(calls) == 1, "odometry that goes on from what is known has nothing done again"
    times = [step.belief.time for step in lagged.steps]
    assert len(times) <= 0.5 / 0.2 + 3
    assert max(np.diff(times)) <= 0.2


def test_what_comes_late_within_a_step_has_its_own_stamp():
    _, _, filter_, known, frames = world(2, 12)
    lag, once = FixedLag(filter_, lag=2.0, every=5.0), records_of(frames)
    late = [record for record in once if record.time == frames[5].time and not isinstance(record, Odometry)]
    rest = [record for record in once if not any(record is each for each in late)]
    lagged = lag.merge(lag.merge(lag.begin(known), rest), late)
    together = lag.merge(lag.begin(known), once)
    assert lagged.late == sum(len(record.robot) for record in late)
    assert snapshot(lagged.belief.polytope) == snapshot(together.belief.polytope)


def test_odometry_from_before_all_that_is_kept_has_nothing_done_again():
    _, _, filter_, known, frames = world(0)
    lag = FixedLag(filter_, lag=0.2)
    lagged = lag.merge(lag.begin(known), frames)
    early = Odometry(known.time - 0.02, known.time - 0.01, [0, 1], 0.0, 0.01, 0.0, 0.01, 0.1, 0.01)
    assert all(one is other for one, other in zip(lag.merge(lagged, [early]).steps, lagged.steps, strict=True))


def test_a_filter_without_advance_has_a_step_for_each_stamp_alone():
    with pytest.raises(InvalidInput, match="advance"):
        FixedLag(ExtendedKalmanFilter(Team(1)), every=0.1)
    with pytest.raises(InvalidInput, match="every"):
        FixedLag(SetMembershipFilter(Team(1)), every=-0.1)
