"""A team that stands, from a log: followed with bounds that its first seconds tell, and what is said when something lies."""

import json
from pathlib import Path

import numpy as np
import pytest
from helpers.own_data.tiers import BAGS, STANDING, needs_bags
from helpers.recordings import rerun, rows_of

from experiments.convert import main as convert
from experiments.show.command import BAD_INPUT
from experiments.standing_team import main

PLACES = {"1": [0.0, 0.0], "2": [6.0, 0.0], "3": [1.0, 5.0], "4": [4.0, 3.0], "5": [6.5, 6.0]}


def lines(*, moves=False, landmarks=None):
    """Yield the records of a log: 16 s, four ranges a second of every ordered pair, each off by up to 0.1 m."""
    rng = np.random.default_rng(0)
    yield {
        "record": "header", "format": "corral-log", "version": 2, "robots": list(PLACES), "landmarks": landmarks or {},
        "arena": [[-9, -9], [15, 15]], "speed_limit": 0.0, "turn_rate_limit": 0.0, "start": 0.0, "rate": None,
    }  # fmt: skip
    yield from ({"record": "initial", "robot": name, "vertices": None, "heading": None} for name in PLACES)
    for time in np.arange(0.25, 16.0, 0.25).tolist():
        for robot, place in PLACES.items():
            where = [place[0] + (0.1 * time if moves else 0.0), place[1]]
            yield {"record": "truth", "time": time, "robot": robot, "position": where, "heading": None}
            for target, other in PLACES.items():
                if target != robot:
                    measured = float(np.hypot(*np.subtract(place, other)) + rng.uniform(-0.1, 0.1))
                    of = {"robot": robot, "target": target, "bound": 0.5, "relative_bound": 0.0}
                    yield {"record": "range", "time": time, **of, "range": measured}


@pytest.fixture
def log(tmp_path):
    def written(**options):
        path = tmp_path / "run.jsonl"
        path.write_text("".join(json.dumps(line) + "\n" for line in lines(**options)))
        return path

    return written


def ran(path, *options, anchors=("1", "2", "5"), quick=("--learned", "8", "--lie-after", "2")):
    """Return the exit code and the summary of a run."""
    out = path.parent / "out"
    code = main([str(path), "--anchors", *anchors, *quick, *options, "--out", str(out)])
    return code, json.loads((out / "summary.json").read_text()) if (out / "summary.json").exists() else {}


@pytest.mark.parametrize("bounds", ["common", "pair"])
def test_a_team_that_keeps_its_bounds_is_in_force_all_the_time(log, bounds):
    code, summary = ran(log(), "--bounds", bounds, "--margin", "0.5")
    assert code == 0
    assert summary["checks"] == 2 * 14
    assert summary["escapes"] == summary["doubts"] == 0
    assert summary["guarantee_in_force"]
    assert summary["guilty"] is summary["guilty_of_the_lie"] is None
    assert 0 < summary["last_area_median_m2"] <= summary["first_area_median_m2"]


def test_a_range_that_is_too_long_is_in_doubt_and_said(log):
    path = log()
    code, summary = ran(path, "--lie", "longer")
    assert code == 0
    assert summary["escapes"] == summary["escapes_in_force"] == 0
    assert (summary["doubts"], summary["first_doubt_s"]) == (1, pytest.approx(10.5))
    assert summary["guarantee_in_force"]
    recording = path.parent / "out/standing_team.rrd"
    assert rerun("verify", str(recording)).returncode == 0
    told = [row["value"][0] for row in rows_of(recording, "/events", "TextLog:text")]
    assert sum("headings known to +-180 degrees" in text for text in told) == 1
    assert sum("in doubt since" in text and "what 3 takes for 1" in text for text in told) == 1
    assert (path.parent / "out/standing_team.png").read_bytes().startswith(b"\x89PNG")


def test_a_range_that_is_too_long_is_no_doubt_where_that_is_tolerated(log):
    code, summary = ran(log(), "--lie", "longer", "--tolerate", "1", "--suspects", "bodies", "--lies", "long")
    assert code == 0
    assert summary["escapes"] == summary["doubts"] == 0
    assert summary["guarantee_in_force"]


def test_an_anchor_that_was_moved_is_in_doubt_at_once(log):
    code, summary = ran(log(), "--lie", "moved")
    assert code == 0
    assert summary["escapes"] == summary["escapes_in_force"] == 0
    assert (summary["doubts"], summary["first_doubt_s"]) == (1, pytest.approx(10.5))


@pytest.mark.parametrize(
    "wrong",
    [
        ({}, (), ("1", "9"), "a robot among 1, 2, 3, 4, 5"),
        ({}, (), tuple(PLACES), "anchors, other robots"),
        ({}, ("--learned", "0"), ("1", "2", "5"), "learned"),
        ({}, ("--learned", "20"), ("1", "2", "5"), "ranges after the first seconds"),
        ({}, ("--margin", "-1"), ("1", "2", "5"), "margin"),
        ({"moves": True}, (), ("1", "2", "5"), "a truth for 1 that stays where it is"),
        ({"landmarks": {"gate": [1.0, 1.0]}}, (), ("1", "2", "5"), "without landmarks"),
    ],
    ids=["no such robot", "nobody left", "nothing learned", "nothing after", "margin", "driving", "landmarks"],
)
def test_what_cannot_be_used_is_refused(log, capsys, wrong):
    how, options, anchors, told = wrong
    assert ran(log(**how), *options, anchors=anchors, quick=())[0] == BAD_INPUT
    assert told in " ".join(capsys.readouterr().err.split())


@pytest.fixture(scope="module")
def real(tmp_path_factory):
    """The log of seven real robots."""
    folder = tmp_path_factory.mktemp("real")
    (folder / "my.toml").write_text(STANDING)
    assert convert([str(folder / "my.toml"), str(Path(str(BAGS)) / "case_4/test1.bag"), str(folder / "run.jsonl")]) == 0
    return folder / "run.jsonl"


@needs_bags
@pytest.mark.parametrize("lie", ["none", "longer", "moved"])
def test_the_real_team_keeps_the_bounds_of_its_first_ten_seconds(real, lie):
    code, summary = ran(real, "--lie", lie, anchors=("1", "2", "6"), quick=())
    assert code == 0
    assert (summary["ranges"], summary["ranges_outside_bounds"]) == (8556, 0)
    assert (summary["checks"], summary["escapes_in_force"]) == (192, 0)
    assert summary["escapes"] == 0
    assert summary["last_area_median_m2"] < 0.7
    if lie == "none":
        assert summary["doubts"] == 0
    else:
        assert (summary["doubts"], summary["first_doubt_s"]) == (1, pytest.approx(20.5))
    if lie == "moved":
        assert (summary["guilty"], summary["guilty_of_the_lie"]) == ("place or marker of 1", 1)
