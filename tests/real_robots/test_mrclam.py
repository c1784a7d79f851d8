import json
import re
from dataclasses import replace

import numpy as np
import pytest
from helpers.mrclam_folder import CLOCK, Made, write_run
from helpers.recordings import rows_of

from experiments import mrclam
from experiments.following.steps import steps
from experiments.logs import read_trajectory
from experiments.mrclam import Changes, main, numbers_of
from experiments.real_robots.bounds import Bounds
from experiments.real_robots.data import read_run
from experiments.real_robots.faults import FAULTS
from experiments.real_robots.figures import stretches
from experiments.real_robots.followed import Followed, team_filter
from experiments.real_robots.frames import Start, frames
from experiments.real_robots.kalman import kalman_filter
from experiments.real_robots.metrics import Escaped, Table, Tally, longest, measured_by, summary_of
from experiments.real_robots.motion import Motions
from filter import Guarantee, InvalidInput, Polygon, Team

KEYS = {
    "checks",
    "escapes",
    "escape_share",
    "longest_escape_s",
    "suspended_share",
    "rejected",
    "resets",
    "outer_area_median_m2",
    "outer_area_p95_m2",
    "set_rmse_m",
    "ekf_rmse_m",
    "ekf_containment_997",
    "heading_checks",
    "heading_escapes",
    "step_median_ms",
    "real_time_factor",
    "escapes_in_force",
}


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("data") / "made", Made(duration=4.0))


@pytest.fixture(scope="module")
def ran(folder, tmp_path_factory):
    """A finished run: its folder and its summary."""
    out = tmp_path_factory.mktemp("out")
    assert main(["--data", str(folder), "--robots", "1,2", "--out", str(out)]) == 0
    return out, json.loads((out / "summary.json").read_text())


@pytest.fixture(scope="module")
def scenario_frames(folder):
    return list(frames(read_run(folder), (1, 2)).frames)


def test_a_run_whose_bounds_hold_has_no_escape_and_rejects_nothing(ran, folder):
    _, summary = ran
    assert set(summary) >= KEYS
    assert summary["checks"] == sum(len(log.measurements) for log in read_run(folder).logs.values())
    for key in ("escapes", "escapes_in_force", "heading_escapes", "rejected", "resets", "suspended_share", "longest_escape_s"):
        assert summary[key] == 0
    assert 0 < summary["set_rmse_m"] < 0.6
    assert 0 < summary["ekf_rmse_m"] < 0.6


def test_a_run_leaves_its_figures_its_trajectories_and_its_recording(ran, scenario_frames):
    out, summary = ran
    for name in ("area.png", "error.png"):
        assert (out / name).stat().st_size > 10_000
    for robot in (0, 1):
        for kind in ("filter", "ekf", "truth"):
            assert len(read_trajectory(out / "trajectories" / f"r{robot}_{kind}.tum").times) == summary["frames"]
    truth = read_trajectory(out / "trajectories" / "r1_truth.tum")
    np.testing.assert_array_equal(truth.positions, [frame.truth.positions[1] for frame in scenario_frames])
    rows = rows_of(out / "mrclam.rrd", "/world/ellipse/r0", "LineStrips3D:strips")
    assert len(rows) > 5


def test_the_same_seed_gives_the_same_run_to_the_last_bit(ran, folder, tmp_path):
    out, _ = ran
    assert main(["--data", str(folder), "--robots", "1,2", "--duration", "1.6", "--out", str(tmp_path)]) == 0
    for name in ("r0_filter.tum", "r1_ekf.tum"):
        part = (tmp_path / "trajectories" / name).read_text()
        assert part
        assert (out / "trajectories" / name).read_text().startswith(part)


def shrunk(scenario, motions, suspended):
    """A filter that lies: it says that each robot is in a tiny square far away."""
    told = Guarantee.full(2).suspended(0.0, "votes") if suspended else Guarantee.full(2)
    for step in team_filter(scenario, motions):
        square = Polygon.box([90, 90], [91, 91])
        regions = tuple(replace(region, outer=square) for region in step.belief.regions)
        yield replace(step, belief=replace(step.belief, regions=regions), guarantee=told)


