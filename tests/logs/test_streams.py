"""Logs of version 2: names, limits of single robots, streams at their own rates, whatever a robot can say."""

import json
from dataclasses import fields, replace
from itertools import pairwise

import numpy as np
import pytest

from experiments.logs import FrameEnd, Header, InitialSet, InvalidLog, Joined, LogReader, LogWriter, TruthAt
from filter import (
    Bearing,
    Compass,
    Frame,
    InvalidInput,
    Left,
    Odometry,
    Polygon,
    Position,
    Range,
    RelativeHeading,
    Sensor,
    Team,
    Truth,
    Twist,
)

MARKS = {"gate": [0.1, 0.2], "door": [1 / 3, -2e-17]}
ARENA = [[-6, -np.inf], [6, np.inf]]
SENSORS = Sensor("camera", [1 / 3, -1e-9], 0.1, -3.0, 1 / 7), Sensor("UWB tag"), Sensor("back", angle=np.pi)
NAMED = Team(
    ["alice", "bob", "3"],
    MARKS,
    {"alice": 0.7, "bob": 0, "3": 1 / 3},
    1.5,
    ARENA,
    acceleration_limit=[1, np.inf, 2],
    sensors=SENSORS,
)
PLAIN = Team(3, list(MARKS.values()), arena=ARENA, sensors=SENSORS)
SQUARE = np.array([[1.0, 1.0], [2.0, 1.0], [2.0, 2.0], [1.0, 2.0]])
START = [InitialSet(SQUARE), InitialSet(SQUARE + 1 / 3, (0.1, 0.2)), InitialSet()]
HEADERS = {"named": Header(NAMED, -0.5), "plain": Header(PLAIN, -0.5, 10.0, version=2)}


def records_of(generator):
    """Records of every kind, in no order of time."""
    values = generator.uniform(0, 1, (7, 2))
    return [
        Odometry(0.0, 0.1, [2, 0], *values),
        Odometry(0.05, 0.1, 1, *generator.uniform(0, 1, 6)),
        Twist(0.07, [0, 1], *values[:6], hold=0.5),
        Twist(0.07, 2, *generator.uniform(0, 1, 8)),
        Compass(0.03, [2, 0], generator.normal(size=2), 0.05),
        Bearing(0.1, [0, 1, 2], [1, 3, 4], generator.normal(size=3), 0.1),
        Range(0.1, [1], [4], [3.0], 0.0, 0.02),
        Compass(0.03, [2, 0], generator.normal(size=2), 0.05, 2),
        Bearing(0.1, [0, 1, 2], [1, 3, 4], generator.normal(size=3), 0.1, [0, -1, 1], [1, -1, -1]),
        Range(0.1, [1, 2], [4, 0], [3.0, 1 / 3], 0.0, 0.02, [-1, 1]),
        Range(0.1, [], [], [], [], []),
        RelativeHeading(0.1, [1, 2], [2, 0], generator.normal(size=2), 0.1),
        RelativeHeading(0.1, [0, 1], [1, 0], generator.normal(size=2), [0.0, np.pi], [2, -1], [-1, 1]),
        RelativeHeading(0.1, [], [], [], []),
        Position.fix(0.2, 1, [1 / 3, 4e5], [0.1, 0.3]),
        Position.disc(0.2, 1, [1 / 3, 4e5], 0.1),
        Position.fix(0.2, 1, [1 / 3, 4e5], [0.1, 0.3], 1),
        Position(0.2, [0, 1, 1], [1, 0, 0], [0, 1, -1], [1, 2, 3], [-1, 2, 0]),
        Joined(0.3, 1, InitialSet(SQUARE / 3)),
        Left(0.4, 2),
        TruthAt(0.4, np.array([1]), Truth([[np.nan, np.nan]], [0.5])),
        TruthAt(0.4, np.arange(3), Truth([[1, 2], [np.nan, np.nan], [3, 4]], [0.5, 1, np.nan])),
        FrameEnd(0.4),
    ]


def told(record):
    """Return all that a record is, to the last bit."""
    values = (
        record._asdict() if isinstance(record, tuple) else {each.name: getattr(record, each.name) for each in fields(record)}
    )
    return type(record), {name: _told(value) for name, value in values.items()}


