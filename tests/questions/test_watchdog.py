"""The monitor's law: no true pose is accused, whatever its rate and its clock; and what it accuses is wrong, by fractions."""

import numpy as np
import pytest
from helpers.driven import TICK, world
from helpers.exact import is_beyond

from experiments.logs import Trajectory
from experiments.watchdog.behind import WORLD, Edge, in_words, traced
from experiments.watchdog.claimed import Claimed
from experiments.watchdog.episodes import Episodes
from experiments.watchdog.judge import Judge, Verdict
from experiments.watchdog.reach import Reach
from filter import (
    Bearing,
    Compass,
    Frame,
    Odometry,
    Polygon,
    Range,
    RelativeHeading,
    SetMembershipFilter,
    Source,
    Step,
    Team,
    follow,
    watch,
)


def verdicts(team, steps, claimed, tolerance):
    judge = Judge(Reach.of(team, [step.frame for step in steps]), tolerance)
    for frame in range(len(steps)):
        beliefs = [step.belief for step in steps[max(0, frame - 1) : frame + 1]]
        yield from judge.verdicts(frame, beliefs, claimed)


@pytest.mark.parametrize("seed", range(3))
def test_no_true_pose_is_accused_at_any_rate_by_any_clock(seed):
    driven, team, steps = world(seed, steady=seed % 2 == 0, limit=0.5 if seed % 3 else 0.5 * (seed % 2))
    offset, tolerance = driven.rng.uniform(-1e3, 1e3), driven.rng.choice([1e-6, 1e-3, 0.3])
    ticks = np.sort(driven.rng.choice(round(steps[-1].frame.time / TICK) + 1, 1000, replace=False))
    judged = 0
    for verdict in verdicts(team, steps, driven.poses(ticks, offset, tolerance), tolerance):
        assert verdict.alarms == {}
        judged += verdict.judged.sum()
    assert judged == 4000  # of 4 robots


@pytest.mark.parametrize("seed", range(2))
def test_every_alarm_is_confirmed_by_fractions(seed):
    driven, team, steps = world(seed, robots=2)
    ticks, believed = np.arange(0, round(steps[-1].frame.time / TICK), 37), {step.belief.time: step.belief for step in steps}
    shift = driven.rng.normal(0, 0.2, 2)
    claimed = driven.poses(ticks, shift=shift)
    alarms = 0
    for verdict in verdicts(team, steps, claimed, 1e-6):
        for robot, alarm in verdict.alarms.items():
            outer = believed[alarm.time].regions[robot].outer
            pose = claimed.positions[claimed.times == verdict.time][0, robot]
            assert is_beyond(outer, verdict.moved[robot], alarm.normal, pose)
            assert not is_beyond(outer, verdict.moved[robot], alarm.normal, pose - shift)
            alarms += 1
    assert alarms > 50


@pytest.mark.parametrize("seed", range(2))
def test_poses_at_frames_are_proved_wrong_as_by_their_own_frame_alone(seed):
    driven, team, steps = world(seed)
    ticks, shift = np.array([round(step.frame.time / TICK) for step in steps]), driven.rng.normal(0, 0.15, 2)
    found = {(v.time, robot) for v in verdicts(team, steps, driven.poses(ticks, shift=shift), 1e-6) for robot in v.alarms}
    pairs = [(step, driven.positions[tick] + shift) for step, tick in zip(steps, ticks, strict=True)]
    alone = {(step.frame.time, alarm.robot) for step, there in pairs for alarm in watch(step.belief, there)}
    assert alone
    assert alone <= found


def standing(speed, frames=(0.0, 1.0)):
    """Return a team of one that stands in the unit square at the frames, as far as is known, and its steps."""
    team = Team(1, speed_limit=speed)
    filter_, square = SetMembershipFilter(team), [Polygon.box([0, 0], [1, 1])]
    return team, [Step(Frame(time), belief, belief, 0.0) for time in frames for belief in [filter_.start(time, square)]]


def one_pose(team, steps, time, x, tolerance=0.0):
    claimed = Claimed.of("", {0: Trajectory(np.array([time]), np.array([[x, 0.5]]))}, 1, 0.0)
    return list(verdicts(team, steps, claimed, tolerance))


@pytest.mark.parametrize(("time", "away"), [(0.0, 0.0), (0.1, 0.06), (0.5, 0.3), (0.9, 0.06), (1.0, 0.0)])
def test_a_pose_between_frames_may_be_as_far_as_the_nearer_one_allows_and_no_farther(time, away):
    team, steps = standing(0.6)
    (near,), (far,) = (one_pose(team, steps, time, 1.0 + away + by) for by in (-1e-7, 1e-7))
    assert near.judged.all()
    assert (len(near.alarms), len(far.alarms)) == (0, 1)
    assert far.alarms[0].distance == pytest.approx(1e-7, abs=1e-8)


