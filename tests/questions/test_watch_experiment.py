import csv
import json

import numpy as np
import pytest

from experiments.logs import LogReader, find_trajectories, read_trajectory, tum_line
from experiments.moving_team import main as moving_team
from experiments.watch import Options, main
from filter import InvalidInput


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The folder of a short run of three robots."""
    folder = tmp_path_factory.mktemp("run")
    assert moving_team(["--robots", "3", "--duration", "1.5", "--seed", "5", "--out", str(folder)]) == 0
    return folder


def write(path, frames, robot, shift=(0.0, 0.0), since=0.0):
    lines = ["# t x y z qx qy qz qw\n", "\n"]
    for frame in frames:
        moved = np.array(shift) if frame.time >= since else np.zeros(2)
        lines.append(tum_line(frame.time, frame.truth.positions[robot] + moved, 0.0))
    path.write_text("".join(lines))
    return path


@pytest.fixture(scope="module")
def frames(run):
    return list(LogReader(run / "log.jsonl").frames())


def watched(run, tum, out, *options):
    code = main(["--log", str(run / "log.jsonl"), "--tum", str(tum), "--out", str(out), *options])
    return code, json.loads((out / "summary.json").read_text()) if (out / "summary.json").exists() else None


@pytest.mark.parametrize("kind", ["truth", "filter"])
def test_the_truth_and_the_filters_own_points_raise_no_alarm(run, tmp_path, kind):
    code, summary = watched(run, run / "trajectories", tmp_path, "--pattern", f"r*_{kind}.tum")
    assert code == 0
    assert (summary["robots"], summary["poses"], summary["checks"], summary["alarms"]) == (3, 45, 45, 0)


def test_an_estimator_that_goes_astray_is_proved_wrong_from_then_on(run, frames, tmp_path, capsys):
    (tmp_path / "tum").mkdir()
    for robot in range(3):
        write(tmp_path / "tum" / f"r{robot}.tum", frames, robot, (3.0 * (robot == 1), 0.0), since=0.95)
    code, summary = watched(run, tmp_path / "tum", tmp_path / "out")
    assert code == 1
    assert (summary["checks"], summary["alarms"]) == (45, 5)
    assert 0 < summary["distance_max_m"] < 3
    with (tmp_path / "out" / "alarms.csv").open(newline="") as file:
        alarms = list(csv.DictReader(file))
    assert [(alarm["robot"], float(alarm["time_s"])) for alarm in alarms] == [("r1", 1 + k / 10) for k in range(5)]
    assert all(alarm["sources"] for alarm in alarms)
    assert any("robot" in alarm["sources"] for alarm in alarms)
    said = capsys.readouterr().out
    assert "Proved wrong" in said
    assert "1.000" in said


def test_the_line_of_an_alarm_separates_the_estimate_from_the_truth(run, frames, tmp_path):
    shifted = write(tmp_path / "r2.tum", frames, 2, (0.0, -2.0))
    assert watched(run, shifted, tmp_path / "out")[0] == 1
    with (tmp_path / "out" / "alarms.csv").open(newline="") as file:
        alarms = list(csv.DictReader(file))
    assert len(alarms) == len(frames)
    for alarm, frame in zip(alarms, frames, strict=True):
        normal = np.array([float(alarm["normal_x"]), float(alarm["normal_y"])])
        truth = frame.truth.positions[2]
        beyond = normal @ (truth - np.array([0.0, 2.0])) - float(alarm["offset_m"])
        assert normal @ truth <= float(alarm["offset_m"])
        assert beyond == pytest.approx(float(alarm["distance_m"]), abs=1e-9)


def test_poses_between_frames_are_not_compared(run, frames, tmp_path):
    path = tmp_path / "r0.tum"
    lines = [
        tum_line(frame.time + (0.02 if k % 2 else 0.0), frame.truth.positions[0] + 9, 0.0) for k, frame in enumerate(frames)
    ]
    path.write_text("".join(lines))
    code, summary = watched(run, path, tmp_path / "out")
    assert (code, summary["poses"], summary["checks"], summary["alarms"]) == (1, 15, 8, 8)
    code, summary = watched(run, path, tmp_path / "out", "--tolerance", "0.03")
    assert (code, summary["checks"]) == (1, 15)


def test_a_trajectory_of_another_time_ends_with_exit_code_2(run, frames, tmp_path, capsys):
    path = tmp_path / "r0.tum"
    path.write_text("".join(tum_line(frame.time + 1e6, frame.truth.positions[0], 0.0) for frame in frames))
    assert watched(run, path, tmp_path / "out") == (2, None)
    assert "poses within" in capsys.readouterr().err


BAD = {
    "no file": (None, "a readable TUM file"),
    "no pose": ("# nothing\n", "at least one pose"),
    "too few numbers": ("0.0 1.0 2.0\n", "line 1: 8 finite numbers"),
    "words": ("0 a b c d e f g\n", "line 1: 8 finite numbers"),
    "a number that is not finite": ("0 nan 0 0 0 0 0 1\n", "line 1: 8 finite numbers"),
    "time that stands still": ("0 1 1 0 0 0 0 1\n0 1 1 0 0 0 0 1\n", "line 2: a time after 0.0 s"),
}


@pytest.mark.parametrize("what", BAD)
def test_a_trajectory_that_cannot_be_used_ends_with_its_place_and_exit_code_2(run, tmp_path, capsys, what):
    text, message = BAD[what]
    if text is not None:
        (tmp_path / "r0.tum").write_text(text)
    assert watched(run, tmp_path / "r0.tum", tmp_path / "out") == (2, None)
    said = capsys.readouterr().err
    assert message in said
    assert "r0.tum" in said
    assert "Traceback" not in said


def test_a_folder_must_tell_one_trajectory_of_each_robot(run, tmp_path):
    with pytest.raises(InvalidInput, match="--pattern"):
        find_trajectories(run / "trajectories", "r*.tum", 3)
    with pytest.raises(InvalidInput, match="none"):
        find_trajectories(tmp_path, "r*.tum", 3)
    (tmp_path / "r3.tum").touch()
    with pytest.raises(InvalidInput, match="r0 to r2"):
        find_trajectories(tmp_path, "r*.tum", 3)
    (tmp_path / "r10_slam.tum").touch()
    assert sorted(find_trajectories(tmp_path, "r*.tum", 11)) == [3, 10]


def test_a_log_that_cannot_be_read_ends_with_exit_code_2(tmp_path, capsys):
    assert main(["--log", str(tmp_path / "log.jsonl"), "--tum", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "expected a readable log" in capsys.readouterr().err


def test_a_pose_is_found_by_its_time(tmp_path):
    path = tmp_path / "r0.tum"
    path.write_text("".join(tum_line(0.1 * k, np.array([k, -k]), 0.0) for k in range(5)))
    trajectory = read_trajectory(path)
    assert trajectory.at(0.3, 1e-6).tolist() == [3, -3]
    assert trajectory.at(0.32, 0.05).tolist() == [3, -3]
    assert trajectory.at(0.38, 0.05).tolist() == [4, -4]
    assert np.isnan(trajectory.at(0.35, 0.01)).all()
    assert np.isnan(trajectory.at(-1.0, 0.01)).all()


def test_the_help_explains_every_option(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    for option in Options.__dataclass_fields__:
        assert f"--{option}" in said
