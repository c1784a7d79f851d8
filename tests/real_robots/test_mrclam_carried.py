"""Frames about carried headings: what is declared is in the records, and silence says nothing."""

from types import SimpleNamespace

import numpy as np
import pytest

from experiments.real_robots.carried import Carried, CarriedBounds
from filter import Bearing, Compass, Frame, Odometry, Range
from filter.errors import InvalidInput


def carried(*commands, hold=2.0, **bounds):
    tables = tuple(np.array(table, dtype=float).reshape(-1, 3) for table in commands)
    return Carried(SimpleNamespace(bounds=SimpleNamespace(hold=hold), commands=tables), CarriedBounds(**bounds))


def moved(carried_, start, time, robots=1):
    told = Odometry(start, time, np.arange(robots), 9.0, 9.0, 9.0, 9.0, 0.0, 0.0)
    return carried_.frame(Frame(time, told, (), None)).odometry


@pytest.mark.parametrize("true", [0.2, 1.0, 7.0])
@pytest.mark.parametrize("side", [-1, 1])
def test_a_range_at_its_bounds_contains_the_true_one(true, side):
    bounds = CarriedBounds()
    share = bounds.longest if side > 0 else -bounds.shortest
    record = bounds.seen(Range(0.0, 0, 1, (1 + share) * true + side * bounds.range, 0.5, 0.0))
    (least,), (greatest,) = record.interval()
    assert least - 1e-12 <= true <= greatest + 1e-12
    assert min(true - least, greatest - true) == pytest.approx(0.0, abs=1e-9)


def test_a_bearing_has_the_jitter_in_its_bound_and_a_compass_is_left_alone():
    bounds = CarriedBounds(bearing=0.1, jitter=0.05)
    assert bounds.seen(Bearing(0.0, 0, 1, 0.3, 0.5)).bound[0] == pytest.approx(0.15)
    compass = Compass(0.0, [0], [0.0], 0.1)
    assert bounds.seen(compass) is compass


def test_commands_hold_until_the_next_one_and_add_up():
    robot = [(0.0, 0.1, 0.2), (1.0, 0.05, -0.4), (2.0, 0.0, 0.0)]
    team = carried(robot, command_lag=0.0, speed_scale=1.0, turn_scale=1.0, turn_share=0.1, turn_drift=0.0)
    whole = moved(team, 0.5, 1.5)
    assert whole.distance[0] == pytest.approx(0.075)
    assert whole.turn[0] == pytest.approx(-0.1)
    assert whole.turn_bound[0] == pytest.approx(0.03)
    parts = [moved(team, *ends) for ends in ((0.5, 0.8), (0.8, 1.3), (1.3, 1.5))]
    for name in ("distance", "distance_bound", "turn", "turn_bound", "slip_bound"):
        assert sum(getattr(part, name)[0] for part in parts) == pytest.approx(getattr(whole, name)[0])


def test_a_robot_whose_commands_have_stopped_is_left_out_until_they_come_again():
    team = carried([(0.0, 0.1, 0.0), (5.0, 0.1, 0.0)], [(t, 0.0, 0.0) for t in range(9)], [(9.0, 0.1, 0.0)], command_lag=0.0)
    assert moved(team, 1.0, 2.0, 3).robot.tolist() == [0, 1, 2]  # who was not told anything yet stands
    assert moved(team, 1.5, 2.5, 3).robot.tolist() == [1, 2]
    assert moved(team, 3.0, 5.0, 3).robot.tolist() == [1, 2]
    assert moved(team, 5.0, 6.0, 3).robot.tolist() == [0, 1, 2]
    assert not moved(team, 1.0, 2.0, 3).distance[2]


def test_nothing_is_known_of_the_motion_of_a_robot_without_any_command():
    assert moved(carried([(0.0, 0.1, 0.0)], []), 1.0, 2.0, 2).robot.tolist() == [0]


def test_bounds_that_are_none_are_refused():
    with pytest.raises(InvalidInput):
        CarriedBounds(shortest=1.0)
    with pytest.raises(InvalidInput):
        CarriedBounds(jitter=-0.1)
