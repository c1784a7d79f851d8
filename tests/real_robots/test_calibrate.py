import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.mrclam_folder import Made, write_run
from helpers.sensing.clocked import ClockedWorld
from helpers.sensing.mounted import MountedWorld

from experiments.calibrate import main
from experiments.logs import LogReader
from experiments.moving_team import main as moving_team
from experiments.real_robots.bounds import Bounds, bound_over
from experiments.real_robots.carried import Carried, CarriedBounds
from experiments.real_robots.carried_bounds import Moves, proposed_carried
from experiments.real_robots.data import read_run
from experiments.real_robots.error_bounds import proposed, said, statistics
from experiments.real_robots.errors import Errors, command_lag, measurement_delay, motion_errors, sensor_errors, speed_scale
from experiments.real_robots.frames import frames
from experiments.real_robots.motion import Motions
from filter import Bearing, Frame, Range, Sensor, Team, Truth, wrap

MADE = Made(duration=24.0, every=0.4, bearing_bias=0.05, range_scale=1.05, delay=0.08, lag=0.16)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("data") / "made", MADE)


@pytest.fixture(scope="module")
def run(folder):
    return read_run(folder)


@pytest.fixture(scope="module")
def found(run):
    scenario = frames(run, (1, 2), bounds=replace(Bounds(), measurement_delay=MADE.delay))
    sensors = [errors for errors in sensor_errors(scenario.frames, scenario.team) if errors.kind != "turn"]
    return sensors + motion_errors(run, (1, 2), replace(Bounds(), command_lag=MADE.lag))


def by(found, kind):
    return next(errors for errors in found if errors.kind == kind)


def made_up(errors, bound, kind="range", true=2.0):
    size = len(errors)
    times = np.arange(size) * 10.0
    return Errors(kind, np.zeros(size, dtype=int), times, errors, np.full(size, true), np.abs(errors) > bound)


def test_what_was_put_into_a_run_is_found_in_it(run, found):
    bearing, distance = by(found, "bearing"), by(found, "range")
    assert np.median(bearing.error) == pytest.approx(MADE.bearing_bias, abs=0.01)
    assert np.abs(bearing.error - MADE.bearing_bias).max() <= MADE.bearing_error + 1e-3
    rows = {row["robot"]: row for row in statistics(distance, Team(2))}
    assert set(rows) == {"r0", "r1", "all"}
    assert rows["all"]["scale"] == pytest.approx(MADE.range_scale, abs=0.02)
    assert rows["all"]["count"] == rows["r0"]["count"] + rows["r1"]["count"]
    for robot in (1, 2):
        assert measurement_delay(run, robot) == pytest.approx(MADE.delay, abs=0.041)
        assert command_lag(run, robot) == pytest.approx(MADE.lag, abs=0.021)
        assert speed_scale(run, robot) == pytest.approx(MADE.scale, abs=0.03)


def test_robots_that_obey_exactly_have_no_errors_of_motion(found):
    for kind in ("turn over 1 s", "path over 1 s", "slip over 1 s"):
        errors = by(found, kind)
        assert len(errors.error) > 500
        assert np.abs(errors.error).max() < 0.01
        assert not errors.broken.any()


def test_the_two_ways_to_a_bearings_error_agree(run):
    """As a frame's record against its truth, and by hand."""
    scenario = frames(run, (1, 2))
    errors = by(sensor_errors(scenario.frames, scenario.team), "bearing")
    log = run.logs[1]
    k = np.flatnonzero(log.measurements[:, 1] == 6)[5]
    time = log.measurements[k, 0] - Bounds().measurement_delay
    x, y, heading = (
        np.interp(time, log.truth[:, 0], np.unwrap(log.truth[:, c]) if c == 3 else log.truth[:, c]) for c in (1, 2, 3)
    )
    mark = run.landmarks[0, 1:]
    by_hand = log.measurements[k, 3] - np.arctan2(mark[1] - y, mark[0] - x) + heading
    assert np.abs(np.angle(np.exp(1j * (errors.error - by_hand))))[np.abs(errors.time - time) < 1e-6].min() < 1e-9


@pytest.mark.parametrize("seed", range(8))
@pytest.mark.parametrize("kind", [MountedWorld, ClockedWorld])
def test_sensors_that_are_mounted_somewhere_and_whose_clocks_are_off_keep_their_bounds(kind, seed):
    world = kind(np.random.default_rng(seed), robots=3, reach=0.8)
    truth = Truth(world.positions, world.headings)
    found = sensor_errors([Frame(0.0, None, world.measure(), truth)], world.team)
    assert {"bearing", "range"} <= {errors.kind for errors in found}
    assert not any(errors.broken.any() for errors in found)
    if kind is MountedWorld:
        assert max(np.abs(by(found, "range").error)) < 0.03 + 4 * world.bound


