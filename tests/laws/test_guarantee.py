"""Whatever filter runs, its belief says whether its guarantee is in force, since when it is not, and why."""

from dataclasses import replace

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
    assert str(after) == "suspended for robots 0, 2 since 3.000 s, as a lie; suspended for robots 1 since 2.000 s, as votes"
    assert partly.in_force.tolist() == [True, False, True]
    with pytest.raises(ValueError, match="read-only"):
        partly.suspended_since[0] = 0.0


@pytest.mark.parametrize("options", [{}, {"exact": False}, {"scope": Window(1)}, {"pairs": 0}], ids=str)
def test_a_rejection_suspends_it_for_good(options):
    """It is a guess that the rejected record was at fault: after a wrong one, what is known may exclude the truth for ever."""
    filter_ = SetMembershipFilter(TEAM, policy="reject", **options)
    before = filter_.predict(filter_.update(filter_.start(0.0, BOXES), [Range(0.0, 0, 2, 4.0, 1.0, 0.0)]), 1.0)
    belief = filter_.update(before, [LIE])
    assert before.guarantee.in_force.all()
    assert belief.guarantee.suspended_since.tolist() == [1.0, 1.0]
    assert belief.guarantee.because[0] == str(belief.events[0])
    later = filter_.predict(belief, 2.0, Odometry(1.0, 2.0, 0, 0.1, 0.01, 0.0, 0.01, 0.01, 0.01))
    for records in ([], [Compass(2.0, 0, 0.0, 0.1)], [replace(LIE, time=2.0)]):
        assert filter_.update(later, records).guarantee.because == belief.guarantee.because
        assert filter_.update(later, records).guarantee.suspended_since.tolist() == [1.0, 1.0]
    agreeing = SetMembershipFilter(TEAM)  # whatever filter goes on with it
    assert not agreeing.update(agreeing.predict(belief, 2.0), []).guarantee.in_force.any()


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
