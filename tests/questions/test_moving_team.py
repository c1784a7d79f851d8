import itertools
import json
import shutil
import socket
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from helpers.recordings import rerun, rows_of

import experiments.keeping.recorded
import experiments.keeping.running
import experiments.show.viewer
from experiments.following.scenarios import from_log
from experiments.following.steps import Contacts, steps
from experiments.logs import LogReader, tum_line
from experiments.moving_team import Following, Options, main, scenario_of
from experiments.show.output import Trajectories, output_folder
from experiments.show.viewer import NoViewer, open_viewer
from filter import Bearing, Compass, Frame, InvalidInput, SetMembershipFilter, Team

SHORT = ["--robots", "3", "--duration", "2", "--seed", "5"]
KEYS = {
    "robots",
    "duration_s",
    "rate_hz",
    "seed",
    "errors",
    "solver",
    "checks",
    "escapes",
    "heading_checks",
    "heading_escapes",
    "measurements",
    "measurements_mode",
    "outer_area_mean_m2",
    "outer_area_p95_m2",
    "performance_ratio_mean",
    "performance_ratio_min",
    "searches_mean",
    "rows_max",
    "step_median_ms",
    "step_p95_ms",
    "point_rmse_m",
}


def summary_in(folder):
    return json.loads((folder / "summary.json").read_text())


@pytest.fixture(scope="module")
def simulated(tmp_path_factory):
    """The folder of a short simulated run."""
    folder = tmp_path_factory.mktemp("simulated")
    assert main([*SHORT, "--out", str(folder)]) == 0
    return folder


@pytest.fixture(scope="module")
def replayed(simulated, tmp_path_factory):
    """The folder of its replay."""
    folder = tmp_path_factory.mktemp("replayed")
    assert main(["--replay", str(simulated / "log.jsonl"), "--out", str(folder)]) == 0
    return folder


def changed_log(simulated, path, change):
    """Write the log again with every record changed; None leaves it out."""
    lines = [json.loads(line) for line in (simulated / "log.jsonl").read_text().splitlines()]
    kept = [record for record in map(change, lines) if record is not None]
    path.write_text("".join(json.dumps(record) + "\n" for record in kept))
    return path


def test_a_run_has_a_flat_summary_with_every_key(simulated):
    summary = summary_in(simulated)
    assert summary.keys() >= KEYS
    assert not [value for value in summary.values() if isinstance(value, list | dict)]
    expected = {"robots": 3, "duration_s": 2.0, "rate_hz": 10.0, "seed": 5, "errors": "uniform", "solver": "exact"}
    assert summary.items() >= expected.items()


def test_a_large_team_may_drive_in_the_light_world_and_be_found_in_windows(tmp_path):
    options = ["--robots", "12", "--duration", "1", "--world", "kinematic", "--hops", "1"]
    assert main([*options, "--out", str(tmp_path)]) == 0
    summary = summary_in(tmp_path)
    assert summary["checks"] == 120
    assert summary["performance_ratio_mean"] is None  # nothing is known from inside
    assert main(["--replay", str(tmp_path / "log.jsonl"), "--hops", "1", "--out", str(tmp_path / "again")]) == 0
    again = summary_in(tmp_path / "again")
    assert [again[key] for key in ("outer_area_mean_m2", "rows_max")] == [
        summary[key] for key in ("outer_area_mean_m2", "rows_max")
    ]


def test_a_check_is_one_robot_at_one_frame(simulated):
    summary = summary_in(simulated)
    assert summary["checks"] == summary["heading_checks"] == 20 * 3
    assert summary["escapes"] == summary["heading_escapes"] == 0


NEW_PROCESS = """
import sys
from pathlib import Path
from experiments.following.scenarios import from_log
from experiments.following.steps import steps, warmed_up
from filter import SetMembershipFilter

scenario = from_log(Path(sys.argv[1]))
print(max(step.seconds for step in steps(SetMembershipFilter(scenario.team), scenario)), warmed_up())
"""


def test_no_step_waits_for_what_is_compiled_or_loaded_and_the_summary_tells_how_long_that_took(simulated):
    command = [sys.executable, "-c", NEW_PROCESS, str(simulated / "log.jsonl")]
    run = subprocess.run(command, cwd=Path(__file__).parents[2], capture_output=True, text=True, check=True)
    slowest, waited = map(float, run.stdout.split())
    assert slowest < waited / 2
    assert summary_in(simulated)["warm_up_s"] > 0


