import csv
import json
import os
import shutil
import signal
import subprocess
import sys
import time

import numpy as np
import pytest
from helpers.recordings import rerun, rows_of

import experiments.ekf_comparison
from experiments.against_ekf.figures import nees_band
from experiments.against_ekf.recording import Episodes
from experiments.against_ekf.table import kept_every_truth, summary_of, write_csv
from experiments.against_ekf.tuning import TUNED, odometry_deviations
from experiments.ekf_comparison import main
from experiments.following.ellipses import (
    WIDE_SIZE,
    EllipseTally,
    ellipse_areas,
    neighbours,
    normalised_squares,
    outside,
)
from experiments.following.side_by_side import Case, compare
from experiments.following.steps import steps
from experiments.paper.merge_orders import compare_orders, spread_over_orders, static_case
from experiments.show.terminal import too_short
from filter import Frame, GaussianBelief, Inconsistent, Polygon, SetMembershipFilter, Stop, Team, Truth, follow, watch
from sim.episode import episode
from sim.errors import ERROR_KINDS, Errors

TINY = ["--runs", "2", "--robots", "2", "--duration", "0.5", "--seed", "3"]
REQUIRED = (
    "set_containment",
    "ekf_containment_95",
    "ekf_containment_997",
    "set_area_m2",
    "ekf_area_997_m2",
    "set_rmse_m",
    "ekf_rmse_m",
    "ekf_nees_mean",
    "ekf_proved_wrong_share",
    "set_step_ms",
    "ekf_step_ms",
)
NAMES = sorted(f"{kind}-{seed}" for kind in ERROR_KINDS for seed in (3, 4))


def few_orders(seed):
    return compare_orders(seed, cases=1, orders=2)


@pytest.fixture(autouse=True)
def fewer_orders(monkeypatch):
    monkeypatch.setattr(experiments.ekf_comparison, "compare_orders", few_orders)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    """The folder of a tiny sweep by two workers."""
    folder = tmp_path_factory.mktemp("swept")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(experiments.ekf_comparison, "compare_orders", few_orders)
        assert main([*TINY, "--workers", "2", "--out", str(folder)]) == 0
    return folder


def summary_in(folder):
    return json.loads((folder / "summary.json").read_text())


def rows_in(path):
    with path.open(newline="") as file:
        return list(csv.DictReader(file))


def test_a_sweep_has_a_flat_summary_with_every_key(swept):
    summary = summary_in(swept)
    assert not [value for value in summary.values() if isinstance(value, list | dict)]
    assert {f"{kind}_{key}" for kind in ERROR_KINDS for key in REQUIRED} <= summary.keys()
    assert (summary["runs"], summary["checks"], summary["nees_expected"]) == (8, 8 * 5 * 2, 2)
    assert {summary[f"{kind}_set_containment"] for kind in ERROR_KINDS} == {1.0}
    assert all(isinstance(summary[f"{kind}_{key}"], int | float) for kind in ERROR_KINDS for key in REQUIRED)


def test_a_short_sweep_warns_that_a_longer_one_may_say_the_opposite(swept, capsys):
    assert summary_in(swept)["too_short"]
    for runs, seconds, warned in ((20, 60.0, False), (19, 60.0, True), (20, 59.0, True)):
        assert too_short("who is ahead", runs=(runs, 20), seconds_a_run=(seconds, 60.0)) == warned
        err = " ".join(capsys.readouterr().err.split())
        assert ("who is ahead can come out the other way in longer runs" in err) == warned
        assert ("runs: 19, where 20 are enough" in err) == (runs == 19)


def test_the_table_of_runs_is_sorted_and_has_one_row_a_run_and_no_timings(swept):
    rows = rows_in(swept / "runs.csv")
    assert [f"{row['errors']}-{row['seed']}" for row in rows] == NAMES
    assert not [column for column in rows[0] if column.endswith("_ms")]
    timings = rows_in(swept / "timings.csv")
    assert [f"{row['errors']}-{row['seed']}" for row in timings] == NAMES
    assert all(float(row["set_step_ms"]) > float(row["ekf_step_ms"]) > 0 for row in timings)


