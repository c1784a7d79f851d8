"""Sensors whose clocks are off: what they measured some time before or after the stamp excludes no truth of the stamp."""

from contextlib import suppress
from dataclasses import replace

import numpy as np
import pytest
from helpers.sensing.clocked import ClockedWorld
from helpers.sensing.mounted import turned

from experiments.follow import main
from experiments.logs import Header, InitialSet, LogReader, LogWriter
from filter import (
    AngularIntervals,
    Bearing,
    Compass,
    ExtendedKalmanFilter,
    GaussianBelief,
    Inconsistent,
    InvalidInput,
    NoiseModel,
    Odometry,
    Polygon,
    Position,
    Range,
    Sensor,
    SetMembershipFilter,
    Team,
)
from filter.linear.constraints import Constraints
from filter.sensing.arms import Arms
from filter.sensing.looks import narrowed_by_bearings
from filter.sensing.readings import Readings

DEGREE = np.pi / 180
MARKS = np.array([[6.0, 0.5], [6.0, -3.0]])
ARENA = [[-10, -10], [10, 10]]


@pytest.mark.parametrize("seed", range(60))
def test_the_truth_is_inside_however_late_or_early_sensors_are(seed):
    rng = np.random.default_rng(seed)
    world = ClockedWorld(rng, int(rng.integers(1, 4)), reach=float(rng.choice([0.0, 0.4, 2.0])))
    filter_ = SetMembershipFilter(world.team, cells=int(rng.choice([0, 16])))
    belief = filter_.start(0.0, *world.initial(float(rng.choice([0.2, 2.0])), float(rng.choice([0.0, 0.02, 0.5, 2.0, np.pi]))))
    for _ in range(3):
        some = rng.choice(3)
        records = [*(world.placed() if some else []), *(world.measure() if some < 2 else [])]
        belief = filter_.update(belief, records)
        assert world.excluded_by(belief) == ([], [])


@pytest.mark.parametrize("seed", range(10))
def test_it_is_at_several_instants(seed):
    rng = np.random.default_rng(seed)
    world = ClockedWorld(rng, int(rng.integers(1, 3)), reach=0.8)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, *world.initial(0.3, float(rng.choice([0.05, 0.5]))))
    for after in world.through_instants(filter_, belief, lambda time: [*world.placed(time, 0.2), *world.measure(time)]):
        assert world.excluded_by(after) == ([], [])


def driven(sensors, off, sensor=0, rate=0.0):
    """Drive at 0.8 m/s and turn, with pictures taken `off` seconds after their stamps; return whether the truth was outside."""
    filter_ = SetMembershipFilter(Team(1, MARKS, 1.0, 1.5, ARENA, sensors=sensors))
    belief = filter_.start(0.0, [Polygon.box([-0.3, -0.3], [0.3, 0.3])], AngularIntervals([0.0], [2 * DEGREE]))

    def pose(time):  # on a circle, or straight on
        turn = rate * time
        way = np.array([np.sin(turn), 1 - np.cos(turn)]) * 0.8 / rate if rate else np.array([0.8 * time, 0.0])
        return way, turn

    for time in 0.1 * np.arange(1, 21):
        before = belief.time
        length, turn = 0.8 * (time - before), rate * (time - before)
        belief = filter_.predict(belief, time, Odometry(before, time, 0, length, 0.001, turn, 0.002, 1 * DEGREE, 0.001))
        place, heading = pose(time + off)
        away = MARKS - place
        ways = np.arctan2(away[:, 1], away[:, 0]) - heading
        belief = filter_.update(
            belief,
            [
                Compass(time, 0, heading, 2 * DEGREE, sensor),
                Bearing(time, 0, [1, 2], ways, 1 * DEGREE, sensor),
                Range(time, 0, [1, 2], np.hypot(*away.T), 0.03, 0.0, sensor),
            ],
        )
        if not (belief.regions.contains(pose(time)[0][None]).all() and belief.headings.contains(pose(time)[1]).all()):
            return True
    return False


@pytest.mark.parametrize("rate", [0.0, 0.6, -1.4])
@pytest.mark.parametrize("off", [-0.1, 0.1, 0.03])
def test_a_camera_whose_clock_is_off_loses_nobody(off, rate):
    assert not driven([Sensor("camera", time_bound=0.1)], off, rate=rate)


