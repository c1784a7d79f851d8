"""Folders of a stream in which the log was made to say less, or the certificates more: each is refused, for its reason."""

import shutil
from pathlib import Path

import numpy as np
import pytest
from helpers.proved.forgeries import Forgeries, check_refused
from helpers.proved.runs import lines_of, moved, rewritten
from helpers.proved.streams import NAMES, Team, as_it_comes, written

from experiments import prove
from experiments.follow import main
from experiments.prove import HEADINGS, LINES

LOG = "log.jsonl"
forged = Forgeries()
SMALLER, LATE = -1e-10, 3.0  # of what was cut and joined: far above its rounding [m]; [s]


def all_of(log, kind, **fields):
    found = [record for record in log if record["record"] == kind and fields.items() <= record.items()]
    assert found
    return found


@forged("box lies")
def odometry_with_a_wider_bound(log):
    for record in all_of(log, "odometry", robot="alice"):
        record["distance_bound"] *= 2


@forged("box lies")
def odometry_that_slips_more(log):
    for record in all_of(log, "odometry", robot="bob"):
        record["slip_bound"] += 1e-6


@forged("box lies")
def odometry_that_is_gone(log):
    for record in all_of(log, "odometry", robot="alice")[::2]:
        log.remove(record)


@forged("box lies")
def odometry_that_turns_more(log):
    for record in all_of(log, "odometry", robot="bob"):
        record["turn_bound"] += 0.01


@forged("box lies")
def odometry_of_another_robot(log):
    for record in all_of(log, "odometry"):
        record["robot"] = {"alice": "bob", "bob": "alice"}[record["robot"]]


@forged("box lies")
def a_twist_that_holds_no_longer(log):
    for record in all_of(log, "twist"):
        record["hold"] = 0.01


@forged("box lies")
def a_twist_with_a_wider_bound(log):
    for record in all_of(log, "twist"):
        record["speed_bound"] += 1e-6


@forged("box lies")
def a_robot_that_drives_another_way(log):
    for record in all_of(log, "twist"):
        del record["aside"]


@forged("box lies")
def robots_that_can_be_faster(log):
    for name in NAMES:
        log[0]["speed_limit"][name] += 0.5


@forged("box lies")
def robots_that_change_their_speed_faster(log):
    log[0]["acceleration_limit"]["alice"] += 0.3


@forged("box lies")
def robots_that_change_their_speed_as_they_like(log):
    del log[0]["acceleration_limit"]


@forged("follows from nothing known")
def positions_with_a_wider_bound(log):
    for record in all_of(log, "position"):
        for name in {"bound", "radius"} & set(record):
            bound = record[name]
            record[name] = [one + 1e-6 for one in bound] if isinstance(bound, list) else bound + 1e-6


@forged("follows from nothing known")
def positions_behind_lines_farther_off(log):
    for record in all_of(log, "position"):
        if "normal" in record:
            record["offset"] += 1e-6


@forged("in one of the cases robot 0 can be beyond")
def pairs_of_wider_bounds(log):
    for record in log:
        if record["record"] in ("bearing", "compass", "range") and isinstance(record["bound"], list):
            record["bound"] = [record["bound"][0], record["bound"][1] + 0.01]


@forged("in one of the cases robot 0 can be beyond")
def pairs_the_other_way_round(log):
    for record in log:
        if record["record"] in ("bearing", "compass", "range") and isinstance(record["bound"], list):
            low, high = record["bound"]
            record["bound"] = [-high, -low]


@forged("the lower one first")
def a_pair_the_wrong_way_round(log):
    next(record for record in log if isinstance(record.get("bound"), list) and record["record"] != "position")[
        "bound"
    ].reverse()


@forged("in one of the cases robot 0 can be beyond")
def measurements_of_somebody_else(log):
    for record in log:
        if record["record"] in ("bearing", "range"):
            record["robot"] = next(name for name in NAMES if name not in (record["robot"], record.get("target")))


