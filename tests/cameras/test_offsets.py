"""The estimate of a camera's offset and delay: it finds what is wrong, suspects nobody else, and stays a distribution."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.camera_worlds import GUILTY, later, turned, world_of

from filter import AngularIntervals, Bearing, Odometry, Range, Team, wrap
from filter.cameras.alignment import Alignment
from filter.cameras.offsets import Offsets
from filter.cameras.sightings import Sightings

RULES = Alignment()


def known_of(offsets, world):
    """Return the estimates, begun with what is known roughly of the poses where there are none, and judged."""
    arcs = AngularIntervals(world.headings, np.full(world.robots, 0.2))
    return offsets.checked(world.positions - 0.5, world.positions + 0.5, arcs, RULES).judged(world.time, RULES)


def stepped(offsets, world, odometry, records):
    """Return the estimates after one step."""
    gone = offsets.moved(odometry, world.team, odometry.time - odometry.start, RULES)
    return known_of(gone.seen(Sightings.of(records, world.robots), world.team.landmarks, RULES), world)


def touring(world, count, by=0.0, during=(0, np.inf), bumped=None):
    """Yield the estimates at each of many steps; one camera is turned by so much for a while, or its robot [rad]."""
    offsets = known_of(Offsets.none(world.robots, 0.0), world)
    for step in range(count):
        odometry = world.tour(0.4)
        if step == bumped:
            world.headings = world.headings + by * (np.arange(world.robots) == GUILTY)
        is_turned = bumped is None and during[0] <= step < during[1]
        records = world.measure(compasses=False)
        offsets = stepped(offsets, world, odometry, turned(records, by) if is_turned else records)
        yield offsets


def late_touring(world, count, during):
    """Yield the estimates at each of many steps; one camera is late by 0.6 s for a while. Turns last 2 s."""
    step, steps, seen, offsets = 0.2, 3, [], known_of(Offsets.none(world.robots, 0.0), world)
    for k in range(count):
        if k % 10 == 0:
            away = world.size / 2 - world.positions
            home = np.clip(wrap(np.arctan2(away[:, 1], away[:, 0]) - world.headings) / 2, -0.6, 0.6)
            rate = np.where(np.hypot(*away.T) > world.size / 2, home, world.rng.uniform(-0.6, 0.6, world.robots))
        odometry = world.drive(np.full(world.robots, 0.15 * step), step * rate, step)
        seen.append(world.measure(compasses=False))
        is_late = during[0] + steps <= k < during[1]
        records = later(seen[-1], seen[-1 - steps], world.time) if is_late else seen[-1]
        offsets = stepped(offsets, world, odometry, records)
        yield offsets


@pytest.mark.parametrize(("begins", "by", "seed"), [(0, -0.35, 0), (0, 0.35, 1), (60, 0.35, 0), (60, -0.35, 1)])
def test_a_turned_camera_is_suspected_and_no_other(begins, by, seed):
    every = list(touring(world_of(seed), begins + 100, by, (begins, np.inf)))
    first = next(k for k, offsets in enumerate(every) if offsets.turned[GUILTY])
    assert begins < first < begins + 50
    assert every[first].good_until[GUILTY, 0] <= 0.4 * begins
    assert not any(offsets.suspected[np.arange(3) != GUILTY].any() or offsets.late.any() for offsets in every)
    assert not any(offsets.vouched[GUILTY] for offsets in every[first:])
    assert every[-1].mean[GUILTY, 3] == pytest.approx(by, abs=0.1)


@pytest.mark.parametrize(("share", "errors"), [(-0.5, "uniform"), (0.0, "extreme"), (0.5, "uniform")])
def test_good_cameras_are_never_suspected_and_are_vouched_for_in_time(share, errors):
    world = world_of(5, errors=errors)
    every = list(touring(world, 150, share * world.bearing))
    assert not any(offsets.suspected.any() for offsets in every)
    assert every[-1].vouched.all()


@pytest.mark.parametrize(("by", "seed"), [(-0.35, 0), (0.35, 1)])
def test_a_robot_that_is_bumped_has_a_good_camera(seed, by):
    """All landmarks are seen aside then, too; only how it drives on tells that it is the robot that was turned."""
    assert not any(offsets.suspected.any() for offsets in touring(world_of(seed), 150, by, bumped=60))


def test_a_camera_that_is_set_right_is_trusted_again():
    every = list(touring(world_of(3), 500, np.radians(20), (30, 150)))
    suspected = np.array([offsets.turned[GUILTY] for offsets in every])
    assert np.diff(suspected.astype(int)).nonzero()[0].shape == (2,)
    assert not suspected[-1]


@pytest.mark.parametrize(("begins", "seed"), [(0, 0), (100, 1)])
def test_a_late_camera_is_suspected_and_no_other(seed, begins):
    every = list(late_touring(world_of(seed), begins + 300, (begins, np.inf)))
    first = next(k for k, offsets in enumerate(every) if offsets.late[GUILTY])
    assert begins < first
    assert 0 <= every[first].good_until[GUILTY, 1] <= 0.2 * begins
    assert 0.2 < every[first].mean[GUILTY, 4] < 0.9  # it is told once it is sure that it is not 0.2 s or less
    assert every[-1].mean[GUILTY, 4] == pytest.approx(0.6, abs=0.2)
    assert not any(offsets.suspected[np.arange(3) != GUILTY].any() for offsets in every)


def test_a_camera_whose_clock_is_set_right_is_trusted_again():
    late = [offsets.late[GUILTY] for offsets in late_touring(world_of(3), 800, (0, 250))]
    assert any(late)
    assert not late[-1]


def test_a_camera_that_is_on_time_is_never_late():
    *_, last = every = list(late_touring(world_of(0, errors="extreme"), 400, (np.inf, np.inf)))
    assert not any(offsets.suspected.any() for offsets in every)
    assert np.abs(last.mean[:, 4]).max() < 0.1


def judged(column, value, deviation, was):
    """Return what is known of one camera that was suspected, or not, to be turned (3) or late (4); bearings are within 0.1."""
    covariance = np.zeros((1, 5, 5))
    covariance[0, column, column] = deviation**2
    mean, running = np.eye(5)[None, column] * value, np.array([True])
    before = replace(Offsets.none(1, 0.0), mean=mean, covariance=covariance, running=running, allowed=np.array([0.1]))
    suspected = was & (np.arange(3, 5)[None] == column)
    return replace(before, suspected=suspected).judged(10.0, RULES)


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


@pytest.mark.parametrize(("slip", "bound"), [(10.0, 1e-3), (1e5, 1e-9)])
@pytest.mark.parametrize("seed", range(2))
def test_an_estimate_stays_a_distribution_whatever_the_bounds(seed, slip, bound):
    marks = np.random.default_rng(seed).uniform(-50, 50, (4, 2))
    bearing, distance, team = np.arctan2(*marks.T[::-1]), np.hypot(*marks.T), Team(1, marks)
    arcs, corner = AngularIntervals([0.0], [0.1]), np.ones((1, 2))
    offsets = Offsets.none(1, 0.0).checked(-corner, corner, arcs, RULES)
    for k in range(1, 40):
        gone = offsets.moved(Odometry(0.1 * k - 0.1, 0.1 * k, 0, 0.0, 0.0, 0.0, 0.01, 0.0, slip), team, 0.1, RULES)
        records = [Bearing(0.1 * k, 0, [1, 2, 3, 4], bearing, bound), Range(0.1 * k, 0, [1, 2, 3, 4], distance, bound, 0)]
        offsets = gone.seen(Sightings.of(records, 1), marks, RULES).checked(-corner, corner, arcs, RULES)
        assert (np.linalg.eigvalsh(offsets.covariance) >= -1e-12).all()
        assert np.isfinite(offsets.judged(0.1 * k, RULES).mean).all()


def test_where_little_is_known_there_is_no_estimate():
    whole, arcs, corner = (
        AngularIntervals.circles(2),
        AngularIntervals([0.0, 0.0], [0.1, 0.1]),
        np.array([[1.0, 1.0], [3.0, 1.0]]),
    )
    assert not Offsets.none(2, 0.0).checked(-corner, corner, whole, RULES).running.any()
    begun = Offsets.none(2, 0.0).checked(-corner, corner, arcs, RULES)
    assert begun.running.tolist() == [True, False]
    assert not begun.without(0).running.any()
