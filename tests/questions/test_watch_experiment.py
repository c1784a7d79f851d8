import csv
import json

import numpy as np
import pytest

from experiments.logs import LogReader, find_trajectories, tum_line
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


def rows_in(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


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
    alarms = rows_in(tmp_path / "out" / "alarms.csv")
    assert [(alarm["robot"], float(alarm["time_s"])) for alarm in alarms] == [("r1", 1 + k / 10) for k in range(5)]
    assert all(alarm["sources"] for alarm in alarms)
    assert any("of r1" in alarm["sources"] for alarm in alarms)
    (episode,) = rows_in(tmp_path / "out" / "episodes.csv")
    assert summary["episodes"] == 1 == int(alarms[0]["episode"])
    assert (episode["trajectory"], episode["poses"], episode["start_s"], episode["end_s"]) == ("r1", "5", "1.0", "1.4")
    assert float(episode["distance_max_m"]) == max(float(alarm["distance_m"]) for alarm in alarms)
    assert "region" not in episode["behind"].split("; ")
    said = capsys.readouterr().out
    assert "1.000" in said
    assert said.splitlines()[-1] == (
        "45 of 45 poses were judged: 0 are before the log's first frame, 0 after its last. "
        "5 are proved wrong, in 1 episode, if every bound of the log holds."
    )


def test_the_line_of_an_alarm_separates_the_estimate_from_the_truth(run, frames, tmp_path):
    shifted = write(tmp_path / "r2.tum", frames, 2, (0.0, -2.0))
    assert watched(run, shifted, tmp_path / "out")[0] == 1
    alarms = rows_in(tmp_path / "out" / "alarms.csv")
    assert len(alarms) == len(frames)
    for alarm, frame in zip(alarms, frames, strict=True):
        normal = np.array([float(alarm["normal_x"]), float(alarm["normal_y"])])
        truth = frame.truth.positions[2]
        beyond = normal @ (truth - np.array([0.0, 2.0])) - float(alarm["offset_m"])
        assert normal @ truth <= float(alarm["offset_m"])
        assert beyond == pytest.approx(float(alarm["distance_m"]), abs=1e-9)


def test_poses_between_frames_are_judged_and_those_outside_the_log_are_counted(run, frames, tmp_path):
    last, there = frames[-1].time, frames[0].truth.positions[0] + 9
    times = np.concatenate([[-0.5, -0.2], np.arange(0.01, last, 0.07), [last + 0.3]])
    path = tmp_path / "r0.tum"
    path.write_text("".join(tum_line(time, there, 0.0) for time in times))
    code, summary = watched(run, path, tmp_path / "out")
    outside = summary["before_first_frame"], summary["after_last_frame"]
    assert (code, summary["poses"], summary["checks"], outside) == (1, len(times), len(times) - 3, (2, 1))
    assert (summary["alarms"], summary["episodes"]) == (len(times) - 3, 1)


def test_a_clock_that_is_known_to_be_off_is_set_right(run, frames, tmp_path):
    path = tmp_path / "r0.tum"
    path.write_text("".join(tum_line(frame.time + 100, frame.truth.positions[0], 0.0) for frame in frames))
    code, summary = watched(run, path, tmp_path / "out", "--offset", "-100", "--tolerance", "0.001")
    assert (code, summary["checks"], summary["alarms"]) == (0, 15, 0)


def test_every_trajectory_in_the_folder_of_a_run_is_judged_the_kalman_filters_too(run, tmp_path):
    code, summary = watched(run, run / "trajectories", tmp_path)
    assert code == int(summary["alarms"] > 0)
    assert (summary["robots"], summary["trajectories"], summary["checks"]) == (3, 9, 135)
    assert {alarm["trajectory"] for alarm in rows_in(tmp_path / "alarms.csv")} <= {"ekf"}


@pytest.mark.parametrize("back", ["0", "0.35"])
def test_regions_are_traced_as_far_back_as_is_asked(run, frames, tmp_path, back):
    shifted = write(tmp_path / "r2.tum", frames, 2, (0.0, -2.0), since=1.35)
    assert watched(run, shifted, tmp_path / "out", "--back", back)[0] == 1
    (episode,) = rows_in(tmp_path / "out" / "episodes.csv")
    regions = [part for part in episode["behind"].split("; ") if part.startswith("region")]
    oldest = max(float(frame.time) for frame in frames if frame.time < 1.4 - 0.05 - float(back))
    assert all(float(part.split()[-2]) <= oldest for part in regions)


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


def test_a_folder_tells_the_trajectories_of_each_estimator_by_robot(run, tmp_path):
    found = find_trajectories(run / "trajectories", "r*.tum", 3)
    assert {name: sorted(files) for name, files in found.items()} == {name: [0, 1, 2] for name in ("ekf", "filter", "truth")}
    with pytest.raises(InvalidInput, match="none"):
        find_trajectories(tmp_path, "r*.tum", 3)
    (tmp_path / "r3.tum").touch()
    with pytest.raises(InvalidInput, match="r0 to r2"):
        find_trajectories(tmp_path, "r*.tum", 3)
    for name in ("r10_slam.tum", "r10_slam_v1.2.tum", "r4-odometry.tum.gz", "r5.txt"):
        (tmp_path / name).touch()
    found = find_trajectories(tmp_path, "r*.t*", 11)
    assert {name: sorted(files) for name, files in found.items()} == {
        "": [3, 5],
        "odometry": [4],
        "slam": [10],
        "slam_v1.2": [10],
    }
    (tmp_path / "r03.tum").touch()
    with pytest.raises(InvalidInput, match="one trajectory a robot"):
        find_trajectories(tmp_path, "r*.tum", 11)


def test_a_log_that_cannot_be_read_ends_with_exit_code_2(tmp_path, capsys):
    assert main(["--log", str(tmp_path / "log.jsonl"), "--tum", str(tmp_path), "--out", str(tmp_path / "out")]) == 2
    assert "expected a readable log" in capsys.readouterr().err


def test_the_help_explains_every_option(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    for option in Options.__dataclass_fields__:
        assert f"--{option}" in said
