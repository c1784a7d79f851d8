"""What follows from evidence on cameras: a robot starts over, and its camera is no longer heard; never is a region smaller."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.camera_worlds import GUILTY, inside, started, turned, world_of

from filter import (
    AngularIntervals,
    Bearing,
    Compass,
    Confirmed,
    Late,
    Left,
    Odometry,
    Placed,
    Polygon,
    Range,
    RelativeHeading,
    RobustFilter,
    SetMembershipFilter,
    StartsOver,
    Team,
    Turned,
)
from filter.cameras.offsets import Offsets
from filter.diagnosis.robust_filter import heard

MARKS = [[4.0, 0.0], [0.0, 4.0], [-4.0, 0.0]]
TEAM = Team(2, MARKS, arena=[[-5, -5], [5, 5]])
FILTER = RobustFilter.light(TEAM, cells=0)
SEEN = [Bearing(10.0, 0, [2, 3, 4], [0.0, np.pi / 2, np.pi], 0.1), Range(10.0, 0, [2, 3, 4], 4.0, 0.05, 0.0)]


def known(**said):
    """Return what is known at 10 s of two robots, and what is estimated of the first one's camera."""
    belief = FILTER.start(10.0, [Polygon.box([-0.1, -0.1], [0.1, 0.1])] * 2, AngularIntervals([0.0, 0.0], [0.05, 0.05]))
    first = np.array([True, False])
    plain = {"mean": np.zeros((2, 5)), "covariance": np.tile(np.diag([0.01, 0.01, 0.001, 1e-6, 1e-6]), (2, 1, 1))}
    plain |= {"running": first, "allowed": np.full(2, 0.1), "good_until": np.array([[1.0, 2.0]] * 2)}
    return replace(belief, cameras=replace(Offsets.none(2, 0.0), **plain | said))


def askew(records, by):
    """Return records whose bearings are off by so much [rad]."""
    return [replace(each, bearing=each.bearing + by) if isinstance(each, Bearing) else each for each in records]


def off(column, value):
    """Return an estimate of a camera that has been turned, 0, or late, 1, by so much since 0 s."""
    mean, since = np.zeros((2, 5)), np.full((2, 2), np.inf)
    mean[0, 3 + column], since[0, column] = value, 0.0
    return {"mean": mean, "bad_since": since}


@pytest.mark.parametrize(("column", "value"), [(0, 0.5), (1, 0.8)])
def test_a_suspicion_is_told_and_its_robot_starts_over_suspended_since_its_camera_looked_good(column, value):
    belief = FILTER.update(known(**off(column, value)), askew(SEEN, value * (column == 0)))
    told, over = belief.events
    assert isinstance(told, (Turned, Late)[column])
    assert (told.robot, told.aside, told.since) == (0, True, [1.0, 2.0][column])
    assert isinstance(over, StartsOver)
    assert (over.robots, over.conflict) == ((0,), ())
    assert str(over).endswith("robot 0; its camera is suspected, by evidence")
    assert belief.guarantee.suspended_since.tolist() == [told.since, np.inf]
    assert belief.guarantee.because[0] == "its camera is suspected, by evidence"
    assert belief.headings.bound[0] == np.pi
    areas = belief.regions.outer.areas
    assert (areas[0] < 1.0, areas[0] == pytest.approx(100.0)) == (column == 0, column == 1)  # ranges of a turned one count
    assert areas[1] < 0.1


@pytest.mark.parametrize(
    ("suspected", "left"), [([False, False], 4), ([True, False], 2), ([False, True], 1), ([True, True], 1)]
)
def test_of_a_turned_camera_no_angle_is_heard_and_of_a_late_one_nothing(suspected, left):
    records = (Compass(0.0, 0, 0.0, 0.1), *SEEN, RelativeHeading(10.0, 0, 1, 0.0, 0.1))
    cameras = known(suspected=np.array([suspected, [False, False]])).cameras
    assert len(heard(records, cameras)) == left
    assert heard(records, replace(cameras, on_trial=np.array([True, False]))) == records
    others = tuple(replace(each, robot=np.ones_like(each.robot)) for each in SEEN)
    assert heard(others, cameras) == others


def test_a_camera_that_agrees_again_is_trusted_and_heard():
    belief = FILTER.update(known(suspected=np.array([[True, True], [False, False]])), SEEN)
    assert [(type(event), event.aside) for event in belief.events] == [(Turned, False), (Late, False)]
    assert belief.guarantee.in_force.all()
    assert belief.regions.outer.areas[0] < 0.02


def test_without_an_estimate_a_suspected_camera_is_on_trial_and_puts_nothing_in_force():
    belief, time = FILTER.update(known(**off(1, 0.8)), SEEN), 10.0
    belief = replace(belief, cameras=belief.cameras.without(0))
    for _ in range(45):
        belief = FILTER.update(replace(belief, time=time), [replace(each, time=time) for each in SEEN])
        assert not belief.guarantee.in_force[0]
        if not belief.cameras.on_trial[0]:
            break
        time += 0.1
    assert belief.cameras.running[0]
    assert any(isinstance(event, StartsOver) and event.robots == (0,) for event in belief.events)
    assert belief.regions.outer.areas[0] == pytest.approx(100.0)


