"""What is known of a team for good."""

import numpy as np
import pytest

from filter import Bearing, Compass, Odometry, Polygon, Range, SetMembershipFilter
from filter.errors import InvalidInput
from filter.team import Team


@pytest.mark.parametrize("robots", [0, -1, 1.5, "two", None])
def test_a_team_without_a_robot_is_refused(robots):
    with pytest.raises(InvalidInput, match="number of robots: whole numbers from 1 to 1000000; came"):
        Team(robots)


@pytest.mark.parametrize(
    "wrong", [[[np.nan, 0.0]], [[np.inf, 0.0]], [1.0, 2.0, 3.0], [[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]], "here"]
)
def test_landmarks_that_are_no_points_are_refused(wrong):
    with pytest.raises(InvalidInput, match="landmark"):
        Team(1, landmarks=wrong)


@pytest.mark.parametrize("name", ["speed_limit", "turn_rate_limit"])
@pytest.mark.parametrize("wrong", [-1.0, np.nan, np.inf])
def test_a_limit_that_is_none_is_refused(name, wrong):
    with pytest.raises(InvalidInput, match="limit"):
        Team(1, **{name: wrong})


@pytest.mark.parametrize("arena", [[[1, 0], [0, 1]], [0, 1], [[np.nan, 0], [1, 1]], [[0, 0, 0], [1, 1, 1]]])
def test_an_arena_without_a_point_is_refused(arena):
    with pytest.raises(InvalidInput, match="arena"):
        Team(1, arena=arena)


def test_an_arena_may_be_open():
    assert Team(1).arena.tolist() == [[-np.inf, -np.inf], [np.inf, np.inf]]


TEAM = Team(2, landmarks=[[1.0, 2.0]])


def odometry(robot):
    return Odometry(0, 1, robot, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)


@pytest.mark.parametrize("record", [Compass(0, 2, 0, 0), Bearing(0, 2, 0, 0, 0), Range(0, [0, 2], 1, 1, 0, 0), odometry(5)])
def test_a_record_of_an_unknown_robot_is_refused(record):
    with pytest.raises(InvalidInput, match=r"a robot among robots 0 to 1; came robot (2|5)"):
        TEAM.check(record)


@pytest.mark.parametrize("record", [Bearing(0, 0, 3, 0, 0), Range(0, 0, [2, 3], 1, 0, 0)])
def test_an_unknown_target_is_refused_with_those_known(record):
    with pytest.raises(InvalidInput, match="a target among robots 0 to 1 and landmarks 2 to 2; came target 3"):
        TEAM.check(record)


def test_without_landmarks_the_message_says_so():
    with pytest.raises(InvalidInput, match="robots 0 to 1 and no landmark; came target 2"):
        Team(2).check(Bearing(0, 0, 2, 0, 0))


@pytest.mark.parametrize(
    "record", [Compass(0, 1, 0, 0), Bearing(0, 0, 2, 0, 0), Range(0, 1, 0, 1, 0, 0), odometry([0, 1]), Compass(0, [], [], [])]
)
def test_records_of_known_bodies_pass(record):
    assert TEAM.check(record) is None


def test_bodies_have_short_names():
    assert [TEAM.name(body) for body in range(3)] == ["r0", "r1", "l0"]


def test_a_team_cannot_be_changed():
    for array in (TEAM.landmarks, TEAM.arena):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 0


NAMED = Team(["alice", "bob"], {"gate": [4.0, 0.0]}, speed_limit={"bob": 0.0, "alice": 3.0}, turn_rate_limit=1.0)


def test_robots_and_landmarks_can_have_names():
    assert (NAMED.robots, NAMED.landmarks.tolist(), NAMED.names) == (2, [[4.0, 0.0]], ("alice", "bob", "gate"))
    assert [NAMED.number_of(NAMED.name(body)) for body in range(3)] == [0, 1, 2]
    assert Team(2, [[1.0, 2.0]]).names == ("r0", "r1", "l0")
    with pytest.raises(InvalidInput, match="as alice; came 'alise'"):
        NAMED.number_of("alise")


def test_each_robot_may_have_limits_of_its_own():
    assert NAMED.speed_limit.tolist() == [3.0, 0.0]
    filter_ = SetMembershipFilter(NAMED)
    begin = filter_.start(0.0, [Polygon.box([0, 0], [1, 1])] * 2)
    after = filter_.update(filter_.predict(begin, 1.0))
    assert after.regions.outer.areas == pytest.approx([49, 1])


@pytest.mark.parametrize(
    ("arguments", "said"),
    [
        ({"robots": ["alice", "alice"]}, "no two alike"),
        ({"robots": ["alice", "a/b"]}, "names of letters"),
        ({"robots": ["alice", ""]}, "names of letters"),
        ({"robots": [1, 2]}, "robots: names"),
        ({"robots": []}, "number of robots"),
        ({"robots": ["gate"], "landmarks": {"gate": [0, 0]}}, "no two alike"),
        ({"robots": ["alice"], "speed_limit": {"bob": 1.0}}, "one for each of alice; came bob"),
        ({"robots": ["alice"], "speed_limit": [1.0, 2.0]}, "one for each of 1 robots"),
        ({"robots": 2, "names": ["alice"]}, "one name for each of 2 robots and landmarks"),
        ({"robots": 2, "acceleration_limit": -1.0}, "acceleration limit"),
        ({"robots": 2, "turn_acceleration_limit": np.nan}, "acceleration limit"),
    ],
)
def test_names_and_limits_that_are_none_are_refused(arguments, said):
    with pytest.raises(InvalidInput, match=said):
        Team(**arguments)