@forged("was expected, not 'alicia'")
def a_name_that_nobody_has(log):
    all_of(log, "odometry")[0]["robot"] = "alicia"


@forged("a name was expected, not '../alice'")
def a_name_that_leads_elsewhere(log):
    log[0]["robots"][0] = "../alice"


@forged("no two alike")
def a_name_of_two(log):
    log[0]["landmarks"] = {"alice": [0, 0], "door": [1, 1]}


@forged("one for each of 3 robots was expected")
def a_limit_that_is_missing(log):
    del log[0]["speed_limit"]["bob"]


@forged("in one of the cases robot 0 can be beyond")
def landmarks_exchanged(log):
    log[0]["landmarks"] = dict(zip(log[0]["landmarks"], reversed(log[0]["landmarks"].values()), strict=True))


@forged("nothing for the log's frame")
def a_robot_that_leaves(log):
    log.append({"record": "leave", "time": LATE, "robot": "bob"})


@forged("nothing for the log's frame")
def a_robot_that_comes_back(log):
    log.append({"record": "initial", "time": LATE, "robot": "bob", "vertices": [[0, 0], [1, 0]], "heading": None})


@forged("are done")
def a_record_that_comes_too_late(log):
    log += [{"record": "frame", "time": LATE}, {"record": "frame", "time": 0.1}]


@forged("takes no time")
def a_twist_for_no_time(log):
    all_of(log, "twist")[0]["hold"] = 0


@forged("where other odometry ends")
def odometry_said_twice(log):
    log.insert(5, all_of(log, "odometry")[0])


@forged("nothing for the log's frame")
def a_frame_more(log):
    log.append({"record": "frame", "time": LATE})


@forged("it is of none of the log's frames, or out of order")
def a_stamp_less(log):
    last = max(record["time"] for record in log if record["record"] not in ("header", "initial", "odometry", "twist"))
    log[:] = [record for record in log if record.get("time") != last]


@forged("columns of one length")
def columns_of_two_lengths(log):
    all_of(log, "odometry")[0].update(robot=["alice"], turn=[0.1, 0.2])


def within(records):
    return [line for record in records for line in record["lines"]]


@forged("step 0: not as it should be: ValueError: an angle of")
def odometry_of_many_turns(log):
    first, *rest = all_of(log, "odometry", robot="alice")
    for record in rest:
        log.remove(record)
    first.update(start=0.0, time=0.001, turn=1e5)
    log.insert(5, {**first, "start": 0.001, "time": 0.002})


@forged("box lies", HEADINGS)
def boxes_that_moved_a_little_less(records):
    for line in within(records):
        for corner in line["upper"].values():
            corner[:] = [moved(value, SMALLER) for value in corner]


@forged("follows from nothing known", HEADINGS)
def rows_that_moved_a_little_less(records):
    for line in within(records):
        for row, source in zip(line["rows"], line["sources"], strict=True):
            if source["t"] != line["t"] and source["kind"] in ("initial set", "region", "cells"):
                row["offset"] = moved(row["offset"], SMALLER)


@forged("is not proved", HEADINGS)
def headings_that_turned_a_little_less(lines):
    for line in lines:
        line["bound"] = [moved(bound, SMALLER) for bound in line["bound"]]


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    path = tmp_path_factory.mktemp("stream")
    log = written(path / "given.jsonl", as_it_comes(Team(np.random.default_rng(3))))
    assert main([str(log), "--certificates", "--light", "--out", str(path / "run")]) == 0
    return path / "run"


@pytest.fixture
def copy(folder, tmp_path):
    return Path(shutil.copytree(folder, tmp_path / "copy"))


def test_the_folder_is_proved_as_it_is(copy):
    for name in (LINES, HEADINGS, LOG):
        rewritten(copy, lines_of(copy, name), name)
    assert prove.main([str(copy)]) == 0


@pytest.mark.parametrize("name", forged)
def test_what_is_forged_is_refused(copy, name, capsys):
    check_refused(copy, forged[name], capsys)
