"""The sample: its conversions give one log, the truth keeps every bound, and the same seed gives the same bytes."""

import json
import math

import numpy as np
import pytest

from experiments.convert import main as convert
from experiments.minute.drive import drive
from experiments.minute.measured import ANCHORS, GATE, MINUTE, ROBOTS, START
from experiments.sample import main as sample
from experiments.show.command import BAD_INPUT

FORMS = ("csv", "mcap", "bag")
SECOND = 10**9
ROOM = 1e-12  # what is worked out here is rounded, too


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    folder = tmp_path_factory.mktemp("sample")
    assert sample([str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def records(folder):
    return [json.loads(line) for line in (folder / "minute.jsonl").read_text().splitlines()]


@pytest.fixture(scope="module")
def truth():
    """Return where the robots are at a time [s], as only the simulator knows."""
    driven = drive(len(ROBOTS), MINUTE + 1, np.random.default_rng(0).spawn(1)[0])

    def at(robot, time):
        places, headings = driven.at(round((time - START) * SECOND))
        return places[ROBOTS.index(robot)], float(headings[ROBOTS.index(robot)])

    return at


@pytest.mark.parametrize("form", FORMS)
def test_every_form_becomes_the_same_log_to_the_last_byte(folder, tmp_path, capsys, form):
    out = tmp_path / "out.jsonl"
    assert convert([str(folder / f"minute_{form}.toml"), str(folder / f"minute.{form}"), str(out)]) == 0
    assert out.read_bytes() == (folder / "minute.jsonl").read_bytes()
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("form", FORMS)
def test_settings_are_at_most_fifteen_lines_a_robot(folder, form):
    lines = (folder / f"minute_{form}.toml").read_text().splitlines()
    assert len([line for line in lines if line.strip() and not line.strip().startswith("#")]) <= 15 * len(ROBOTS)


def test_the_same_seed_gives_the_same_bytes_and_another_one_others(folder, tmp_path):
    assert sample([str(tmp_path / "again"), "--seed", "0"]) == 0
    files = sorted(path.relative_to(folder) for path in folder.rglob("*") if path.is_file())
    assert [str(path) for path in files if (folder / path).read_bytes() != (tmp_path / "again" / path).read_bytes()] == []
    assert sample([str(tmp_path / "again"), "--seed", "1"]) == 0
    assert [str(path) for path in files if (folder / path).read_bytes() == (tmp_path / "again" / path).read_bytes()] == []


def test_a_seed_below_zero_is_told(tmp_path):
    assert sample([str(tmp_path), "--seed", "-1"]) == BAD_INPUT


def test_the_robots_start_where_the_settings_say(records, truth):
    for record in records[1:3]:
        place, heading = truth(record["robot"], START)
        assert (np.min(record["vertices"], axis=0) < place).all()
        assert (place < np.max(record["vertices"], axis=0)).all()
        assert off(heading, record["heading"]["centre"]) <= record["heading"]["bound"]


def off(a, b):
    return abs(math.remainder(a - b, 2 * math.pi))


def test_the_truth_keeps_every_bound_of_what_was_measured(records, truth):
    landmarks = records[0]["landmarks"]
    assert set(landmarks) == {GATE, *ANCHORS}
    checked = dict.fromkeys(("compass", "bearing", "range", "truth"), 0)
    for record in (record for record in records if record["record"] in checked):
        (x, y), heading = truth(record["robot"], record["time"])
        checked[record["record"]] += 1
        if record["record"] == "compass":
            assert off(record["heading"], heading) <= record["bound"]
        elif record["record"] == "truth":
            assert record["position"] == [x, y]
            assert off(record["heading"], heading) < ROOM
        else:
            there = landmarks[record["landmark"]] if "landmark" in record else truth(record["target"], record["time"])[0]
            check_sighting(record, there[0] - x, there[1] - y, heading)
    assert min(checked.values()) > 1000


def check_sighting(record, x, y, heading):
    bound = record["bound"]
    if record["record"] == "bearing":
        assert off(record["bearing"], math.atan2(y, x) - heading) <= bound
    else:
        low, high = bound if isinstance(bound, list) else (-bound, bound)
        assert low <= record["range"] - math.hypot(x, y) <= high


def test_the_truth_keeps_every_bound_of_odometry(records, truth):
    """A displacement is a path within its bound, along a direction within its own, and a slip."""
    driven = [record for record in records if record["record"] == "odometry"]
    assert len(driven) == 2 * (50 * MINUTE - 1)
    for record in driven:
        (first, heading), (last, after) = (truth(record["robot"], record[name]) for name in ("start", "time"))
        turn, (x, y) = after - heading, last - first
        way = heading + turn / 2
        forward, aside = x * math.cos(way) + y * math.sin(way), y * math.cos(way) - x * math.sin(way)
        assert abs(record["turn"] - turn) <= record["turn_bound"]
        path = math.copysign(math.hypot(forward, aside), forward)
        assert abs(record["distance"] - path) <= record["distance_bound"] + ROOM
        within = abs(forward) * math.tan(record["direction_bound"])
        assert abs(aside) <= within + record["slip_bound"]


def test_each_stream_has_its_own_rate_and_stamps_of_its_own(records):
    times = {}
    for record in records[3:]:
        about = record.get("target", record.get("landmark", ""))
        kind = "uwb" if record["record"] == "range" and isinstance(record["bound"], list) else record["record"]
        times.setdefault((record["robot"], kind, about if kind == "uwb" else ""), set()).add(record["time"])
    for (_, kind, _), stamps in times.items():
        rate = {"odometry": 50, "compass": 20, "truth": 20, "uwb": 7}.get(kind)
        if rate:
            assert np.diff(sorted(stamps)) == pytest.approx(1 / rate, abs=1e-6)
    shared = [stamps for (robot, kind, _), stamps in times.items() if kind in ("odometry", "compass", "uwb")]
    assert sum(map(len, shared)) == len(set.union(*shared))


def test_another_reader_finds_the_same_in_the_mcap_file(folder, records):
    """By the reader of MCAP's own makers, and its reader of ROS 2's messages."""
    reading, decoding = pytest.importorskip("mcap.reader"), pytest.importorskip("mcap_ros2.decoder")
    found = []
    with (folder / "minute.mcap").open("rb") as file:
        reader = reading.make_reader(file, decoder_factories=[decoding.DecoderFactory()])
        assert reader.get_header().profile == "ros2"
        for schema, channel, message, decoded in reader.iter_decoded_messages():
            assert (schema.encoding, channel.message_encoding) == ("ros2msg", "cdr")
            stamp = decoded.header.stamp.sec * SECOND + decoded.header.stamp.nanosec
            assert 0 < message.log_time - stamp <= 4_000_000
            if "/uwb/" in channel.topic:
                found.append((stamp / SECOND, *channel.topic.split("/")[1::2], decoded.range))
    ranges = [record for record in records if record["record"] == "range" and isinstance(record["bound"], list)]
    assert sorted(found) == sorted(
        (record["time"], record["robot"], record.get("target", record.get("landmark")), record["range"]) for record in ranges
    )
