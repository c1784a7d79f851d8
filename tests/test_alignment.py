"""A camera that is turned is suspected, and no other; its robot stays where it is claimed to be, with any heading."""

from dataclasses import replace

import numpy as np
import pytest
from test_robust import started, world_of

from filter.alignment import Alignment, Offsets
from filter.angles import wrap
from filter.errors import InvalidInput
from filter.estimating import Estimating
from filter.measurements import Bearing, Compass, Odometry, Range
from filter.polygon import Polygon
from filter.robust import RobustFilter
from filter.robust_belief import Late, Restarted, Turned
from filter.team import Team
from filter.voting import Rules

GUILTY = 1


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


def inside(belief, world):
    """Return (n,) whether positions, and whether headings, are inside."""
    outers = [region.outer for region in belief.regions]
    places = np.array([bool(outer.contains(place)) for outer, place in zip(outers, world.positions, strict=True)])
    return places, belief.headings.contains(world.headings)


def named(beliefs):
    return [event for belief in beliefs for event in belief.events if isinstance(event, Turned)]


@pytest.mark.parametrize("begins", [0, 60])
@pytest.mark.parametrize("by", np.radians([-20, 20]))
@pytest.mark.parametrize("seed", range(4))
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
    (event,) = named(beliefs)
    assert (event.robot, event.aside) == (GUILTY, True)
    assert event.since <= 0.4 * begins < event.time < 0.4 * begins + 20
    assert np.sign(event.offset) == np.sign(by)
    assert "camera of robot 1 suspected to be turned" in str(event)
    assert "no proof" in str(event)
    assert beliefs[-1].headings.bound[GUILTY] == np.pi
    assert beliefs[-1].regions[GUILTY].outer.area < 1.0


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("seed", range(4))
def test_good_cameras_are_never_suspected(seed, errors):
    world = world_of(seed, errors=errors)
    for belief in touring(world, 250):
        assert belief.events == ()
        assert not belief.offsets.suspected.any()


@pytest.mark.parametrize("share", [-0.5, 0.5])
def test_a_camera_off_by_half_its_bound_is_a_good_one(share):
    world = world_of(5)
    for belief in touring(world, 250, share * world.bearing):
        assert named([belief]) == []


def test_a_robot_of_a_suspected_camera_starts_over_and_says_since_when_it_is_doubtful():
    world = world_of(2)
    beliefs = list(touring(world, 100, np.radians(20), (40, np.inf)))
    (belief,) = [each for each in beliefs if named([each])]
    (restart,) = [event for event in belief.events if isinstance(event, Restarted)]
    assert (restart.robot, restart.because) == (GUILTY, "its camera is suspected to be turned")
    assert restart.doubtful_since <= 16.0
    assert belief.suspended[GUILTY] == belief.time
    assert belief.in_force[GUILTY]


def test_a_camera_that_is_set_right_is_trusted_again():
    world = world_of(3)
    beliefs = list(touring(world, 500, np.radians(20), (30, 150)))
    assert [(event.robot, event.aside) for event in named(beliefs)] == [(GUILTY, True), (GUILTY, False)]
    assert "trusted again" in str(named(beliefs)[1])
    places, headings = inside(beliefs[-1], world)
    assert (places & headings).all()
    assert beliefs[-1].headings.bound[GUILTY] < 0.3


@pytest.mark.parametrize("by", np.radians([-20, 20]))
def test_a_robot_that_is_bumped_has_a_good_camera(by):
    """All landmarks are seen aside then, too; only how it drives on tells that it is the robot that was turned."""
    for seed in range(3):
        world = world_of(seed)
        for step, belief in enumerate(touring(world, 200)):
            world.headings = world.headings + by * (step == 60) * (np.arange(3) == GUILTY)
            assert named([belief]) == []


def test_the_estimate_begins_where_little_is_known_and_finds_the_offset():
    world = world_of(4)
    beliefs = list(touring(world, 150, np.radians(8), known="arena"))
    offset, deviation = beliefs[-1].offsets.offset, beliefs[-1].offsets.deviations[:, 0]
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


def judged(column, value, deviation, was):
    """Return what is known of one camera that was suspected, or not, to be turned (3) or late (4); bearings are within 0.1."""
    covariance = np.zeros((1, 5, 5))
    covariance[0, column, column] = deviation**2
    mean, running = np.eye(5)[None, column] * value, np.array([True])
    before = replace(Offsets.none(1, 0.0), mean=mean, covariance=covariance, running=running, allowed=np.array([0.1]))
    suspected = was & (np.arange(3, 5)[None] == column)
    estimating = Estimating(replace(before, suspected=suspected), Alignment())
    estimating.judge(10.0)
    return estimating.offsets