@pytest.mark.parametrize(("suspended", "code"), [(False, 1), (True, 4)])
def test_the_exit_code_is_one_only_for_an_escape_while_the_guarantee_is_in_force(
    folder, tmp_path, monkeypatch, suspended, code
):
    monkeypatch.setattr(mrclam, "team_filter", lambda scenario, motions, *_: shrunk(scenario, motions, suspended))
    assert main(["--data", str(folder), "--robots", "1,2", "--duration", "1.6", "--out", str(tmp_path)]) == code
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["escape_share"] == 1
    assert summary["escapes_in_force"] == (0 if suspended else summary["checks"])
    assert summary["longest_escape_s"] > 0.5
    assert summary["suspended_share"] == float(suspended)
    assert summary["guarantee_in_force"] != suspended
    assert summary["guarantee_suspended_because"] == ("suspended for r0, r1 since 0.000 s, as votes" if suspended else None)
    assert summary["too_short"]
    levels = rows_of(tmp_path / "mrclam.rrd", "/events", "TextLog:level")
    assert "ERROR" in {row["value"][0] for row in levels}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_faulty_run_ends_without_a_crash(folder, tmp_path, monkeypatch, fault):
    monkeypatch.setattr(mrclam, "draw_all", lambda *_: None)  # the figures are those of any run
    options = ["--robots", "1,2", "--duration", "1.1", "--fault", fault, "--fault-robot", "2"]
    assert main(["--data", str(folder), *options, "--out", str(tmp_path)]) in (0, 1)
    assert json.loads((tmp_path / "summary.json").read_text())["fault"] == f"{fault}, robot 2"


@pytest.mark.parametrize(
    "options",
    [["--robots", "1,x"], ["--robots", "7"], ["--fault", "lazy"], ["--start", "1e6"], ["--data", "nowhere"], ["--seed", "-1"]],
)
def test_bad_input_ends_with_two(folder, tmp_path, options, capsys):
    assert main(["--data", str(folder), "--robots", "1,2", *options, "--out", str(tmp_path)]) == 2
    assert "expected" in capsys.readouterr().err


