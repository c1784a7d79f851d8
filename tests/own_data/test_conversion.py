"""The order of records, what comes late, the start, and that a log is there as a whole or not at all."""

import errno
import json
from pathlib import Path

import numpy as np
import pytest
from helpers.own_data.settings_files import OF_TABLES, of_robots
from hypothesis import given
from hypothesis import strategies as st

from experiments.convert import main
from experiments.own_data.conversion import Entry, ordered
from experiments.own_data.driven import Increment, Pose, increment, relative, shared
from experiments.show.command import BAD_INPUT, CANNOT_WRITE
from filter import InvalidInput

SECOND = 10**9


def entries(stamps):
    return [Entry(stamp, 0, number, f"message {number}", "/topic", {}) for number, stamp in enumerate(stamps)]


@given(st.lists(st.integers(0, 10**10)))
def test_entries_come_out_in_order_if_none_is_too_late(stamps):
    came = list(ordered(entries(stamps), 10.0))
    assert came == sorted(entries(stamps), key=lambda entry: (entry.stamp, entry.number))


@given(st.lists(st.integers(0, 3 * SECOND)), st.integers(0, 3))
def test_an_entry_that_is_too_late_is_refused_and_no_other(stamps, lateness):
    late = any(stamp < max(stamps[: k + 1]) - lateness * SECOND for k, stamp in enumerate(stamps))
    if not late:
        assert len(list(ordered(entries(stamps), lateness))) == len(stamps)
        return
    with pytest.raises(InvalidInput, match=r"lateness = SECONDS"):
        list(ordered(entries(stamps), lateness))


def test_memory_holds_only_what_may_still_be_overtaken():
    waiting = most = 0

    def arriving():
        nonlocal waiting, most
        for entry in entries(range(0, 1000 * SECOND, SECOND)):
            waiting += 1
            most = max(most, waiting)
            yield entry

    for _ in ordered(arriving(), 5.0):
        waiting -= 1
    assert most <= 8


@given(st.lists(st.floats(-10, 10), min_size=6, max_size=6))
def test_an_increment_leads_from_one_pose_to_the_other(numbers):
    first, last = Pose(*numbers[:3]), Pose(*numbers[3:])
    moved = increment(first, last)
    way = first.heading + moved.turn / 2
    along, left = np.array([np.cos(way), np.sin(way)]), np.array([-np.sin(way), np.cos(way)])
    assert np.array(first[:2]) + moved.forward * along + moved.aside * left == pytest.approx(np.array(last[:2]), abs=1e-9)
    assert np.exp(1j * (first.heading + moved.turn)) == pytest.approx(np.exp(1j * last.heading))


@given(st.floats(-2, 2), st.floats(-2, 2), st.floats(0, 1), st.booleans())
def test_nothing_of_an_increment_is_lost_when_it_is_shared_out(forward, aside, least, sideways):
    distance, direction, slip = shared(Increment(forward, aside, 0.0), least, sideways=sideways)
    said = distance * np.array([np.cos(direction), np.sin(direction)])
    assert np.hypot(*(said - [forward, aside])) <= slip + 1e-12


@given(st.floats(-5, 5), st.floats(0, 1), st.floats(0, 0.9), st.floats(-1, 1))
def test_a_relative_bound_holds_for_the_true_value(true, bound, share, error):
    measured = true + error * (bound + share * abs(true))
    assert abs(measured - true) <= relative(bound, share, measured) + 1e-12


@pytest.fixture
def convert(tmp_path, capsys):
    """Return a function that converts tables; it returns exit code, all records, and what was told."""

    def convert(files, settings):
        for name, text in files.items():
            (tmp_path / name).write_text(text)
        (tmp_path / "my.toml").write_text(settings)
        code = main([str(tmp_path / "my.toml"), str(tmp_path), str(tmp_path / "out.jsonl")])
        out = tmp_path / "out.jsonl"
        records = [json.loads(line) for line in out.read_text().splitlines()] if out.exists() else []
        return code, records, capsys.readouterr().err

    return convert


