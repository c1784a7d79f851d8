"""A camera that is turned is suspected, and no other; its robot stays where it is claimed to be, with any heading."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.robust_worlds import GUILTY, inside, started, turned_in, world_of

from filter import Bearing, Compass, Odometry, Range
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.robust.belief import Late, Restarted, Turned
from filter.robust.cameras import Alignment
from filter.robust.robust_filter import RobustFilter
from filter.team import Team


def touring(world, count, by=0.0, during=(0, np.inf), known="position"):
    """Yield the belief at each of many steps, with the truth at each: one camera is turned by so much for a while [rad]."""
    robust = RobustFilter(world.team)
    belief = started(robust, world, known)
    for step in range(count):
        belief = robust.predict(belief, world.time + 0.4, world.tour(0.4))
        records = world.measure(compasses=False)
        belief = robust.update(belief, turned(records, by) if during[0] <= step < during[1] else records)
        yield belief


def turned(records, by):
    return [replace(r, bearing=r.bearing + by * (r.robot == GUILTY)) if isinstance(r, Bearing) else r for r in records]


@pytest.mark.parametrize("begins", [0, 60])
@pytest.mark.parametrize("by", np.radians([-20, 20]))
@pytest.mark.parametrize("seed", range(2))
def test_a_turned_camera_is_suspected_and_the_others_keep_their_guarantee(seed, by, begins):
    world, beliefs = world_of(seed), []
    others = np.arange(3) != GUILTY
    for belief in touring(world, begins + 100, by, (begins, np.inf)):
        beliefs.append(belief)
        places, headings = inside(belief, world)
        assert (places & headings)[others].all()
        if belief.offsets.turned[GUILTY] and not belief.events:
            assert places.all()
            assert headings.all()
    (event,) = turned_in(beliefs)
    assert (event.robot, event.aside) == (GUILTY, True)
    assert event.since <= 0.4 * begins < event.time < 0.4 * begins + 20
    assert np.sign(event.offset) == np.sign(by)
    assert "camera of robot 1 suspected to be turned" in str(event)
    assert "no proof" in str(event)
    assert beliefs[-1].headings.bound[GUILTY] == np.pi
    assert beliefs[-1].regions[GUILTY].outer.area < 1.0


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("seed", range(2))
def test_good_cameras_are_never_suspected(seed, errors):
    world = world_of(seed, errors=errors)
    for belief in touring(world, 250):
        assert belief.events == ()
        assert not belief.offsets.suspected.any()


@pytest.mark.parametrize("share", [-0.5, 0.5])
def test_a_camera_off_by_half_its_bound_is_a_good_one(share):
    world = world_of(5)
    for belief in touring(world, 250, share * world.bearing):
        assert turned_in([belief]) == []


def test_a_robot_of_a_suspected_camera_starts_over_and_says_since_when_it_is_doubtful():
    world = world_of(2)
    beliefs = list(touring(world, 100, np.radians(20), (40, np.inf)))
    (belief,) = [each for each in beliefs if turned_in([each])]
    (restart,) = [event for event in belief.events if isinstance(event, Restarted)]
    assert (restart.robot, restart.because) == (GUILTY, "its camera is suspected to be turned")
    assert restart.suspended_since <= 16.0
    assert belief.guarantee.in_force[GUILTY]


def test_a_camera_that_is_set_right_is_trusted_again():
    world = world_of(3)
    beliefs = list(touring(world, 500, np.radians(20), (30, 150)))
    assert [(event.robot, event.aside) for event in turned_in(beliefs)] == [(GUILTY, True), (GUILTY, False)]
    assert "trusted again" in str(turned_in(beliefs)[1])
    assert beliefs[-1].headings.bound[GUILTY] < 0.3


@pytest.mark.parametrize("by", np.radians([-9, 6]))
@pytest.mark.parametrize("seed", range(2))
def test_a_robot_whose_camera_is_trusted_again_starts_over_and_is_inside_from_then_on(seed, by):
    """Its slices were those of the camera's heading, which has changed since."""
    world, trusted = world_of(seed), False
    for step, belief in enumerate(touring(world, 240, by, (30, 150))):
        if any(not event.aside for event in turned_in([belief])) and step >= 150:
            (restart,) = [event for event in belief.events if isinstance(event, Restarted) and event.robot == GUILTY]
            assert restart.because == "its camera is trusted again"
            trusted = True
        places, headings = inside(belief, world)
        assert not trusted or (places & headings).all()


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize(("duration", "speed", "rate"), [(2.0, 0.4, 1.0), (5.0, 0.4, 0.6)])
def test_robots_that_turn_much_between_pictures_have_good_cameras(duration, speed, rate, errors):
    """A chord is shorter than its path: by a third after half a turn."""
    world = world_of(0, errors=errors)
    robust = RobustFilter(world.team)
    belief = started(robust, world)
    for _ in range(60):
        away = world.size / 2 - world.positions
        home = np.clip(wrap(np.arctan2(away[:, 1], away[:, 0]) - world.headings), -rate * duration, rate * duration)
        turn = np.where(np.hypot(*away.T) > world.size / 2, home, world.rng.uniform(-rate, rate, 3) * duration)
        belief = robust.predict(belief, world.time + duration, world.drive(np.full(3, speed * duration), turn, duration))
        belief = robust.update(belief, world.measure(compasses=False))
        assert turned_in([belief]) == []


