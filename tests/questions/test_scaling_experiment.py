"""The step over the size of the team: what is measured is what is said, and an escape is told."""

import json
import os
from dataclasses import replace

import numpy as np
import pytest
from helpers import tasks
from helpers.recordings import rerun, rows_of

from experiments import scaling
from experiments.following.steps import steps
from experiments.growth import run as scaling_run
from experiments.growth.run import area_ratio_to_team, ekf_step_ms, mean_area, measure, window_sizes
from experiments.growth.size import LEFT_OUT, Case
from experiments.scaling import GROWTH, LISTED, Options, cases_of, growth_exponent, main, summary_of
from experiments.sweep.own_process import in_own_process
from experiments.sweep.results import WorkerLost
from filter import Inconsistent, SetMembershipFilter, Truth, Window

TINY = Case(4, "kinematic", "uniform", 2, steps=3)


def measured(case):
    *seconds, size = measure(case)
    return seconds, size


@pytest.fixture(scope="module")
def tiny():
    return measured(TINY)


@pytest.fixture(scope="module")
def swept(tmp_path_factory):
    folder = tmp_path_factory.mktemp("scaling")
    assert main(["--robots", "5,2", "--steps", "2", "--errors", "extreme", "--recording", "--out", str(folder)]) == 0
    return folder


def test_every_size_is_in_the_lists_of_the_summary(swept):
    summary = json.loads((swept / "summary.json").read_text())
    assert summary["robots"] == [2, 5]
    assert summary["world"] == ["mujoco", "mujoco"]
    assert all(len(summary[key]) == 2 for key in LISTED)
    assert (summary["escapes"], summary["conflicts"], summary["growth_exponent"]) == (0, 0, None)
    assert 0 <= summary["kernel_fallback_share"] <= 1
    assert all(0 < median <= p95 for median, p95 in zip(summary["step_median_ms"], summary["step_p95_ms"], strict=True))
    assert all(ratio >= 1 - 1e-3 for ratio in summary["area_ratio_to_team"])
    assert min(summary["memory_mib"]) > 50
    assert (swept / "scaling.png").read_bytes().startswith(b"\x89PNG")


def test_the_largest_team_is_recorded_if_asked_for(swept):
    assert rerun("verify", swept / "scaling.rrd").returncode == 0
    assert len(rows_of(swept / "scaling.rrd", "/world/outer/r4", "LineStrips3D:strips")) == LEFT_OUT + 2


def test_the_first_steps_are_checked_and_left_out_of_every_time(tiny):
    seconds, size = tiny
    assert len(seconds) == LEFT_OUT + 3
    assert size.steps == 3
    assert size.projections == 4 * (LEFT_OUT + 3)
    assert size.step_median_ms == pytest.approx(1e3 * np.median(seconds[LEFT_OUT:]), rel=1e-5)
    assert sum(size.phases_median_ms.values()) <= 1e3 * sum(seconds[LEFT_OUT:])
    assert all(median > 0 for median in size.phases_median_ms.values())
    assert size.compile_seconds > 0


def test_all_but_times_and_memory_is_repeated(tiny):
    _, again = measured(TINY)
    for key in ("rows", "area_m2", "window_robots_mean", "window_robots_max", "area_ratio_to_team", "escapes", "fallbacks"):
        assert getattr(again, key) == getattr(tiny[1], key)


def last_step(case=TINY):
    scenario = case.scenario()
    team_filter = SetMembershipFilter(scenario.team, scope=Window())
    return team_filter, list(steps(team_filter, scenario))[-1]


def test_a_window_has_those_that_a_robot_has_rows_with():
    _, step = last_step(Case(9, "kinematic", "uniform", 0, steps=0))
    rows = step.belief.constraints
    pairs = {tuple(sorted(pair)) for pair in zip(rows.i.tolist(), rows.j.tolist(), strict=True) if pair[0] >= 0}
    near = [sum(robot in pair for pair in pairs) for robot in range(9)]
    assert max(near) > 1
    assert window_sizes(step.belief, Window(hops=1, robots=9)) == [1 + count for count in near]
    assert window_sizes(step.belief, Window(hops=1, robots=2)) == [1 + min(1, count) for count in near]


def test_areas_are_held_against_the_whole_team_from_the_same_belief():
    team_filter, step = last_step(Case(9, "kinematic", "uniform", 0, steps=0))
    team = replace(team_filter, scope=Window.everybody())
    area = mean_area(team.update(step.predicted, step.frame.measurements))
    assert area_ratio_to_team(team_filter, [step, step]) == pytest.approx(mean_area(step.belief) / area, rel=1e-5)
    assert area_ratio_to_team(team, [replace(step, belief=team.update(step.predicted, step.frame.measurements))]) == 1
    assert area_ratio_to_team(team_filter, []) is None