def _told(value):
    if isinstance(value, np.ndarray):
        return value.dtype, value.shape, value.tobytes()
    if isinstance(value, tuple):
        return tuple(map(_told, value))
    return told(value) if hasattr(value, "__dict__") else value


@pytest.fixture(params=HEADERS)
def log(request, tmp_path):
    with LogWriter(tmp_path / "log.jsonl", HEADERS[request.param], START) as log:
        for record in records_of(np.random.default_rng(3)):
            log.append(record)
    return tmp_path / "log.jsonl"


def test_a_log_gives_back_the_same_records_bit_for_bit(log):
    again = list(LogReader(log).records())
    assert [*map(told, again)] == [*map(told, records_of(np.random.default_rng(3)))]


def test_a_log_gives_back_the_same_team_and_initial_sets_bit_for_bit(log):
    reader = LogReader(log)
    team = NAMED if reader.header.team.is_named else PLAIN
    assert told(reader.header.team) == told(team)
    assert (reader.header.start, reader.header.version) == (-0.5, 2)
    assert [*map(told, reader.initial)] == [*map(told, START)]


def test_a_copy_of_a_log_is_the_same_file(log, tmp_path):
    reader = LogReader(log)
    with LogWriter(tmp_path / "copy.jsonl", reader.header, reader.initial) as copy:
        for record in reader.records():
            copy.append(record)
    assert (tmp_path / "copy.jsonl").read_bytes() == log.read_bytes()


def test_who_has_a_name_is_called_by_it(log):
    named = LogReader(log).header.team.is_named
    assert (b'"alice"' in log.read_bytes()) == (b'"gate"' in log.read_bytes()) == named


def test_frames_of_version_2_are_those_of_version_1(tmp_path):
    frames = [
        Frame(0.0, None, (Compass(0.0, 1, 0.5, 0.1), Range(0.0, 0, 4, 3.0, 0.1, 0.0)), Truth(np.ones((3, 2)), np.ones(3))),
        Frame(0.1, Odometry(0.0, 0.1, [0, 2], *np.ones((6, 2)))),
    ]
    copies = {}
    for version in (1, 2):
        header = Header(PLAIN, 0.0, 10.0, version)
        with LogWriter(tmp_path / f"{version}.jsonl", header, START) as log:
            for frame in frames:
                log.write(frame)
        copies[version] = (tmp_path / f"{version}.jsonl").read_text()
        reader = LogReader(tmp_path / f"{version}.jsonl")
        for frame, copy in zip(frames, reader.frames(), strict=True):
            assert told(frame.truth) == told(copy.truth) if frame.truth else copy.truth is None
            assert [*map(told, frame.measurements)] == [*map(told, copy.measurements)]
            assert told(frame.odometry) == told(copy.odometry) if frame.odometry else copy.odometry is None
    assert copies[1].replace('"version": 1', '"version": 2') == copies[2]


HEAD = {"format": "corral-log", "version": 2, "robots": ["alice", "bob"], "landmarks": {"gate": [0, 1]}}
HEAD |= {"arena": [[-5, -5], [5, 5]], "speed_limit": 0.5, "turn_rate_limit": {"alice": 1, "bob": 0}, "start": 0}


def text_of(*lines, **changed):
    head = {name: value for name, value in {**HEAD, **changed}.items() if value != "gone"}
    initial = [{"record": "initial", "robot": robot, "vertices": None, "heading": None} for robot in (0, 1)]
    return "".join(json.dumps(each) + "\n" for each in ({"record": "header", **head}, *initial, *lines))


def read(path, *lines, **changed):
    path.write_text(text_of(*lines, **changed))
    return list(LogReader(path).records())


def test_the_truth_of_single_robots_is_put_together(tmp_path):
    alice = {"record": "truth", "time": 1, "robot": "alice", "position": [1, 2], "heading": None}
    bob = {"record": "truth", "time": 1, "robot": 1, "position": None, "heading": 0.5}
    path, frame = tmp_path / "log.jsonl", {"record": "frame", "time": 1}
    path.write_text(text_of(bob, alice, frame))
    (found,) = LogReader(path).frames()
    assert told(found.truth) == told(Truth([[1, 2], [np.nan, np.nan]], [np.nan, 0.5]))
    path.write_text(text_of(bob, frame))
    (found,) = LogReader(path).frames()
    assert told(found.truth) == told(Truth(np.full((2, 2), np.nan), [np.nan, 0.5]))
    path.write_text(text_of(bob, alice, bob, frame))
    with pytest.raises(InvalidLog, match=r"line 6: .*one truth of each robot a frame; came another of bob"):
        list(LogReader(path).frames())


