"""One command for one's own log: what it leaves, what it tells, and what its exit code says."""

import csv
import gzip
import json
import os
import subprocess
import sys
import threading
from dataclasses import fields
from pathlib import Path

import numpy as np
import pytest
from helpers.recordings import rerun, rows_of
from helpers.teams import write_log

import experiments.keeping.recorded
import experiments.keeping.running
from experiments import prove
from experiments.follow import Options, main
from experiments.following.steps import steps
from experiments.following.tolerating import Tolerating
from experiments.logs import LogReader, tum_line
from experiments.moving_team import main as moving_team
from experiments.regions import FILES, FORMATS
from experiments.show.viewer import NoViewer
from experiments.watch import main as watch
from filter import Compass

ROOT = Path(__file__).parents[2]
FULL = Path("/dev/full")


@pytest.fixture(scope="module")
def log(tmp_path_factory):
    return write_log(tmp_path_factory.mktemp("log") / "own.jsonl")


@pytest.fixture(scope="module")
def done(log, tmp_path_factory):
    """The folder of a run with everything that there is without a screen."""
    folder = tmp_path_factory.mktemp("done")
    assert main([str(log), "--out", str(folder), "--formats", *FORMATS, "--against", "ekf", "--recording"]) == 0
    return folder


def summary_in(folder):
    return json.loads((folder / "summary.json").read_text())


def lines_in(folder):
    return [json.loads(line) for line in (folder / "regions.jsonl").read_text().splitlines()]


def without_truth(path):
    return write_log(path, truth=False)


def lie(k, records):
    """At step 4 a compass is off by far more than its bound."""
    first = records[0]
    return [Compass(first.time, first.robot, first.heading + np.eye(2)[0], first.bound), *records[1:]] if k == 4 else records


def moved(log, path, **places):
    """Write a log again with another truth at one time."""
    records = [json.loads(line) for line in log.read_text().splitlines()]
    told = [record for record in records if record["record"] == "truth"]
    told[5].update(places)
    path.write_text("".join(json.dumps(record) + "\n" for record in records))
    return path


def test_by_default_it_leaves_summary_log_trajectories_and_json_lines(log, tmp_path):
    assert main([str(log), "--out", str(tmp_path)]) == 0
    left = sorted(path.name for path in tmp_path.iterdir())
    assert left == ["log.jsonl", "regions.jsonl", "summary.json", "trajectories"]
    poses = sorted(path.name for path in (tmp_path / "trajectories").iterdir())
    assert poses == ["r0_filter.tum", "r0_truth.tum", "r1_filter.tum", "r1_truth.tum"]


def test_everything_that_is_asked_for_is_there(done):
    left = sorted(path.name for path in done.iterdir())
    assert left == sorted(["follow.rrd", "log.jsonl", *FILES.values(), "summary.json", "trajectories"])
    assert rerun("verify", done / "follow.rrd").returncode == 0
    assert len(lines_in(done)) == 16
    assert {line["robot"] for line in lines_in(done)} == {"r0", "r1"}


def test_it_finds_what_a_replay_finds(log, done, tmp_path):
    assert moving_team(["--replay", str(log), "--out", str(tmp_path)]) == 0
    for file in (tmp_path / "trajectories").iterdir():
        assert (done / "trajectories" / file.name).read_bytes() == file.read_bytes()
    one, other = summary_in(done), summary_in(tmp_path)
    assert list(one)[: len(other)] == list(other)
    times = {"step_median_ms", "step_p95_ms", "warm_up_s"}
    assert {name: value for name, value in other.items() if name not in times} == {
        name: one[name] for name in other if name not in times
    }


def test_the_regions_are_those_that_the_recording_shows(done):
    for robot in ("r0", "r1"):
        drawn = rows_of(done / "follow.rrd", f"/world/outer/{robot}", "LineStrips3D:strips")
        written = [line["outer"] for line in lines_in(done) if line["robot"] == robot]
        for row, outer in zip(drawn, written, strict=True):
            strip = np.array(row["value"][0])[:-1, :2]
            assert strip == pytest.approx(np.array(outer), abs=1e-6)


def test_the_log_comes_out_as_it_came_in(log, tmp_path):
    spelled = tmp_path / "spelled.jsonl"
    spelled.write_bytes(b"\xef\xbb\xbf" + log.read_bytes().replace(b"\n", b"\r\n") + b"\n\n")
    assert main([str(spelled), "--out", str(tmp_path / "out")]) == 0
    assert (tmp_path / "out" / "log.jsonl").read_bytes() == spelled.read_bytes()