@pytest.mark.parametrize("by", np.radians([-20, 20]))
def test_a_robot_that_is_bumped_has_a_good_camera(by):
    """All landmarks are seen aside then, too; only how it drives on tells that it is the robot that was turned."""
    for seed in range(2):
        world = world_of(seed)
        for step, belief in enumerate(touring(world, 200)):
            world.headings = world.headings + by * (step == 60) * (np.arange(3) == GUILTY)
            assert turned_in([belief]) == []


def test_the_estimate_begins_where_little_is_known_and_finds_the_offset():
    world = world_of(4)
    beliefs = list(touring(world, 150, np.radians(8), known="arena"))
    offset, deviation = beliefs[-1].offsets.mean[:, 3], beliefs[-1].offsets.deviations[:, 0]
    assert beliefs[-1].offsets.running.all()
    assert (np.abs(offset - np.radians(8) * (np.arange(3) == GUILTY)) < 3 * deviation).all()
    assert (deviation < np.radians(3)).all()


def test_without_bearings_nothing_is_suspected():
    world = world_of(6)
    robust = RobustFilter(world.team)
    belief = started(robust, world, "pose")
    for _ in range(20):
        belief = robust.predict(belief, world.time + 0.4, world.tour(0.4))
        belief = robust.update(belief, [r for r in world.measure(compasses=False) if not isinstance(r, Bearing)])
        assert not belief.offsets.suspected.any()
        assert np.isfinite(belief.offsets.mean).all()


@pytest.mark.parametrize("wrong", [{"share": 1.5}, {"deviations": 0.0}, {"wander": -1.0}, {"prior": np.nan}])
def test_an_alignment_out_of_range_is_refused(wrong):
    with pytest.raises(InvalidInput):
        Alignment(**wrong)


@pytest.mark.parametrize("compass", [False, True])
def test_a_compass_does_no_harm_while_a_camera_is_suspected(compass):
    """The slices are then of the camera's heading; the robot stands in the middle and its camera is off by 0.4."""
    marks, off = np.array([[4.0, 0.0], [0.0, 4.0], [-4.0, 0.0], [0.0, -4.0]]), 0.4
    robust = RobustFilter(Team(1, marks, arena=np.array([[-5.0, -5.0], [5.0, 5.0]])))
    belief = robust.start(0.0, [Polygon.box([-5, -5], [5, 5])])
    mean, covariance = belief.offsets.mean.copy(), belief.offsets.covariance.copy()
    mean[0, 3], covariance[0] = off, np.diag([0.01, 0.01, 0.001, 0.001, 0.001])
    said = {"running": np.array([True]), "suspected": np.array([[True, False]]), "allowed": np.array([0.1])}
    belief = replace(belief, offsets=replace(belief.offsets, mean=mean, covariance=covariance, **said))
    for k in range(1, 60):
        time = 0.2 * k
        belief = robust.predict(belief, time, Odometry(belief.time, time, 0, 0.0, 0.001, 0.0, 0.01, 0.01, 0.001))
        records = [Bearing(time, 0, 1, off, 0.1), Range(time, 0, 1, 4.0, 0.1, 0.0)]
        belief = robust.update(belief, [*records, *([Compass(time, 0, 0.0, 0.05)] if compass else [])])
        assert belief.regions[0].outer.contains([0.0, 0.0])
    assert belief.offsets.turned[0]


@pytest.mark.parametrize(("column", "value"), [(0, 0.5), (1, 0.8)])
def test_the_guarantee_was_doubtful_since_the_camera_last_looked_good(column, value):
    robust = RobustFilter(Team(1, [[4.0, 0.0]]))
    belief = robust.start(0.0, [Polygon.box([-0.1, -0.1], [0.1, 0.1])], AngularIntervals([0.0], [0.05]))
    mean, covariance, bad_since = np.zeros((1, 5)), np.diag([0.01, 0.01, 0.001, 1e-6, 1e-6])[None], np.full((1, 2), np.inf)
    mean[0, 3 + column], bad_since[0, column] = value, 0.0
    said = {"mean": mean, "covariance": covariance, "running": np.array([True]), "allowed": np.array([0.1])}
    offsets = replace(belief.offsets, **said, bad_since=bad_since, good_until=np.array([[1.0, 2.0]]))
    found, restart = robust.update(replace(belief, time=10.0, offsets=offsets), []).events
    assert isinstance(found, (Turned, Late)[column])
    assert found.since == restart.suspended_since == [1.0, 2.0][column]
