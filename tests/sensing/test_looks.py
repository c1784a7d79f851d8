"""A bearing tells the direction of a range between the same two, whoever of them saw the other."""

import numpy as np
import pytest

from filter import AngularIntervals, Bearing, Range, Sensor, Team
from filter.geometry.angles import wrap
from filter.sensing.looks import narrowed_by_bearings
from filter.sensing.readings import Readings

BODIES = 5  # of which the last two are landmarks
MOUNTINGS = Team(3, sensors=[Sensor("ahead", [0.3, 0.0]), Sensor("turned", angle=0.5)]).mountings


def pairs(rng, count):
    robot = rng.integers(0, 3, count)
    target = (robot + rng.integers(1, BODIES, count)) % BODIES
    return robot, target


def readings_of(rng, mounted):
    """Return bearings and ranges of random pairs, by sensors here and there if need be."""
    both = []
    for kind, values in ((Bearing, (rng.random(12), 0.1)), (Range, (rng.random(12), 0.1, 0.0))):
        robot, target = pairs(rng, 12)
        sensor, tag = (rng.integers(-1, 2, 12) if mounted else np.full(12, -1) for _ in range(2))
        both.append(kind(0.0, robot, target, *values, sensor=sensor, target_sensor=np.where(target < 3, tag, -1)))
    return Readings.of(0.0, both, mountings=MOUNTINGS if mounted else None)


def arcs(rng, count):
    return AngularIntervals(rng.uniform(-np.pi, np.pi, count), rng.uniform(0.5, 1.5, count))


def place_of(sensor):
    """Return where a sensor is: the turned one is at the centre."""
    return 0 if sensor == 0 else -1


def ends(record, k):
    """Return between which places the k-th reading is, in an order of its own, and whether that is turned round."""
    one = record.robot[k].item(), place_of(record.sensor[k])
    other = record.target[k].item(), place_of(record.target_sensor[k])
    return (one, other) if one < other else (other, one), one > other


@pytest.mark.parametrize("mounted", [False, True])
@pytest.mark.parametrize("seed", range(12))
def test_it_is_what_each_bearing_between_the_same_places_leaves(seed, mounted):
    rng = np.random.default_rng(seed)
    readings = readings_of(rng, mounted)
    ways, spans = arcs(rng, 12), arcs(rng, 12)
    found = narrowed_by_bearings(spans, ways, readings, BODIES)
    shared = 0
    for k in range(12):
        between, back = ends(readings.ranges, k)
        whole = np.linspace(-np.pi, np.pi, 721)
        left = np.abs(wrap(whole - spans.centre[k])) <= spans.bound[k]
        for b in range(12):
            if ends(readings.bearings, b)[0] == between:
                shared += 1
                turn = 0.0 if ends(readings.bearings, b)[1] == back else np.pi
                left &= np.abs(wrap(whole - ways.centre[b] - turn)) <= ways.bound[b]
        inside = np.abs(wrap(whole - found.centre[k])) <= found.bound[k] + 1e-9
        assert inside[left].all()  # what two arcs share may be two pieces, of which one arc is around
        if not any(ends(readings.bearings, b)[0] == between for b in range(12)):
            assert (found.centre[k], found.bound[k]) == pytest.approx((spans.centre[k], spans.bound[k]))
        elif left.any():
            assert found.bound[k] <= spans.bound[k] + 1e-9
    assert shared > (0 if mounted else 5)


def test_without_bearings_nothing_is_known():
    spans = arcs(np.random.default_rng(0), 1)
    assert (
        narrowed_by_bearings(spans, arcs(np.random.default_rng(1), 0), Readings.of(0.0, [Range(0.0, 0, 3, 1, 0, 0)]), 5)
        is spans
    )
