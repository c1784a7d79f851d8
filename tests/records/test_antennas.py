"""Positions by antennas that are mounted somewhere: the truth is never outside, and rows are as wide as they have to be."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.sensing.mounted import MountedWorld, rotation, turned

from filter import (
    AngularIntervals,
    Bearing,
    Compass,
    ExtendedKalmanFilter,
    GaussianBelief,
    Inconsistent,
    InvalidInput,
    NoiseModel,
    Polygon,
    Position,
    Sensor,
    SetMembershipFilter,
    Team,
)

ARM, OFF = np.array([0.8, -0.6]), 0.05
SENSORS = [Sensor("antenna", ARM, OFF), Sensor("exact", ARM), Sensor("tag", [0.0, 0.3])]
TEAM = Team(2, [[3.0, 0.0]], arena=[[-50, -50], [50, 50]], sensors=SENSORS)
BOX = Polygon.box([-3, -3], [3, 3])


def updated(records, headings, filter_=None):
    filter_ = filter_ or SetMembershipFilter(TEAM)
    return filter_.update(filter_.start(0.0, [BOX] * 2, AngularIntervals(*headings)), records)


@pytest.mark.parametrize("seed", range(40))
def test_the_truth_is_inside_whatever_the_mountings(seed):
    rng = np.random.default_rng(seed)
    world = MountedWorld(rng, int(rng.integers(1, 4)), reach=float(rng.choice([0.0, 0.4, 1.5, 6.0])))
    filter_ = SetMembershipFilter(world.team, cells=int(rng.choice([0, 16])))
    belief = filter_.start(0.0, *world.initial(float(rng.choice([0.2, 2.0])), float(rng.choice([0.0, 0.02, 0.5, 2.0, np.pi]))))
    for _ in range(3):
        others = world.measure(bearings=0.3, ranges=0.3) if rng.random() < 0.6 else []
        belief = filter_.update(belief, [*world.placed(), *others])
        assert world.excluded_by(belief) == ([], [])


@pytest.mark.parametrize("seed", range(10))
def test_at_earlier_instants_the_headings_of_those_count(seed):
    rng = np.random.default_rng(seed)
    world = MountedWorld(rng, int(rng.integers(1, 3)), reach=0.8)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, *world.initial(0.3, float(rng.choice([0.05, 0.5]))))
    for after in world.through_instants(filter_, belief, lambda time: [*world.placed(time), *world.measure(time, ranges=0.2)]):
        assert world.excluded_by(after) == ([], [])


@pytest.mark.parametrize("heading", [0.0, 0.7, np.pi, -2.5])
def test_where_the_heading_is_known_the_region_is_the_fix_moved_back(heading):
    fix, arm = np.array([1.2, -0.7]), rotation(heading) @ ARM
    belief = updated([Position.fix(0.0, 0, fix, 0.3, 1)], ([heading, 0.0], [0.0, 0.1]))
    low, high = belief.regions[0].outer.bounds
    assert low == pytest.approx(fix - arm - 0.3, abs=1e-7)
    assert high == pytest.approx(fix - arm + 0.3, abs=1e-7)
    wider = updated([Position.fix(0.0, 0, fix, 0.3, 0)], ([heading, 0.0], [0.0, 0.1])).regions[0].outer.bounds
    assert np.ptp(wider, axis=0) == pytest.approx([0.6 + 2 * OFF] * 2, abs=1e-6)


@pytest.mark.parametrize("half", [0.1, 0.6, 2.0, np.pi])
def test_no_place_that_fits_is_cut_off_and_hardly_any_other_is_left(half):
    """The judge draws headings in the arc and places of the antenna in the half-plane, and asks where the centre is."""
    rng, heading = np.random.default_rng(5), 0.4
    for way in np.linspace(-np.pi, np.pi, 9):
        normal = np.array([np.cos(way), np.sin(way)])
        record = Position.half_plane(0.0, 0, normal, 0.5, 0)
        outer = updated([record], ([heading, 0.0], [half, 0.1])).regions[0].outer
        headings = heading + np.append(rng.uniform(-half, half, 4000), [-half, half])
        arms = turned(headings, np.tile(ARM, (len(headings), 1)))
        most = 0.5 + OFF - (arms @ normal).min()  # normal . x <= offset - normal . R(h) m
        left = (outer.vertices @ normal).max()
        assert min(most, (BOX.vertices @ normal).max()) - 1e-3 <= left + 1e-9
        assert left <= most + 0.02 * np.hypot(*ARM) + 1e-6


def test_a_compass_and_a_bearing_of_the_same_instant_tell_where_the_antenna_is():
    fix = Position.fix(0.0, 0, ARM, 0.1, 1)
    wide = updated([fix], ([0.0, 0.0], [0.5, 0.1])).regions[0].outer.area
    known = updated([fix, Compass(0.0, 0, 0.0, 0.01)], ([0.0, 0.0], [0.5, 0.1])).regions[0].outer.area
    seen = updated([fix, Bearing(0.0, 0, 2, 0.0, 0.01)], ([0.0, 0.0], [0.5, 0.1])).regions[0].outer.area
    assert known < 0.1 * wide
    assert seen < 0.3 * wide


def test_an_antenna_at_the_centre_makes_no_difference_to_any_bit():
    record, found = Position.disc(0.0, 0, [1.0, 0.5], 0.4), []
    for sensors, number in (((), -1), ((Sensor("here"),), 0)):
        filter_ = SetMembershipFilter(replace(TEAM, sensors=sensors))
        belief = updated([replace(record, sensor=np.full(len(record.robot), number))], ([0.0, 0.0], [0.1, 0.1]), filter_)
        found.append((belief.constraints.offset, belief.regions.outer.vertices))
    assert all((one == other).all() for one, other in zip(*found, strict=True))


def test_what_two_antennas_of_a_robot_say_in_one_record_are_two_measurements():
    good, bad = Position.fix(0.0, 0, ARM, 0.2, 1), Position.fix(0.0, 0, [9, 9], 0.2, 2)
    columns = ("robot", "normal_x", "normal_y", "offset", "sensor")
    both = Position(0.0, *(np.concatenate([getattr(each, name) for each in (good, bad)]) for name in columns))
    assert both.first.tolist() == [0, 0, 0, 0, 4, 4, 4, 4]
    belief = updated([both], ([0.0, 0.0], [0.01, 0.1]), SetMembershipFilter(TEAM, policy="reject"))
    assert {source.sensor for source in belief.events[0].conflict if source.kind == "position"} == {2}
    assert belief.regions.contains([[0.0, 0.0], [0.0, 0.0]]).all()


def test_the_heading_that_an_antenna_rests_on_is_named():
    with pytest.raises(Inconsistent) as caught:
        updated([Position.fix(0.0, 0, [-3.5, 0.6], 0.2, 1)], ([0.0, 0.0], [0.1, 0.1]))
    assert {source.kind for source in caught.value.sources} == {"position", "heading", "initial set"}


@pytest.mark.parametrize("sensor", [-1, 0, 2])
def test_a_kalman_filter_expects_the_antenna_where_it_is_mounted(sensor):
    kalman, mean = ExtendedKalmanFilter(TEAM, NoiseModel.same(1.0)), np.array([[0.3, 0.2, 0.5], [2.0, 1.0, -2.0]])
    place = mean[1, :2] + rotation(-2.0) @ (np.zeros(2) if sensor < 0 else SENSORS[sensor].position)
    record = Position.fix(0.0, 1, place + np.array([0.01, -0.02]), [0.1, 0.2], sensor)

    def linearised(state):
        return kalman._linearised(GaussianBelief(0.0, state.reshape(2, 3), np.eye(6)), record)

    innovation, H, variance = linearised(mean.ravel())
    assert innovation == pytest.approx([0.01, -0.02], abs=1e-6)
    assert np.sqrt(variance) == pytest.approx(np.array([0.1, 0.2]) + (OFF if sensor == 0 else 0.0), abs=1e-4)
    steps = 1e-2 * np.eye(6)  # the box around a fix is cut from one of 1e9 m, and rounded like that
    numeric = [(linearised(mean.ravel() - step)[0] - linearised(mean.ravel() + step)[0]) / 2e-2 for step in steps]
    assert pytest.approx(np.stack(numeric, axis=1), abs=1e-4) == H


def test_what_is_no_antenna_is_refused():
    with pytest.raises(InvalidInput, match="a sensor among the team's, 0 to 2, or -1 for the centre; came 3"):
        updated([Position.fix(0.0, 0, ARM, 0.1, 3)], ([0.0, 0.0], [0.1, 0.1]))
    with pytest.raises(InvalidInput, match="whole numbers"):
        Position.disc(0.0, 0, ARM, 0.1, sensor=0.5)