POSITIONS = [
    ({"position": [1, 2], "bound": 0.5}, Position.fix(1.0, 1, [1, 2], 0.5)),
    ({"position": [1, 2], "bound": [0.5, 0]}, Position.fix(1.0, 1, [1, 2], [0.5, 0])),
    ({"position": [1, 2], "radius": 0.5}, Position.disc(1.0, 1, [1, 2], 0.5)),
    ({"vertices": SQUARE.tolist()}, Position.within(1.0, 1, Polygon.from_vertices(SQUARE))),
    ({"normal": [3, 4], "offset": 2}, Position.half_plane(1.0, 1, [3, 4], 2)),
    ({"normal_x": [1, 0], "normal_y": [0, -1], "offset": 2}, Position(1.0, 1, [1, 0], [0, -1], 2)),
]


@pytest.mark.parametrize(("fields", "expected"), POSITIONS, ids=[" ".join(fields) for fields, _ in POSITIONS])
def test_a_position_has_many_forms(tmp_path, fields, expected):
    (found,) = read(tmp_path / "log.jsonl", {"record": "position", "time": 1, "robot": "bob", **fields})
    assert told(found) == told(expected)
    line = {"record": "position", "time": 1, "robot": "bob", "sensor": "tag", **fields}
    (by_antenna,) = read(tmp_path / "log.jsonl", line, sensors={"tag": {"position": [1, 0]}})
    assert told(by_antenna) == told(replace(expected, sensor=np.zeros(len(expected.robot), dtype=np.int64)))


def test_numbers_will_do_and_names_are_given_to_what_has_none(tmp_path):
    line = {"record": "bearing", "time": 1, "robot": "r0", "landmark": "l1", "bearing": 0, "bound": 0.1}
    (found,) = read(tmp_path / "log.jsonl", line, robots=2, landmarks=[[0, 0], [1, 1]], turn_rate_limit=1)
    assert (found.robot.tolist(), found.target.tolist()) == ([0], [3])


def test_limits_are_of_all_or_of_each(tmp_path):
    path = tmp_path / "log.jsonl"
    read(path, acceleration_limit={"alice": 2, "bob": None})
    team = LogReader(path).header.team
    assert team.turn_rate_limit.tolist() == [1.0, 0.0]
    assert team.acceleration_limit.tolist() == [2.0, np.inf]


