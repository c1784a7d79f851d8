"""Sensors that are mounted somewhere: the truth is never outside, and regions are hardly larger than they have to be."""

import pickle
from dataclasses import replace

import numpy as np
import pytest
from helpers.sensing.mounted import MountedWorld, rotation
from helpers.worlds import World

from filter import (
    AngularIntervals,
    Bearing,
    Compass,
    Doubted,
    Inconsistent,
    InvalidInput,
    Polygon,
    Range,
    Sensor,
    SetMembershipFilter,
    Source,
    Team,
    watch,
)

DEGREE = np.pi / 180


@pytest.mark.parametrize("seed", range(40))
def test_the_truth_is_inside_whatever_the_mountings(seed):
    rng = np.random.default_rng(seed)
    world = MountedWorld(rng, int(rng.integers(1, 4)), reach=float(rng.choice([0.0, 0.4, 1.5, 6.0])))
    filter_ = SetMembershipFilter(world.team, cells=int(rng.choice([0, 16])))
    belief = filter_.start(0.0, *world.initial(float(rng.choice([0.2, 2.0])), float(rng.choice([0.02, 0.5, 2.0, np.pi]))))
    for _ in range(3):
        belief = filter_.update(belief, world.measure())
        assert world.excluded_by(belief) == ([], [])


@pytest.mark.parametrize("seed", range(12))
def test_at_earlier_instants_the_headings_of_those_count(seed):
    """A robot that turns between instants carries its sensors elsewhere each time."""
    rng = np.random.default_rng(seed)
    world = MountedWorld(rng, int(rng.integers(1, 3)), reach=0.8)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, *world.initial(0.3, float(rng.choice([0.05, 0.5]))))
    for after in world.through_instants(filter_, belief, world.measure):
        assert world.excluded_by(after) == ([], [])


def camera_and_robot(seed, bound):
    """Return what is known of a robot with a camera, and of one that is where that camera is; and how far it is mounted off."""
    rng = np.random.default_rng(seed)
    marks, heading = rng.uniform(-4, 4, (4, 2)), rng.uniform(-np.pi, np.pi)
    arm, turn = rng.uniform(-0.7, 0.7, 2), rotation(heading)
    away, some, found = marks - turn @ arm, rng.permutation(4)[: int(rng.integers(2, 5))], []
    ranges = np.hypot(*away.T) + rng.uniform(-0.02, 0.02, 4)
    ways = np.arctan2(away[:, 1], away[:, 0]) - heading - 0.5 + rng.uniform(-DEGREE, DEGREE, 4)
    records = [Range(0.0, 0, 1 + some, ranges[some], 0.02, 0.0, 0)]
    if seed % 3:
        records.append(Bearing(0.0, 0, 1 + some[:2], ways[some[:2]], DEGREE, 0))
    for place, where in ((arm, np.zeros(2)), (np.zeros(2), turn @ arm)):
        team = Team(1, marks, arena=[[-9, -9], [9, 9]], sensors=[Sensor("camera", place, angle=0.5)])
        filter_ = SetMembershipFilter(team)
        start = filter_.start(0.0, [Polygon.box(where - 2, where + 2)], AngularIntervals(heading, bound))
        found.append(filter_.update(start, records))
        assert found[-1].regions.contains(where[None]).all()
    return *found, np.hypot(*arm)


@pytest.mark.parametrize("seed", range(24))
def test_where_the_heading_is_known_a_mounting_is_a_shift(seed):
    """What is left of the robot is what is left of its camera, along the arc of where that can be."""
    carried, itself, length = camera_and_robot(seed, (1e-9, 0.01)[seed % 2])
    outer = itself.regions[0].outer
    perimeter = np.hypot(*(outer.vertices - np.roll(outer.vertices, 1, axis=0)).T).sum()
    most = outer.area + perimeter * carried.headings.bound[0] * length
    assert carried.regions[0].outer.area < (1.05 if seed % 2 else 1.0001) * most


def lever_arm(bound, sensors, sensor):
    """Return what a compass and three bearings leave of a robot whose camera is 0.25 m ahead, and how far off the camera is."""
    marks = np.array([[2.0, 1.0], [0.5, 2.0], [-1.0, 1.5]])
    away = marks - rotation(0.3) @ [0.25, 0]
    bearings = np.arctan2(away[:, 1], away[:, 0]) - 0.3
    filter_ = SetMembershipFilter(Team(1, marks, arena=[[-5, -5], [5, 5]], sensors=sensors))
    belief = filter_.start(0.0, [Polygon.box([-2, -2], [2, 2])])
    records = [Compass(0.0, 0, 0.3, DEGREE), Bearing(0.0, 0, [1, 2, 3], bearings, bound, sensor)]
    return filter_.update(belief, records).regions[0].outer