def test_the_kalman_filter_is_timed_without_the_first_frame_and_ends_in_time(monkeypatch):
    scenario = TINY.scenario()
    frames = list(scenario.frames)
    assert ekf_step_ms(scenario, "uniform", frames[:1]) is None
    assert ekf_step_ms(scenario, "uniform", frames) > 0
    followed = []
    monkeypatch.setattr(scaling_run, "EKF_PATIENCE", 0.0)

    def noticed(*arguments):
        for step in steps(*arguments):
            followed.append(step.frame)
            yield step

    monkeypatch.setattr(scaling_run, "steps", noticed)
    ekf_step_ms(scenario, "uniform", frames)
    assert followed == frames[:2]


def test_a_robot_that_escapes_ends_with_exit_code_1(monkeypatch, tmp_path):
    def moved(*arguments):
        for step in steps(*arguments):
            truth = Truth(step.frame.truth.positions + 50.0, step.frame.truth.headings)
            yield replace(step, frame=replace(step.frame, truth=truth))

    monkeypatch.setattr(scaling_run, "steps", moved)
    monkeypatch.setattr(scaling, "in_own_process", lambda function, case: function(case))
    assert main(["--robots", "2", "--steps", "1", "--out", str(tmp_path)]) == 1
    assert json.loads((tmp_path / "summary.json").read_text())["escapes"] == 2 * (LEFT_OUT + 1)


def test_measurements_that_disagree_end_with_exit_code_1(monkeypatch, tmp_path, capsys):
    def stopping(*arguments):
        for count, step in enumerate(steps(*arguments)):
            if count == LEFT_OUT + 1:
                raise Inconsistent("here", ["a source"])
            yield step

    monkeypatch.setattr(scaling_run, "steps", stopping)
    monkeypatch.setattr(scaling, "in_own_process", lambda function, case: function(case))
    assert main(["--robots", "2", "--steps", "4", "--out", str(tmp_path)]) == 1
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert (summary["conflicts"], summary["steps"]) == (1, [1])
    assert "a source" in capsys.readouterr().err


def test_growth_is_the_slope_on_logarithmic_scales(tiny):
    assert growth_exponent({100: 10.0, 1000: 100.0}) == 1.0
    assert growth_exponent({100: 10.0, 1000: 1000.0}) == 2.0
    assert growth_exponent({100: 10.0, 300: 40.0}) is None
    assert growth_exponent({100: None, 1000: 40.0}) is None
    few, many = (replace(tiny[1], robots=robots, step_median_ms=time) for robots, time in zip(GROWTH, (9.0, 90.0), strict=True))
    again = replace(few, step_median_ms=90.0)
    summary = summary_of(Options(robots="100,1000"), [few, many, again])
    assert (summary["growth_exponent"], summary["growth_exponent_kinematic"]) == (1.0, 0.0)
    assert summary["kinematic_100_step_median_ms"] == 90.0


def test_large_teams_drive_in_the_kinematic_world_and_a_hundred_in_both():
    cases = cases_of(Options(robots="300,100,10"))
    assert [(case.robots, case.world, case.steps) for case in cases] == [
        (10, "mujoco", 100),
        (100, "mujoco", 100),
        (300, "kinematic", 60),
        (100, "kinematic", 100),
    ]
    assert [case.baselines for case in cases] == [True, True, True, False]
    assert [case.steps for case in cases_of(Options(robots="300,10", steps=7))] == [7, 7]


@pytest.mark.parametrize(
    ("options", "says"),
    [
        (["--robots", "10,ten"], "whole numbers with commas"),
        (["--robots", ""], "whole numbers with commas"),
        (["--robots", "0,3"], "from 1 on"),
        (["--robots", "3,3"], "each once"),
        (["--steps", "0"], "steps: finite numbers within [1"),
        (["--seed", "-1"], "seed"),
    ],
)
def test_bad_options_end_with_a_message_and_exit_code_2(tmp_path, capsys, options, says):
    assert main([*options, "--out", str(tmp_path / "out")]) == 2
    assert says in capsys.readouterr().err
    assert not (tmp_path / "out").exists()


def test_a_process_that_dies_is_told():
    told = in_own_process(tasks.dies_half_way, 7)
    assert next(told) == 7
    with pytest.raises(WorkerLost, match="ended before its work"):
        next(told)


def test_a_process_of_its_own_has_one_thread_for_linear_algebra_and_this_one_is_left_alone():
    before = dict(os.environ)
    assert list(in_own_process(tasks.yields_threads, None)) == [{"threads": "1"}]
    assert dict(os.environ) == before


def test_memory_is_the_process_own():
    size = 300
    ballast = b"x" * (2 * size * 2**20)  # of this process, no part of the other's
    before, after = in_own_process(tasks.remembers, size * 2**20)
    assert before < len(ballast) / 2**20
    assert size - 5 < after - before < size + 50
