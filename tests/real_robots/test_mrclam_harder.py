"""A run made harder is what it says, and nothing else; the sweep over them counts as the experiment does."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from helpers.mrclam_folder import Made, write_run

from experiments.mrclam import main as mrclam
from experiments.mrclam_margins import main
from experiments.real_robots.data import read_tables, run_of
from experiments.real_robots.errors import command_lag, measurement_delay, sensor_errors, speed_scale
from experiments.real_robots.frames import frames
from experiments.real_robots.harder import GAP, HARDER, Harder

ROBOTS = (1, 2)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("data") / "made", Made(duration=40.0))


@pytest.fixture(scope="module")
def tables(folder):
    return read_tables(folder)


def harder(tables, seed=0, **changes):
    return Harder(**changes).made_of(tables, np.random.default_rng(seed))


def errors(tables):
    scenario = frames(run_of(tables), ROBOTS)
    return {errors.kind: errors for errors in sensor_errors(scenario.frames, scenario.team)}


def test_the_defaults_leave_a_run_as_it_is(tables):
    same = harder(tables)
    for robot in ROBOTS:
        for name in ("commands", "measurements", "truth"):
            np.testing.assert_allclose(getattr(same.logs[robot], name), getattr(tables.logs[robot], name), rtol=0, atol=1e-6)


def test_a_range_that_cannot_be_is_still_dropped(tables):
    measurements = tables.logs[1].measurements.copy()
    measurements[3, 2] = -0.5
    wrong = replace(tables, logs=tables.logs | {1: replace(tables.logs[1], measurements=measurements)})
    assert run_of(harder(wrong, errors=1.5, ranges=1.1)).dropped.impossible == 1


def test_errors_around_the_truth_are_larger_and_those_of_confused_barcodes_are_not(tables):
    wrong = harder(tables, misread=0.05)
    before, after = errors(wrong), errors(Harder(errors=2.0).made_of(wrong, np.random.default_rng(1)))
    for kind, size in (("range", 1.5), ("bearing", np.radians(15))):
        plain = (np.abs(before["range"].error) < 1.5) & (np.abs(before["bearing"].error) < np.radians(15))
        assert 0 < (~plain).sum() < 0.2 * len(plain)
        np.testing.assert_allclose(after[kind].error[plain], 2 * before[kind].error[plain], rtol=0, atol=1e-6)
        np.testing.assert_allclose(after[kind].error[~plain], before[kind].error[~plain], rtol=0, atol=1e-6)
        assert np.abs(before[kind].error[~plain]).max() > size


def test_cameras_are_turned_and_ranges_are_longer(tables):
    before, after = errors(tables), errors(harder(tables, camera=0.2, ranges=1.1))
    np.testing.assert_allclose(after["bearing"].error - before["bearing"].error, 0.2, rtol=0, atol=1e-6)
    said = before["range"].error + before["range"].true
    np.testing.assert_allclose(after["range"].error - before["range"].error, 0.1 * said, rtol=0, atol=1e-6)


def test_clocks_and_scales_are_what_calibration_finds(tables):
    before, after = run_of(tables), run_of(harder(tables, measured=0.06, obeyed=0.1, speed=1.1))
    assert measurement_delay(after, 1) == pytest.approx(measurement_delay(before, 1) + 0.06, abs=0.021)
    assert command_lag(after, 1) == pytest.approx(command_lag(before, 1) + 0.1, abs=0.021)
    assert speed_scale(after, 1) == pytest.approx(speed_scale(before, 1) / 1.1, rel=0.01)


def test_about_the_share_of_barcodes_is_confused_with_others_that_exist(tables):
    changed, count = 0, 0
    for seed in range(20):
        after = harder(tables, seed, misread=0.02)
        for robot in ROBOTS:
            old, new = tables.logs[robot].measurements, after.logs[robot].measurements
            assert set(new[:, 1]) <= set(tables.barcodes)
            np.testing.assert_allclose(old[:, [0, 2, 3]], new[:, [0, 2, 3]], rtol=0, atol=1e-6)
            changed, count = changed + (old[:, 1] != new[:, 1]).sum(), count + len(old)
    assert 0.01 < changed / count < 0.025  # a barcode is taken for itself now and then


def test_commands_are_missing_and_each_robot_is_blind_for_a_while(tables):
    after = harder(tables, gaps=True)
    for robot in ROBOTS:
        assert np.diff(after.logs[robot].commands[:, 0]).max() >= GAP
        times, all_times = (each.logs[robot].measurements[:, 0] for each in (after, tables))
        begin, end = all_times.min() - 0.5, all_times.max() + 0.5
        assert np.diff(np.concatenate([[begin], times, [end]])).max() > 40 / 3 - 1
        assert 0.6 < len(times) / len(all_times) < 0.7


def test_the_same_seed_makes_the_same_run(tables):
    once, again = (harder(tables, 3, misread=0.1, gaps=True) for _ in range(2))
    assert all((once.logs[robot].measurements == again.logs[robot].measurements).all() for robot in ROBOTS)


def test_the_sweep_says_of_the_run_as_it_is_what_the_experiment_says(folder, tmp_path, capsys):
    shared = ["--data", str(folder), "--duration", "8"]
    names = "as_it_is,errors_1.5,together"
    assert main([*shared, "--changes", names, "--workers", "1", "--out", str(tmp_path / "margins")]) == 0
    assert "together" in capsys.readouterr().out
    assert mrclam([*shared, "--robots", "1,2", "--out", str(tmp_path / "plain")]) == 0
    swept, plain = (json.loads((tmp_path / name / "summary.json").read_text()) for name in ("margins", "plain"))
    for key in ("checks", "outer_area_median_m2", "set_rmse_m", "ekf_rmse_m"):
        assert swept[f"as_it_is_{key}"] == plain[key]
    assert {key.split("_checks")[0] for key in swept if key.endswith("_checks")} == set(names.split(","))


@pytest.mark.parametrize("options", ["--changes easier", "--changes gaps,gaps", "--seed -1", "--data nowhere"])
def test_bad_input_ends_with_two(folder, tmp_path, options, capsys):
    assert main(["--data", str(folder), *options.split(), "--out", str(tmp_path)]) == 2
    assert capsys.readouterr().err


def test_a_run_without_truth_cannot_be_judged(folder, tmp_path, capsys):
    blind = tmp_path / "blind"
    shutil.copytree(folder, blind)
    for path in blind.glob("*Groundtruth.dat"):
        if path.name.startswith("Robot"):
            path.unlink()
    assert main(["--data", str(blind), "--out", str(tmp_path / "out")]) == 2
    assert "truth" in capsys.readouterr().err


def test_every_way_is_a_change(tables):
    for name, ways in HARDER.items():
        after = ways.made_of(tables, np.random.default_rng(0))
        differs = any(
            getattr(after.logs[1], table).shape != getattr(tables.logs[1], table).shape
            or not np.allclose(getattr(after.logs[1], table), getattr(tables.logs[1], table), rtol=0, atol=1e-6)
            for table in ("commands", "measurements")
        )
        assert differs == (name not in ("as_it_is", "misread"))  # so few are misread that a short run may have none