def test_a_run_counts_what_its_log_holds(simulated):
    frames = list(LogReader(simulated / "log.jsonl").frames())
    assert len(frames) == 20
    assert summary_in(simulated)["measurements"] == sum(len(record.robot) for frame in frames for record in frame.measurements)


def test_a_run_leaves_a_recording_that_verifies(simulated):
    assert rerun("verify", simulated / "moving_team.rrd").returncode == 0


def test_trajectories_are_tum_files_with_the_exact_truth(simulated):
    files = sorted(file.name for file in (simulated / "trajectories").iterdir())
    assert files == [f"r{robot}_{kind}.tum" for robot in range(3) for kind in ("ekf", "filter", "truth")]
    frames = list(LogReader(simulated / "log.jsonl").frames())
    for robot in range(3):
        lines = (simulated / "trajectories" / f"r{robot}_truth.tum").read_text().splitlines()
        poses = [[float(word) for word in line.split(" ")] for line in lines]
        assert all(len(pose) == 8 for pose in poses)
        assert [pose[0] for pose in poses] == [frame.time for frame in frames]
        assert [pose[1:3] for pose in poses] == [frame.truth.positions[robot].tolist() for frame in frames]
        yaws = [2 * np.arctan2(pose[6], pose[7]) for pose in poses]
        assert yaws == pytest.approx([frame.truth.headings[robot] for frame in frames])


def test_a_step_predicts_with_the_odometry_and_then_updates_with_the_measurements(simulated):
    scenario = from_log(simulated / "log.jsonl")
    followed = SetMembershipFilter(scenario.team)
    belief = followed.start(0.0, [known.polygon() for known in scenario.initial])
    frames = LogReader(simulated / "log.jsonl").frames()
    for step, frame in zip(steps(followed, scenario), frames, strict=True):
        moved = followed.predict(belief, frame.time, frame.odometry) if frame.odometry else belief
        belief = followed.update(moved, frame.measurements)
        areas = [region.outer.area for region in step.belief.regions]
        assert areas == [region.outer.area for region in belief.regions]
        assert step.seconds > 0


def test_what_a_log_knows_of_the_first_headings_reaches_the_filter(simulated, tmp_path):
    def known(record):
        if record["record"] == "initial" and record["robot"] == 1:
            record["heading"] = {"centre": 3.1, "bound": 0.2}
        return None if record["record"] in ("compass", "bearing") else record

    scenario = from_log(changed_log(simulated, tmp_path / "log.jsonl", known))
    headings = next(steps(SetMembershipFilter(scenario.team), scenario)).belief.headings
    assert headings.full.tolist() == [True, False, True]
    assert (headings.centre[1], headings.bound[1]) == pytest.approx((3.1, 0.2))


def test_the_filters_trajectory_is_of_centroids_and_interval_centres(simulated):
    scenario = from_log(simulated / "log.jsonl")
    lines = (simulated / "trajectories" / "r1_filter.tum").read_text().splitlines(keepends=True)
    made = list(steps(SetMembershipFilter(scenario.team), scenario))
    expected = [(s.frame.time, s.belief.regions[1].outer.centroid, float(s.belief.headings.centre[1])) for s in made]
    assert lines == [tum_line(*pose) for pose in expected]


def test_a_tum_line_has_eight_numbers_with_one_blank_between():
    assert tum_line(0.1, np.array([1.5, -2.0]), np.pi) == f"0.1 1.5 -2.0 0.0 0.0 0.0 1.0 {float(np.cos(np.pi / 2))!r}\n"


def test_a_replay_gives_the_same_regions_byte_for_byte(simulated, replayed):
    for file in (simulated / "trajectories").iterdir():
        assert (replayed / "trajectories" / file.name).read_bytes() == file.read_bytes()
    for robot in range(3):
        path, column = f"/world/outer/r{robot}", "LineStrips3D:strips"
        assert rows_of(replayed / "moving_team.rrd", path, column) == rows_of(simulated / "moving_team.rrd", path, column)