COMPASS = {"record": "compass", "time": 1, "robot": "bob", "heading": 0.5, "bound": 0.1}
RANGE = {"record": "range", "time": 1, "robot": "bob", "target": "alice", "range": 2, "bound": 0.1, "relative_bound": 0}
MATE = {"record": "relative_heading", "time": 1, "robot": "bob", "target": "alice", "heading": 2, "bound": 0.1}
FIX = {"record": "position", "time": 1, "robot": "bob", "position": [1, 2], "bound": 0.1}
FAULTS = {
    "a name that nobody has": ({**COMPASS, "robot": "bop"}, "robot: a name, as bob; came .bop."),
    "a name like no other": ({**COMPASS, "robot": "xyz"}, 'whole numbers from 0 to 1, or names, as "alice"; came .xyz.'),
    "a number that nobody has": ({**COMPASS, "robot": 2}, "whole numbers from 0 to 1, or names"),
    "a landmark that sees": ({**COMPASS, "robot": "gate"}, "robot: whole numbers from 0 to 1, or names"),
    "a landmark for a robot": ({**RANGE, "target": "gate"}, "target: whole numbers from 0 to 1, or names"),
    "a robot for a landmark": ({**RANGE, "landmark": "alice"}, "landmark: whole numbers from 0 to 0, or names"),
    "a pair the wrong way round": ({**COMPASS, "bound": [0.2, 0.1]}, "pairs .low, high., the lower one first"),
    "a pair of three": ({**COMPASS, "bound": [0.2, 0.1, 0.3]}, "bound: a number or a pair"),
    "a pair of three in a list": ({**COMPASS, "robot": [0, 1], "bound": [[0.2, 0.1, 0.3], 0]}, "bound: numbers or pairs"),
    "a pair that is too wide": ({**COMPASS, "bound": [-4, 4]}, "compass bound"),
    "a pair of words": ({**COMPASS, "bound": ["a", "b"]}, "bound: numbers"),
    "lists of several lengths": ({**COMPASS, "robot": ["alice", "bob"], "bound": [0.1]}, "compass: lists of one length"),
    "a list of one among more": ({**RANGE, "robot": ["bob"], "bound": [0.0, 0.6]}, "range: lists of one length"),
    "a bound and a radius": ({**FIX, "radius": 1}, "position: no further field; came .bound."),
    "a landmark that has a heading": (
        {**{name: MATE[name] for name in MATE if name != "target"}, "landmark": "gate"},
        'a field "target"',
    ),
    "a heading of a landmark as well": ({**MATE, "landmark": None}, "relative_heading: no further field; came .landmark."),
    "a heading of nobody": ({**MATE, "target": None}, "target: whole numbers from 0 to 1, or names.*null"),
    "a heading of oneself": ({**MATE, "target": "bob"}, "relative heading: a target other than the robot"),
    "a mate's heading in degrees": ({**MATE, "heading": 90}, "relative heading .rad.: no more than four turns"),
    "a position without a bound": ({name: FIX[name] for name in FIX if name != "bound"}, 'a field "bound"'),
    "a position in space": ({**FIX, "position": [1, 2, 3]}, "position: .x, y."),
    "a normal of nothing": ({**POSITIONS[4][0], "normal": [0, 0], "record": "position", "time": 1, "robot": 0}, "a direction"),
    "a robot that joins nowhere": ({"record": "initial", "robot": "bob", "vertices": None, "heading": None}, 'a field "time"'),
    "a robot that leaves for good": ({"record": "leave", "robot": "bob", "time": 1, "until": 2}, "no further field"),
    "a truth of half a point": ({"record": "truth", "time": 1, "robot": 0, "position": [1, None], "heading": 0}, "numbers"),
    "a truth of one and of all": (
        {"record": "truth", "time": 1, "robot": 0, "positions": [], "headings": []},
        "truth of 2 robots",
    ),
    "an unknown kind of record": (
        {"record": "sonar", "time": 1},
        "a record among odometry, .*, twist, position, relative_heading, initial, leave",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_is_refused_with_its_line(tmp_path, fault):
    line, match = FAULTS[fault]
    with pytest.raises(InvalidLog, match=match) as caught:
        read(tmp_path / "log.jsonl", COMPASS, line)
    assert caught.value.line == 5


HEADS = {
    "the same name twice": ({"robots": ["alice", "alice"]}, "no two alike"),
    "a robot called as a landmark is": ({"robots": ["alice", "gate"], "turn_rate_limit": 1}, "no two alike"),
    "a name of nothing": ({"robots": ["alice", ""]}, "names of letters"),
    "a number for a name": ({"robots": ["alice", 3]}, "robots: names; came 3"),
    "no robot": ({"robots": [], "turn_rate_limit": 1}, "number of robots"),
    "half a robot": ({"robots": 2.5}, "whole number"),
    "a landmark in space": ({"landmarks": {"gate": [0, 1, 2]}}, "landmarks: gate: .x, y."),
    "a limit of nobody": ({"turn_rate_limit": {"alice": 1, "bop": 1}}, "turn_rate_limit: one for each of alice, bob"),
    "a limit that is missing": ({"turn_rate_limit": {"alice": 1}}, "turn_rate_limit: one for each of alice, bob"),
    "a limit that is no number": ({"turn_rate_limit": {"alice": 1, "bob": None}}, "turn_rate_limit: bob: a number"),
    "a negative limit": ({"speed_limit": -1}, "speed limit"),
    "a limit of acceleration that is no number": ({"acceleration_limit": True}, "acceleration_limit: a number"),
    "no limit": ({"speed_limit": "gone"}, '"speed_limit"'),
    "a rate of nothing": ({"rate": 0}, "rate: a number above 0"),
    "something else": ({"lights": {}}, "header: no further field"),
    "a sensor that is none": ({"sensors": {"camera": {"place": [0, 1]}}}, "sensors: camera: no further field"),
}


@pytest.mark.parametrize("fault", HEADS)
def test_a_header_at_fault_is_refused(tmp_path, fault):
    changed, match = HEADS[fault]
    with pytest.raises(InvalidLog, match=f"line 1: .*{match}"):
        read(tmp_path / "log.jsonl", **changed)


def test_a_log_needs_no_frames(tmp_path):
    path, later = tmp_path / "log.jsonl", {**COMPASS, "time": COMPASS["time"] + 0.5}
    for lines, times in (([COMPASS], [COMPASS["time"]]), ([COMPASS, later], [COMPASS["time"], later["time"]])):
        path.write_text(text_of(*lines))
        assert [frame.time for frame in LogReader(path).frames()] == times


def test_a_log_of_version_1_takes_what_version_1_has(tmp_path):
    header, records = Header(replace(PLAIN, sensors=()), -0.5), records_of(np.random.default_rng(3))
    there = [records[1], *records[4:7], records[10], records[-1]]  # positions and mates' headings are none of them
    with LogWriter(tmp_path / "log.jsonl", header, START) as log:
        for record in records:
            if record in there:
                log.append(record)
                continue
            with pytest.raises(InvalidInput, match="a log of version 2"):
                log.append(record)
    assert [*map(type, LogReader(tmp_path / "log.jsonl").records())] == [*map(type, there)]


def test_times_of_a_stream_come_as_they_come(log):
    times = [record.time for record in LogReader(log).records()]
    assert any(after < before for before, after in pairwise(times))


def test_there_are_two_versions():
    with pytest.raises(InvalidInput, match="version 1 or 2; came 3"):
        Header(PLAIN, 0.0, version=3)
    assert Header(NAMED, 0.0).version == 2
    assert Header(replace(PLAIN, sensors=()), 0.0).version == Header(Team(3), 0.0).version == 1


def test_a_sensor_that_the_header_does_not_have_is_refused_on_its_line(tmp_path):
    header = Header(Team(2, [[1.0, 2.0]], arena=ARENA, sensors=[Sensor("camera", [0.2, 0.0])]), 0.0)
    assert header.version == 2
    with LogWriter(tmp_path / "log.jsonl", header, START[:2]) as log:
        log.append(Compass(0.0, 0, 0.1, 0.1, 0))
        with pytest.raises(InvalidInput, match="a sensor among the header's 1"):
            log.append(Compass(0.0, 0, 0.1, 0.1, 1))
    lines = (tmp_path / "log.jsonl").read_text()
    for wrong, text in (
        ('"sensor": ["camra"]', "sensor: a name, as camera"),
        ('"sensor": [2]', "sensor: whole numbers from 0 to 0, or names"),
        ('"target_sensor": [0]', 'no further field; came "target_sensor"'),
    ):
        (tmp_path / "log.jsonl").write_text(lines.replace('"sensor": ["camera"]', wrong))
        with pytest.raises(InvalidLog, match=f"line 4.*{text}"):
            list(LogReader(tmp_path / "log.jsonl").records())
    tag = '{"record": "range", "time": 0.0, "robot": 0, "landmark": 0, "range": 1, "bound": 1, "relative_bound": 0, '
    (tmp_path / "log.jsonl").write_text(lines + tag + '"target_sensor": "camera"}\n')
    with pytest.raises(InvalidLog, match=r"line 5.*a target_sensor on a robot"):
        list(LogReader(tmp_path / "log.jsonl").records())
    mounted = '"camera": {"position": [0.2, 0.0], "position_bound": 0.0, "angle": 0.0, "angle_bound": 0.0}'
    for wrong, text in (('"camera": {"positoin": [0.2, 0]}', "no further field"), ('"camera": [0.2, 0]', "an object or null")):
        (tmp_path / "log.jsonl").write_text(lines.replace(mounted, wrong))
        with pytest.raises(InvalidLog, match=f"line 1.*{text}"):
            LogReader(tmp_path / "log.jsonl")
    (tmp_path / "log.jsonl").write_text(lines.replace(mounted, '"camera": {}'))
    (sensor,) = LogReader(tmp_path / "log.jsonl").header.team.sensors
    assert (sensor.name, sensor.position.tolist(), sensor.angle) == ("camera", [0, 0], 0)
