import json
import re
from pathlib import Path

import numpy as np
import pytest

from experiments.logs import Header, InitialSet, InvalidLog, LogReader, LogWriter
from experiments.logs.reading.fast import Fast
from filter import Bearing, Compass, Frame, InvalidInput, Odometry, Range, Team, Truth
from filter.records.record import field_names

TEAM = Team(
    3, landmarks=[[0.1, 0.2], [1 / 3, -2e-17]], speed_limit=0.7, turn_rate_limit=1.5, arena=[[-6, -np.inf], [6, np.inf]]
)
SQUARE = np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]])


def initial_sets(generator, robots=3):
    return [
        InitialSet(SQUARE + generator.normal(size=2), (generator.normal(), 0.1) if robot else None) for robot in range(robots)
    ]


def odometry(generator, start, time):
    return Odometry(start, time, np.arange(3), *generator.uniform(0, 1, (6, 3)))


def frames_of(generator, count=4):
    frames = []
    for step in range(count):
        time = 0.1 * step
        measurements = (
            Compass(time, [2, 0], generator.normal(size=2), 0.05),
            Bearing(time, [0, 1, 2], [1, 3, 4], generator.normal(size=3), 0.1),
            Bearing(time, [0], [2], generator.normal(size=1), 0.1),
            Range(time, [1], [4], [3.0], 0.0, 0.02),
            Range(time, [], [], [], [], []),
        )
        truth = Truth(generator.normal(size=(3, 2)), generator.normal(size=3))
        moved = odometry(generator, 0.1 * (step - 1), time) if step else None
        frames.append(Frame(time, moved, measurements if step % 2 else (), truth if step != 3 else None))
    return frames


def write(path, frames, team=TEAM, initial=None, *, start=0.0, rate=10.0):
    with LogWriter(path, Header(team, start, rate), initial or initial_sets(np.random.default_rng(7))) as writer:
        for frame in frames:
            writer.write(frame)
    return path


@pytest.fixture
def log(tmp_path):
    return write(tmp_path / "log.jsonl", frames_of(np.random.default_rng(1)))


def same_bits(one, other):
    one, other = np.asarray(one), np.asarray(other)
    return one.shape == other.shape and one.dtype == other.dtype and one.tobytes() == other.tobytes()


def same_records(one, other):
    names = field_names(one)
    return (
        type(one) is type(other)
        and one.time == other.time
        and all(same_bits(getattr(one, n), getattr(other, n)) for n in names)
    )


def test_a_log_gives_back_the_same_frames_bit_for_bit(tmp_path):
    frames = frames_of(np.random.default_rng(1))
    reader = LogReader(write(tmp_path / "log.jsonl", frames))
    again = list(reader.frames())
    assert [frame.time for frame in again] == [frame.time for frame in frames]
    for frame, copy in zip(frames, again, strict=True):
        assert (frame.odometry is None) == (copy.odometry is None)
        if frame.odometry is not None:
            assert same_records(frame.odometry, copy.odometry)
            assert frame.odometry.start == copy.odometry.start
        assert len(frame.measurements) == len(copy.measurements)
        assert all(map(same_records, frame.measurements, copy.measurements))
        assert (frame.truth is None) == (copy.truth is None)
        if frame.truth is not None:
            assert same_bits(frame.truth.positions, copy.truth.positions)
            assert same_bits(frame.truth.headings, copy.truth.headings)


def test_frames_are_the_same_without_the_fast_reader(log, monkeypatch):
    frames = list(LogReader(log).frames())
    monkeypatch.setattr(Fast, "read", lambda *_: None)
    for frame, copy in zip(frames, LogReader(log).frames(), strict=True):
        assert frame.time == copy.time
        assert all(map(same_records, frame.measurements, copy.measurements))
        assert frame.odometry is copy.odometry is None or same_records(frame.odometry, copy.odometry)
        assert frame.truth is copy.truth is None or same_bits(frame.truth.positions, copy.truth.positions)


def test_a_log_gives_back_the_same_team_and_initial_sets_bit_for_bit(tmp_path):
    initial = initial_sets(np.random.default_rng(3))
    reader = LogReader(
        write(tmp_path / "log.jsonl", frames_of(np.random.default_rng(1)), initial=initial, start=-0.1, rate=None)
    )
    team = reader.header.team
    assert (team.robots, team.speed_limit.tolist(), team.turn_rate_limit.tolist()) == (3, [0.7] * 3, [1.5] * 3)
    assert same_bits(team.landmarks, TEAM.landmarks)
    assert same_bits(team.arena, TEAM.arena)
    assert (reader.header.start, reader.header.rate) == (-0.1, None)
    for known, copy in zip(initial, reader.initial, strict=True):
        assert same_bits(known.vertices, copy.vertices)
        assert known.heading == copy.heading
        assert same_bits(known.polygon().offsets, copy.polygon().offsets)