def test_a_replay_writes_the_same_log_and_the_same_summary_but_for_times(simulated, replayed):
    assert (replayed / "log.jsonl").read_bytes() == (simulated / "log.jsonl").read_bytes()
    one, other = summary_in(simulated), summary_in(replayed)
    differ = {"seed", "errors", "measurements_mode", "replay", "step_median_ms", "step_p95_ms"}
    assert {key: value for key, value in one.items() if key not in differ} == {
        key: value for key, value in other.items() if key not in differ
    }


def test_the_same_seed_gives_the_same_run(simulated, tmp_path):
    assert main([*SHORT, "--out", str(tmp_path)]) == 0
    assert (tmp_path / "log.jsonl").read_bytes() == (simulated / "log.jsonl").read_bytes()
    assert rerun("compare", "--unordered", tmp_path / "moving_team.rrd", simulated / "moving_team.rrd").returncode == 0


def test_a_log_without_truth_has_no_checks(simulated, tmp_path):
    log = changed_log(simulated, tmp_path / "log.jsonl", lambda record: None if record["record"] == "truth" else record)
    assert main(["--replay", str(log), "--out", str(tmp_path / "out")]) == 0
    summary = summary_in(tmp_path / "out")
    assert (summary["checks"], summary["point_rmse_m"]) == (0, None)
    assert summary["outer_area_mean_m2"] == summary_in(simulated)["outer_area_mean_m2"]
    assert not list((tmp_path / "out" / "trajectories").glob("*_truth.tum"))


@pytest.mark.parametrize(
    ("column", "wrong", "key"), [("positions", [5.0, 5.0], "escapes"), ("headings", 3.0, "heading_escapes")]
)
def test_an_escape_ends_with_exit_code_1(simulated, tmp_path, column, wrong, key):
    def moved(record):
        if record["record"] == "truth" and record["time"] == 1.0:
            record[column][2] = wrong
        return record

    log = changed_log(simulated, tmp_path / "log.jsonl", moved)
    assert main(["--replay", str(log), "--out", str(tmp_path / "out")]) == 1
    summary = summary_in(tmp_path / "out")
    assert (summary["checks"], summary[key]) == (60, 1)
    events = [row["value"][0] for row in rows_of(tmp_path / "out" / "moving_team.rrd", "/events", "TextLog:text")]
    assert [event for event in events if "escaped" in event] == [f"1.0 s: r2: the {column[:-1]} escaped"]


def broken(record):
    if record["record"] == "range" and record["time"] == 1.0:
        record["range"] = [3 * value + 1 for value in record["range"]]
    return record


def test_what_is_rejected_suspends_the_guarantee_and_everything_says_so(simulated, tmp_path, capsys):
    log, out = changed_log(simulated, tmp_path / "log.jsonl", broken), tmp_path / "out"
    assert main(["--replay", str(log), "--policy", "reject", "--out", str(out)]) == 4
    summary = summary_in(out)
    assert summary["doubts"] > 0
    assert (summary["guarantee_in_force"], summary["guarantee_suspended_since_s"]) == (False, 1.0)
    assert "more is wrong than one of: " in summary["guarantee_suspended_because"]
    told = capsys.readouterr()
    assert "guarantee_in_force" in told.out
    assert "since 1.000 s, as more is wrong than one of: " in " ".join(told.err.split())
    events = [row["value"][0] for row in rows_of(out / "moving_team.rrd", "/events", "TextLog:text")]
    assert [event[:29] for event in events if "guarantee suspended for" in event] == ["1.0 s: guarantee suspended fo"]
    assert len(rows_of(out / "moving_team.rrd", "/world/suspended/r0", "LineStrips3D:strips")) == 10


def test_an_escape_while_nothing_is_promised_ends_with_4_and_a_broken_promise_with_1(simulated, tmp_path):
    def moved(time):
        def change(record):
            if record["record"] == "truth" and record["time"] == time:
                record["positions"][2] = [5.0, 5.0]
            return broken(record)

        return change

    for time, code in ((0.5, 1), (1.5, 4)):
        log, out = changed_log(simulated, tmp_path / f"{time}.jsonl", moved(time)), tmp_path / str(time)
        assert main(["--replay", str(log), "--policy", "reject", "--out", str(out)]) == code
        assert summary_in(out)["escapes"] == 1
        assert summary_in(out)["escapes_in_force"] == (code == 1)


