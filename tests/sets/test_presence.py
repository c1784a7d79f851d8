"""Robots that join, leave and come back: nothing is said of one that is away, and the truth of the others stays inside."""

import json
import pickle
from dataclasses import fields, replace

import numpy as np
import pytest
from helpers.worlds import World

from experiments.follow import main
from experiments.logs import InvalidLog, LogReader, LogWriter, tum_line
from filter import (
    AngularIntervals,
    Compass,
    ExtendedKalmanFilter,
    FixedLag,
    Frame,
    InvalidInput,
    Left,
    OutOfOrder,
    Placed,
    Polygon,
    Range,
    SetMembershipFilter,
    Team,
    Truth,
    follow,
    frames_of,
    watch,
)

BOX = Polygon.box([-1, -1], [1, 1])
HEADER = {"record": "header", "format": "corral-log", "version": 2, "robots": ["alice", "bob"], "landmarks": {"gate": [0, 2]}}
LIMITS = {"arena": [[None, None], [None, None]], "speed_limit": 0.5, "turn_rate_limit": 1.5, "start": 0.0}
ALICE = {"record": "initial", "robot": "alice", "vertices": [[-1, -1], [1, -1], [1, 1]], "heading": None}


def among(records, there):
    """Return what those that are there say of one another and of landmarks."""
    found = []
    for record in records:
        target = getattr(record, "target", record.robot)
        kept = there[record.robot] & np.append(there, np.ones(9, dtype=bool))[target]
        columns = {each.name: getattr(record, each.name)[kept] for each in fields(record) if each.name != "time"}
        found.append(type(record)(record.time, **columns))
    return found


def frames_with_changes(world, count):
    """Return frames in which robots come and go, who is there, and where all are; one that is away is carried anywhere."""
    there, frames, told = np.ones(world.robots, dtype=bool), [], []
    for _ in range(count):
        driven, changes = world.tour(), []
        for robot in np.flatnonzero(world.rng.random(world.robots) < 0.3).tolist():
            if world.rng.random() < 0.6:
                place = world.positions.copy()
                place[robot] = world.rng.uniform(0, world.size, 2)
                world.positions = place
                heading = AngularIntervals([world.headings[robot]], [0.3]) if world.rng.random() < 0.5 else None
                changes.append(Placed(world.time, robot, Polygon.box(place[robot] - 0.4, place[robot] + 0.2), heading))
            else:
                changes.append(Left(world.time, robot))
            there[robot] = isinstance(changes[-1], Placed)
        world.positions = np.where(there[:, None], world.positions, world.rng.uniform(-30, 30, (world.robots, 2)))
        frames.append(Frame(world.time, driven, among(world.measure(), there), changes=changes))
        told.append((there.copy(), world.positions, world.headings))
    return frames, told


@pytest.mark.parametrize("every", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(4))
def test_the_truth_of_those_that_are_there_is_inside(seed, every):
    world = World(np.random.default_rng(seed), robots=4, errors=["uniform", "extreme"][seed % 2], landmarks=2)
    filter_ = SetMembershipFilter(world.team)
    belief = filter_.start(0.0, world.initial_sets(), world.initial_headings())
    frames, told = frames_with_changes(world, 12)
    where = dict(zip([frame.time for frame in frames], told, strict=True))
    for step in follow(filter_, belief, frames, every=every):
        there, positions, headings = where[step.belief.time]
        assert step.belief.guarantee.in_force.tolist() == there.tolist()
        assert (step.belief.regions.contains(positions) | ~there).all()
        assert (step.belief.headings.contains(headings) | ~there).all()
        assert {alarm.robot for alarm in watch(step.belief, positions)} == set()


def team_of_two(**options):
    return Team(["alice", "bob"], {"gate": [0.0, 2.0]}, 0.5, 1.5, **options)


def test_of_a_robot_that_is_away_nothing_is_said_and_nothing_may_be_measured():
    filter_ = SetMembershipFilter(team_of_two())
    belief = filter_.changed(filter_.start(0.0, [BOX, BOX]), Left(0.0, 1))
    assert belief.guarantee.in_force.tolist() == [True, False]
    assert (str(belief.guarantee), belief.guarantee.away) == ("in force", {1})
    assert pickle.loads(pickle.dumps(belief)).guarantee.away == {1}
    for record in (Compass(0.0, 1, 0.1, 0.1), Range(0.0, 0, 1, 1.0, 0.1, 0.0)):
        with pytest.raises(InvalidInput, match=r"robots that are there; came bob, which has left"):
            filter_.update(belief, [record])
    back = filter_.changed(belief, Placed(0.0, 1, BOX))
    assert back.guarantee.in_force.all()
    filter_.update(back, [Range(0.0, 0, 1, 1.0, 0.1, 0.0)])