def test_a_run_without_truth_is_followed_and_not_judged(tmp_path):
    own = write_run(tmp_path / "own", Made(duration=1.6))
    for path in own.glob("Robot*_Groundtruth.dat"):
        path.unlink()
    assert main(["--data", str(own), "--robots", "1,2", "--out", str(tmp_path / "out")]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    assert (summary["checks"], summary["frame_checks"], summary["ekf_rmse_m"]) == (0, 0, None)
    assert summary["frames"] > 0
    assert not (tmp_path / "out" / "trajectories" / "r0_truth.tum").exists()


def test_robots_are_numbers_with_commas():
    assert numbers_of("3, 1,2") == (3, 1, 2)
    with pytest.raises(InvalidInput, match="commas"):
        numbers_of("1;2")


def test_the_kalman_filter_follows_and_keeps_the_truth_in_its_ellipses(folder):
    scenario = frames(read_run(folder), (1, 2), known=Start(0.1, 0.05), generator=np.random.default_rng(4))
    wide = []
    for step in steps(kalman_filter(scenario.team), scenario):
        estimate = step.belief
        errors = estimate.mean[:, :2] - step.frame.truth.positions
        wide += [e @ np.linalg.solve(P, e) < 11.6 for e, P in zip(errors, estimate.position_covariances, strict=True)]
    assert np.mean(wide) > 0.9
    assert estimate.rejected == 0


def test_an_escape_lasts_from_the_first_frame_outside_to_the_first_one_inside():
    time = np.array([0.0, 1.0, 2.0, 4.0, 7.0, 8.0])
    known = np.ones((6, 2), dtype=bool)
    out = np.zeros((6, 2), dtype=bool)
    assert longest(time, known, out) == 0
    out[1:3, 0] = True
    assert longest(time, known, out) == 3.0
    out[4:, 1] = True  # to the end
    assert longest(time, known, out) == 3.0
    known[3, 0] = False  # nobody knows whether it was back
    assert longest(time, known, out) == 6.0
    assert longest(time, np.zeros_like(known), out) == 0


def table(**changed):
    k, n = 4, 2
    plain = {
        "time": np.array([1.0, 2.0, 3.0, 4.0]),
        "weight": np.array([[1, 0], [2, 1], [0, 1], [3, 0]]),
        "rejected": np.zeros((k, n), dtype=np.int64),
        "seconds": np.full(k, 0.1),
    }
    plain |= {name: np.ones((k, n), dtype=bool) for name in ("known", "inside", "turned", "ekf_inside")}
    plain |= {name: np.full((k, n), 2.0) for name in ("area", "error", "ekf_error", "ekf_area")}
    return Table(**(plain | {"suspended": np.zeros((k, n), dtype=bool)} | changed))


def test_a_check_is_one_robot_at_one_of_its_measurements_that_has_truth():
    inside, known, suspended = np.ones((4, 2), dtype=bool), np.ones((4, 2), dtype=bool), np.zeros((4, 2), dtype=bool)
    inside[1, 0] = inside[3, 1] = False  # the second one measured nothing then
    known[3, 0] = False
    suspended[1, 0] = True
    summary = summary_of(table(inside=inside, known=known, suspended=suspended), 0.0, 3)
    assert (summary["checks"], summary["escapes"], summary["escapes_in_force"]) == (5, 2, 0)
    assert summary["escape_share"] == pytest.approx(0.4)
    assert (summary["frame_checks"], summary["frame_escapes"], summary["frame_escapes_in_force"]) == (7, 2, 1)
    assert summary["suspended_share"] == pytest.approx(1 / 8)
    assert summary["resets"] == 3
    assert summary["real_time_factor"] == pytest.approx(10.0)


def test_areas_and_errors_are_those_at_the_checks():
    area = np.array([[1.0, 50.0], [2.0, 3.0], [70.0, 4.0], [5.0, 90.0]])
    error = area.copy()
    error[3, 0] = np.nan
    known = np.isfinite(error)
    summary = summary_of(table(area=area, error=error, known=known), 0.0, 0)
    assert summary["outer_area_median_m2"] == pytest.approx(np.median([1, 2, 2, 3, 4]))
    assert summary["set_rmse_m"] == pytest.approx(np.sqrt(np.mean(np.square([1, 2, 2, 3, 4]))), rel=1e-5)


def test_nothing_is_said_of_a_run_without_truth():
    nobody = np.zeros((4, 2), dtype=bool)
    summary = summary_of(table(known=nobody, error=np.full((4, 2), np.nan), ekf_error=np.full((4, 2), np.nan)), 0.0, 0)
    assert summary["checks"] == 0
    assert (summary["escape_share"], summary["set_rmse_m"], summary["frame_escape_share"]) == (None, None, None)


def test_a_tally_counts_what_each_robot_measured(folder, scenario_frames):
    scenario, again = (frames(read_run(folder), (1, 2)) for _ in range(2))
    tally, estimates = Tally(0.0), steps(kalman_filter(scenario.team), again)
    for step in team_filter(scenario, Motions(read_run(folder), (1, 2), Bounds())):
        escaped = tally.add(step, next(estimates).belief)
        assert not escaped.positions.any()
        if len(tally.table().time) == 3:
            break
    found = tally.table()
    assert found.weight.tolist() == [measured_by(frame, 2).tolist() for frame in scenario_frames[:3]]
    assert found.weight.sum() == sum(len(frame.measurements[0].robot) for frame in scenario_frames[:3])
    assert (found.area > 0).all()


def test_what_lasts_is_told_once_and_its_end_too():
    changes, nobody = Changes(Team(2)), np.zeros(2, dtype=bool)

    def told(outside, suspended, events=()):
        told = Guarantee(np.where(suspended, 1.0, np.inf), tuple("votes" if each else "" for each in suspended))
        step = Followed(None, None, told, nobody, (), 0, (), events, 0.0)
        return changes.words(step, Escaped(np.array(outside), nobody, np.array(suspended)))

    assert told([False, False], [False, False]) == []
    assert told([True, False], [False, True], ("rejected it",)) == [
        ("rejected it", "WARN"),
        ("r1: guarantee suspended, as votes", "WARN"),
        ("r0: truth outside the polygon", "ERROR"),
    ]
    assert told([True, False], [False, True]) == []
    assert told([False, False], [False, False]) == [
        ("r1: guarantee in force again", "INFO"),
        ("r0: truth inside again", "INFO"),
    ]


def test_a_robot_that_falls_silent_and_a_log_that_was_written_twice_are_named_in_the_events(tmp_path):
    folder, out = write_run(tmp_path / "made", Made(duration=12.0)), tmp_path / "out"
    for kind in ("Odometry", "Measurement"):
        path = folder / f"Robot1_{kind}.dat"
        lines = path.read_text().splitlines(keepends=True)
        path.write_text("".join(lines + lines[-3:]))
    path = folder / "Robot2_Odometry.dat"
    kept = [line for line in path.read_text().splitlines(keepends=True) if "#" in line or not 3 < stamp_of(line) < 9]
    path.write_text("".join(kept))
    main(["--data", str(folder), "--robots", "1,2", "--out", str(out)])  # commands that were lost break what is declared
    events = [line.split(maxsplit=2) for line in (out / "events.txt").read_text().splitlines()]
    assert events[0][1] == "WARN"
    assert re.fullmatch(r"r0: 6 of \d+ lines of its log repeat others, and are left out", events[0][2])
    told = [(float(time), text) for time, _, text in events if text.startswith("r1:") and "commands" in text]
    assert [text for _, text in told] == ["r1: no commands, nothing is known of its motion", "r1: commands again"]
    assert told[0][0] == pytest.approx(3 + Bounds().hold, abs=0.8)
    assert told[1][0] == pytest.approx(9, abs=0.8)


def stamp_of(line):
    return float(line.split()[0]) - CLOCK


def test_stretches_end_where_it_holds_no_longer():
    times = np.array([0.0, 1.0, 2.0, 3.0, 5.0])
    assert list(stretches(times, np.array([True, True, False, False, True]))) == [(0.0, 2.0), (5.0, 5.0)]
    assert list(stretches(times, np.zeros(5, dtype=bool))) == []