def test_measurements_that_disagree_end_with_exit_code_1_and_whole_files(simulated, tmp_path, capsys):
    log = changed_log(simulated, tmp_path / "log.jsonl", broken)
    out = tmp_path / "out"
    assert main(["--replay", str(log), "--out", str(out)]) == 1
    summary = summary_in(out)
    assert summary["checks"] == 30
    assert "range of r" in summary["inconsistent"]
    assert "the filter stopped" in capsys.readouterr().err
    assert rerun("verify", out / "moving_team.rrd").returncode == 0
    assert [frame.time for frame in LogReader(out / "log.jsonl").frames()][-1] == 1.0


def test_a_log_that_is_cut_off_ends_with_exit_code_2_and_its_line(simulated, tmp_path, capsys):
    log = tmp_path / "log.jsonl"
    log.write_bytes((simulated / "log.jsonl").read_bytes()[:-3])
    assert main(["--replay", str(log), "--out", str(tmp_path / "out")]) == 2
    last = len(log.read_bytes().splitlines())
    assert f"line {last}: expected a whole line" in capsys.readouterr().err
    assert not (tmp_path / "out" / "summary.json").exists()


@pytest.mark.parametrize("mode", ["absolute", "none"])
def test_measurements_can_be_left_out(simulated, tmp_path, mode):
    assert main([*SHORT, "--measurements", mode, "--out", str(tmp_path)]) == 0
    fewer, all_of_them = summary_in(tmp_path), summary_in(simulated)
    assert fewer["measurements_mode"] == mode
    assert fewer["measurements"] < all_of_them["measurements"]
    assert fewer["outer_area_mean_m2"] > all_of_them["outer_area_mean_m2"]
    assert (tmp_path / "trajectories" / "r0_truth.tum").read_bytes() == (
        simulated / "trajectories" / "r0_truth.tum"
    ).read_bytes()


