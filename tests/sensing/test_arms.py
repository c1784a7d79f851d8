"""Where sensors are mounted: what holds of their places holds of the centres, moved by no more than it has to be."""

import numpy as np
import pytest
from helpers.sensing.mounted import MountedWorld, turned

from filter import AngularIntervals, Bearing, Compass, Frame, Odometry, Polygon, Range, Sensor, Team
from filter.geometry.angles import wrap
from filter.linear.constraints import Constraints
from filter.sensing.arms import Arms, ways_from
from filter.sensing.looks import Look, narrowed_by_bearings
from filter.sensing.motion import CORNERS
from filter.sensing.readings import Readings
from filter.sensing.since import Since

SEEDS = range(30)


def way_of(seed):
    """Return a mounting, an arc of headings, and ways from the sensor to the centre for headings and places in the bounds."""
    rng = np.random.default_rng(seed)
    place = rng.choice([0.0, 1.0, 30.0]) * rng.uniform(-1, 1, 2)
    bound, half = rng.choice([0.0, 0.05]), rng.choice([0.0, 1e-3, 0.3, 1.5, 3.0, np.pi])
    arc = AngularIntervals(rng.uniform(-np.pi, np.pi), half)
    heading = arc.centre.astype(np.longdouble) + half * np.append(rng.uniform(-1, 1, 300), [-1, 0, 1])
    off, shorter = rng.uniform(-np.pi, np.pi, len(heading)).astype(np.longdouble), np.longdouble(1 - 1e-18)
    really = place + bound * shorter * np.stack([np.cos(off), np.sin(off)], axis=1)
    mountings = Team(3, sensors=[Sensor("a", [9, 9]), Sensor("b", place, bound)]).mountings
    return ways_from(mountings, np.array([1]), arc), -turned(heading, really), (place, bound, arc)


@pytest.mark.parametrize("seed", SEEDS)
def test_no_way_is_beyond_the_supports_and_the_disc(seed):
    """The ways are computed with eleven bits more, and there is no tolerance."""
    ways, true, (place, bound, _) = way_of(seed)
    assert ways.vertices.shape == (1, CORNERS, 2)
    assert ways.slip[0] >= bound + 3e-15 * np.hypot(*place)
    for angle in np.linspace(-np.pi, np.pi, 41):
        direction = np.array([np.cos(angle), np.sin(angle)])
        (most,) = ways.support(np.array([0]), direction[None])
        assert (true @ direction.astype(np.longdouble)).max() <= most
    (centre,), (radius,), (size,) = ways.discs
    assert np.hypot(*(true - centre).T).max() <= radius + 1e-12 * size


@pytest.mark.parametrize("seed", SEEDS)
def test_the_supports_are_hardly_more_than_the_closed_form(seed):
    ways, _, (place, bound, arc) = way_of(seed)
    length, middle = np.hypot(*place), np.arctan2(-place[1], -place[0]) + arc.centre[0]
    for angle in np.linspace(-np.pi, np.pi, 40):
        off = max(0.0, abs(wrap(angle - middle)) - arc.bound[0])
        (most,) = ways.support(np.array([0]), np.array([[np.cos(angle), np.sin(angle)]]))
        half = arc.bound[0] / 6
        assert (
            length * np.cos(off) + bound - 1e-9 <= most <= length * np.cos(off) + bound + length * (1 / np.cos(half) - 1) + 1e-9
        )


def test_sensors_at_one_place_have_one_spot():
    sensors = [Sensor("a", [1, 0]), Sensor("b", [1, 0], angle=2), Sensor("c", [0, 0], 0.1), Sensor("d", angle=1)]
    sensors += [Sensor("e", [1, 0], 0.1), Sensor("f", [1, 0], 0.1), Sensor("g", time_bound=0.1)]
    assert Team(1, sensors=sensors).mountings.spot.tolist() == [1, 1, 3, 0, 5, 6, 7, 0]


