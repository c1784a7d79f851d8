"""A robot that odometry leads out of the arena: some vote was wrong, or all is lost, and it is told at once."""

from dataclasses import replace

import numpy as np
import pytest

from filter import Bearing, Odometry, Range
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.guarantee import Guarantee
from filter.poses.slices import EARLIER
from filter.robust.belief import Disagreement, Restarted
from filter.robust.robust_filter import RobustFilter
from filter.team import Team


def test_a_robot_that_has_left_the_arena_starts_over_and_it_is_told():
    robust = RobustFilter(Team(1, np.zeros((0, 2)), arena=np.array([[-2.0, -2.0], [2.0, 2.0]])))
    before = robust.start(0.0, [Polygon.box([1.0, -0.1], [1.2, 0.1])], AngularIntervals([0.0], [0.1]))
    after = robust.predict(before, 1.0, Odometry(0.0, 1.0, 0, 3.0, 0.01, 0.0, 0.01, 0.01, 0.001))
    assert [type(event) for event in after.events] == [Restarted]
    assert after.headings.bound[0] == pytest.approx(np.pi)
    corners = np.array([[-1.99, -1.99], [1.99, 1.99], [-1.99, 1.99]])
    assert all(after.regions[0].outer.contains(corner) for corner in corners)
    assert before.events == ()


def test_what_leaves_the_arena_names_when_doubt_began_and_no_vote_of_an_earlier_window():
    robust = RobustFilter(Team(1, np.zeros((0, 2)), arena=np.array([[-2.0, -2.0], [2.0, 2.0]])))
    odometry = Odometry(1.0, 2.0, 0, 3.0, 0.01, 0.0, 0.01, 0.01, 0.001)
    before = robust.start(1.0, [Polygon.box([1.0, -0.1], [1.2, 0.1])], AngularIntervals([0.0], [0.1]))
    (event,) = robust.predict(replace(before, guarantee=Guarantee(np.array([0.5]), ("votes",))), 2.0, odometry).events
    assert event.suspended_since == 0.5
    stays = robust.start(1.0, [Polygon.box([-1.0, -0.1], [-0.9, 0.1])]).sets[0]
    earlier = replace(stays, without=np.full(len(stays), EARLIER))
    (event,) = robust.predict(replace(before, sets=(earlier,)), 2.0, replace(odometry, distance=np.array([0.1]))).events
    assert isinstance(event, Disagreement)
    assert [source.kind for source in event.suspects] == ["odometry"]


def test_a_vote_that_leads_out_of_the_arena_is_told_and_the_next_right_one_is_not_charged():
    """The robot drives from 3.2 m to 3.7 m; a wrong sighting, which is tolerated, has it at 4.9 m. The arena ends at 5 m."""
    marks = np.array([[4.0, 0.0], [0.0, 4.0]])
    robust = RobustFilter(Team(1, marks, arena=np.array([[-5.0, -5.0], [5.0, 5.0]])))
    belief = robust.start(0.0, [Polygon.box([3.0, -0.1], [5.0, 0.1])], AngularIntervals([0.0], [0.05]))
    belief = robust.update(belief, [Bearing(0.0, 0, 1, np.pi, 0.05), Range(0.0, 0, 1, 0.9, 0.05, 0.0)])
    assert belief.events == ()
    belief = robust.predict(belief, 1.0, Odometry(0.0, 1.0, 0, 0.5, 0.01, 0.0, 0.01, 0.01, 0.001))
    assert [(event.robot, [source.kind for source in event.suspects]) for event in belief.events] == [
        (0, ["sighting", "odometry"])
    ]
    assert belief.disputed[0] == 1.0
    away = marks[1] - [3.7, 0.0]
    bearing, distance = np.arctan2(away[1], away[0]), np.hypot(*away)
    belief = robust.update(belief, [Bearing(1.0, 0, 2, bearing, 0.05), Range(1.0, 0, 2, distance, 0.05, 0.0)])
    assert belief.events == ()
    assert belief.regions[0].outer.contains([3.7, 0.0])
