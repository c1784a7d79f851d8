"""Whatever filter runs, its belief says whether its guarantee is in force, since when it is not, and why."""

import numpy as np
import pytest
from helpers.worlds import World

from filter import (
    Compass,
    ExtendedKalmanFilter,
    Frame,
    Guarantee,
    Inconsistent,
    InvalidInput,
    Odometry,
    Polygon,
    Range,
    RobustFilter,
    SetMembershipFilter,
    Team,
    Window,
    follow,
)

KINDS = [SetMembershipFilter, RobustFilter, ExtendedKalmanFilter]
TEAM = Team(2, [[4.0, 0.0]], 0.5, 1.5, [[-6, -6], [6, 6]])
BOXES = [Polygon.box([-1, -1], [1, 1]), Polygon.box([0, 2], [1, 3])]
LIE = Range(1.0, 0, 2, 11.0, 0.1, 0.0)


@pytest.mark.parametrize("kind", KINDS)
def test_every_belief_says_it_of_every_robot(kind):
    world = World(np.random.default_rng(3), robots=3, landmarks=2, sight=99.0)
    filter_ = kind(world.team)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    frames = [Frame(motion.time, motion, tuple(records)) for motion, records in world.steps(3)]
    promises = kind is not ExtendedKalmanFilter
    for each in (belief, *(step.belief for step in follow(filter_, belief, frames))):
        assert each.guarantee.in_force.tolist() == [promises] * 3
        assert (str(each.guarantee) == "in force") == promises
        assert all(why == "" for why in each.guarantee.because) == promises


def test_one_that_is_suspended_stays_so_since_the_first_time_and_for_the_first_reason():
    partly = Guarantee(np.array([np.inf, 2.0, np.inf]), ("", "votes", ""))
    after = partly.suspended(3.0, "a lie").suspended(4.0, "another")
    assert after.suspended_since.tolist() == [3.0, 2.0, 3.0]
    assert str(after) == "suspended for robot 0, robot 2 since 3.000 s, as a lie; suspended for robot 1 since 2.000 s, as votes"
    assert partly.in_force.tolist() == [True, False, True]
    with pytest.raises(ValueError, match="read-only"):
        partly.suspended_since[0] = 0.0


@pytest.mark.parametrize("options", [{}, {"exact": False}, {"scope": Window(1)}, {"pairs": 0}], ids=str)
def test_after_a_conflict_it_is_in_force_on_an_assumption(options):
    filter_ = SetMembershipFilter(TEAM, policy="reject", **options)
    before = filter_.predict(filter_.update(filter_.start(0.0, BOXES), [Range(0.0, 0, 2, 4.0, 1.0, 0.0)]), 1.0)
    belief = filter_.update(before, [LIE])
    assert str(before.guarantee) == "in force"
    assert belief.guarantee.in_force.all()
    said = belief.guarantee.assuming
    assert said.startswith("if only one of these is wrong since 0.000 s: ")
    later = filter_.predict(belief, 2.0, Odometry(1.0, 2.0, 0, 0.1, 0.01, 0.0, 0.01, 0.01, 0.01))
    for records in ([], [Compass(2.0, 0, 0.0, 0.1)]):
        assert filter_.update(later, records).guarantee.assuming == said
    agreeing = SetMembershipFilter(TEAM, **options)  # whatever filter goes on with it
    assert agreeing.update(agreeing.predict(belief, 2.0), []).guarantee.assuming == said


def test_it_is_suspended_for_some_robots_and_restored_for_one():
    some = Guarantee.full(3).suspended(1.0, "a lie", {0, 2})
    assert some.in_force.tolist() == [False, True, False]
    assert some.because == ("a lie", "", "a lie")
    assert some.restored(2).in_force.tolist() == [False, True, True]
    assert str(some.restored(2)) == "suspended for robot 0 since 1.000 s, as a lie"
    assert (
        str(some.under("if all is well")) == "suspended for robot 0, robot 2 since 1.000 s, as a lie; in force if all is well"
    )
    assert str(Guarantee.full(1).under("if all is well").under("")) == "in force"


def test_with_the_policy_that_raises_it_is_never_suspended():
    filter_ = SetMembershipFilter(TEAM)
    belief = filter_.predict(filter_.start(0.0, BOXES), 1.0)
    with pytest.raises(Inconsistent):
        filter_.update(belief, [LIE])
    assert filter_.update(belief, []).guarantee.in_force.all()


@pytest.mark.parametrize("kind", KINDS)
def test_none_stands_for_the_arena_at_the_start(kind):
    filter_ = kind(TEAM)
    unknown, said = filter_.start(0.0, [None, BOXES[1]]), filter_.start(0.0, [Polygon.box(*TEAM.arena), BOXES[1]])
    if kind is ExtendedKalmanFilter:
        assert unknown.mean.tolist() == said.mean.tolist()
        assert unknown.position_covariances[0] == pytest.approx(np.eye(2) * 12**2 / 12)  # a uniform square of 12 m
    else:
        assert [each.outer.area for each in unknown.regions] == [each.outer.area for each in said.regions]
        assert unknown.regions[0].outer.area == pytest.approx(144.0)
    with pytest.raises(InvalidInput, match="a closed arena, for which None stands"):
        kind(Team(2, arena=[[-6, -np.inf], [6, 6]])).start(0.0, [None, BOXES[1]])
