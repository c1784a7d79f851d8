"""When time is up, regions that are not refined yet are what was propagated: larger, and still sound; the eldest come first."""

import numpy as np
import pytest
from helpers.programs import round_set
from helpers.teams import begun
from helpers.worlds import World, escapes

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import InvalidInput
from filter.projection.stop import REASONS, Budget, Stop, never
from filter.projection.window import Window


class Ticks:
    """A clock that is one second later each time it is looked at."""

    def __init__(self):
        self.now = -1.0

    def __call__(self):
        self.now += 1.0
        return self.now


def test_it_ends_when_its_time_has_passed():
    is_over = Budget(2.0, Ticks()).begin()
    assert [is_over() for _ in range(3)] == [False, True, True]
    assert not never()
    assert Budget(0.0, Ticks()).begin()()


@pytest.mark.parametrize("wrong", [-1.0, np.nan, np.inf, "soon"])
def test_a_time_that_is_none_is_refused(wrong):
    with pytest.raises(InvalidInput, match="time budget"):
        Budget(wrong, Ticks())


def test_a_budget_that_is_none_is_refused():
    with pytest.raises(InvalidInput, match="budget: a Budget or None"):
        SetMembershipFilter(World(np.random.default_rng(0)).team, budget=1.0)


@pytest.mark.parametrize(
    "wrong",
    [
        {"performance_ratio": 1.1},
        {"performance_ratio": np.nan},
        {"area_gap": -1.0},
        {"area_gap": np.inf},
        {"searches": 3},
        {"searches": np.nan},
    ],
)
def test_a_stop_out_of_its_range_is_refused(wrong):
    with pytest.raises(InvalidInput):
        Stop(**wrong)


@pytest.mark.parametrize(
    ("inside", "gap", "searches", "reason"),
    [
        (0.9, 0.1, 4, "performance ratio"),
        (0.89, 0.11, 4, None),
        (0.4, 0.05, 4, "area gap"),
        (0.5, 0.5, 9, None),
        (0.5, 0.5, 10, "searches"),
        (0.0, 0.0, 4, "performance ratio"),
    ],
)
def test_whichever_comes_first_ends_a_search(inside, gap, searches, reason):
    assert Stop(0.9, 0.05, 10).reason(inside, gap, searches) == reason
    assert reason is None or reason in REASONS


def test_the_goal_is_what_was_asked_for():
    assert Stop(1, 2, 5).goal == (1.0, 2.0, 5)


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 4)])
@pytest.mark.parametrize(("exact", "seconds"), [(True, 3.0), (False, 5.0), (True, 0.0)])
def test_robots_take_turns_and_none_escapes(scope, exact, seconds, monkeypatch):
    monkeypatch.setattr("filter.projection.team.TOGETHER", 1)
    world = World(np.random.default_rng(3), robots=5, errors="extreme")
    stop = Stop() if exact else Stop(searches=4)  # from the fourth direction on a search looks at the clock
    budget = Budget(seconds, Ticks())
    hurried = SetMembershipFilter(world.team, exact, stop=stop, scope=scope, budget=budget, threads=1, cells=0)
    belief = begun(hurried, world)
    refined = []
    for motion, records in world.steps(5):
        belief = hurried.update(hurried.predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []
        refined.append({robot for robot, region in enumerate(belief.regions) if region.reason != "time"})
        assert all(region.inner is None and not region.searches for region in belief.regions if region.reason == "time")
    if not seconds:
        assert refined == [set()] * 5
    else:
        assert [len(some) for some in refined] == [2] * 5
        assert refined[0] | refined[1] | refined[2] == set(range(5))


@pytest.mark.parametrize("seconds", [1.0, 2.0, 3.0, 4.0, 9.0])
@pytest.mark.parametrize("exact", [True, False])
def test_time_may_run_out_at_any_moment(exact, seconds):
    world = World(np.random.default_rng(4), robots=3)
    hurried = SetMembershipFilter(world.team, exact, scope=Window(1, 3), budget=Budget(seconds, Ticks()))
    start = hurried.start(0.0, [round_set(position) for position in world.positions])
    belief = hurried.update(start, world.measure())
    assert escapes(belief, world.positions) == []
    assert len(belief.regions) == 3


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 4)])
def test_searches_that_time_cuts_short_take_turns_too(scope):
    world = World(np.random.default_rng(3), robots=3, errors="extreme")
    hurried = SetMembershipFilter(world.team, False, scope=scope, budget=Budget(4.0, Ticks()), cells=0)
    belief, begun_at = begun(hurried, world), []
    for motion, records in world.steps(3):
        belief = hurried.update(hurried.predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []
        assert {region.reason for region in belief.regions} == {"time"}
        begun_at.append({robot for robot, region in enumerate(belief.regions) if region.searches})
        assert len(begun_at[-1]) == 1
    assert set.union(*begun_at) == {0, 1, 2}


def test_who_was_not_reached_keeps_the_propagated_region():
    world = World(np.random.default_rng(1), robots=4)
    unhurried, hurried = (SetMembershipFilter(world.team, budget=b) for b in (None, Budget(0.0, Ticks())))
    belief = unhurried.update(begun(unhurried, world), world.measure())
    motion = world.move()
    predicted = hurried.predict(belief, motion.time, motion)
    after = hurried.update(predicted)
    before = predicted.regions.outer.areas
    assert (before * (1 - 1e-12) <= after.regions.outer.areas).all()
    assert (after.regions.outer.areas <= before * 1.001).all()  # of many rows some are pruned
    assert after.polytope.lower.tolist() == predicted.polytope.lower.tolist()
    kinds = {source.kind for robot in range(4) for edge in range(3) for source in after.causes(robot, edge)}
    assert kinds <= {"region", "range", "bearing", "initial set", "cells"}


def test_time_enough_changes_nothing():
    world = World(np.random.default_rng(2), robots=4)
    start, records = (world.initial_sets(), world.initial_headings()), world.measure()
    for scope in (Window.everybody(), Window()):
        one, other = (SetMembershipFilter(world.team, scope=scope, budget=b) for b in (None, Budget(1e9, Ticks())))
        areas = [each.update(each.start(0.0, *start), records).regions.outer.areas.tolist() for each in (one, other)]
        assert areas[0] == areas[1]
