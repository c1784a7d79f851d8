"""Runs of a team with names: summaries, tables and errors say the names, none of them says a number."""

import csv
import json

import numpy as np
import pytest

from experiments.follow import main as follow
from experiments.logs import Header, InitialSet, InvalidLog, LogReader, LogWriter, tum_line
from experiments.watch import main as watch
from filter import Compass, Frame, Odometry, Position, Range, Team

TEAM = Team(["alice", "bob"], {"gate": [2.0, 0.0]}, speed_limit=0.1, arena=[[-5, -5], [5, 5]])
SQUARE = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
STILL = {"turn": 0.0, "turn_bound": 0.1, "distance_bound": 0.01, "direction_bound": 0.1, "slip_bound": 0.0}


def written(path, *frames, truth=None):
    """Write a log of a team whose robots look east."""
    with LogWriter(path, Header(TEAM, 0.0), [InitialSet(SQUARE, (0.0, 0.1))] * 2) as log:
        for frame in frames:
            log.write(frame)
    return path


def run(log, folder, *options):
    code = follow([str(log), "--out", str(folder), *options])
    return code, json.loads((folder / "summary.json").read_text())


def row_in(path):
    with path.open(newline="") as file:
        (row,) = csv.DictReader(file)
    return row


def test_what_stops_a_filter_has_names(tmp_path, capsys):
    away = Odometry(0.0, 1.0, [0, 1], [0.0, 20.0], **STILL)
    code, summary = run(written(tmp_path / "own.jsonl", Frame(1.0, away)), tmp_path / "out")
    assert code == 1
    assert summary["inconsistent"].startswith("bob has left the arena by 1.0 s: ")
    assert "the filter stopped: bob has left the arena" in " ".join(capsys.readouterr().err.split())


def test_why_a_guarantee_is_suspended_has_names(tmp_path, capsys):
    lie = Range(1.0, 0, 2, 9.0, 0.1, 0.0)
    nowhere = Position(1.0, 1, [1.0, -1.0], 0.0, [0.5, -1.5])
    frames = Frame(0.0, None, [Compass(0.0, [0, 1], 0.0, 0.1)]), Frame(1.0, None, [lie, nowhere])
    code, summary = run(written(tmp_path / "own.jsonl", *frames), tmp_path / "out", "--policy", "reject", "--every", "0")
    because = summary["guarantee_suspended_because"]
    assert code == 4
    assert because.startswith("suspended for ")
    assert " since 1.000 s, as more is wrong than one of: " in because
    assert "robot" not in because
    assert f"the guarantee is {because}" in " ".join(capsys.readouterr().err.split())


def test_what_is_proved_wrong_has_names(tmp_path, capsys):
    log = written(tmp_path / "own.jsonl", *(Frame(t, None, [Position.disc(t, 1, [0.5, 0.5], 0.1)]) for t in (0.0, 1.0)))
    (tmp_path / "r1_slam.tum").write_text(tum_line(1.0, np.array([3.0, 0.5]), 0.0))
    assert watch(["--log", str(log), "--tum", str(tmp_path / "r1_slam.tum"), "--out", str(tmp_path / "out")]) == 1
    alarm, episode = (row_in(tmp_path / "out" / f"{name}.csv") for name in ("alarms", "episodes"))
    assert alarm["robot"] == "bob"
    for said in (alarm["sources"], episode["behind"]):
        assert "position of bob at 1.000 s" in said
        assert "robot" not in said
    assert "robot" not in capsys.readouterr().out.split("watch, in")[0]


TWICE = {
    "initial set": '{"record": "initial", "robot": "bob", "vertices": [[0, 0], [1, 0], [1, 1]], "heading": null}',
    "truth": '{"record": "truth", "time": 1.0, "robot": "bob", "position": [0.0, 0.0], "heading": null}',
    "odometry": json.dumps({"record": "odometry", "start": 0.0, "time": 1.0, "robot": "bob", "distance": 0.0, **STILL}),
}


@pytest.mark.parametrize("what", TWICE)
def test_who_is_in_a_log_twice_is_named(tmp_path, what):
    path = written(tmp_path / "own.jsonl", Frame(0.0))
    lines = path.read_text().splitlines()
    place = 1 if what == "initial set" else len(lines)
    path.write_text("\n".join([*lines[:place], TWICE[what], TWICE[what], *lines[place:]]) + "\n")
    with pytest.raises(InvalidLog, match=r"; came bob again|; came another of bob"):
        list(LogReader(path).frames())
