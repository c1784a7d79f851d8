"""Robots that are put elsewhere, leave, come back and join: of those that are there all is proved, of others nothing said."""

import json
import shutil
from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from helpers.proved.forgeries import Forgeries, check_refused
from helpers.proved.runs import lines_of, moved, rewritten
from helpers.proved.streams import BACK, JOINED, LEFT, PUT, Team, as_it_comes, coming_and_going, in_step, written

from experiments import prove
from experiments.follow import main
from experiments.logs import LogReader
from experiments.proof.given.log import Log
from experiments.prove import LINES, REGIONS
from experiments.prove import prove as links_of

LOG, TUM = "log.jsonl", "trajectories/bob_filter.tum"
forged = Forgeries()


def change_of(log, robot):
    """Return the record that puts a robot somewhere, later on."""
    return next(record for record in log if record["record"] == "initial" and record["robot"] == robot and "time" in record)


def at(lines, time):
    return [line for line in lines if float.fromhex(line["t"]) == time]


def followed(path, seed, make=as_it_comes, *options):
    """Return the folder of a run with certificates."""
    path.mkdir(exist_ok=True)
    log = written(path / "given.jsonl", coming_and_going(Team(np.random.default_rng(seed)), make))
    assert main([str(log), "--certificates", "--light", "--out", str(path / "run"), *options]) == 0
    return path / "run"


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return followed(tmp_path_factory.mktemp("changes"), 3)


@pytest.fixture
def copy(folder, tmp_path):
    return Path(shutil.copytree(folder, tmp_path / "copy"))


def silent(text):
    """Show nothing."""


def test_it_is_proved(tmp_path):
    links = Counter()
    for seed, make in ((0, as_it_comes), (1, as_it_comes), (2, in_step)):
        folder = followed(tmp_path / str(seed), seed, make)
        links += links_of(folder, silent)
        told = json.loads((folder / "summary.json").read_text())
        assert told["checks"] > 0
        assert told["escapes"] == told["heading_escapes"] == 0
    assert links["rows of initial sets"] > 20
    assert links["rows that are edges of an earlier step, moved"] > 50


@pytest.mark.parametrize("make", [in_step, as_it_comes])
@pytest.mark.parametrize("seed", range(4))
def test_who_comes_and_goes_is_read_as_the_filter_reads_it(tmp_path, make, seed):
    log = coming_and_going(Team(np.random.default_rng(seed)), make)
    path, away = written(tmp_path / "log.jsonl", log), {2}
    for frame, exactly in zip(LogReader(path).frames(), Log(tmp_path).frames, strict=True):
        assert [change.robot for change in frame.changes] == [robot for robot, _ in exactly.changes]
        for change, (robot, start) in zip(frame.changes, exactly.changes, strict=True):
            away = away - {robot} if start else away | {robot}
            if start:
                assert [list(map(float, corner)) for corner in start.place.corners] == log_corners(log, change)
        assert exactly.away == away


def log_corners(log, change):
    """Return the corners that a log says of a robot that is placed."""
    same = (record for record in log if record.get("time") == change.time and record["record"] == "initial")
    return next(record["vertices"] for record in same if record["robot"] == ("alice", "bob", "3rd")[change.robot])


def test_of_a_robot_that_is_away_nothing_is_shown(folder):
    for record in lines_of(folder, REGIONS):
        time, (alice, bob, third) = float.fromhex(record["t"]), record["regions"]
        assert alice is not None
        assert (bob is None) == (LEFT <= time < BACK)
        assert (third is None) == (time < JOINED)
    times = [float(line.split()[0]) for line in (folder / TUM).read_text().splitlines()]
    assert LEFT < BACK in times
    assert not any(LEFT <= time < BACK for time in times)


def test_nor_in_a_recording(tmp_path, capsys):
    assert prove.main([str(followed(tmp_path, 3, as_it_comes, "--recording"))]) == 0
    assert "regions of the recording" in capsys.readouterr().out


@forged("there is no region, though the robot is there")
def one_that_has_not_left(log):
    truth = {"record": "truth", "time": LEFT, "robot": "3rd", "position": None, "heading": None}
    log[log.index({"record": "leave", "time": LEFT, "robot": "bob"})] = truth


@forged("by or of robot 1, which is away")
def one_that_never_comes_back(log):
    log[log.index(change_of(log, "bob"))] = {"record": "frame", "time": BACK}