def test_what_a_robot_that_is_away_drives_is_in_conflict_with_nothing():
    filter_ = SetMembershipFilter(team_of_two(arena=[[-2, -2], [2, 2]]))
    belief = filter_.changed(filter_.start(0.0, [BOX, BOX], AngularIntervals([0, 0], [0.1, 0.1])), Left(0.0, 1))
    world = World(np.random.default_rng(0), robots=2)
    odometry = world.drive(np.array([0.1, 9.0]), np.zeros(2), 0.1)
    after = filter_.predict(belief, odometry.time, odometry)
    assert after.regions[0].outer.area < 6
    frames = [Frame(odometry.time, odometry), Frame(0.2, replace(odometry, start=odometry.time, time=0.2))]
    assert filter_.advance(belief, frames).time == 0.2


def test_what_tied_others_to_it_is_gone():
    filter_ = SetMembershipFilter(team_of_two())
    belief = filter_.update(filter_.start(0.0, [BOX, BOX]), [Range(0.0, 0, 1, 2.0, 0.01, 0.0)])
    left = filter_.changed(belief, Left(0.0, 0))
    assert (left.constraints.i >= 0).sum() == 0
    assert left.regions.outer.areas[1] == pytest.approx(belief.regions.outer.areas[1])


@pytest.mark.parametrize(
    ("change", "error", "said"),
    [
        (Left(0.1, 1), OutOfOrder, "left"),
        (Placed(0.1, 1), OutOfOrder, "placed"),
        (Left(0.0, 2), InvalidInput, "robots 0 to 1; came robot 2"),
        (Placed(0.0, 0), InvalidInput, "closed arena"),
        ("bob", InvalidInput, "placed, or has left"),
    ],
)
@pytest.mark.parametrize("kind", [SetMembershipFilter, ExtendedKalmanFilter])
def test_what_is_no_change_is_refused(kind, change, error, said):
    filter_ = kind(team_of_two())
    with pytest.raises(error, match=said):
        filter_.changed(filter_.start(0.0, [BOX, BOX]), change)


def test_a_kalman_filter_starts_anew_with_it():
    filter_ = ExtendedKalmanFilter(team_of_two())
    belief = filter_.update(filter_.start(0.0, [BOX, BOX]), [Range(0.0, 0, 1, 2.0, 0.01, 0.0)])
    away = filter_.changed(belief, Left(0.0, 1))
    with pytest.raises(InvalidInput, match="bob, which has left"):
        filter_.update(away, [Range(0.0, 0, 1, 1.0, 0.1, 0.0)])
    back = filter_.changed(away, Placed(0.0, 1, Polygon.box([4, 4], [5, 5])))
    assert back.mean[1].tolist() == [4.5, 4.5, 0]
    assert (back.covariance[:3, 3:] == 0).all()
    assert back.away == set()


def test_a_filter_that_cannot_says_so():
    class Fixed(ExtendedKalmanFilter):
        changed = None

    filter_ = Fixed(team_of_two(arena=[[-9, -9], [9, 9]]))
    frames = [Frame(0.0, changes=[Left(0.0, 1)])]
    with pytest.raises(InvalidInput, match=r"that robots can join and leave.*; came Fixed"):
        list(follow(filter_, filter_.start(0.0, [BOX, BOX]), frames))


def test_a_stream_has_a_frame_for_it():
    team = team_of_two()
    arrivals = [Left(1.0, 1), Compass(0.5, 0, 0.1, 0.1), Placed(2.0, 1, BOX), Frame(2.0, truth=Truth(np.zeros((2, 2)), [0, 0]))]
    frames = list(frames_of(team, 0.0, arrivals))
    assert [(frame.time, len(frame.changes)) for frame in frames] == [(0.5, 0), (1.0, 1), (2.0, 1)]
    with pytest.raises(InvalidInput, match="robots 0 to 1"):
        list(frames_of(team, 0.0, [Left(1.0, 2)]))


@pytest.mark.parametrize("every", [0.0, 1.0])
@pytest.mark.parametrize("seed", range(2))
def test_who_comes_and_goes_may_be_told_late(seed, every):
    world = World(np.random.default_rng(seed), robots=3, landmarks=2)
    inner = SetMembershipFilter(world.team)
    start = inner.start(0.0, world.initial_sets(), world.initial_headings())
    frames, told = frames_with_changes(world, 8)
    events = [(frame.time, 0, [frame.odometry, *frame.changes, Frame(frame.time)]) for frame in frames]
    events += [(frame.time + world.rng.uniform(0, 0.9), 1, frame.measurements) for frame in frames if frame.measurements]
    filter_ = FixedLag(inner, lag=1.0, every=every)
    lagged = filter_.begin(start)
    for _, _, records in sorted(events, key=lambda event: event[:2]):
        lagged = filter_.merge(lagged, records)
    there, positions, _ = told[-1]
    assert lagged.belief.guarantee.in_force.tolist() == there.tolist()
    assert (lagged.belief.regions.contains(positions) | ~there).all()
    if not every:
        (*_, last) = follow(inner, start, frames)
        assert lagged.belief.headings.bound.tobytes() == last.belief.headings.bound.tobytes()
        assert (lagged.belief.polytope.lower == last.belief.polytope.lower).all()


def log_of(path, *lines):
    path.write_text("".join(json.dumps(line) + "\n" for line in (HEADER | LIMITS, *lines)))
    return path