def sighted(seed):
    """Return a world, arms for arcs around the headings, and the ways from sensors to what they measured."""
    world = MountedWorld(np.random.default_rng(seed), robots=3, reach=0.2 + seed % 3)
    arcs = world.initial(0.0, (0.0, 0.01, 0.5)[seed // 3 % 3])[1]
    readings = Readings.of(0.0, world.measure(), mountings=world.team.mountings)
    names, pairs = ("robot", "target", "sensor", "target_sensor"), (readings.bearings, readings.ranges)
    robot, target, sensor, tag = (np.concatenate([getattr(each, name) for each in pairs]) for name in names)
    away = world.places_of(target, tag) - world.places_of(robot, sensor)
    return world, Arms.of(readings, arcs, 3), (robot, target, away)


@pytest.mark.parametrize("seed", range(9))
def test_rows_that_just_hold_of_sensors_hold_of_the_centres(seed):
    """In every direction, and with landmarks on the robot alone; where headings are known they just hold, too."""
    world, arms, (robot, target, away) = sighted(seed)
    bodies, few = np.vstack([world.positions, world.team.landmarks]), 0.0
    for angle in np.linspace(-np.pi, np.pi, 13):
        normal = np.tile([np.cos(angle), np.sin(angle)], (len(robot), 1))
        fixed = target >= 3
        rows = Constraints.between(robot, target, normal, (normal * away).sum(axis=1), np.arange(len(robot)))
        known = (normal * bodies[target]).sum(axis=1)[rows.source]
        alone = fixed[rows.source]
        offset, normal = np.where(alone, rows.offset - known, rows.offset), np.where(alone[:, None], -rows.normal, rows.normal)
        i, j = np.where(alone, -1, rows.i), np.where(alone, rows.i, rows.j)
        moved = arms.moved(centred := Constraints(i, j, normal, offset, rows.source), centred.source)
        start = np.where((moved.i < 0)[:, None], 0.0, world.positions[moved.i])
        slack = moved.offset - (moved.normal * (world.positions[moved.j] - start)).sum(axis=1)
        assert slack.min() > -1e-12
        few = max(few, slack.max())
    size = np.hypot(*world.places.T).max()
    assert few < 4 * world.bound + 4 * size * (0.0, 0.02, 1.0)[seed // 3 % 3] + 0.01 * size


@pytest.mark.parametrize("seed", range(9))
def test_the_ways_between_centres_are_others_by_no_more_than_is_said(seed):
    world, arms, (robot, target, away) = sighted(seed)
    bodies, which = np.vstack([world.positions, world.team.landmarks]), np.arange(len(robot))
    by, radius = arms.between(which)
    apart = bodies[target] - bodies[robot] - away
    assert (np.hypot(*(apart - by).T) <= radius + 1e-12).all()
    for k in which.tolist():
        for from_other, sign in ((False, -1.0), (True, 1.0)):
            corners = arms.seen(k, from_other)
            hull = Polygon.hull(
                np.concatenate([corners + 1e-9 * np.array(side) for side in ((1, 1), (-1, 1), (-1, -1), (1, -1))])
            )
            assert hull.contains(sign * apart[k])


def test_what_is_added_up_errs_outward():
    mountings = Team(3, sensors=[Sensor("a", [3.0, 1.0]), Sensor("b", [0.0, 0.0], 0.3), Sensor("c", [3.0, 0.0], 0.3)]).mountings
    record = Range(0.0, 0, 1, 5.0, 0.1, 0.0, [0, 1, 2, 1], [0, 1, 0, 0])
    readings = Readings.of(0.0, [record], mountings=mountings)
    arms = Arms.of(readings, AngularIntervals([0.5, 0.5], [0.0, 0.0]), 2)
    (_, own, size), (_, others, further) = arms.own.discs, arms.others.discs
    _, radius = arms.between(np.arange(4))
    assert (radius >= own + others + 0.9e-12 * (size + further)).all()
    for k, bound in enumerate(arms.own.slip + arms.others.slip):
        corners = arms.seen(k, False) + arms.between(np.array([k]))[0]
        for angle in np.arange(16) * np.pi / 8:
            assert (corners @ [np.cos(angle), np.sin(angle)]).max() >= bound * (1 + 1e-15)


def test_at_each_instant_the_heading_of_that_instant_counts():
    team = Team(2, turn_rate_limit=0.0, sensors=[Sensor("a", [1.0, 0.0])])
    turns = [Odometry(k, k + 1.0, [0, 1], 0, 0, [1.0, -0.5], 0, 0, 0) for k in range(2)]
    frames = [Frame(k + 1.0, turn, [Range(k + 1.0, 0, 1, 2.0, 0.1, 0.0, 0, 0)]) for k, turn in enumerate(turns)]
    since = Since.of(team, AngularIntervals([0.0, 0.0], [0.0, 0.0]), 0.0, frames)
    readings = Readings.of(2.0, [record for frame in frames for record in frame.measurements], since, team.mountings)
    arms = Look.of_compasses(since.headings, readings).arms
    for robot, ways in ((0, arms.own), (1, arms.others)):
        heading = np.array([1.0, 2.0]) * (1.0, -0.5)[robot]
        assert ways.discs[0] == pytest.approx(-np.stack([np.cos(heading), np.sin(heading)], axis=1))


def test_readings_of_sensors_are_turned_to_the_robots_forward_axis():
    mountings = Team(3, sensors=[Sensor("a", angle=0.4, angle_bound=0.1), Sensor("b", [1, 0], angle=-3.0)]).mountings
    records = [Compass(0.0, 0, 1.0, 0.2, 0), Bearing(0.0, 0, 1, [0.5, 0.5], 0.05, [0, -1]), Compass(0.0, 1, 1.0, 0.2, 1)]
    readings = Readings.of(0.0, records, mountings=mountings)
    assert readings.compasses.heading.tolist() == pytest.approx([0.6, 4.0])
    assert readings.compasses.bound.tolist() == pytest.approx([0.3, 0.2])
    assert readings.bearings.bearing.tolist() == pytest.approx([0.5, 0.9])
    assert readings.bearings.bound.tolist() == pytest.approx([0.05, 0.15])
    assert readings.mountings is None
    assert Arms.of(readings, AngularIntervals.circles(2), 2) is None


@pytest.mark.parametrize(("sensor", "tag", "same"), [(1, 2, True), (2, 1, False), (1, -1, False), (-1, 2, False)])
def test_a_bearing_tells_the_direction_of_a_range_between_the_same_places(sensor, tag, same):
    """From either: the bearing is the other one's here, from its sensor 2 to the first one's sensor 1."""
    mountings = Team(3, sensors=[Sensor("a"), Sensor("b", [1, 0]), Sensor("c", [2, 0])]).mountings
    records = [Bearing(0.0, 1, 0, 0.0, 0.1, 2, 1), Range(0.0, 0, 1, 5.0, 0.1, 0.0, sensor, tag)]
    readings = Readings.of(0.0, records, mountings=mountings)
    ways = AngularIntervals(0.3, 0.1)
    arcs = narrowed_by_bearings(AngularIntervals.circles(1), ways, readings, 2)
    assert bool(arcs.full[0]) is not same
    assert not same or arcs.centre[0] == pytest.approx(wrap(0.3 + np.pi))
