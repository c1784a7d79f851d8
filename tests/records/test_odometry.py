"""How robots moved: what a record of it is, and what is left of it without some robots."""

import numpy as np
import pytest

from filter import InvalidInput, Odometry, Twist
from filter.records.record import field_names


def drawn(rng, robots):
    values = rng.uniform(0, 1, (7, len(robots)))
    return Odometry(0.5, 1.5, robots, *values)


@pytest.mark.parametrize("away", [set(), {2}, {0, 5}, {0, 2, 5}, {1, 9}])
def test_without_some_robots_it_says_the_same_of_the_others(away):
    whole = drawn(np.random.default_rng(0), [5, 0, 2])
    left = whole.without(away)
    assert (left.start, left.time) == (0.5, 1.5)
    others = [robot not in away for robot in (5, 0, 2)]
    for name in field_names(whole):
        assert getattr(left, name).tolist() == getattr(whole, name)[others].tolist()
        assert not getattr(left, name).flags.writeable
    assert len(whole.robot) == 3


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"time": 0.4}, "ends at its start or later"),
        ({"robot": [1, 1]}, "each robot at most once"),
        ({"direction_bound": np.pi / 2}, "direction bound"),
        ({"distance_bound": -1e-9}, "distance bound"),
        ({"aside": 7}, "aside"),
        ({"turn": [0.1, 0.2, 0.3]}, "columns of one length"),
    ],
)
def test_what_is_no_motion_is_refused(change, said):
    bounds = {"distance_bound": 0.1, "turn_bound": 0.1, "direction_bound": 0.1, "slip_bound": 0.1}
    given = {"start": 0.5, "time": 1.5, "robot": [0, 1], "distance": 1.0, "turn": 0.0, **bounds}
    Odometry(**given)
    with pytest.raises(InvalidInput, match=said):
        Odometry(**given | change)


def test_a_twist_holds_for_some_time():
    with pytest.raises(InvalidInput, match="hold"):
        Twist(0.0, 0, 0.2, 0.01, 0.0, 0.02, 0.05, 0.0, 0.0)