MOTION = "longest = 1.0, distance_bound = 0.1, turn_bound = 0.1, direction_bound = 0.1, slip_bound = 0.1"
STREAMS = {
    "odometry": f'file = "odom.csv", distance = "d", turn = "w", {MOTION}, distance_relative_bound = 0.5',
    "compass": 'file = "imu.csv", bound = 0.1',
}
FILES = {"odom.csv": "t,d,w\n0.5,0,0\n1.0,0.2,0.1\n1.5,0.2,0.1\n", "imu.csv": "t,heading\n1.0,0.5\n0.75,0.4\n1.5,0.6\n"}


def test_records_come_in_the_order_of_stamps_then_kinds_and_the_start_is_the_earliest_time(convert):
    code, records, _ = convert(FILES, of_robots(OF_TABLES, **STREAMS))
    assert code == 0
    assert records[0]["start"] == 0.5
    assert [(record["record"], record["time"]) for record in records[3:]] == [
        ("compass", 0.75),
        ("odometry", 1.0),
        ("compass", 1.0),
        ("odometry", 1.5),
        ("compass", 1.5),
    ]
    assert records[4]["distance_bound"] == 0.1 + 0.5 * 0.3 / 0.5


def test_what_is_before_a_declared_start_is_left_out(convert):
    code, records, told = convert(FILES, of_robots(OF_TABLES.replace("[team]", "[team]\nstart = 0.9"), **STREAMS))
    assert code == 0
    assert [(record["record"], record["time"]) for record in records[3:]] == [
        ("compass", 1.0),
        ("odometry", 1.5),
        ("compass", 1.5),
    ]
    assert "left out: imu.csv, CSV, 1 records: it is before the start" in told
    assert "left out: odom.csv, CSV, 1 records: it is before the start" in told


def test_clocks_that_differ_are_told_and_an_offset_mends_them(convert):
    files = FILES | {"imu.csv": "t,heading\n101.0,0.5\n"}
    code, _, told = convert(files, of_robots(OF_TABLES, **STREAMS))
    assert code == BAD_INPUT or "lateness" not in told
    files |= {"imu.csv": "t,heading\n100.5,0.5\n0.5,0.5\n"}
    code, _, told = convert(files, of_robots(OF_TABLES, **STREAMS))
    assert code == BAD_INPUT
    assert "imu.csv, line 3: a stamp at most 10 s older than one that came before" in told
    offset = STREAMS | {"compass": STREAMS["compass"] + ", clock_offset = -100"}
    code, records, _ = convert(files | {"imu.csv": "t,heading\n100.75,0.5\n"}, of_robots(OF_TABLES, **offset))
    assert code == 0
    assert [record["time"] for record in records[3:]] == [0.75, 1.0, 1.5]


def test_a_log_that_cannot_be_written_leaves_the_old_one(convert, tmp_path, monkeypatch):
    (tmp_path / "out.jsonl").write_text('{"old": true}\n')

    def full(*_):
        raise OSError(errno.ENOSPC, "No space left on device")

    monkeypatch.setattr("experiments.own_data.conversion.os.fsync", full)
    code, records, _ = convert(FILES, of_robots(OF_TABLES, **STREAMS))
    assert (code, records) == (CANNOT_WRITE, [{"old": True}])
    assert [path.name for path in Path(tmp_path).iterdir() if path.name.startswith(".")] == []


def test_what_is_read_is_never_written_over(convert, tmp_path):
    convert(FILES, of_robots(OF_TABLES, **STREAMS))
    for out in ("my.toml", "imu.csv", "", "/dev/null"):
        before = (tmp_path / "imu.csv").read_bytes()
        assert main([str(tmp_path / "my.toml"), str(tmp_path / "imu.csv"), str(tmp_path / out)]) == BAD_INPUT
        assert (tmp_path / "imu.csv").read_bytes() == before
    assert not Path("/dev/null").is_file()


def test_bad_input_on_the_way_leaves_the_old_log(convert, tmp_path):
    (tmp_path / "out.jsonl").write_text('{"old": true}\n')
    code, records, _ = convert(FILES | {"imu.csv": "t,heading\n1,0.5\n2,x\n"}, of_robots(OF_TABLES, **STREAMS))
    assert (code, records) == (BAD_INPUT, [{"old": True}])