def test_both_settings_of_the_kalman_filter_are_in_the_table(swept):
    row = rows_in(swept / "runs.csv")[0]
    assert row["ekf_area_997_m2"] != row["ekf_conservative_area_997_m2"]
    words = (swept / "table.md").read_text()
    assert "EKF, tuned" in words
    assert "EKF, bound = 3 deviations" in words
    assert "area: outer polygon, 99.7 % ellipse [m2]" in words


def test_a_sweep_leaves_figures_and_a_recording_that_verifies(swept):
    for name in ("containment", "area", "nees", "rmse"):
        assert (swept / f"{name}.png").read_bytes().startswith(b"\x89PNG")
    assert rerun("verify", swept / "ekf_comparison.rrd").returncode == 0


def test_the_recording_has_an_ellipse_of_33_points_for_every_robot_and_step(swept):
    for robot in range(2):
        rows = rows_of(swept / "ekf_comparison.rrd", f"/world/ellipse/r{robot}", "LineStrips3D:strips")
        assert [row["step"] for row in rows] == list(range(5))
        strips = [np.array(row["value"][0]) for row in rows]
        assert {strip.shape for strip in strips} == {(33, 3)}
        assert all(strip[0] == pytest.approx(strip[-1]) for strip in strips)


def test_the_table_is_the_same_byte_for_byte_with_one_worker(swept, tmp_path):
    assert main([*TINY, "--workers", "1", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "runs.csv").read_bytes() == (swept / "runs.csv").read_bytes()


def test_the_table_is_the_same_byte_for_byte_on_a_dask_cluster(swept, tmp_path):
    distributed = pytest.importorskip("distributed")
    with distributed.LocalCluster(
        n_workers=2, threads_per_worker=1, host="127.0.0.1", dashboard_address=None, silence_logs=50
    ) as cluster:
        assert main([*TINY, "--scheduler", cluster.scheduler_address, "--out", str(tmp_path)]) == 0
    assert (tmp_path / "runs.csv").read_bytes() == (swept / "runs.csv").read_bytes()
    results = [json.loads((tmp_path / "runs" / f"{name}.json").read_text()) for name in NAMES]
    assert [result["row"] for result in results] == [
        json.loads((swept / "runs" / f"{name}.json").read_text())["row"] for name in NAMES
    ]


def test_a_sweep_that_was_killed_goes_on_to_the_same_table(tmp_path):
    options = ["--runs", "2", "--robots", "2", "--duration", "0.3", "--workers", "1"]
    killed, whole = tmp_path / "killed", tmp_path / "whole"
    command = [sys.executable, "-m", "experiments.ekf_comparison", *options, "--out", str(killed)]
    sweep = subprocess.Popen(command, start_new_session=True, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    end = time.monotonic() + 120
    while len(list(killed.glob("runs/*.json"))) < 2 and time.monotonic() < end:
        time.sleep(0.02)
    os.killpg(sweep.pid, signal.SIGKILL)
    sweep.wait()
    written = {path: path.stat().st_mtime_ns for path in killed.glob("runs/*.json")}
    assert 2 <= len(written) < 8
    assert not (killed / "summary.json").exists()
    assert main([*options, "--resume", "--out", str(killed)]) == 0
    assert {path: path.stat().st_mtime_ns for path in written} == written
    assert main([*options, "--out", str(whole)]) == 0
    assert (killed / "runs.csv").read_bytes() == (whole / "runs.csv").read_bytes()
    assert summary_in(killed)["runs"] == 8


def test_a_sweep_can_be_made_longer(swept, tmp_path):
    for name in ("runs", "options.json"):
        copy = shutil.copytree if (swept / name).is_dir() else shutil.copy
        copy(swept / name, tmp_path / name)
    before = (tmp_path / "runs" / "bias-3.json").stat().st_mtime_ns
    assert main([*TINY, "--runs", "3", "--resume", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "runs" / "bias-3.json").stat().st_mtime_ns == before
    assert len(rows_in(tmp_path / "runs.csv")) == 12
    assert [row for row in rows_in(tmp_path / "runs.csv") if row["seed"] != "5"] == rows_in(swept / "runs.csv")


BAD = {
    "no runs": (["--runs", "0"], "runs: finite numbers within [1"),
    "no robots": (["--robots", "0"], "robots"),
    "no time": (["--duration", "0"], "duration"),
    "a negative seed": (["--seed", "-1"], "seed"),
    "no workers": (["--workers", "0"], "workers"),
    "workers and a scheduler": (["--workers", "1", "--scheduler", "tcp://127.0.0.1:1"], "either workers"),
}


@pytest.mark.parametrize("what", BAD)
def test_bad_options_end_with_a_message_and_exit_code_2(tmp_path, capsys, what):
    options, message = BAD[what]
    assert main([*TINY, *options, "--out", str(tmp_path / "out")]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert "Traceback" not in said


def test_a_folder_with_results_is_left_alone_unless_asked_to_resume(swept, capsys):
    before = (swept / "summary.json").read_bytes()
    assert main([*TINY, "--out", str(swept)]) == 2
    assert "--resume to go on" in capsys.readouterr().err
    assert main([*TINY, "--duration", "0.6", "--resume", "--out", str(swept)]) == 2
    assert "came duration 0.5" in capsys.readouterr().err
    assert (swept / "summary.json").read_bytes() == before


def test_a_robot_that_escapes_ends_with_exit_code_1(swept, tmp_path, capsys):
    for name in ("runs", "options.json"):
        copy = shutil.copytree if (swept / name).is_dir() else shutil.copy
        copy(swept / name, tmp_path / name)
    path = tmp_path / "runs" / "extreme-4.json"
    result = json.loads(path.read_text())
    result["row"]["set_contained"] -= 1
    path.write_text(json.dumps(result))
    assert main([*TINY, "--resume", "--out", str(tmp_path)]) == 1
    summary = summary_in(tmp_path)
    assert summary["extreme_set_containment"] == 19 / 20
    assert summary["uniform_set_containment"] == 1.0
    assert "lost the truth" in capsys.readouterr().err


def test_a_filter_that_stops_has_not_contained_what_came_after(monkeypatch):
    def stopping(*arguments):
        for count, step in enumerate(steps(*arguments)):
            if count == 3:
                raise Inconsistent("here", ["a source"])
            yield step

    monkeypatch.setattr("experiments.following.side_by_side.steps", stopping)
    row = compare(Case("uniform", 3, robots=2, duration=0.5))["row"]
    assert (row["checks"], row["set_contained"], row["set_inconsistent"]) == (10, 6, 1)
    assert row["set_containment"] == 0.6
    assert not kept_every_truth([row])


def test_both_filters_are_given_the_same_frames(monkeypatch):
    first, again = (compare(Case("gaussian", 5, robots=2, duration=0.8)) for _ in range(2))
    assert first["row"] == again["row"]
    assert first["series"] == again["series"]
    assert {len(values) for values in first["series"].values()} == {1}
    assert compare(Case("gaussian", 6, robots=2, duration=0.8))["row"] != first["row"]


def test_an_error_of_one_deviation_has_a_normalised_square_of_one():
    covariances = np.array([np.diag([4.0, 9.0]), np.array([[2.0, 1.0], [1.0, 2.0]])])
    assert normalised_squares(np.array([[2.0, 3.0], [1.0, 1.0]]), covariances) == pytest.approx([2.0, 2 / 3])


def test_a_consistent_estimator_is_contained_as_often_as_its_ellipses_say():
    rng = np.random.default_rng(0)
    covariance = np.array([[0.04, 0.01], [0.01, 0.02]])
    belief = SetMembershipFilter(Team(200)).start(0.0, [Polygon.box([-9, -9], [9, 9])] * 200)
    tally = EllipseTally()
    for _ in range(50):
        mean = np.column_stack([rng.multivariate_normal([0, 0], covariance, 200), rng.normal(0, 0.1, 200)])
        blocks = np.zeros((200, 3, 200, 3))
        blocks[np.arange(200), :, np.arange(200), :] = np.diag([0, 0, 0.1**2])
        blocks[np.arange(200), :2, np.arange(200), :2] = covariance
        frame = Frame(0.0, None, (), Truth(np.zeros((200, 2)), np.zeros(200)))
        tally.add(frame, GaussianBelief(0.0, mean, blocks.reshape(600, 600)), belief, 0.001)
    row = tally.row("ekf")
    assert row["ekf_containment_95"] == pytest.approx(0.95, abs=0.008)
    assert row["ekf_containment_997"] == pytest.approx(0.997, abs=0.002)
    assert row["ekf_heading_containment_997"] == pytest.approx(0.997, abs=0.002)
    assert row["ekf_nees_mean"] == pytest.approx(2.0, rel=0.04)
    assert row["ekf_rmse_m"] == pytest.approx(np.sqrt(0.06), rel=0.02)
    assert row["ekf_area_997_m2"] == pytest.approx(np.pi * WIDE_SIZE * np.sqrt(np.linalg.det(covariance)), rel=1e-5)
    assert row["ekf_relative_nees_mean"] == pytest.approx(2.0, rel=0.1)
    assert row["ekf_proved_wrong_share"] == 0.0


def test_the_area_of_an_ellipse_is_that_of_its_outline():
    covariance = np.array([[0.3, 0.1], [0.1, 0.2]])
    turn = np.linspace(0, 2 * np.pi, 2000, endpoint=False)
    outline = np.sqrt(WIDE_SIZE) * np.column_stack([np.cos(turn), np.sin(turn)]) @ np.linalg.cholesky(covariance).T
    assert ellipse_areas(covariance[None])[0] == pytest.approx(Polygon.from_vertices(outline).area, rel=1e-4)


def test_what_is_proved_wrong_does_not_depend_on_estimates_inside():
    belief = SetMembershipFilter(Team(3)).start(0.0, [Polygon.box([0, 0], [1, 1])] * 3)
    positions = np.array([[0.5, 0.5], [1.05, 0.5], [3.0, 3.0]])
    covariances = np.array([np.eye(2) * 0.01] * 3)
    some, every = (watch(belief, places, covariances) for places in (outside(belief, positions), positions))
    assert [(alarm.robot, alarm.everything) for alarm in some] == [(1, False), (2, True)]
    assert [(alarm.robot, alarm.everything, alarm.distance) for alarm in some] == [
        (alarm.robot, alarm.everything, alarm.distance) for alarm in every
    ]


def test_a_relative_region_contains_the_truth_and_says_more_than_two_regions_where_robots_see_one_another():
    run = episode(3, duration=1.0, seed=2)
    followed = SetMembershipFilter(run.team, stop=Stop(0.999, searches=60))
    half = run.start_bound
    belief = followed.start(0.0, [Polygon.box(centre - half, centre + half) for centre in run.start_centres])
    *_, step = follow(followed, belief, run)
    belief, frame = step.belief, step.frame
    ratios = []
    pairs = neighbours(3)
    seen = followed.relative(belief, np.array([j for _, j in pairs]), np.array([i for i, _ in pairs]))
    for (i, j), outer in zip(pairs, seen, strict=True):
        assert outer.contains(frame.truth.positions[i] - frame.truth.positions[j])
        far = belief.regions[i].outer.vertices[:, None] - belief.regions[j].outer.vertices
        ratios.append(outer.area / Polygon.hull(far.reshape(-1, 2)).area)
    assert max(ratios) < 1.002
    assert min(ratios) < 0.9


def test_a_mean_over_runs_of_containment_is_a_quotient_of_counts():
    shared = {"set_headings_contained": 30_000_000, "set_inconsistent": 0, "ekf_rmse_m": 3.0}
    rows = [
        {"errors": "bias", "seed": k, "checks": 30_000_000, "set_contained": 30_000_000 - (k == 1), **shared} for k in range(2)
    ]
    timings = [{"errors": "bias", "seed": k, "set_step_ms": 10.0 + k} for k in range(2)]
    summary = summary_of(rows, timings)
    assert summary["bias_set_containment"] == 59_999_999 / 60_000_000 < 1
    assert summary["bias_set_heading_containment"] == 1.0
    assert summary["bias_set_step_ms"] == 10.5


def test_rows_are_written_in_order_and_come_back_exactly(tmp_path):
    rows = [{"errors": kind, "seed": seed, "value": 0.1 * seed + 0.2} for kind in ("b", "a") for seed in (10, 9)]
    write_csv(tmp_path / "a.csv", rows)
    back = rows_in(tmp_path / "a.csv")
    assert [(row["errors"], row["seed"]) for row in back] == [("a", "9"), ("a", "10"), ("b", "9"), ("b", "10")]
    assert [float(row["value"]) for row in back] == [0.1 * int(row["seed"]) + 0.2 for row in back]


def test_the_band_of_a_consistent_filter_narrows_around_its_expectation():
    low, high = nees_band(40)
    assert 1.4 < low < 2 < high < 2.7
    wider = nees_band(4)
    assert wider[0] < low
    assert high < wider[1]


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_the_filter_is_tuned_to_the_errors_that_are_drawn(kind):
    errors = Errors(kind, (5000,), np.random.default_rng(2))
    deviation = np.sqrt(np.mean([errors.draw() ** 2 for _ in range(20)]))
    noise = TUNED[kind]
    assert [noise.compass, noise.bearing, noise.range] == pytest.approx([deviation] * 3, rel=0.01)


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_the_filter_is_tuned_to_what_wheels_do(kind):
    runs = [odometry_deviations(list(episode(6, duration=6.0, seed=seed, errors=kind))) for seed in range(70, 75)]
    for name, factor in {"distance": 1.4, "turn": 1.4, "direction": 2.0, "slip": 2.0}.items():
        deviation = np.sqrt(np.mean([run[name] ** 2 for run in runs]))
        assert 1 / factor < getattr(TUNED[kind], name) / deviation < factor, name


def test_errors_of_wheels_add_up_over_seconds():
    frames = list(episode(6, duration=10.0, seed=77, errors="gaussian"))
    single, seconds = odometry_deviations(frames, horizon=1), odometry_deviations(frames)
    assert seconds["distance"] > 3 * single["distance"]
    assert seconds["turn"] > 2 * single["turn"]


def test_regions_do_not_depend_on_the_order_of_bearings_and_a_kalman_filter_does():
    generator = np.random.default_rng(6)
    spread = spread_over_orders(static_case(generator), 4, generator)
    assert spread.set_contains
    assert spread.set_area < 1e-5
    assert spread.ekf_position > 0.01


def test_an_alarm_that_lasts_is_told_once_and_its_end_too():
    belief = SetMembershipFilter(Team(2)).start(0.0, [Polygon.box([0, 0], [1, 1])] * 2)

    def told(places, size=0.01):
        return [level for _, level in episodes.changes(watch(belief, np.array(places), np.array([np.eye(2) * size] * 2)))]

    episodes = Episodes(Team(2))
    assert told([[0.5, 0.5], [0.5, 0.5]]) == []
    assert told([[1.05, 0.5], [0.5, 0.5]]) == ["WARN"]
    assert told([[1.06, 0.5], [0.5, 0.5]]) == []
    assert told([[3.0, 0.5], [3.0, 0.5]]) == ["ERROR", "ERROR"]
    assert told([[1.05, 0.5], [3.0, 0.5]]) == []
    assert told([[0.5, 0.5], [3.0, 0.5]]) == ["INFO"]
