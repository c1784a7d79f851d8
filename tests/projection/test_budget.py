"""When time is up, regions that are not refined yet are what was propagated: larger, and still sound; the eldest come first."""

import numpy as np
import pytest
from filter.projection.budget import Budget, never
from helpers.worlds import World, escapes

from filter.errors import InvalidInput
from filter.projection.window import Window
from filter.sets.set_membership import SetMembershipFilter


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


def test_a_time_before_it_begins_is_refused():
    with pytest.raises(InvalidInput, match="time budget"):
        Budget(-1.0, Ticks())
    with pytest.raises(InvalidInput, match="a Budget"):
        SetMembershipFilter(World(np.random.default_rng(0)).team, budget=1.0)


@pytest.mark.parametrize("scope", ["team", Window(1, 4)])
@pytest.mark.parametrize(("solver", "seconds"), [("exact", 3.0), ("piqp", 3.0), ("exact", 0.0)])
def test_robots_take_turns_and_none_escapes(scope, solver, seconds, monkeypatch):
    monkeypatch.setattr("filter.projection.team.TOGETHER", 1)
    world = World(np.random.default_rng(3), robots=5, errors="extreme")
    hurried = SetMembershipFilter(world.team, solver, scope=scope, budget=Budget(seconds, Ticks()), threads=1)
    belief = hurried.start(0.0, world.initial_sets(), world.initial_headings())
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


def test_who_was_not_reached_keeps_the_propagated_region():
    world = World(np.random.default_rng(1), robots=4)
    unhurried, hurried = (SetMembershipFilter(world.team, budget=b) for b in (None, Budget(0.0, Ticks())))
    belief = unhurried.update(unhurried.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    motion = world.move()
    predicted = hurried.predict(belief, motion.time, motion)
    after = hurried.update(predicted)
    before = predicted.regions.outer.areas
    assert (before * (1 - 1e-12) <= after.regions.outer.areas).all()
    assert (after.regions.outer.areas <= before * 1.001).all()  # of many rows some are pruned
    assert after.polytope.lower.tolist() == predicted.polytope.lower.tolist()
    kinds = {source.kind for robot in range(4) for edge in range(3) for source in after.causes(robot, edge)}
    assert kinds <= {"region", "range", "bearing", "initial set"}


def test_time_enough_changes_nothing():
    world = World(np.random.default_rng(2), robots=4)
    start, records = (world.initial_sets(), world.initial_headings()), world.measure()
    for scope in ("team", Window()):
        one, other = (SetMembershipFilter(world.team, scope=scope, budget=b) for b in (None, Budget(1e9, Ticks())))
        areas = [each.update(each.start(0.0, *start), records).regions.outer.areas.tolist() for each in (one, other)]
        assert areas[0] == areas[1]