@pytest.mark.parametrize(("time", "tolerance"), [(0.1, 0.2), (0.5, 0.2), (1.1, 0.15), (-0.1, 0.2)])
def test_a_clock_that_may_be_wrong_widens_by_what_is_driven_in_that_time(time, tolerance):
    team, steps = standing(0.6)
    away = 0.6 * min(max(abs(time + by - frame) for by in (-tolerance, tolerance)) for frame in (0.0, 1.0))
    (near,), (far,) = (one_pose(team, steps, time, 1.0 + away + by, tolerance) for by in (-1e-7, 1e-7))
    assert (len(near.alarms), len(far.alarms)) == (0, 1)


@pytest.mark.parametrize("time", [-0.01, 1.01])
def test_poses_before_the_first_and_after_the_last_frame_are_not_judged(time):
    assert one_pose(*standing(0.6), time, 99.0, tolerance=0.009) == []


def test_odometry_that_is_faster_than_the_speed_limit_counts():
    said = {
        "distance": [-0.4, 0.1],
        "distance_bound": 0.02,
        "turn": 0,
        "turn_bound": 0.1,
        "direction_bound": 0,
        "slip_bound": 0.01,
    }
    frames = [Frame(0.0), Frame(0.5, Odometry(start=0.0, time=0.5, robot=[2, 0], **said)), Frame(2.5)]
    reach = Reach.of(Team(3, speed_limit=0.5), frames)
    np.testing.assert_allclose(reach.speeds, [[0.5, 0.5, 0.86], [0.5] * 3, [0.5] * 3])
    np.testing.assert_allclose(reach.away(0, 0.25, 0.5), [0.25, 0.25, 0.43], atol=2e-9)
    np.testing.assert_allclose(reach.away(2, 0.25, 0.6), [1.125, 1.125, 1.215], atol=2e-9)
    np.testing.assert_allclose(reach.away(2, 2.4, 3.0), [0.25] * 3, atol=2e-9)
    assert (reach.away(1, 0.5, 0.5) > 0).all(), "sums are rounded"


def test_a_region_is_traced_to_sensors_as_far_back_as_there_are_steps():
    _, _, steps = world(5, robots=3)
    recorded = {time: step.frame for step in steps for time in [step.frame.time]}
    for robot in range(3):
        for normal in np.array([[1.0, 0.0], [-0.6, 0.8]]):
            edges = [Edge(steps[-1].frame.time, WORLD, robot, normal)]
            near, far = traced(steps[-2:], edges), traced(steps, edges)
            assert {source.kind for source in far} <= {"bearing", "range", "compass", "odometry", "initial set"}
            assert any(source.kind in ("bearing", "range") for source in near)
            assert all(source.time < steps[-2].frame.time for source in near if source.kind == "region")
            assert {source for source in near if source.kind != "region"} <= set(far)
            assert all(was_said(source, recorded[source.time]) for source in far if source.kind != "initial set")


def test_each_edge_is_traced_to_what_bounded_it_and_not_to_what_bounded_another():
    filter_ = SetMembershipFilter(Team(2, [[10.0, 0.0]], speed_limit=0.0))
    start = filter_.start(0.0, [Polygon.box([-1, -1], [1, 1]), Polygon.box([-99, -99], [99, 99])])
    near = Range(0.0, 0, 2, 10.9, 1.1, 0.0)  # x of robot 0 is below 0.2; nothing else is new
    seen = [near, Compass(0.0, 0, 0.0, 0.01), Bearing(0.0, 0, 1, 0.0, 0.01), Range(0.0, 0, 1, 5.0, 0.1, 0.0)]
    steps = list(follow(filter_, start, [Frame(0.0, None, seen), Frame(1.0)]))
    known, landmark = Source("initial set", 0.0, 0), Source("range", 0.0, 0, 2)
    for x, expected in ((1.0, landmark), (-1.0, known)):
        edge = Edge(1.0, WORLD, 1, np.array([x, 0.0]))
        assert set(traced(steps, [edge])) & {known, landmark} == {expected}
        assert Source("region", 0.0, 1) in traced(steps[1:], [edge])


@pytest.mark.parametrize(("i", "j"), [(0, 1), (0, 2), (1, 2)])
def test_what_is_known_of_a_pair_is_traced_to_those_two(i, j):
    filter_ = SetMembershipFilter(Team(3, speed_limit=0.01), cells=0)
    start = filter_.start(0.0, [Polygon.box([-99, -99], [99, 99])] * 3)
    one, other = np.array([0, 0, 1]), np.array([1, 2, 2])
    fine = np.where((one == i) & (other == j), 0.1, 1.0)  # the other two say less of these two than they do themselves
    seen = [Compass(0.0, [0, 1], 0.0, 0.1), Bearing(0.0, one, other, [0, 1, 2], fine), Range(0.0, one, other, 5, 2 * fine, 0.0)]
    steps = list(follow(filter_, start, [Frame(0.0, None, seen), Frame(1.0)]))
    found = {
        source for angle in range(6) for source in traced(steps, [Edge(1.0, i, j, np.array([np.cos(angle), np.sin(angle)]))])
    }
    assert found == {Source("compass", 0.0, i), Source("bearing", 0.0, i, j), Source("range", 0.0, i, j)}