def test_in_a_doubt_nobody_is_suspected_and_afterwards_all_is():
    lie = [*SEEN, Range(10.0, 1, 2, 1.0, 0.05, 0.0)]
    doubtful = FILTER.update(known(), lie)
    assert doubtful.diagnosis.hypotheses
    wrong = known(**off(0, 0.5)).cameras
    belief = FILTER.update(replace(doubtful, cameras=wrong), [])
    assert belief.diagnosis.hypotheses
    assert not belief.cameras.suspected.any()
    assert belief.cameras.bad_since[0, 0] == 0.0
    assert belief.diagnosis.metres.tolist() == [0.0, 0.0]
    over = replace(belief, diagnosis=replace(belief.diagnosis, hypotheses=()))
    assert isinstance(FILTER.update(over, []).events[0], Turned)


@pytest.mark.parametrize("change", [Left(10.0, 0), Placed(10.0, 0, Polygon.box([0, 0], [1, 1]))])
def test_whoever_leaves_or_is_put_somewhere_has_no_estimate_and_the_same_camera(change):
    suspected = np.array([[True, False], [False, False]])
    cameras = FILTER.changed(known(suspected=suspected), change).cameras
    assert cameras.running.tolist() == [False, False]
    assert (cameras.suspected == suspected).all()


def test_where_a_robot_with_a_suspected_camera_is_put_it_stays():
    suspected = FILTER.update(known(**off(1, 0.8)), SEEN)
    gone = FILTER.update(FILTER.changed(suspected, Left(10.0, 0)))
    placed = FILTER.changed(gone, Placed(10.0, 0, Polygon.box([-0.1, -0.1], [0.1, 0.1]), AngularIntervals([0.0], [0.05])))
    belief = FILTER.update(placed, SEEN)
    assert not belief.events
    assert belief.cameras.late[0]
    assert belief.regions.outer.areas[0] < 0.05
    assert belief.headings.bound[0] <= 0.05


def run_of(filter_, world, steps, by=0.0):
    """Yield what is predicted and what is known at each step, the guilty one's camera turned by so much [rad]."""
    belief = started(filter_, world)
    for _ in range(steps):
        gone = filter_.predict(belief, world.time + 0.4, world.tour(0.4))
        belief = filter_.update(gone, turned(world.measure(compasses=False), by))
        yield gone, belief


def test_while_no_camera_is_suspected_it_is_the_filter_without_evidence_bit_by_bit():
    runs = []
    for kind in (RobustFilter, SetMembershipFilter):
        world = world_of(1, robots=2)
        runs.append([belief for _, belief in run_of(kind.light(world.team, policy="reject"), world, 12)])
    for ours, plain in zip(*runs, strict=True):
        assert ours.events == plain.events
        assert np.array_equal(ours.regions.outer.offsets, plain.regions.outer.offsets)
        assert np.array_equal(ours.headings.centre, plain.headings.centre)
        assert plain.cameras is None


def test_from_a_suspicion_on_the_truth_is_inside_where_it_is_promised():
    world, told = world_of(1, robots=2, bearing=np.radians(6)), []
    for gone, belief in run_of(RobustFilter.light(world.team), world, 30, np.radians(20)):
        told += [event for event in (*gone.events, *belief.events) if isinstance(event, Turned)]
        places, headings = inside(belief, world)
        assert not told or ((places & headings) | ~belief.guarantee.in_force).all()
    assert [(event.robot, event.aside) for event in told] == [(GUILTY, True)]


def test_a_robot_is_in_force_again_when_its_ranges_have_agreed_for_long_with_its_compass():
    belief, events = FILTER.update(known(**off(0, 0.5)), askew(SEEN, 0.5)), []
    for k in range(1, 46):
        time = 10 + 0.1 * k
        belief = FILTER.predict(belief, time, Odometry(belief.time, time, 0, 0.0, 0.001, 0.0, 0.001, 0.001, 0.0))
        seen = [replace(each, time=time) for each in askew(SEEN, 0.5)]
        belief = FILTER.update(belief, [*seen, Compass(time, 0, 0.0, 0.05)])
        events += belief.events
        assert belief.regions[0].outer.contains([0.0, 0.0])
    assert Confirmed in map(type, events)
    assert belief.guarantee.in_force[0]
    assert belief.cameras.turned[0]
    assert belief.headings.bound[0] <= 0.05 + 1e-9


def test_sightings_without_any_error_make_no_trouble():
    robust = RobustFilter(Team(1, [[0.0, 0.0]]))
    belief = robust.start(0.0, [Polygon.box([0, 0], [0, 0])], AngularIntervals([0.0], [0.0]))
    for _ in range(3):
        belief = robust.update(belief, [Bearing(0.0, 0, 1, 0.0, 0.05), Range(0.0, 0, 1, 0.0, 0.0, 0.0)])
        assert belief.regions[0].outer.contains([0.0, 0.0])


def test_without_bearings_nothing_is_suspected_and_without_odometry_neither():
    belief = known()
    for k in range(1, 6):
        moved = Odometry(belief.time, 10 + 0.2 * k, 1, 0.1, 0.01, 0.0, 0.01, 0.01, 0.01)
        belief = FILTER.update(FILTER.predict(belief, moved.time, moved), [replace(SEEN[1], time=moved.time)])
        assert not belief.cameras.suspected.any()
        assert np.isfinite(belief.cameras.mean).all()