@pytest.mark.parametrize(("column", "bound", "name"), [(3, 0.1, "turned"), (4, 0.2, "late")])
def test_a_suspicion_lasts_until_the_estimate_is_good_for_sure(column, bound, name):
    assert getattr(judged(column, 0.95 * bound, 0.2 * bound, True), name)
    assert not getattr(judged(column, 0.75 * bound, 0.2 * bound, True), name)
    assert not getattr(judged(column, 0.95 * bound, 0.2 * bound, False), name)


@pytest.mark.parametrize("turns", [-2, -1, 1, 2])
def test_a_camera_that_is_off_by_full_turns_is_not_turned(turns):
    offsets = judged(3, turns * 2 * np.pi + 0.01, 0.01, True)
    assert not offsets.turned
    assert offsets.offset == pytest.approx(0.01)


def later(records, before, time):
    """Return records with those of one robot's camera as they were some steps before, with the time of now."""
    others, own = ([r for r in each if isinstance(r, Bearing | Range)] for each in (records, before))
    chosen = [(r, r.robot != GUILTY) for r in others] + [(r, r.robot == GUILTY) for r in own]
    return [part(r, mask, time) for r, mask in chosen]


def part(record, mask, time):
    columns = {name: column[mask] for name, column in vars(record).items() if isinstance(column, np.ndarray)}
    return replace(record, **columns, time=time)


def late_touring(world, count, during, step=0.2, steps=3):
    """Yield the belief at each of many steps; one camera's clock is late by some of them for a while. Turns last 2 s."""
    robust, seen, path = RobustFilter(world.team), [], np.full(3, 0.15 * step)
    belief = started(robust, world, "pose")
    for k in range(count):
        if k % 10 == 0:
            away = world.size / 2 - world.positions
            home = np.clip(wrap(np.arctan2(away[:, 1], away[:, 0]) - world.headings) / 2, -0.6, 0.6)
            rate = np.where(np.hypot(*away.T) > world.size / 2, home, world.rng.uniform(-0.6, 0.6, 3))
        belief = robust.predict(belief, world.time + step, world.drive(path, step * rate, step))
        seen.append(world.measure(compasses=False))
        wrong = during[0] + steps <= k < during[1]
        belief = robust.update(belief, later(seen[-1], seen[-1 - steps], world.time) if wrong else seen[-1])
        yield belief


def told(beliefs):
    return [event for belief in beliefs for event in belief.events if isinstance(event, Late)]


@pytest.mark.parametrize("begins", [0, 100])
@pytest.mark.parametrize("seed", range(4))
def test_a_late_camera_is_suspected_and_from_then_on_does_no_harm(seed, begins):
    world, beliefs = world_of(seed), []
    for belief in late_touring(world, begins + 300, (begins, np.inf)):
        beliefs.append(belief)
        places, headings = inside(belief, world)
        if len(beliefs) <= begins or belief.offsets.late[GUILTY]:
            assert places.all()
            assert headings.all()
    (event,) = told(beliefs)
    assert (event.robot, event.aside) == (GUILTY, True)
    assert 0.2 < event.delay < 0.9  # it is told once it is sure that it is not 0.2 s or less
    assert beliefs[-1].offsets.delay[GUILTY] == pytest.approx(0.6, abs=0.2)
    assert "camera of robot 1 suspected to be late" in str(event)
    assert "no proof" in str(event)
    (restart,) = [
        each for belief in beliefs for each in belief.events if isinstance(each, Restarted) and "late" in each.because
    ]
    assert restart.robot == GUILTY
    assert 0 <= restart.doubtful_since == event.since <= 0.2 * begins
    assert all(not each.aside or each.robot != GUILTY for each in named(beliefs[int(event.time / 0.2) :]))


@pytest.mark.parametrize("seed", range(3))
def test_whoever_has_believed_a_late_camera_lately_starts_over_with_its_robot(seed):
    beliefs = list(late_touring(world_of(seed), 120, (0, np.inf)))
    (place,) = [k for k, belief in enumerate(beliefs) if told([belief])]
    before, now = beliefs[place - 1], beliefs[place]
    by_it = before.votes.accepted[:, before.votes.accepted.shape[1] - 3 + GUILTY]
    believers = set(np.flatnonzero(by_it > now.time - Rules().window).tolist()) - {GUILTY}
    restarted = {each.robot for each in now.events if isinstance(each, Restarted) and each.because == "it was misled"}
    assert believers
    assert believers <= restarted


@pytest.mark.parametrize("seed", range(3))
def test_a_camera_that_is_on_time_is_never_late(seed):
    world = world_of(seed, errors="extreme")
    for belief in late_touring(world, 400, (np.inf, np.inf)):
        assert told([belief]) == []
    assert np.abs(belief.offsets.delay).max() < 0.1


def test_a_camera_whose_clock_is_set_right_is_trusted_again():
    world = world_of(3)
    beliefs = list(late_touring(world, 900, (0, 250)))
    assert [event.aside for event in told(beliefs)] == [True, False]
    places, headings = inside(beliefs[-1], world)
    assert (places & headings).all()