def bob(time, vertices=((1, 0), (2, 0), (2, 1))):
    return {"record": "initial", "time": time, "robot": "bob", "vertices": vertices, "heading": None}


def measured(time, mate=True):
    ranges = [{"record": "range", "time": time, "robot": "alice", "range": 1.2, "bound": 1.5, "relative_bound": 0.0}]
    return [{**each, **({"target": "bob"} if mate else {"landmark": "gate"})} for each in ranges]


def test_a_log_in_which_a_robot_joins_leaves_and_comes_back(tmp_path):
    lines = [ALICE, *measured(1.0, mate=False), bob(2.0), *measured(2.0), {"record": "leave", "time": 3.0, "robot": "bob"}]
    truth = {"record": "truth", "time": 4.0, "positions": [[0, 0], [70, 70]], "headings": [0, 3]}  # it was carried away
    lines += [*measured(4.0, mate=False), truth, bob(5.0), *measured(5.5), {"record": "frame", "time": 6.0}]
    path = log_of(tmp_path / "log.jsonl", *lines)
    for form, every, code in (("ekf", [], 4), ("sets", ["--every", "0"], 0), ("sets", ["--every", "0"], 0)):
        assert main([str(path), "--out", str(tmp_path / form), "--filter", form, *every]) == code
        rows = [json.loads(line) for line in (tmp_path / form / "regions.jsonl").read_text().splitlines()]
        assert [row["time"] for row in rows if row["robot"] == "bob"] == [2.0, 5.0, 5.5, 6.0]
        assert [row["time"] for row in rows if row["robot"] == "alice"] == [1.0, 2.0, 3.0, 4.0, 5.0, 5.5, 6.0]
    assert (tmp_path / "sets" / "trajectories" / "bob_filter.tum").read_text().count("\n") == 4
    summary = json.loads((tmp_path / "sets" / "summary.json").read_text())
    assert (summary["checks"], summary["escapes"], summary["heading_escapes"]) == (1, 0, 0)
    assert main([str(path), "--out", str(tmp_path / "more"), "--recording", "--against", "ekf"]) == 0
    assert main([str(path), "--out", str(tmp_path / "evidence"), "--filter", "robust"]) == 0
    log = LogReader(path)
    with LogWriter(tmp_path / "again.jsonl", log.header, log.initial) as again:
        for frame in log.frames():
            again.write(frame)
    first, second = ([frame.changes for frame in LogReader(each).frames()] for each in (path, tmp_path / "again.jsonl"))
    assert [[type(change) for change in changes] for changes in first] == [[type(change) for change in each] for each in second]
    placed = [change for changes in second for change in changes if isinstance(change, Placed)]
    assert all(change.polygon.contains([[1, 0], [2, 0], [2, 1]]).all() for change in placed)


def test_what_others_claim_of_a_robot_that_is_carried_is_not_accused(tmp_path):
    frames = [{"record": "frame", "time": time} for time in (0.0, 1.0, 2.0, 4.0, 6.0, 8.0)]
    there, left = bob(3.0, [[30, 0], [31, 0], [31, 1]]), {"record": "leave", "time": 5.0, "robot": "bob"}
    lines = [ALICE, bob(0.0), *frames[:3], there, frames[3], left, frames[4], bob(7.0), frames[5]]
    path, poses = log_of(tmp_path / "log.jsonl", *lines), tmp_path / "poses"
    poses.mkdir()
    places = {0.0: 1.8, 1.5: 1.8, 2.5: 15, 3.0: 30.9, 3.5: 30.9, 4.5: 30.9, 5.5: -70, 6.5: 40, 7.0: 1.8, 7.5: 1.8}
    (poses / "r1.tum").write_text("".join(tum_line(time, np.array([x, 0.5]), 0.0) for time, x in places.items()))
    run = [str(path), "--out", str(tmp_path / "out"), "--watch", str(poses)]
    assert main(run) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["watch_alarms"], summary["watch_checks"]) == (0, 3)  # at 1.5, 3.5 and 7.5 s
    (poses / "r1.tum").write_text(tum_line(3.5, np.array([1.8, 0.5]), 0.0))
    assert main(run) == 1


def test_a_robot_that_never_came_cannot_measure(tmp_path):
    log = log_of(tmp_path / "log.jsonl", ALICE, *measured(1.0))
    assert main([str(log), "--out", str(tmp_path / "out")]) == 2
    only = log_of(tmp_path / "only.jsonl", ALICE, {"record": "frame", "time": 1.0})
    assert main([str(only), "--out", str(tmp_path / "out")]) == 0


def test_in_version_1_all_are_there(tmp_path):
    path = log_of(tmp_path / "log.jsonl", {**ALICE, "robot": 0}, {"record": "frame", "time": 1.0})
    head = {**HEADER, **LIMITS, "version": 1, "robots": 2, "landmarks": [], "rate": None}
    path.write_text("\n".join([json.dumps(head), *path.read_text().splitlines()[1:]]) + "\n")
    with pytest.raises(InvalidLog, match='a record "initial"'):
        LogReader(path)