def test_a_camera_ahead_of_the_centre():
    """By hand, with bearings made wider by the largest change of direction, the region is many times as large."""
    outer = lever_arm(2 * DEGREE, [Sensor("camera", [0.25, 0])], 0)
    ignored, wider = lever_arm(2 * DEGREE, (), -1), lever_arm(2 * DEGREE + np.arcsin(0.25 / 1.5), (), -1)
    assert outer.contains([0.0, 0.0])
    assert not ignored.contains([0.0, 0.0])
    assert wider.contains([0.0, 0.0])
    assert outer.area < 1.1 * ignored.area < 0.1 * wider.area


@pytest.mark.parametrize("seed", range(6))
def test_sensors_at_the_centre_make_no_difference_to_any_bit(seed):
    world = World(np.random.default_rng(seed), robots=3)
    begin, steps = (world.initial_sets(), world.initial_headings()), list(world.steps(3))
    found = []
    for sensors, number in (((), -1), ((Sensor("here"), Sensor("there")), 1)):
        filter_ = SetMembershipFilter(replace(world.team, sensors=sensors))
        belief = filter_.start(0.0, *begin)
        for driven, records in steps:
            belief = filter_.predict(belief, driven.time, driven)
            belief = filter_.update(belief, [replace(record, sensor=np.full(len(record.robot), number)) for record in records])
        found.append((belief.constraints.offset, belief.headings.bound, belief.regions.outer.vertices))
    assert all((one == other).all() for one, other in zip(*found, strict=True))


def test_two_sensors_of_one_robot_see_one_target_in_two_directions():
    """The bearing of a camera on the right does not tell in which direction a radio on the left measures."""
    camera, radio, place = Sensor("camera", [0.0, -0.5]), Sensor("radio", [0.0, 0.5]), np.zeros(2)
    filter_ = SetMembershipFilter(Team(1, [[1.0, 0.0]], arena=[[-3, -3], [3, 3]], sensors=[camera, radio]))
    belief = filter_.start(0.0, [Polygon.box(place - 1, place + 1)], AngularIntervals(0.0, 0.001))
    measured = [Bearing(0.0, 0, 1, np.arctan2(0.5, 1.0), 0.01, 0), Range(0.0, 0, 1, np.hypot(1, 0.5), 0.01, 0.0, 1)]
    after = filter_.update(belief, measured)
    assert after.regions.contains(place[None]).all()
    assert after.regions[0].outer.area < 0.01


def test_what_a_wrong_mounting_excludes_is_named():
    team = Team(1, [[2.0, 0.0]], arena=[[-9, -9], [9, 9]], sensors=[Sensor("camera", [0.5, 0.0])])
    filter_ = SetMembershipFilter(team)
    start = filter_.start(0.0, [Polygon.box([-0.1, -0.1], [0.1, 0.1])], AngularIntervals(0.0, 0.1))
    with pytest.raises(Inconsistent) as caught:
        filter_.update(start, [Range(0.0, 0, 1, 2.0, 0.05, 0.0, 0)])
    assert [source.kind for source in caught.value.sources] == ["initial set", "heading", "range"]
    kept = SetMembershipFilter(team, policy="reject").update(start, [Range(0.0, 0, 1, [1.5, 2.0], 0.05, 0.0, [0, 0])])
    assert isinstance(kept.events[0], Doubted)
    assert kept.regions.contains(np.zeros((1, 2))).all()


def two_radios(bad=5.0):
    """Return a filter of alice, who has two radios at her centre, and what these say of a gate 2 m ahead: one is wrong."""
    team = Team(["alice"], {"gate": [2.0, 0.0]}, arena=[[-9, -9], [9, 9]], sensors=[Sensor("radio"), Sensor("uwb")])
    records = [Range(0.0, 0, 1, 2.0, 0.1, 0.0, 0), Range(0.0, 0, 1, bad, 0.1, 0.0, 1), Range(0.0, 0, 1, 2.0, 0.1, 0.0)]
    return team, records, AngularIntervals(0.0, 0.1)