BAD = {
    "no robots": (["--robots", "0"], "robots"),
    "an unknown solver": (["--solver", "oracle"], "solver"),
    "no time": (["--duration", "0"], "duration"),
    "a duration that is no number": (["--duration", "nan"], "duration"),
    "a rate that no timestep divides": (["--rate", "7"], "rate"),
    "a negative seed": (["--seed", "-1"], "seed"),
    "a log that is not there": (["--replay", "nothing.jsonl"], "nothing.jsonl: expected a readable log"),
    "a seed for a log": (["--replay", "nothing.jsonl", "--seed", "3"], "--seed with --replay"),
    "a camera for a log": (["--replay", "nothing.jsonl", "--camera"], "--camera with --replay"),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_options_end_with_a_message_and_exit_code_2(tmp_path, capsys, what):
    options, message = BAD[what]
    assert main([*options, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize(
    "options", [["--robots", "many"], ["--errors", "strange"], ["--measurements", "some"], ["--colour", "red"]]
)
def test_options_of_the_wrong_kind_end_with_exit_code_2(options):
    with pytest.raises(SystemExit) as ended:
        main(options)
    assert ended.value.code == 2


def test_the_help_explains_every_option(capsys):
    with pytest.raises(SystemExit) as ended:
        main(["--help"])
    assert ended.value.code == 0
    said = capsys.readouterr().out
    for option in Options.__dataclass_fields__:
        assert f"--{option}" in said


def test_a_folder_that_cannot_be_written_to_is_told(tmp_path, capsys):
    (tmp_path / "file").touch()
    assert main([*SHORT, "--out", str(tmp_path / "file" / "out")]) == 2
    assert "an output folder that can be written to" in capsys.readouterr().err
    with pytest.raises(InvalidInput):
        output_folder(tmp_path / "file")


def test_a_run_that_fails_leaves_no_summary_of_an_earlier_one(tmp_path):
    (tmp_path / "summary.json").write_text("{}")
    output_folder(tmp_path)
    assert not (tmp_path / "summary.json").exists()


def test_a_log_is_never_replayed_onto_itself(simulated, tmp_path, capsys):
    shutil.copy(simulated / "log.jsonl", tmp_path)
    assert main(["--replay", str(tmp_path / "log.jsonl"), "--out", str(tmp_path / "x" / "..")]) == 2
    assert "another --out" in capsys.readouterr().err
    assert (tmp_path / "log.jsonl").read_bytes() == (simulated / "log.jsonl").read_bytes()


def test_ctrl_c_ends_with_a_message_and_whole_files(tmp_path, monkeypatch, capsys):
    def interrupted(*arguments, **options):
        for step in steps(*arguments, **options):
            yield step
            if step.frame.time >= 0.5:
                raise KeyboardInterrupt

    monkeypatch.setattr(experiments.keeping.running, "steps", interrupted)
    assert main([*SHORT, "--out", str(tmp_path)]) == 130
    assert "stopped" in capsys.readouterr().err
    assert rerun("verify", tmp_path / "moving_team.rrd").returncode == 0
    assert [frame.time for frame in LogReader(tmp_path / "log.jsonl").frames()][-1] == 0.5


def test_trajectories_are_whole_however_long_they_are(tmp_path, simulated, monkeypatch):
    monkeypatch.setattr("experiments.show.output.FRAMES_KEPT", 3)
    scenario = from_log(simulated / "log.jsonl")
    with Trajectories(tmp_path, scenario.team) as trajectories:
        for step in steps(SetMembershipFilter(scenario.team), scenario):
            trajectories.write(step.frame, step.belief)
    for file in (simulated / "trajectories").glob("*_[!e]*.tum"):
        assert (tmp_path / "trajectories" / file.name).read_bytes() == file.read_bytes()


def test_the_camera_takes_a_picture_every_second(tmp_path):
    options = Options(robots=2, duration=2.5, camera=True)
    scenario = replace(scenario_of(options), picture=lambda: np.zeros((4, 6, 3), dtype=np.uint8))
    Following(options, scenario, tmp_path).run(SetMembershipFilter(scenario.team))
    images = rows_of(tmp_path / "moving_team.rrd", "/camera", "EncodedImage:media_type")
    assert [row["step"] for row in images] == [0, 10, 20]


def test_a_live_viewer_that_cannot_be_opened_is_told(tmp_path, monkeypatch, capsys):
    def nothing():
        raise NoViewer("none here")

    monkeypatch.setattr(experiments.keeping.recorded, "open_viewer", nothing)
    assert main([*SHORT, "--view", "--out", str(tmp_path)]) == 2
    assert "no live viewer (none here)" in capsys.readouterr().err


def test_an_open_viewer_is_used_and_one_that_dies_is_told(monkeypatch):
    with socket.create_server(("127.0.0.1", 0)) as server:
        monkeypatch.setattr(experiments.show.viewer, "PORT", server.getsockname()[1])
        assert open_viewer() == f"rerun+http://127.0.0.1:{server.getsockname()[1]}/proxy"
    monkeypatch.setattr(experiments.show.viewer, "_program", lambda: shutil.which("false"))
    with pytest.raises(NoViewer, match="ended with 1"):
        open_viewer()


def test_contacts_tell_what_has_changed():
    contacts, times = Contacts(Team(3, landmarks=[[0.0, 0.0]])), itertools.count(0.0)

    def seen(robots, targets):
        time = next(times)
        bearings = (Bearing(time, robots, targets, np.zeros(len(robots)), 0.1),) if robots else ()
        return contacts.changes(Frame(time, None, (Compass(time, [0, 1, 2], 0.0, 0.1), *bearings), None))

    assert seen([], []) == []
    assert seen([0, 0], [1, 3]) == ["r0 sees l0", "r0 is in sight of the team", "r1 is in sight of the team"]
    assert seen([0, 0], [1, 3]) == []
    assert seen([0], [3]) == ["r1 is on its own"]
    assert seen([1], [2]) == [
        "r0 no longer sees l0",
        "r0 is on its own",
        "r1 is in sight of the team",
        "r2 is in sight of the team",
    ]
    assert [contacts.changes(Frame(4.0 + short, None, (), None)) for short in (0.1, 0.4)] == [
        [],
        [],
    ]  # of another sensor's stamp
    assert contacts.changes(Frame(4.6, None, (), None)) == ["r1 is on its own", "r2 is on its own"]
