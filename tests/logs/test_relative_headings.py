"""What robots see of their mates' headings, in a log: the programs take it, and know more of headings."""

import io
import json
import sys

import numpy as np
import pytest
from helpers.teams import write_log

from experiments.follow import main as follow
from experiments.live import main as live
from experiments.logs import LogReader, LogWriter
from filter import Frame, RelativeHeading, wrap


@pytest.fixture
def logs(tmp_path):
    """Return two logs of the same drive: what one robot sees of the other's heading is in one of them only."""
    plain, more, rng = write_log(tmp_path / "plain.jsonl"), tmp_path / "more.jsonl", np.random.default_rng(1)
    reader = LogReader(plain)
    header = type(reader.header)(reader.header.team, reader.header.start, version=2)
    with LogWriter(more, header, reader.initial) as log:
        for frame in reader.frames():
            first, last = frame.truth.headings
            seen = RelativeHeading(frame.time, 0, 1, wrap(last - first) + 0.01 * rng.choice([-1, 1]), 0.010001)
            log.write(Frame(frame.time, frame.odometry, (*frame.measurements, seen), frame.truth))
    return plain, more


def rows_of(folder):
    return [json.loads(line) for line in (folder / "regions.jsonl").read_text().splitlines()]


def test_headings_are_narrower_with_the_truth_inside(logs, tmp_path):
    bounds = []
    for log in logs:
        assert follow([str(log), "--out", str(tmp_path / log.stem)]) == 0
        summary = json.loads((tmp_path / log.stem / "summary.json").read_text())
        assert (summary["escapes"], summary["heading_escapes"]) == (0, 0)
        assert summary["heading_checks"] > 0
        bounds.append([row["heading"]["bound"] for row in rows_of(tmp_path / log.stem)])
    assert np.mean(bounds[1]) < 0.95 * np.mean(bounds[0])


def test_live_answers_as_follow_does(logs, tmp_path, monkeypatch, capsys):
    _, log = logs
    assert follow([str(log), "--every", "0", "--out", str(tmp_path / "followed")]) == 0
    options = ["--every", "0", "--full", "--budget", "None", "--lag", "100"]
    with io.TextIOWrapper(log.open("rb")) as stdin:
        monkeypatch.setattr(sys, "stdin", stdin)
        assert live(["--out", str(tmp_path / "live"), *options]) == 0
    last = [[{**row, "inner": None} for row in rows_of(tmp_path / name)[-2:]] for name in ("followed", "live")]
    assert last[0] == last[1]