@forged("by or of robot 1, which is away")
def a_measurement_of_one_that_is_away(log):
    time = next(record["time"] for record in log if record["record"] == "range" and LEFT < record["time"] < BACK)
    log.insert(4, {"record": "compass", "time": time, "robot": "bob", "heading": 0.1, "bound": 0.1})


@forged("by or of robot 1, which is away")
def a_place_of_one_that_is_away(log):
    time = next(record["time"] for record in log if record["record"] == "range" and LEFT < record["time"] < BACK)
    log.insert(4, {"record": "position", "time": time, "robot": "bob", "position": [0, 0], "bound": 1})


@forged("box lies")
def a_set_that_is_larger(log):
    for corner in change_of(log, "bob")["vertices"]:
        corner[0] *= 1 + 1e-6


@forged("follows from nothing known")
def a_set_with_one_corner_farther_out(log):
    corners = np.array(change_of(log, "alice")["vertices"])
    low, high = corners.min(axis=0), corners.max(axis=0)
    change_of(log, "alice")["vertices"] += [[low[0], high[1]], [high[0], high[1]], low.tolist(), [high[0], low[1]]]


@forged("the heading of robot 2 is not proved")
def a_heading_that_is_wider(log):
    change_of(log, "3rd")["heading"]["bound"] += 1e-6


@forged("box lies")
def one_that_was_put_nowhere_else(log):
    log[log.index(change_of(log, "alice"))] = {"record": "frame", "time": PUT}


@forged("nothing for the log's frame")
def one_that_leaves_later(log):
    next(record for record in log if record["record"] == "leave")["time"] += 0.001


@forged("was expected, not 'carol'")
def nobody(log):
    change_of(log, "bob")["robot"] = "carol"


@forged("there is no region, though the robot is there", REGIONS)
def no_region(lines):
    at(lines, PUT)[0]["regions"][0] = None


@forged("not as it should be: KeyError: 'vertices'", REGIONS)
def an_empty_region(lines):
    at(lines, PUT)[0]["regions"][0] = {}


@forged("a region of a robot that is away", REGIONS)
def an_empty_region_of_one_that_is_away(lines):
    at(lines, LEFT)[0]["regions"][1] = {}


@forged("a region of a robot that is away", REGIONS)
def a_region_of_one_that_is_away(lines):
    at(lines, LEFT)[0]["regions"][1] = at(lines, LEFT)[0]["regions"][0]


@forged("box lies", LINES)
def a_set_that_is_smaller_than_said(lines):
    for line in at(lines, PUT):
        for corner in [line["upper"]["0"]] if "0" in line["upper"] else []:
            corner[:] = [moved(value, -1e-9) for value in corner]


@forged("follows from nothing known", LINES)
def what_was_known_before(lines):
    """It would hold had alice driven: by a metre more than she can."""
    before = max(float.fromhex(line["t"]) for line in lines if float.fromhex(line["t"]) < PUT)
    edge = next(line for line in at(lines, before) if (line["from"], line["robot"]) == (-1, 0) and line["rows"])
    line = next(line for line in at(lines, PUT) if line["robot"] == 0 and line["from"] == -1)
    normal, offset = edge["normal"], moved(edge["offset"], 1.0)
    line["rows"].append({"i": -1, "j": 0, "normal": normal, "offset": offset, "multiplier": "0x0p+0"})
    line["sources"].append({"kind": "region", "t": edge["t"], "robot": 0, "target": None})


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(copy, name, capsys):
    check_refused(copy, forged[name], capsys)


def test_a_pose_of_one_that_is_away_is_refused(copy, capsys):
    lines = (copy / TUM).read_text().splitlines(keepends=True)
    (copy / TUM).write_text("".join([lines[0], *lines]))
    assert prove.main([str(copy)]) == 1
    assert "frames with it" in capsys.readouterr().out


def test_what_one_that_is_away_drives_says_nothing(copy):
    log = lines_of(copy, LOG)
    some = [record for record in log if record["record"] == "odometry" and record["robot"] == "bob"]
    some = [record for record in some if record["start"] > LEFT and record["time"] < BACK]
    assert some
    for record in some:
        record.update(distance=9.0, turn=1.0)
    rewritten(copy, log, LOG)
    assert prove.main([str(copy)]) == 0
