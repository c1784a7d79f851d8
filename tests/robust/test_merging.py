"""What one sighting does to a belief: of whom it can be, what is learned of whom, and who is charged with what."""

from dataclasses import replace

import numpy as np
import pytest

from filter import Bearing, Range
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.robust.belief import Rejected
from filter.robust.robust_filter import RobustFilter
from filter.robust.votes import Rules
from filter.team import Team

AHEAD = [Bearing(0.0, 0, 1, 0.0, 0.05), Range(0.0, 0, 1, 3.0, 0.1, 0.0)]


def box(x, y, half=1.0):
    return Polygon.box([x - half, y - half], [x + half, y + half])


def seen(one, other):
    """Return the belief of a robot at the origin and two others before and after it reads the barcode of one, 3 m ahead."""
    robust = RobustFilter(Team(3, arena=[[-9.0, -9.0], [9.0, 9.0]]), Rules(tolerated=0))
    before = robust.start(0.0, [box(0, 0, 0.01), one, other], AngularIntervals([0.0] * 3, [0.01] * 3))
    return before, robust.update(before, AHEAD)


def areas(belief):
    return np.array([region.outer.area for region in belief.regions])


def test_who_can_have_been_nobody_else_is_found():
    before, after = seen(box(3, 0), box(3, 4))
    assert areas(after)[1] < areas(before)[1] / 4
    assert areas(after)[2] == pytest.approx(areas(before)[2])
    assert after.trust.seen[0, 1] == 1


def test_of_two_that_can_have_been_seen_nothing_is_learned():
    before, after = seen(box(3, 0), box(3, 1))
    assert areas(after)[1:] == pytest.approx(areas(before)[1:])
    assert after.events == ()
    assert after.trust.seen.sum() == 0  # that it agrees says nothing
    assert (after.votes.believed == -np.inf).all()


def test_a_barcode_that_only_another_one_can_have_worn_is_rejected_and_learned_nothing_from():
    before, after = seen(box(-3, 0), box(3, 0))
    (event,) = after.events
    assert isinstance(event, Rejected)
    assert (event.source.robot, event.source.target) == (0, 1)
    assert areas(after) == pytest.approx(areas(before))
    assert after.trust.struck[0, 1] == 1
    assert (after.disputed == -np.inf).all()  # it is the barcode that is wrong, nobody's region


def test_a_robot_whose_region_is_disputed_can_be_anywhere_for_others():
    """What a lost robot is believed to be must not tell others who they see."""
    robust = RobustFilter(Team(3, arena=[[-9.0, -9.0], [9.0, 9.0]]), Rules(tolerated=0))
    before, _ = seen(box(3, 0), box(-3, 0))
    assert areas(robust.update(before, AHEAD))[1] < areas(before)[1] / 4
    disputed = replace(before, disputed=np.array([-np.inf, -np.inf, 0.0]))
    assert areas(robust.update(disputed, AHEAD))[1] == pytest.approx(areas(before)[1])
