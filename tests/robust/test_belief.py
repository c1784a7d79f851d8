"""What a robust belief says of itself: where robots are, when its guarantee is in force, and events in words."""

import dataclasses

import numpy as np
import pytest
from helpers.robust_worlds import started, world_of

from filter.guarantee import Guarantee
from filter.linear.sources import Source
from filter.robust.belief import Disagreement, Distrusted, Late, Restarted, Turned
from filter.robust.robust_filter import RobustFilter


@pytest.fixture(scope="module")
def believed():
    """Return a belief after an update, and its world."""
    world = world_of(0)
    robust = RobustFilter(world.team)
    return robust.update(started(robust, world), world.measure(compasses=False)), world


def test_a_region_is_the_hull_of_all_positions_and_the_headings_are_those_of_all_slices(believed):
    belief, world = believed
    assert len(belief.regions) == len(belief.headings) == world.robots
    for robot, known in enumerate(belief.sets):
        region = belief.regions[robot]
        assert region.outer.support(np.array([[1.0, 0.0], [0.0, 1.0]])) == pytest.approx(known.reach.max(axis=0)[[0, 6]])
        assert (region.inner, region.searches, region.reason) == (None, 0, None)
        for heading in (*known.low, *known.high):
            assert abs(np.angle(np.exp(1j * (heading - belief.headings.centre[robot])))) <= belief.headings.bound[robot] + 1e-9


def test_where_a_camera_is_suspected_to_be_turned_the_heading_can_be_any(believed):
    belief, _ = believed
    suspected = belief.offsets.suspected.copy()
    suspected[1, 0] = True
    after = dataclasses.replace(belief, offsets=dataclasses.replace(belief.offsets, suspected=suspected))
    assert after.headings.full.tolist() == [False, True, False]


def test_the_guarantee_is_in_force_where_nothing_is_doubtful(believed):
    belief, _ = believed
    assert belief.guarantee.in_force.all()
    doubtful = dataclasses.replace(belief, guarantee=Guarantee(np.array([np.inf, 3.0, np.inf]), ("", "votes", "")))
    assert doubtful.guarantee.in_force.tolist() == [True, False, True]
    for array in (belief.guarantee.suspended_since, belief.disputed):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0.0


SEEN = Source("sighting", 2.0, 1, 4)


@pytest.mark.parametrize(
    ("event", "told"),
    [
        (Disagreement(2.0, 1, (SEEN,)), "on robot 1 disagree, one of them is wrong: sighting of robot 1 to 4 at 2.000 s"),
        (Restarted(3.0, 2, 1.5, "it is lost"), "robot 2 starts over, guarantee suspended since 1.500 s: it is lost"),
        (
            Distrusted(3.0, "camera", "robot", 2, True, 1.0, (4, 5)),
            "camera of robot 2 put aside at 3.000 s: sightings of 4, 5 contradict regions since 1.000 s",
        ),
        (
            Distrusted(3.0, "identity", "landmark", 4, True, 1.0, (0,)),
            "identity of landmark 4 put aside at 3.000 s: sightings by robot 0 contradict regions since 1.000 s",
        ),
        (Distrusted(3.0, "camera", "robot", 2, False, np.inf, ()), "camera of robot 2 trusted again at 3.000 s"),
    ],
)
def test_an_event_says_who_when_and_why(event, told):
    assert str(event) == told


@pytest.mark.parametrize("aside", [True, False])
def test_evidence_is_called_evidence(aside):
    turned = str(Turned(9.0, 1, aside, np.radians(-20), np.radians(2), 4.0))
    late = str(Late(9.0, 1, aside, -0.31, 0.02, 4.0))
    assert "off by -20 +- 2 degrees" in turned
    assert "0.31 +- 0.02 s too early" in late
    for told in (turned, late):
        assert "evidence, no proof" in told
        assert ("suspected" in told, "trusted again" in told) == (aside, not aside)
    assert "too late" in str(Late(9.0, 1, aside, 0.31, 0.02, 4.0))
