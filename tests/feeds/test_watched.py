"""The law of the watch over a feed: no true pose is accused, whatever comes when; what is accused is wrong, by fractions."""

import csv
import json
from collections import Counter
from dataclasses import replace

import numpy as np
import pytest
from helpers.driven import TICK
from helpers.exact import is_beyond
from helpers.feeds.late import batches, delayed, records_of, world

import experiments.feeds.watched
from experiments.feeds.beside import Answered
from experiments.feeds.now import Now, gone_on
from experiments.feeds.watched import AT_ONCE, Watched
from experiments.keeping.watched import TOLERANCE, AlarmFiles
from experiments.watchdog.claimed import Claimed
from filter import AngularIntervals, FixedLag, Frame, Left, Odometry, Placed, Polygon, Position, Team, Twist


class Said:
    """Keeps what is said of alarms."""

    def __init__(self):
        self.alarms = []

    def __call__(self, what, time, why, place):
        self.alarms.append((what, time, why, place))


def watched(path, filter_, known, claims, *, lag=1.0, every=0.0):
    now = Now(FixedLag(filter_, lag=lag, every=every, gap=60.0, restart=lambda *at: gone_on(filter_, *at)), filter_, known)
    said = Said()
    return now, Watched(now, filter_.team, claims, AlarmFiles(path), said), said


def fed(now, watch, batches):
    with watch:
        for batch in batches:
            now.take(batch)
            watch.keep(Answered(now, tuple(batch), ()))


@pytest.mark.parametrize("every", [0.0, 0.1])
@pytest.mark.parametrize("late", [0.0, 0.4])
@pytest.mark.parametrize("seed", range(2))
def test_no_true_pose_is_accused_whatever_comes_when(seed, late, every, tmp_path, monkeypatch):
    monkeypatch.setattr(experiments.feeds.watched, "AT_ONCE", 100_000)
    rng, driven, filter_, known, frames = world(seed)
    ticks = np.arange(round(known.time / TICK), round(frames[-1].time / TICK) + 1, 3)
    claimed = driven.poses(ticks, rng.uniform(-1e3, 1e3), TOLERANCE / 2)
    now, watch, said = watched(tmp_path, filter_, known, [claimed], every=every)
    fed(now, watch, batches(rng, delayed(rng, records_of(frames), late)))
    assert said.alarms == []
    assert (watch.judged.checks, watch.unjudged) == (claimed.poses(), 0)


@pytest.mark.parametrize("every", [0.0, 0.1])
@pytest.mark.parametrize("seed", [1])
def test_every_alarm_is_confirmed_by_fractions_and_most_of_what_is_far_off_is_found(seed, every, tmp_path):
    rng, driven, filter_, known, frames = world(seed)
    shift = rng.normal(0, 0.4, 2)
    ticks = np.arange(round(known.time / TICK) + 100, round(frames[-1].time / TICK) + 1, 7)
    claimed = driven.poses(ticks, shift=shift)
    now, watch, said = watched(tmp_path, filter_, known, [claimed], every=every)
    believed = {known.time: [known]}

    def remembered():
        for batch in batches(rng, delayed(rng, records_of(frames), 0.1)):
            yield batch
            for step in now.lagged.steps:
                believed.setdefault(step.belief.time, []).append(step.belief)

    fed(now, watch, remembered())
    with (tmp_path / "alarms.csv").open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert len(rows) == len(said.alarms) == watch.judged.alarms > 100
    for row in rows:
        robot, normal = int(row["robot"][1:]), np.array([float(row["normal_x"]), float(row["normal_y"])])
        pose, moved = claimed.positions[claimed.times == float(row["time_s"])][0, robot], float(row["moved_m"])
        outers = [belief.regions[robot].outer for belief in believed[float(row["frame_s"])]]
        assert any(is_beyond(outer, moved, normal, pose) for outer in outers)
        assert not any(is_beyond(outer, moved, normal, pose - shift) for outer in outers)
    what, time, why, place = said.alarms[0]
    assert what in ("r0 is proved wrong", "r1 is proved wrong")
    assert why.startswith("by 0.")
    assert place.tolist() == claimed.positions[claimed.times == time][0, int(what[1])].tolist()


