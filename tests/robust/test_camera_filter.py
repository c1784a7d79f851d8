"""The estimate of a camera's offset and delay stays a distribution, and judges a camera only by what it knows."""

from dataclasses import replace

import numpy as np
import pytest

from filter import Bearing, Odometry, Range
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.robust.belief import Late, Turned
from filter.robust.cameras import Alignment, Offsets
from filter.robust.robust_filter import RobustFilter
from filter.team import Team


def judged(column, value, deviation, was):
    """Return what is known of one camera that was suspected, or not, to be turned (3) or late (4); bearings are within 0.1."""
    covariance = np.zeros((1, 5, 5))
    covariance[0, column, column] = deviation**2
    mean, running = np.eye(5)[None, column] * value, np.array([True])
    before = replace(Offsets.none(1, 0.0), mean=mean, covariance=covariance, running=running, allowed=np.array([0.1]))
    suspected = was & (np.arange(3, 5)[None] == column)
    return replace(before, suspected=suspected).judged(10.0, Alignment())


@pytest.mark.parametrize(("column", "bound", "name"), [(3, 0.1, "turned"), (4, 0.2, "late")])
def test_a_suspicion_lasts_until_the_estimate_is_good_for_sure(column, bound, name):
    assert getattr(judged(column, 0.95 * bound, 0.2 * bound, True), name)
    assert not getattr(judged(column, 0.75 * bound, 0.2 * bound, True), name)
    assert not getattr(judged(column, 0.95 * bound, 0.2 * bound, False), name)


@pytest.mark.parametrize("turns", [-2, -1, 1, 2])
def test_a_camera_that_is_off_by_full_turns_is_not_turned(turns):
    offsets = judged(3, turns * 2 * np.pi + 0.01, 0.01, True)
    assert not offsets.turned
    assert offsets.mean[:, 3] == pytest.approx(0.01)


@pytest.mark.parametrize("suspected", [[True, False], [False, True]])
def test_an_estimate_that_begins_says_nothing_of_a_camera_yet(suspected):
    robust = RobustFilter(Team(1, [[4.0, 0.0]]))
    belief = robust.start(0.0, [Polygon.box([-0.1, -0.1], [0.1, 0.1])], AngularIntervals([0.0], [0.05]))
    said = {"suspected": np.array([suspected]), "allowed": np.array([0.25])}
    belief = robust.update(replace(belief, time=100.0, offsets=replace(belief.offsets, **said)), [])
    assert belief.offsets.running.all()
    assert belief.offsets.suspected.tolist() == [suspected]
    assert not any(isinstance(event, Turned | Late) for event in belief.events)
    assert belief.offsets.good_until.max() == 0


def test_sightings_without_any_error_make_no_trouble():
    robust = RobustFilter(Team(1, [[0.0, 0.0]]))
    belief = robust.start(0.0, [Polygon.box([0, 0], [0, 0])], AngularIntervals([0.0], [0.0]))
    for _ in range(3):
        belief = robust.update(belief, [Bearing(0.0, 0, 1, 0.0, 0.05), Range(0.0, 0, 1, 0.0, 0.0, 0.0)])
        assert belief.regions[0].outer.contains([0.0, 0.0])


@pytest.mark.parametrize(("slip", "bound"), [(10.0, 1e-3), (1e3, 1e-6), (1e5, 1e-9)])
@pytest.mark.parametrize("seed", range(4))
def test_an_estimate_stays_a_distribution_whatever_the_bounds(seed, slip, bound):
    marks = np.random.default_rng(seed).uniform(-50, 50, (4, 2))
    robust = RobustFilter(Team(1, marks))
    belief = robust.start(0.0, [Polygon.box([-1, -1], [1, 1])], AngularIntervals([0.0], [0.1]))
    bearing, distance = np.arctan2(*marks.T[::-1]), np.hypot(*marks.T)
    for k in range(1, 40):
        belief = robust.predict(belief, 0.1 * k, Odometry(belief.time, 0.1 * k, 0, 0.0, 0.0, 0.0, 0.01, 0.0, slip))
        records = [
            Bearing(0.1 * k, [0] * 4, [1, 2, 3, 4], bearing, bound),
            Range(0.1 * k, [0] * 4, [1, 2, 3, 4], distance, bound, 0),
        ]
        belief = robust.update(belief, records)
        assert (np.linalg.eigvalsh(belief.offsets.covariance) >= -1e-12).all()
        assert belief.regions[0].outer.contains([0.0, 0.0])