def test_the_error_of_a_camera_is_what_it_is_off_where_it_is():
    team = Team(1, [[2.0, 0.0], [0.5, 1.0]], sensors=[Sensor("camera", [0.5, 0.0], 0.0, np.pi / 2)])
    measured = [Range(0.0, 0, [1, 2], [1.6, 1.2], 0.1, 0.0, 0), Bearing(0.0, 0, [1, 2], [-np.pi / 2, 0.3], 0.2, 0)]
    found = sensor_errors([Frame(0.0, None, measured, Truth([[0.0, 0.0]], [0.0]))], team)
    assert by(found, "range").error == pytest.approx([0.1, 0.2])
    assert by(found, "range").broken.tolist() == [False, True]
    assert by(found, "bearing").error == pytest.approx([0.0, 0.3])
    assert by(found, "bearing").broken.tolist() == [False, True]


def test_statistics_are_those_of_the_errors():
    errors = np.concatenate([np.linspace(-0.1, 0.1, 997), [0.5, 0.6, -0.7]])
    (row, _) = statistics(made_up(errors, 0.3), Team(1))
    assert row["median"] == pytest.approx(np.median(np.abs(errors)), rel=1e-5)
    assert row["q99"] == pytest.approx(np.quantile(np.abs(errors), 0.99), rel=1e-5)
    assert row["largest"] == pytest.approx(0.7)
    assert row["broken"] == 3
    assert row["broken_per_hour"] == pytest.approx(3600 * 3 / 9990, rel=1e-4)


def test_broken_bounds_that_follow_one_another_are_one_burst():
    times = np.array([0.0, 10.0, 10.3, 10.6, 20.0, 30.0, 30.5])
    broken = np.array([False, True, True, True, False, True, True])
    errors = Errors("range", np.zeros(7, dtype=int), times, broken * 9.0, np.ones(7), broken)
    (row, _) = statistics(errors, Team(1))
    assert (row["bursts"], row["longest_burst"]) == (2, 3)


@pytest.mark.parametrize("seed", range(5))
@pytest.mark.parametrize("share", [0.0, 0.001, 0.01, 0.1])
def test_no_more_than_a_share_of_the_errors_break_what_is_proposed(seed, share):
    generator = np.random.default_rng(seed)
    true = generator.uniform(0.2, 8.0, 5000)
    ranges = Errors("range", *np.zeros((2, 5000)), 0.05 * true * generator.standard_normal(5000), true, true > 99)
    bearings = made_up(0.03 * generator.standard_normal(5000), 1.0, "bearing")
    motion = [
        made_up(spread * length**0.7 * generator.standard_normal(2000), 1.0, f"{kind} over {length:g} s")
        for kind, spread in (("turn", 0.05), ("path", 0.01), ("slip", 0.005))
        for length in (0.1, 1.0, 10.0)
    ]
    bounds = proposed([ranges, bearings, *motion], Bounds(), share, 1.0)
    limit = np.maximum(bounds.range, bounds.relative_range * true)
    assert (np.abs(ranges.error) > limit).mean() <= share
    assert (np.abs(bearings.error) > bounds.bearing).mean() <= share
    for errors in motion:
        kind, length = errors.kind.split()[0], float(errors.kind.split()[2])
        knots = getattr(bounds, "distance" if kind == "path" else kind)
        assert (np.abs(errors.error) > bound_over(knots, length)).mean() <= share


def test_what_is_said_is_python_for_the_bounds(found):
    bounds = proposed(found, Bounds(), 0.001, 1.25)
    assert vars(eval(said(bounds), {"Bounds": Bounds})) == vars(bounds)


def carried_for(run, found, **how):
    return proposed_carried(run, (1, 2), found, Bounds(command_lag=MADE.lag, speed_scale=MADE.scale), **how)


def test_robots_that_obey_exactly_need_little_for_a_carried_heading(run, found):
    bounds = carried_for(run, found, share=0.0, margin=1.0)
    assert bounds.turn_scale == pytest.approx(1.0, abs=0.002)
    assert bounds.jitter < np.radians(0.5)
    assert (bounds.turn_share, bounds.slip) == (pytest.approx(0.0, abs=0.011), pytest.approx(0.0, abs=0.002))
    assert bounds.distance_share < 0.03


@pytest.mark.parametrize("share", [0.0, 0.01, 0.1])
def test_no_more_than_a_share_break_what_is_proposed_for_the_camera(run, found, share):
    bounds = carried_for(run, found, share=share, margin=1.0)
    ranges, bearings = by(found, "range"), by(found, "bearing")
    short = ranges.error < -bounds.shortest * ranges.true - bounds.range
    long = ranges.error > bounds.longest * ranges.true + bounds.range
    assert (short | long).mean() <= share
    assert (np.abs(bearings.error) > bounds.bearing).mean() <= share