def test_a_copy_of_a_log_is_the_same_file(log, tmp_path):
    reader = LogReader(log)
    copy = write(tmp_path / "copy.jsonl", reader.frames(), reader.header.team, reader.initial)
    assert copy.read_bytes() == log.read_bytes()


def test_a_team_without_landmarks_and_frames_without_anything_survive(tmp_path):
    frames = [Frame(0.0, None, (), None), Frame(0.1, None, (), None)]
    reader = LogReader(write(tmp_path / "log.jsonl", frames, Team(1), [InitialSet([[0.0, 0.0]])]))
    assert [frame.time for frame in reader.frames()] == [0.0, 0.1]
    assert reader.header.team.landmarks.shape == (0, 2)
    assert np.isinf(reader.header.team.arena).all()


def test_frames_can_be_read_twice(log):
    reader = LogReader(log)
    assert len(list(reader.frames())) == len(list(reader.frames())) == 4


def test_a_killed_run_leaves_its_whole_frames_and_then_the_line_that_is_cut_off(log):
    text = log.read_bytes()
    log.write_bytes(text[:-5])
    frames, last = LogReader(log).frames(), text.count(b"\n")
    assert [next(frames).time for _ in range(3)] == [0.0, 0.1, 0.2]
    with pytest.raises(InvalidLog, match=rf"line {last}: .*truncated"):
        next(frames)


def test_records_without_a_frame_at_the_end_are_reported(log):
    lines = log.read_text().splitlines(keepends=True)
    log.write_text("".join(lines[:-1]))
    with pytest.raises(InvalidLog, match=rf"line {len(lines) - 1}: .*cut off"):
        list(LogReader(log).frames())


def changed(log, line, change):
    """Change one record of a log: line from 0 on, negative from the end."""
    lines = log.read_text().splitlines()
    record = json.loads(lines[line])
    change(record)
    lines[line] = json.dumps(record)
    log.write_text("\n".join(lines) + "\n")
    return line % len(lines) + 1


def lines_of(log, kind):
    return [k for k, line in enumerate(log.read_text().splitlines()) if json.loads(line)["record"] == kind]


def refused(log, line, match):
    with pytest.raises(InvalidInput, match=match) as caught:
        list(LogReader(log).frames())
    assert isinstance(caught.value, InvalidLog)
    assert caught.value.line == line
    assert str(caught.value).startswith(f"{log}, line {line}: expected ")