def was_said(source, frame):
    if source.kind == "odometry":
        return source.robot in frame.odometry.robot
    kind = {"compass": Compass, "bearing": Bearing, "range": Range}[source.kind]
    told = [record for record in frame.measurements if isinstance(record, kind)]
    pairs = [pair for record in told for pair in zip(record.robot, getattr(record, "target", record.robot), strict=True)]
    return (source.robot, source.robot if source.target is None else source.target) in pairs


def test_a_bearing_comes_with_the_compass_of_its_instant_and_a_row_with_the_odometry_that_moved_it():
    _, _, steps = world(6, robots=1)
    edges = [Edge(steps[-1].frame.time, WORLD, 0, np.array(normal)) for normal in ([1.0, 0.0], [-1.0, 0.0], [0.0, 1.0])]
    found = traced(steps, edges)
    bearings, compasses = ({source.time for source in found if source.kind == kind} for kind in ("bearing", "compass"))
    assert bearings == compasses != set()
    first, last = min(source.time for source in found), steps[-1].frame.time
    driven = {source.time for source in found if source.kind == "odometry"}
    assert driven == {step.frame.time for step in steps if first < step.frame.time <= last}


def test_a_bearing_comes_with_the_mates_headings_that_lead_to_a_compass_and_with_no_other():
    filter_ = SetMembershipFilter(Team(4, [[5.0, 0.0]], speed_limit=0.0), cells=0)
    start = filter_.start(0.0, [Polygon.box([-1, -9], [1, 9])] * 4)
    mates = RelativeHeading(0.0, [1, 1], [0, 2], 0.0, 0.01)
    seen = [Bearing(0.0, 0, 4, 0.0, 0.01), Compass(0.0, [2, 3], 0.0, 0.01), mates]
    steps = list(follow(filter_, start, [Frame(0.0, None, seen)]))
    found = set(traced(steps, [Edge(0.0, WORLD, 0, np.array([0.0, 1.0]))]))
    led = {Source("relative heading", 0.0, 1, 0), Source("relative heading", 0.0, 1, 2), Source("compass", 0.0, 2)}
    assert found == {Source("bearing", 0.0, 0, 4), *led} | {source for source in found if source.kind == "initial set"}


def test_what_is_of_one_kind_between_the_same_two_is_told_together():
    sources = [Source("range", 0.1, 0, 3), Source("range", 0.2, 0, 3), Source("compass", 0.1, 0)]
    assert in_words(sources) == "range of robot 0 to 3 at 2 times from 0.100 s to 0.200 s; compass of robot 0 at 0.100 s"
    by_two = [Source("range", 0.1, 0, 3, 0), Source("range", 0.1, 0, 3, 1)]
    assert in_words(by_two) == "range of robot 0 to 3 by sensor 0 at 0.100 s; range of robot 0 to 3 by sensor 1 at 0.100 s"


def test_alarms_that_follow_one_another_are_one_episode_and_a_pose_that_may_be_right_ends_it():
    team, steps = standing(0.0)
    episodes, xs = Episodes(), [1.5, 3.0, 2.0, 1.0, np.nan, 1.5]
    claimed = Claimed("slam", np.linspace(0, 1, 6), np.array([[[x, 0.5]] for x in xs]))
    for verdict in verdicts(team, steps, claimed, 0.0):
        episodes.add(claimed, verdict, steps)
    episodes.end()
    (first, behind), (second, _) = episodes.ended
    assert (first.number, first.trajectory, first.start, first.end, first.poses) == (1, "r0_slam", 0.0, 0.4, 3)
    assert (first.worst.distance, first.worst_time) == (pytest.approx(2.0), 0.2)
    assert behind == "initial set of robot 0 at 0.000 s"
    assert (second.number, second.start, second.end, second.poses, second.steps) == (2, 1.0, 1.0, 1, ())


def test_a_moment_without_a_pose_does_not_end_an_episode():
    _, steps = standing(0.0)
    episodes, claimed = Episodes(), Claimed("", np.zeros(1), np.full((1, 1, 2), np.nan))
    (alarm,) = watch(steps[0].belief, [[3.0, 0.5]])
    for time, judged, alarms in ((0.0, True, {0: alarm}), (0.2, False, {}), (0.4, True, {0: alarm})):
        episodes.add(claimed, Verdict(time, np.array([judged]), alarms, {0: 0.0}), steps)
    episodes.end()
    assert [episode.poses for episode, _ in episodes.ended] == [2]