@pytest.mark.parametrize("off", [-0.1, 0.1])
def test_a_clock_that_is_off_and_not_declared_loses_the_truth(off):
    with suppress(Inconsistent):
        assert driven([], off, -1)


def known(sensor, records, team=None):
    """Return what records leave of a robot that heads along x, and of its heading."""
    filter_ = SetMembershipFilter(team or Team(1, MARKS, 1.0, 0.5, ARENA, sensors=[sensor]))
    return filter_.update(filter_.start(0.0, [Polygon.box([-3, -3], [3, 3])], AngularIntervals(0.0, 0.2)), records)


def test_a_position_is_wider_by_how_far_the_robot_can_get():
    fix = Position.fix(0.0, 0, [1.0, 0.5], 0.3, 0)
    low, high = known(Sensor("gps", time_bound=0.2), [fix]).regions[0].outer.bounds
    assert low == pytest.approx([0.5, 0.0], abs=1e-6)
    assert high == pytest.approx([1.5, 1.0], abs=1e-6)
    standing = Team(1, MARKS, 0.0, 0.0, ARENA, sensors=[Sensor("gps", time_bound=0.2)])
    assert known(None, [fix], standing).regions[0].outer.area == pytest.approx(0.36, rel=1e-6)


def test_a_compass_is_wider_by_how_far_the_robot_can_turn():
    assert known(Sensor("compass", time_bound=0.2), [Compass(0.0, 0, 0.05, 0.01, 0)]).headings.bound == pytest.approx(0.11)


def test_a_range_is_wider_by_how_far_both_can_get():
    team = Team(2, speed_limit=[1.0, 0.5], arena=ARENA, sensors=[Sensor("uwb", time_bound=0.1)])
    filter_ = SetMembershipFilter(team, tangent_spacing=0.01)
    start = filter_.start(0.0, [Polygon.box([0, 0], [0, 0]), Polygon.box([-5, 0], [5, 0])])
    belief = filter_.update(start, [Range(0.0, 0, 1, 2.0, 0.1, 0.0, 0)])
    assert np.array(belief.regions[1].outer.bounds)[:, 0] == pytest.approx([-2.25, 2.25], abs=1e-3)


def test_readings_of_such_a_sensor_tell_no_direction_to_one_another():
    """A bearing and a range of one stamp may be of two instants."""
    records = [Bearing(0.0, 0, 1, 0.0, 0.1, 0), Range(0.0, 0, 1, 5.0, 0.1, 0.0, 0), Range(0.0, 0, 1, 5.0, 0.1, 0.0, -1)]
    for sensor, narrow in ((Sensor("a"), [True, True]), (Sensor("a", time_bound=0.1), [False, False])):
        readings = Readings.of(0.0, records, mountings=Team(2, sensors=[sensor, Sensor("b", [1, 0])]).mountings)
        arcs = narrowed_by_bearings(AngularIntervals.circles(2), AngularIntervals(0.3, 0.1), readings, 2)
        assert (~arcs.full).tolist() == (narrow if readings.mountings is None else [False, False])


@pytest.mark.parametrize("seed", range(4))
def test_with_clocks_that_are_right_nothing_is_another_to_any_bit(seed):
    world, found = ClockedWorld(np.random.default_rng(seed), 2), []
    records, begin = [*world.measure(), *world.placed()], world.initial(0.5, 0.3)
    standing = replace(world.team, speed_limit=0.0, turn_rate_limit=0.0)
    for team in (standing, replace(standing, sensors=[replace(sensor, time_bound=0.0) for sensor in standing.sensors])):
        try:
            belief = SetMembershipFilter(team).update(SetMembershipFilter(team).start(0.0, *begin), records[-3:])
            found.append((belief.regions.outer.vertices, belief.headings.bound))
        except Inconsistent as error:
            found.append((np.zeros(0), len(error.sources)))
    assert all(np.array_equal(one, other) for one, other in zip(*found, strict=True))