def test_a_log_that_is_compressed_or_comes_through_a_pipe_comes_out_plain(log, done, tmp_path):
    packed, pipe = tmp_path / "own.jsonl.gz", tmp_path / "pipe"
    packed.write_bytes(gzip.compress(log.read_bytes()))
    os.mkfifo(pipe)
    writing = threading.Thread(target=lambda: pipe.write_bytes(packed.read_bytes()), daemon=True)
    writing.start()
    for number, path in enumerate((packed, pipe)):
        assert main([str(path), "--out", str(tmp_path / str(number)), "--against", "ekf"]) == 0
        assert (tmp_path / str(number) / "log.jsonl").read_bytes() == log.read_bytes()
        assert (tmp_path / str(number) / "regions.jsonl").read_bytes() == (done / "regions.jsonl").read_bytes()
    writing.join()


def test_the_same_log_gives_the_same_bytes(log, done, tmp_path):
    assert main([str(log), "--out", str(tmp_path), "--formats", *FORMATS, "--against", "ekf"]) == 0
    for name in FILES.values():
        assert (tmp_path / name).read_bytes() == (done / name).read_bytes()


def test_a_log_without_truth_is_checked_against_nothing_and_that_is_said(tmp_path, capsys):
    log = without_truth(tmp_path / "own.jsonl")
    assert main([str(log), "--out", str(tmp_path / "out"), "--against", "ekf"]) == 0
    summary = summary_in(tmp_path / "out")
    assert (summary["checks"], summary["point_rmse_m"], summary["ekf_point_rmse_m"]) == (0, None, None)
    assert (summary["guarantee_in_force"], summary["ekf_points_judged"]) == (True, 16)
    assert "the log tells no truth: nothing was checked against it" in capsys.readouterr().err


@pytest.mark.parametrize("wrong", [{"positions": [[50.0, 50.0], [0.0, 0.0]]}, {"headings": [0.0, 9.0]}])
def test_a_truth_outside_ends_with_1(log, tmp_path, wrong):
    assert main([str(moved(log, tmp_path / "own.jsonl", **wrong)), "--out", str(tmp_path / "out")]) == 1
    assert summary_in(tmp_path / "out")["escapes_in_force"] > 0


def test_a_lie_is_lived_with_and_a_conflict_ends_with_1(tmp_path, capsys):
    log = write_log(tmp_path / "own.jsonl", change=lie)
    assert main([str(log), "--policy", "reject", "--out", str(tmp_path / "reject")]) == 0
    assert all(line["in_force"] for line in lines_in(tmp_path / "reject"))
    assert summary_in(tmp_path / "reject")["doubts"] > 0
    assert main([str(log), "--out", str(tmp_path / "raise")]) == 1
    assert "compass of r0" in summary_in(tmp_path / "raise")["inconsistent"]
    assert len(lines_in(tmp_path / "raise")) == 8
    assert "the filter stopped" in capsys.readouterr().err


def test_a_kalman_filter_guarantees_nothing(log, tmp_path, capsys):
    assert main([str(log), "--filter", "ekf", "--out", str(tmp_path), "--formats", "jsonl", "mcap"]) == 4
    summary = summary_in(tmp_path)
    assert (summary["guarantee_in_force"], summary["checks"], summary["escapes"]) == (False, 0, 0)
    assert summary["ekf_point_rmse_m"] == summary["point_rmse_m"] > 0
    assert summary["ekf_points_judged"] == 0
    assert all(line["outer"] is None and line["ekf"]["position"] for line in lines_in(tmp_path))
    poses = (tmp_path / "trajectories" / "r0_filter.tum").read_text().splitlines()
    assert [float(pose.split()[1]) for pose in poses] == [line["ekf"]["position"][0] for line in lines_in(tmp_path)[::2]]
    assert "it holds with a probability" in capsys.readouterr().err


def test_a_robust_filter_goes_the_same_way(log, tmp_path):
    assert main([str(log), "--filter", "robust", "--out", str(tmp_path), "--recording"]) == 0
    summary = summary_in(tmp_path)
    assert (summary["checks"], summary["escapes"], summary["doubts"]) == (16, 0, 0)
    assert summary["outer_area_mean_m2"] == pytest.approx(np.mean([line["area_m2"] for line in lines_in(tmp_path)]), rel=1e-5)


def test_both_are_told_of_a_kalman_filter_beside(done):
    summary, lines = summary_in(done), lines_in(done)
    assert summary["ekf_points_judged"] == len(lines)
    assert 0 <= summary["ekf_points_proved_wrong"] <= len(lines)
    assert all(line["outer"] and len(line["ekf"]["covariance"]) == 3 for line in lines)
    assert (done / "trajectories" / "r1_ekf.tum").exists()