FAULTS = {
    "an unknown kind of record": ("bearing", lambda r: r.update(record="sonar"), "sonar"),
    "a kind that is no name": ("bearing", lambda r: r.update(record=3), "record"),
    "a second header": ("bearing", lambda r: r.update(record="header"), "header"),
    "a late initial set": ("bearing", lambda r: r.update(record="initial"), "initial"),
    "an unknown field": ("bearing", lambda r: r.update(sigma=1.0), "sigma"),
    "an unknown field of a frame": ("frame", lambda r: r.update(sigma=1.0), "sigma"),
    "a missing field": ("bearing", lambda r: r.pop("bound"), '"bound"'),
    "no target at all": ("bearing", lambda r: (r.pop("target"), r.pop("landmark")), "target"),
    "target and landmark at once": ("bearing", lambda r: r["target"].__setitem__(1, 2), "either a target or a landmark"),
    "neither target nor landmark": ("bearing", lambda r: r["target"].__setitem__(0, None), "either a target or a landmark"),
    "columns of several lengths": ("bearing", lambda r: r["bearing"].pop(), "one length"),
    "targets and landmarks of several lengths": ("bearing", lambda r: r["landmark"].pop(), "either a target or a landmark"),
    "an unknown robot": ("bearing", lambda r: r["robot"].__setitem__(0, 3), "0 to 2"),
    "no robot": ("bearing", lambda r: r["robot"].__setitem__(0, None), "0 to 2"),
    "a negative robot": ("compass", lambda r: r["robot"].__setitem__(0, -1), "0 to 2"),
    "a robot that is no whole number": ("compass", lambda r: r["robot"].__setitem__(0, 1.0), "0 to 2"),
    "an unknown target": ("bearing", lambda r: r["target"].__setitem__(0, 3), "0 to 2"),
    "an unknown landmark": ("bearing", lambda r: r["landmark"].__setitem__(1, 2), "0 to 1"),
    "a robot that measures itself": ("bearing", lambda r: r["robot"].__setitem__(0, 1), "itself"),
    "a word for a number": ("bearing", lambda r: r["bearing"].__setitem__(0, "0.5"), "numbers"),
    "true for a number": ("bearing", lambda r: r["bearing"].__setitem__(0, True), "numbers"),
    "null for a number": ("bearing", lambda r: r["bearing"].__setitem__(0, None), "numbers"),
    "a list in a list": ("bearing", lambda r: r["bearing"].__setitem__(0, [0.5]), "numbers"),
    "a list for a time": ("frame", lambda r: r.update(time=[0.1]), "a number"),
    "an endless whole number": ("frame", lambda r: r.update(time=10**400), "finite"),
    "NaN": ("bearing", lambda r: r["bearing"].__setitem__(0, float("nan")), "NaN"),
    "NaN for a position": ("truth", lambda r: r["positions"][0].__setitem__(0, float("nan")), "NaN"),
    "infinity": ("odometry", lambda r: r["distance"].__setitem__(0, float("inf")), "Infinity"),
    "a negative bound": ("odometry", lambda r: r["distance_bound"].__setitem__(0, -0.1), "distance bound"),
    "a robot that moves twice": ("odometry", lambda r: r["robot"].__setitem__(0, 1), "once"),
    "odometry that ends before it starts": ("odometry", lambda r: r.update(time=-1.0), "ends at its start"),
    "a measurement of another time": ("bearing", lambda r: r.update(time=0.05), "0.1 s; came 0.05 s"),
    "a truth of too few robots": ("truth", lambda r: r["positions"].pop(), "truth of 3 robots"),
    "a truth without headings": ("truth", lambda r: r.update(headings=0.1), "truth of 3 robots"),
    "a point in space": ("truth", lambda r: r["positions"][0].append(0.0), "points"),
    "positions that are no list": ("truth", lambda r: r.update(positions="here"), "points"),
    "header: another format": ("header", lambda r: r.update(format="bag"), "corral-log"),
    "header: a version to come": ("header", lambda r: r.update(version=3), "version 3"),
    "header: no version": ("header", lambda r: r.pop("version"), '"version"'),
    "header: no robots": ("header", lambda r: r.update(robots=0), "number of robots"),
    "header: half a robot": ("header", lambda r: r.update(robots=2.5), "whole number"),
    "header: a negative speed": ("header", lambda r: r.update(speed_limit=-1), "speed limit"),
    "header: an arena inside out": ("header", lambda r: r["arena"][0].__setitem__(0, 9), "arena"),
    "header: a flat arena": ("header", lambda r: r.update(arena=[]), "arena"),
    "header: a rate of nothing": ("header", lambda r: r.update(rate=0), "rate"),
    "header: something else": ("header", lambda r: r.update(name="x"), "name"),
    "initial: an unknown robot": ("initial", lambda r: r.update(robot=3), "0 to 2"),
    "initial: no vertex": ("initial", lambda r: r.update(vertices=[]), "at least one point"),
    "initial: half a heading": ("initial", lambda r: r.update(heading={"centre": 0.0}), '"bound"'),
    "initial: a negative bound": ("initial", lambda r: r.update(heading={"centre": 0.0, "bound": -1.0}), "heading bound"),
    "initial: a number for a heading": ("initial", lambda r: r.update(heading=0.0), "an object or null"),
    "initial: another record": ("initial", lambda r: r.update(record="frame"), '"initial"'),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_refused_with_its_line(log, fault):
    kind, change, match = FAULTS[fault]
    line = changed(log, lines_of(log, kind)[0], change)
    refused(log, line, match)


def test_a_second_initial_set_of_a_robot_is_refused(log):
    line = changed(log, 2, lambda record: record.update(robot=0))
    refused(log, line, "r0 again")


@pytest.mark.parametrize(
    ("time", "said"), [(0.1, "after the last frame"), (0.05, "a time from 0.1 s on; came 0.05 s, which is too late")]
)
def test_time_that_does_not_advance_is_refused(log, time, said):
    line = changed(
        log,
        lines_of(log, "odometry")[1],
        lambda record: record.update(start=0.1, time=time) if time == 0.1 else record.update(start=0.0, time=time),
    )
    refused(log, line, said)


def test_odometry_may_begin_at_a_stamp_of_its_own(log):
    """What is not known before that, the limits tell."""
    before = list(LogReader(log).frames())
    changed(log, lines_of(log, "odometry")[1], lambda record: record.update(start=0.15))
    after = list(LogReader(log).frames())
    assert [frame.time for frame in after] == [frame.time for frame in before]
    assert (after[2].odometry.slip_bound > before[2].odometry.slip_bound[after[2].odometry.robot]).all()


def test_a_frame_before_the_start_is_refused(log):
    changed(log, 0, lambda record: record.update(start=0.05))
    refused(log, lines_of(log, "truth")[0] + 1, "from the start")


def test_odometry_at_the_start_is_refused(tmp_path):
    frame = Frame(0.0, odometry(np.random.default_rng(0), 0.0, 0.0), (), None)
    refused(write(tmp_path / "log.jsonl", [frame]), 5, "no odometry at the start")


def test_a_second_truth_and_a_second_odometry_of_a_robot_are_refused(log):
    lines = log.read_text().splitlines(keepends=True)
    for kind, match in (("truth", "one truth"), ("odometry", "r0 again")):
        where = lines_of(log, kind)[0]
        doubled = log.with_name(f"{kind}.jsonl")
        doubled.write_text("".join([*lines[: where + 1], lines[where], *lines[where + 1 :]]))
        refused(doubled, where + 2, match)


@pytest.mark.parametrize(
    "text",
    ["", "\n", "[]\n", "{\n", "nonsense\n", "[" * 100_000 + "\n", "\xff\n", '{"record": "header", "record": "header"}\n'],
)
def test_what_is_no_log_at_all_is_refused(tmp_path, text):
    path = tmp_path / "log.jsonl"
    path.write_bytes(text.encode("latin-1"))
    with pytest.raises(InvalidLog, match=re.escape(str(path))):
        LogReader(path)


def test_a_log_without_its_header_is_refused(log):
    log.write_text("".join(log.read_text().splitlines(keepends=True)[1:]))
    refused(log, 1, 'a record "header"')


def test_a_log_that_ends_before_its_initial_sets_or_its_first_frame_is_refused(log):
    lines = log.read_text().splitlines(keepends=True)
    log.write_text("".join(lines[:3]))
    refused(log, 3, "3 initial sets; came 2")
    log.write_text("".join(lines[:4]))
    refused(log, 4, "at least one frame")


def test_a_log_that_is_not_there_is_refused(tmp_path):
    with pytest.raises(InvalidLog, match="a readable log"):
        LogReader(tmp_path / "nothing.jsonl")
    with pytest.raises(InvalidLog, match="a readable log"):
        LogReader(tmp_path)


def test_odometry_may_come_a_line_a_robot(log, tmp_path):
    lines = []
    for text in log.read_text().splitlines():
        record = json.loads(text)
        if record["record"] == "odometry":
            columns = [name for name, value in record.items() if isinstance(value, list)]
            lines += [json.dumps(record | {name: record[name][robot] for name in columns}) for robot in range(3)]
        else:
            lines.append(text)
    alone = tmp_path / "alone.jsonl"
    alone.write_text("\n".join(lines) + "\n")
    frames = zip(LogReader(log).frames(), LogReader(alone).frames(), strict=True)
    assert all(same_records(a.odometry, b.odometry) for a, b in frames if a.odometry is not None)


def test_the_example_in_the_documentation_writes_a_log(tmp_path, monkeypatch):
    text = (Path(__file__).parents[2] / "docs" / "log.md").read_text()
    (program,) = re.findall(r"```python\n(.*?)```", text, re.DOTALL)
    monkeypatch.chdir(tmp_path)
    exec(program, {})  # the reader's own words
    frames = list(LogReader(tmp_path / "log.jsonl").frames())
    assert [len(frame.measurements) for frame in frames] == [0, 3]
    (sample,) = re.findall(r"```json\n(.*?)```", text, re.DOTALL)
    (tmp_path / "sample.jsonl").write_text(sample)
    records = list(LogReader(tmp_path / "sample.jsonl").records())
    assert len(records) == len(sample.splitlines()) - 3
    assert records[4].bound == pytest.approx(0.3)
    assert [each.__class__.__name__ for each in records[-3:]] == ["FrameEnd", "Left", "Joined"]


def test_what_was_a_log_of_version_1_is_one_for_ever():
    reader = LogReader(Path(__file__).with_name("version_1.jsonl"))
    first, second = reader.frames()
    assert (first.time, first.measurements, first.odometry, first.truth) == (0.0, (), None, None)
    assert second.odometry.distance.tolist() == [0.03, 0.0]
    compass, bearing, distance = second.measurements
    assert (compass.robot.tolist(), compass.heading.tolist(), compass.bound.tolist()) == ([1], [-2.9], [0.05])
    assert (bearing.target.tolist(), bearing.bearing.tolist(), bearing.bound.tolist()) == ([1, 2], [-0.3, 0.15], [0.05, 0.05])
    assert (distance.target.tolist(), distance.range.tolist(), distance.relative_bound.tolist()) == ([1], [3.7], [0.05])
    assert second.truth.headings.tolist() == [0.42, -2.88]
    assert reader.initial[0].heading == (0.4, 0.1)