def test_a_kalman_filter_weighs_how_far_robots_can_get():
    sensors = [Sensor("camera", [0.4, 0.3], 0.02, 0.0, 0.03, 0.1), Sensor("tag", [0.0, 0.2])]
    team = Team(2, [[3.6, 0.3]], [1.0, 2.0], [0.5, 0.4], sensors=sensors)
    kalman = ExtendedKalmanFilter(team, NoiseModel.same(1.0))
    belief = GaussianBelief(0.0, [[0.0, 0.0, 0.0], [2.4, 0.1, 0.0]], np.eye(6))
    own, mate, turn = 0.1 * 1.0 + 0.5 * 0.05, 0.1 * 2.0 + 0.2 * 0.04, 0.05
    cases = [
        (Compass(0.0, 0, 0.0, 0.05, 0), 0.05 + 0.03 + turn),
        (Range(0.0, 0, 1, 2.0, 0.1, 0.0, 0, 1), 0.1 + 0.02 + own + mate),
        (Range(0.0, 0, 2, 3.2, 0.1, 0.0, 0), 0.1 + 0.02 + own),
        (Range(0.0, 0, 1, 2.0, 0.1, 0.0, -1, 0), 0.1 + 0.02),  # the clock of a tag says nothing
        (Bearing(0.0, 0, 2, 0.0, 0.05, 0), 0.05 + 0.03 + turn + (0.02 + own) / 3.2),
        (Position.fix(0.0, 0, [0.4, 0.3], 0.1, 0), 0.1 + 0.02 + own),
    ]
    for record, expected in cases:
        assert np.sqrt(kalman._linearised(belief, record)[2]) == pytest.approx(expected, abs=1e-4)


def test_a_log_says_how_far_a_clock_is_off(tmp_path):
    team = Team(1, sensors=[Sensor("camera", time_bound=1 / 3), Sensor("tag")])
    with LogWriter(tmp_path / "log.jsonl", Header(team, 0.0), [InitialSet()]):
        pass
    assert (tmp_path / "log.jsonl").read_text().count("time_bound") == 1
    assert [sensor.time_bound for sensor in LogReader(tmp_path / "log.jsonl").header.team.sensors] == [1 / 3, 0.0]


def test_clocks_that_are_off_are_not_proved_as_yet(tmp_path, capsys):
    team = Team(1, arena=ARENA, sensors=[Sensor("gps", time_bound=0.1)])
    with LogWriter(tmp_path / "log.jsonl", Header(team, 0.0), [InitialSet()]) as log:
        log.append(Position.fix(0.0, 0, [0, 0], 0.1, 0))
    assert main([str(tmp_path / "log.jsonl"), "--certificates", "--out", str(tmp_path / "run")]) == 2
    assert "--certificates" in capsys.readouterr().err


def test_what_is_no_bound_of_a_clock_is_refused():
    with pytest.raises(InvalidInput, match="time bound of a sensor"):
        Sensor("camera", time_bound=-0.1)
    with pytest.raises(InvalidInput, match="in which robots get no farther than 1e\\+100 m"):
        Team(1, speed_limit=1e60, sensors=[Sensor("camera", time_bound=1e60)])


def test_the_ways_of_clocked_sensors_hold_whatever_the_robots_do():
    """The judge draws where both were when it was measured, and moves rows that just held then."""
    rng = np.random.default_rng(4)
    team = Team(2, speed_limit=[0.7, 1.3], turn_rate_limit=[0.5, 2.0], sensors=[Sensor("a", [0.5, 0.1], 0.0, 0.0, 0.0, 0.3)])
    record = Range(0.0, 0, 1, 1.0, 0.1, 0.0, 0, 0)
    readings = Readings.of(0.0, [record], mountings=team.mountings)
    x, h = np.array([[0.0, 0.0], [2.0, 1.0]]), np.array([0.4, -2.0])
    arms, slack = Arms.of(readings, AngularIntervals(h, 0.0), 2), []
    for _ in range(3000):
        way = rng.uniform(-np.pi, np.pi, 2)
        far = 0.3 * team.speed_limit * np.sign(rng.uniform(-1, 1, 2))
        then = x + far[:, None] * np.stack([np.cos(way), np.sin(way)], axis=1)
        heading = h + 0.3 * team.turn_rate_limit * rng.choice([-1, 1, rng.uniform(-1, 1)], 2)
        places = then + turned(heading, np.tile([0.5, 0.1], (2, 1)))
        angle = rng.uniform(-np.pi, np.pi)
        normal = np.array([[np.cos(angle), np.sin(angle)]])
        row = Constraints(np.array([0]), np.array([1]), normal, normal @ (places[1] - places[0]), np.array([0]))
        slack.append((arms.moved(row, np.array([0])).offset - normal @ (x[1] - x[0]))[0])
    assert -1e-9 < min(slack) < 0.05