def test_what_it_watches_is_judged_as_by_the_monitor(log, tmp_path):
    (tmp_path / "slam").mkdir()
    frames = list(LogReader(log).frames())
    for robot in range(2):
        lines = [tum_line(frame.time, frame.truth.positions[robot] + 5.0 * robot, 0.0) for frame in frames]
        (tmp_path / "slam" / f"r{robot}_slam.tum").write_text("".join(lines))
    assert main([str(log), "--watch", str(tmp_path / "slam"), "--out", str(tmp_path / "own")]) == 1
    assert watch(["--log", str(log), "--tum", str(tmp_path / "slam"), "--out", str(tmp_path / "its")]) == 1
    for name in ("alarms.csv", "episodes.csv"):
        assert (tmp_path / "own" / name).read_bytes() == (tmp_path / "its" / name).read_bytes()
    summary = summary_in(tmp_path / "own")
    assert {name: summary[f"watch_{name}"] for name in summary_in(tmp_path / "its")} == summary_in(tmp_path / "its")
    with (tmp_path / "own" / "alarms.csv").open(newline="") as file:
        assert {row["robot"] for row in csv.DictReader(file)} == {"r1"}
    assert summary["escapes"] == 0
    (tmp_path / "slam" / "r1_slam.tum").unlink()
    assert main([str(log), "--watch", str(tmp_path / "slam"), "--out", str(tmp_path / "right")]) == 0


@pytest.mark.parametrize("recording", [[], ["--recording"]])
def test_its_certificates_are_proved_with_a_recording_and_without(log, tmp_path, recording, capsys):
    assert main([str(log), "--certificates", "--out", str(tmp_path), *recording]) == 0
    assert prove.main([str(tmp_path)]) == 0
    assert ("regions of the recording" in capsys.readouterr().out) == bool(recording)
    told = summary_in(tmp_path) | {"recording": "follow.rrd"}
    (tmp_path / "summary.json").write_text(json.dumps(told) + "\n")
    (tmp_path / "follow.rrd").unlink(missing_ok=True)
    assert prove.main([str(tmp_path)]) == 1
    (tmp_path / "summary.json").write_text(json.dumps(told | {"recording": "../other.rrd"}) + "\n")
    assert prove.main([str(tmp_path)]) == 1


REFUSED = {
    "a window": (["--filter", "ekf", "--hops", "1"], "--filter sets, which has --hops"),
    "light": (["--filter", "ekf", "--light"], "--filter sets, which has --light"),
    "a policy": (["--filter", "robust", "--policy", "reject"], "--filter sets, which has --policy"),
    "certificates": (["--filter", "robust", "--certificates"], "--filter sets, which has --certificates"),
    "a watch": (["--filter", "ekf", "--watch", "x"], "--filter sets, which has --watch"),
    "itself beside it": (["--filter", "ekf", "--against", "ekf"], "a filter with regions for --against"),
    "a picture of no regions": (["--filter", "ekf", "--recording"], "a filter with regions for --recording"),
    "nothing to watch": (["--watch", "nowhere/r0.tum"], "a readable TUM file"),
    "no such window": (["--hops", "-1"], "hops"),
    "a tolerance": (["--filter", "ekf", "--tolerate", "1"], "--filter sets or robust, which have --tolerate"),
    "lies of nobody": (["--lies", "long"], "a --tolerate above 0"),
    "fewer than nobody": (["--tolerate", "-1"], "q, suspects that lie"),
}


@pytest.mark.parametrize("what", REFUSED)
def test_no_option_is_ignored(log, tmp_path, capsys, what):
    options, message = REFUSED[what]
    assert main([str(log), *options, "--out", str(tmp_path / "out")]) == 2
    assert message in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_options_that_sets_have_are_taken(log, tmp_path):
    assert main([str(log), "--hops", "1", "--light", "--out", str(tmp_path)]) == 0
    assert summary_in(tmp_path)["performance_ratio_mean"] is None


def test_a_log_that_is_not_there_or_cut_off_ends_with_2(log, tmp_path, capsys):
    assert main([str(tmp_path / "none.jsonl"), "--out", str(tmp_path / "out")]) == 2
    assert "none.jsonl: expected a readable log" in capsys.readouterr().err
    assert not (tmp_path / "out").exists()
    cut = tmp_path / "cut.jsonl"
    cut.write_bytes(log.read_bytes()[:-3])
    assert main([str(cut), "--out", str(tmp_path / "out")]) == 2
    assert "expected a whole line" in capsys.readouterr().err
    assert not (tmp_path / "out" / "summary.json").exists()
    assert len(lines_in(tmp_path / "out")) == 14


