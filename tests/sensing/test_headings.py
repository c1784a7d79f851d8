"""Headings narrowed by compasses and bearings, the same in any order; who disagrees is named."""

import numpy as np
import pytest
from helpers.worlds import World, of_robot

from filter import AngularIntervals, Bearing, Compass, Range, Sensor, Source, Team
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent
from filter.sensing.headings import narrowed_headings
from filter.sensing.readings import Readings
from filter.sensing.rows import spans_of_targets


def begun(seed, errors="uniform"):
    world = World(np.random.default_rng(seed), robots=4, landmarks=2, errors=errors)
    belief = SetMembershipFilter(world.team).start(0.0, world.initial_sets(), world.initial_headings(1.0))
    return world, belief


def narrowed(world, belief, records):
    readings = Readings.of(belief.time, records)
    bearings = readings.bearings
    spans = spans_of_targets(belief.polytope, world.team.landmarks, bearings.robot, bearings.target)
    return narrowed_headings(belief.headings, readings, spans)


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("seed", range(8))
def test_the_true_heading_stays_and_nothing_grows(seed, errors):
    world, belief = begun(seed, errors)
    found = narrowed(world, belief, world.measure())
    assert found.contains(world.headings).all()
    assert (found.bound <= belief.headings.bound + 1e-12).all()
    assert (found.bound <= world.compass + 1e-9).all()


@pytest.mark.parametrize("seed", range(4))
def test_the_order_of_records_makes_no_difference(seed):
    world, belief = begun(seed)
    records = world.measure()
    one, other = (narrowed(world, belief, some) for some in (records, records[::-1]))
    assert (one.centre.tolist(), one.bound.tolist()) == (other.centre.tolist(), other.bound.tolist())


def test_ranges_alone_say_nothing_of_headings():
    world, belief = begun(0)
    ranges = [record for record in world.measure() if isinstance(record, Range)]
    assert narrowed(world, belief, ranges).bound.tolist() == belief.headings.bound.tolist()


def test_a_bearing_to_a_known_place_tells_the_heading():
    world, belief = begun(1)
    robot, mark = 0, world.team.landmarks[0]
    offset = mark - world.positions[robot]
    bearing = np.arctan2(offset[1], offset[0]) - world.headings[robot]
    found = narrowed(world, belief, [Bearing(0.0, robot, 4, bearing, 0.01)])
    corners = mark - of_robot(belief.polytope, robot)[0].vertices
    angles = np.unwrap(np.sort(np.arctan2(corners[:, 1], corners[:, 0])))
    if np.ptp(angles) < 1:  # seen from all of the start's box within this angle
        assert found.bound[robot] <= np.ptp(angles) / 2 + 0.01 + 1e-6


def test_readings_that_exclude_one_another_are_named():
    world, belief = begun(2)
    first, second = Compass(0.0, [1], world.headings[1] + 0.1, 0.05), Compass(0.0, [1], world.headings[1] - 0.1, 0.06)
    with pytest.raises(Inconsistent) as caught:
        narrowed(world, belief, [first, second])
    assert [(source.kind, source.robot) for source in caught.value.sources] == [("compass", 1), ("compass", 1)]


def test_arcs_that_exclude_one_another_name_their_sensors():
    team = Team(1, [[1.0, 0.0]], sensors=[Sensor("needle"), Sensor("camera")])
    records = [Compass(0.0, 0, 2.0, 0.1, 0), Bearing(0.0, 0, 1, 0.0, 0.05, 1)]
    with pytest.raises(Inconsistent) as caught:
        narrowed_headings(
            AngularIntervals.circles(1), Readings.of(0.0, records, None, team.mountings), AngularIntervals(0.0, 0.1)
        )
    assert set(caught.value.sources) == {Source("compass", 0.0, 0, None, 0), Source("bearing", 0.0, 0, 1, 1)}