def standing(time=0.0, limit=0.6, **options):
    """Return one robot of which is known that it is in the unit square."""
    rng, _, filter_, _, _ = world(0)
    team = Team(1, [[0.0, 9.0]], speed_limit=limit, arena=[[-20, -20], [20, 20]])
    filter_ = type(filter_).light(team, **options)
    return rng, filter_, filter_.start(time, [Polygon.box([0, 0], [1, 1])])


def seen(time, robot=0):
    return Position.within(time, robot, Polygon.box([0, 0], [1, 1]))


def one_pose(time, x):
    return Claimed("", np.array([time]), np.array([[[x, 0.5]]]))


@pytest.mark.parametrize(("time", "away"), [(0.0, 0.0), (0.1, 0.06), (0.5, 0.3), (0.9, 0.06), (1.0, 0.0)])
def test_a_pose_between_steps_may_be_as_far_as_the_nearer_one_allows_and_no_farther(time, away, tmp_path):
    alarms = []
    for by in (-2e-6, 2e-6):
        _, filter_, known = standing()
        now, watch, said = watched(tmp_path, filter_, known, [one_pose(time, 1.0 + away + 2 * TOLERANCE * 0.6 + by)])
        fed(now, watch, [[seen(1.0)]])
        assert watch.judged.checks == 1
        alarms.append(len(said.alarms))
    assert alarms == [0, 1]


def test_a_robot_that_may_have_been_carried_is_not_accused_and_one_that_is_away_is_not_judged(tmp_path):
    _, filter_, known = standing()
    times = np.array([0.5, 1.5, 2.5, 3.5, 4.5])
    claimed = Claimed("slam", times, np.full((5, 1, 2), 9.0))
    now, watch, said = watched(tmp_path, filter_, known, [claimed], lag=10.0)
    placed = Placed(3.0, 0, Polygon.box([0, 0], [1, 1]))
    fed(now, watch, [[seen(1.0)], [Left(2.0, 0)], [placed, seen(3.0)], [seen(4.0)], [seen(5.0)]])
    assert [time for _, time, _, _ in said.alarms] == [0.5, 4.5]
    assert watch.judged.checks == 2


def test_by_what_is_not_guaranteed_nothing_is_proved(tmp_path):
    _, filter_, known = standing()
    claimed = Claimed("", np.array([0.5, 2.5]), np.full((2, 1, 2), 9.0))
    known = replace(known, guarantee=known.guarantee.suspended(0.0, "a lie"))
    now, watch, said = watched(tmp_path, filter_, known, [claimed])
    fed(now, watch, [[seen(1.0)], [seen(2.0)], [seen(3.0)]])
    assert now.belief.guarantee.lapsed.all()
    assert said.alarms == []
    assert watch.judged.checks == 0


def test_a_twist_that_is_ended_late_has_the_poses_since_then_judged_anew(tmp_path):
    """Until the end of the twist was told the robot seemed to go on."""
    _, filter_, _ = standing()
    bounds = {"speed_bound": 0.0, "turn_rate_bound": 0.0, "direction_bound": 0.1, "slip_rate": 0.01}
    there = filter_.start(0.0, [Polygon.box([0, 0], [0.1, 0.1])], AngularIntervals([0.0], [0.1]))
    claimed = Claimed("", np.array([0.9]), np.array([[[0.05 + 0.5, 0.05]]]))
    now, watch, said = watched(tmp_path, filter_, there, [claimed])
    going = Twist(0.0, 0, 1.0, turn_rate=0.0, hold=5.0, **bounds)
    stopped = Twist(0.5, 0, 0.0, turn_rate=0.0, hold=5.0, **bounds)
    fed(now, watch, [[going, Frame(0.8)], [stopped, Frame(1.0)]])
    assert said.alarms == []
    assert watch.judged.checks == 1