def test_what_comes_in_is_never_written_over(log, tmp_path, capsys):
    for name in ("log.jsonl", "regions.jsonl"):
        (tmp_path / name).write_bytes(log.read_bytes())
        assert main([str(tmp_path / name), "--out", str(tmp_path / "x" / "..")]) == 2
        assert "another --out" in capsys.readouterr().err
        assert (tmp_path / name).read_bytes() == log.read_bytes()
    (tmp_path / "trajectories").mkdir()
    assert main([str(log), "--watch", str(tmp_path / "trajectories"), "--out", str(tmp_path)]) == 2
    assert "another --out than that of the watched trajectories" in capsys.readouterr().err


def test_nothing_of_an_earlier_run_is_left_to_be_taken_for_this_ones(log, tmp_path):
    stale = ("regions.mcap", "regions.parquet", "regions_ros2.mcap", "certificates.jsonl.gz", "alarms.csv", "follow.rrd")
    for name in stale:
        (tmp_path / name).write_text("old")
    assert main([str(log), "--out", str(tmp_path)]) == 0
    assert not [name for name in stale if (tmp_path / name).exists()]


@pytest.mark.skipif(not FULL.exists(), reason="no device that is always full")
@pytest.mark.parametrize("name", ["log.jsonl", *FILES.values(), "trajectories/r0_filter.tum"])
def test_a_full_disk_ends_with_one_line_and_no_summary(log, tmp_path, capfd, monkeypatch, name):
    monkeypatch.setattr("experiments.show.output.FRAMES_KEPT", 2)
    (tmp_path / name).parent.mkdir(exist_ok=True)
    (tmp_path / name).symlink_to(FULL)
    before = Path.unlink
    monkeypatch.setattr(Path, "unlink", lambda path, missing_ok=False: path.is_symlink() or before(path, missing_ok))
    assert main([str(log), "--formats", *FORMATS, "--out", str(tmp_path)]) == 3
    assert not (tmp_path / "summary.json").exists()
    (line,) = [line for line in capfd.readouterr().err.splitlines() if line.startswith("error")]
    assert "space" in line
    assert not name.startswith("regions") or name in line


def test_a_folder_that_cannot_be_written_to_ends_with_2(log, tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main([str(log), "--out", str(tmp_path / "file" / "out")]) == 2
    assert "an output folder that can be written to" in capsys.readouterr().err


def test_ctrl_c_leaves_whole_files(log, tmp_path, monkeypatch, capsys):
    def interrupted(*arguments, **options):
        for number, step in enumerate(steps(*arguments, **options)):
            yield step
            if number == 3:
                raise KeyboardInterrupt

    monkeypatch.setattr(experiments.keeping.running, "steps", interrupted)
    assert main([str(log), "--formats", *FORMATS, "--out", str(tmp_path)]) == 130
    assert "stopped" in capsys.readouterr().err
    assert len(lines_in(tmp_path)) == 8
    assert parquet_rows(tmp_path) == 8


def parquet_rows(folder):
    from pyarrow import parquet

    return parquet.read_table(folder / "regions.parquet").num_rows


def test_a_viewer_that_cannot_be_opened_is_told(log, tmp_path, monkeypatch, capsys):
    def nothing():
        raise NoViewer("none here")

    monkeypatch.setattr(experiments.keeping.recorded, "open_viewer", nothing)
    assert main([str(log), "--view", "--out", str(tmp_path)]) == 2
    assert "no live viewer (none here)" in capsys.readouterr().err


def test_a_lie_that_is_tolerated_ends_with_0(tmp_path):
    path = write_log(tmp_path / "lying.jsonl", change=lie)
    assert (
        main([str(path), "--tolerate", "1", "--suspects", "pairs", "compasses", "--light", "--out", str(tmp_path / "out")]) == 0
    )
    assert summary_in(tmp_path / "out")["tolerated"].startswith("if at most 1 of these is wrong within any 5 s: what a robot")


def test_the_help_explains_every_option(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    assert "LOG" in said
    for option in (*fields(Options), *fields(Tolerating)):
        assert option.name in ("log", "tolerating") or f"--{option.name}" in said


LOADED = """
import sys
from experiments.follow import main
assert main(sys.argv[1:]) == 0
dear = {"rerun", "pyarrow", "mcap", "google.protobuf", "mujoco", "matplotlib", "scipy.stats"}
print(*(dear & set(sys.modules)))
"""


def test_nothing_is_loaded_that_was_not_asked_for(log, tmp_path):
    command = [sys.executable, "-c", LOADED, str(log), "--out", str(tmp_path)]
    ran = subprocess.run(command, cwd=ROOT, capture_output=True, text=True, check=True)
    assert ran.stdout.splitlines()[-1] == ""