@pytest.mark.parametrize("share", [0.0, 0.01])
def test_no_more_than_a_share_of_the_turns_break_jitter_and_drift(tmp_path, share):
    run = read_run(write_run(tmp_path / "made", replace(MADE, duration=40.0)))
    logs = {k: replace(log, commands=log.commands * [1, 1.1, 1.2]) for k, log in run.logs.items()}  # obeyed less than said
    off = replace(run, logs=logs)
    scenario = frames(off, (1, 2))
    bounds = carried_for(off, sensor_errors(scenario.frames, scenario.team), share=share, margin=1.0)
    assert bounds.turn_scale == pytest.approx(1 / 1.2, rel=0.02)
    carried = Carried(Motions(off, (1, 2), Bounds()), bounds)
    for length in (0.1, 1.0, 10.0):
        moves = Moves.of(off, (1, 2), carried, length)
        assert len(moves.told) > 1000
        error = np.abs(wrap(moves.did[:, 2] - bounds.turn_scale * moves.told[:, 2]))
        allowed = 2 * bounds.jitter + bounds.turn_share * moves.told[:, 3] + bounds.turn_drift * length
        assert (error > allowed + 1e-9).mean() <= share


def test_the_moves_of_a_team_leave_out_silence_and_gaps(run):
    carried = Carried(Motions(run, (1, 2), Bounds()))
    whole = Moves.of(run, (1, 2), carried, 1.0)
    truth = run.logs[1].truth
    gap = replace(run, logs=run.logs | {1: replace(run.logs[1], truth=truth[(truth[:, 0] < 3) | (truth[:, 0] > 4)])})
    fewer = Moves.of(gap, (1, 2), carried, 1.0)
    assert len(whole.told) - len(fewer.told) == pytest.approx(40, abs=2)  # begun from 2 s to 4 s, every 0.05 s


def test_both_kinds_of_bounds_are_said(folder, tmp_path):
    assert main(["--data", str(folder), "--robots", "1,2", "--out", str(tmp_path)]) == 0
    text = (tmp_path / "bounds.txt").read_text()
    given = {"Bounds": Bounds, "CarriedBounds": CarriedBounds}
    at = text.index("CarriedBounds(")
    assert isinstance(eval(text[:at], given), Bounds)
    assert isinstance(eval(text[at:], given), CarriedBounds)


def test_a_run_is_judged_from_the_command_line(folder, tmp_path, capsys):
    assert main(["--data", str(folder), "--robots", "1,2", "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["bearing_r0_bias"] == pytest.approx(MADE.bearing_bias, abs=0.02)
    assert summary["turn_over_1_s_all_broken"] == 0
    assert summary["r1_speed_scale"] == pytest.approx(MADE.scale, abs=0.03)
    assert (tmp_path / "errors.png").stat().st_size > 10_000
    assert (tmp_path / "bounds.txt").read_text() in capsys.readouterr().out


def test_a_log_of_our_own_keeps_its_bounds(tmp_path):
    assert moving_team(["--robots", "2", "--duration", "2", "--errors", "extreme", "--out", str(tmp_path / "run")]) == 0
    log = tmp_path / "run" / "log.jsonl"
    assert main(["--log", str(log), "--out", str(tmp_path / "out")]) == 0
    summary = json.loads((tmp_path / "out" / "summary.json").read_text())
    frames_ = list(LogReader(log).frames())
    assert summary["compass_all_count"] == 2 * len(frames_)
    for kind in ("bearing", "compass", "range", "turn"):
        assert summary[f"{kind}_all_broken"] == 0
    assert summary["compass_all_median"] == pytest.approx(np.radians(3), rel=1e-3)
    assert not (tmp_path / "out" / "bounds.txt").exists()


@pytest.mark.parametrize("arguments", [[], ["--data", "a", "--log", "b"], ["--data", "nowhere"], ["--log", "nowhere"]])
def test_bad_input_ends_with_two(arguments, tmp_path, capsys):
    assert main([*arguments, "--out", str(tmp_path / "out")]) == 2
    assert "expected" in capsys.readouterr().err


def test_a_run_without_truth_cannot_be_judged(tmp_path, capsys):
    own = write_run(tmp_path / "own", Made(duration=2.0))
    for path in own.glob("Robot*_Groundtruth.dat"):
        path.unlink()
    assert main(["--data", str(own), "--robots", "1,2", "--out", str(tmp_path / "out")]) == 2
    assert "truth" in capsys.readouterr().err