def test_who_has_left_as_is_told_late_is_not_accused_of_that_time_from_then_on(tmp_path):
    _, filter_, known = standing()
    claimed = Claimed("", np.array([2.5]), np.full((1, 1, 2), 9.0))
    now, watch, said = watched(tmp_path, filter_, known, [claimed], lag=10.0)
    fed(now, watch, [[Frame(2.0)], [Left(1.0, 0), Placed(1.5, 0, Polygon.box([8, 8], [10, 10])), Frame(3.0)]])
    assert said.alarms == []


def test_of_too_many_at_once_the_newest_are_judged(tmp_path):
    _, filter_, known = standing()
    times = np.linspace(0.001, 1.0, 1000)
    claimed = Claimed("", times, np.full((1000, 1, 2), 9.0))
    now, watch, said = watched(tmp_path, filter_, known, [claimed])
    fed(now, watch, [[seen(1.0)]])
    assert (watch.judged.checks, watch.unjudged) == (AT_ONCE, 1000 - AT_ONCE)
    assert [time for _, time, _, _ in said.alarms] == times[-AT_ONCE:].tolist()


@pytest.mark.parametrize("jump", [1000.0, -1000.0])
def test_after_stamps_have_jumped_it_goes_on_from_there(jump, tmp_path):
    _, filter_, known = standing(2000.0)
    there = 2000.0 + jump
    times = np.array([2000.5, there + 0.15, there + 0.35])
    claimed = Claimed("", np.sort(times), np.full((3, 1, 2), 9.0))
    now, watch, said = watched(tmp_path, filter_, known, [claimed])
    fed(now, watch, [[seen(time)] for time in (2001.0, there, there + 0.1, there + 0.2, there + 0.3, there + 0.4)])
    assert sorted(time for _, time, _, _ in said.alarms) == np.sort(times).tolist()


def test_odometry_faster_than_the_limit_counts_for_the_poses_on_its_way(tmp_path):
    """Half of it is faster than all of it together: what it says is what counts, not its mean."""
    _, filter_, known = standing(limit=0.1)
    rows = [(0.0, 0.5, 2.0), (0.5, 1.0, 0.0)]
    driven = [
        {"start": begin, "time": end, "robot": 0, "distance": way, "distance_bound": 0.0, "turn": 0.0, "turn_bound": 0.0}
        for begin, end, way in rows
    ]
    odometry = [Odometry(**each, direction_bound=0.0, slip_bound=0.0) for each in driven]
    now, watch, said = watched(tmp_path, filter_, known, [Claimed("", np.array([0.5]), np.array([[[3.0, 0.5]]]))])
    fed(now, watch, [[*odometry, Position.within(1.0, 0, Polygon.box([2, 0], [3, 1]))]])
    assert said.alarms == []
    assert watch.judged.checks == 1


def test_alarms_are_said_written_and_counted(tmp_path):
    _, filter_, known = standing()
    claims = [Claimed(name, np.arange(0.1, 1.0, 0.1), np.full((9, 1, 2), where)) for name, where in (("slam", 9.0), ("", 0.5))]
    now, watch, said = watched(tmp_path, filter_, known, claims)
    fed(now, watch, [[seen(1.0)]])
    assert Counter(what for what, *_ in said.alarms) == {"r0_slam is proved wrong": 9}
    assert (watch.judged.checks, watch.judged.alarms, len(watch.judged.episodes)) == (18, 9, 1)
    with (tmp_path / "episodes.csv").open(newline="") as file:
        (episode,) = csv.DictReader(file)
    assert (episode["trajectory"], episode["poses"]) == ("r0_slam", "9")
    assert json.loads(episode["distance_max_m"]) > 8