def test_conflicts_name_the_sensor():
    team, records, heading = two_radios()
    filter_ = SetMembershipFilter(team)
    start = filter_.start(0.0, [Polygon.box([-8, -8], [8, 8])], heading)
    with pytest.raises(Inconsistent) as caught:
        filter_.update(start, records[:2])
    assert caught.value.sources == (Source("range", 0.0, 0, 1, 0), Source("range", 0.0, 0, 1, 1))
    assert str(caught.value).endswith(
        "range of robot 0 to 1 by sensor 0 at 0.000 s; range of robot 0 to 1 by sensor 1 at 0.000 s"
    )
    named = "range of alice to gate by radio at 0.000 s; range of alice to gate by uwb at 0.000 s"
    assert caught.value.named(team) == f"at 0.0 s: no configuration satisfies all of: {named}"
    assert pickle.loads(pickle.dumps(caught.value)).named(team) == caught.value.named(team)


def test_rejections_and_causes_name_the_sensor():
    team, records, heading = two_radios()
    filter_ = SetMembershipFilter(team, policy="reject")
    belief = filter_.update(filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])], heading), records)
    event = belief.events[0]
    assert Source("range", 0.0, 0, 1, 1) in event.conflict
    assert "range of alice to gate by uwb at 0.000 s" in event.named(team)
    assert "by sensor 1" in str(event)
    belief = filter_.update(filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])], heading), [records[0], records[2]])
    edges = range(len(belief.regions[0].outer.offsets))
    by = {cause.sensor for edge in edges for cause in belief.causes(0, edge) if cause.kind == "range"}
    assert by <= {None, 0}
    assert by


def test_a_compass_and_a_bearing_that_exclude_one_another_name_their_sensors():
    team = Team(1, [[2.0, 0.0]], arena=[[-9, -9], [9, 9]], sensors=[Sensor("camera"), Sensor("needle")])
    filter_ = SetMembershipFilter(team)
    start = filter_.start(0.0, [Polygon.box([-0.1, -0.1], [0.1, 0.1])])
    with pytest.raises(Inconsistent) as caught:
        filter_.update(start, [Compass(0.0, 0, 1.0, 0.1, 1), Bearing(0.0, 0, 1, 1.0, 0.1, 0)])
    by = {source.kind: source.sensor for source in caught.value.sources}
    assert (by["compass"], by["bearing"]) == (1, 0)


def test_a_team_with_sensors_is_a_team_as_any_other():
    world = MountedWorld(np.random.default_rng(3))
    filter_ = pickle.loads(pickle.dumps(SetMembershipFilter(world.team)))
    belief = filter_.update(filter_.start(0.0, *world.initial(0.2, 0.1)), world.measure())
    assert [sensor.name for sensor in filter_.team.sensors] == ["camera", "tag", "compass"]
    assert filter_.team.sensor_number("tag") == 1
    assert watch(pickle.loads(pickle.dumps(belief)), world.positions) == ()


def test_what_is_no_sensor_is_refused():
    team = Team(2, [[1.0, 1.0]], sensors=[Sensor("camera")])
    filter_ = SetMembershipFilter(team)
    start = filter_.start(0.0, [Polygon.box([0, 0], [1, 1])] * 2)
    for wrong, text in (
        (Compass(0.0, 0, 0.0, 0.1, 1), "a sensor among the team's, 0 to 0, or -1 for the centre; came 1"),
        (Range(0.0, 0, 1, 1.0, 0.1, 0.0, 0, 3), "a sensor among the team's"),
        (Range(0.0, 0, 2, 1.0, 0.1, 0.0, 0, 0), "a target_sensor on a robot"),
    ):
        with pytest.raises(InvalidInput, match=text):
            filter_.update(start, [wrong])
    with pytest.raises(InvalidInput, match="none, hence -1"):
        Team(1).check(Compass(0.0, 0, 0.0, 0.1, 0))
    with pytest.raises(InvalidInput, match="whole numbers from -1 on"):
        Compass(0.0, 0, 0.0, 0.1, -2)
    with pytest.raises(InvalidInput, match="no two alike"):
        Team(1, sensors=[Sensor("camera"), Sensor("camera")])
    with pytest.raises(InvalidInput, match="two coordinates"):
        Sensor("camera", [1.0])
    with pytest.raises(InvalidInput, match="as camera; came 'camra'"):
        team.sensor_number("camra")
