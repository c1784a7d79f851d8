"""The one filter for all teams, on frames about carried headings of real robots, and what proves its run again."""

import json
import shutil
from dataclasses import replace

import numpy as np
import pytest
from helpers.mrclam_folder import CLOCK, Made, write_run

from experiments import prove
from experiments.logs import InitialSet, read_trajectory
from experiments.mrclam import main
from experiments.real_robots import followed
from experiments.real_robots.bounds import Bounds
from experiments.real_robots.carried import Carried
from experiments.real_robots.data import read_run
from experiments.real_robots.followed import believing
from experiments.real_robots.frames import frames
from experiments.real_robots.motion import Motions
from filter import AngularIntervals, Judged, SetMembershipFilter, Step, Suspect, Team


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return write_run(tmp_path_factory.mktemp("data") / "made", Made(duration=4.0))


@pytest.fixture(scope="module")
def certified(folder, tmp_path_factory):
    """A finished run of the one filter that is to be proved again."""
    out = tmp_path_factory.mktemp("certified")
    options = ["--data", str(folder), "--robots", "1,2", "--duration", "1.2", "--tolerate", "0", "--certificates"]
    assert main([*options, "--out", str(out)]) == 0
    return out


def test_the_one_filter_keeps_the_truth_inside_and_is_proved_again(certified, capsys):
    summary = json.loads((certified / "summary.json").read_text())
    assert summary["tolerate"] == 0
    assert (summary["escapes"], summary["heading_escapes"], summary["guarantee_in_force"]) == (0, 0, True)
    assert 0 < summary["outer_area_median_m2"] < 10
    assert prove.main([str(certified)]) == 0
    assert "on trust: the folder's own figures" in capsys.readouterr().out


def test_what_is_certified_is_what_the_run_tells(certified):
    inner = certified / "certified"
    for robot in (0, 1):
        names = (folder / "trajectories" / f"r{robot}_filter.tum" for folder in (certified, inner))
        own, proved = map(read_trajectory, names)
        np.testing.assert_array_equal(own.positions, proved.positions)
        np.testing.assert_array_equal(own.times, proved.times)
    told = json.loads((inner / "summary.json").read_text())
    assert told["checks"] == 2 * json.loads((certified / "summary.json").read_text())["frames"]
    assert told["heading_checks"] == 0  # it is of carried headings, of which nobody knows the truth


def test_a_certified_region_that_was_changed_is_not_proved(certified, tmp_path):
    other = shutil.copytree(certified, tmp_path / "other")
    path = other / "certified" / "trajectories" / "r1_filter.tum"
    first, *lines = path.read_text().splitlines(keepends=True)
    path.write_text("".join([first.replace(".", ".1", 1), *lines]))
    assert prove.main([str(other)]) == 1


def test_certificates_are_of_the_one_filter_and_of_this_run(certified, folder, tmp_path, capsys):
    out = shutil.copytree(certified, tmp_path / "again")
    options = ["--data", str(folder), "--robots", "1,2", "--duration", "1.2", "--out", str(out)]
    assert main([*options, "--certificates", "--filter", "robust"]) == 2
    assert "--filter sets" in capsys.readouterr().err
    assert (out / "certified").exists()
    assert main([*options, "--tolerate", "0"]) == 0
    assert not (out / "certified").exists()
    assert prove.main([str(out)]) == 2


def test_certificates_are_proved_where_votes_may_be_wrong_too(folder, tmp_path, capsys):
    options = ["--data", str(folder), "--robots", "1,2", "--duration", "0.6", "--out", str(tmp_path)]
    assert main([*options, "--certificates"]) in {0, 4}
    assert prove.main([str(tmp_path)]) == 0
    assert "no more than one vote on its robot is wrong" in capsys.readouterr().out


def believed(folder, robots=(1, 2)):
    run = read_run(folder)
    bounds = Bounds().chained()
    return list(believing(frames(run, robots, bounds=bounds), Carried(Motions(run, robots, bounds))))


def test_measurements_that_cannot_be_are_in_doubt(tmp_path):
    steps = believed(write_run(tmp_path / "made", Made(duration=3.0, range_scale=3.0)))
    first = next(k for k, step in enumerate(steps) if step.rejected or step.resets)
    assert not any(step.suspended.any() for step in steps[:first])
    assert all(step.events for step in steps if step.rejected)
    assert any(step.rejected for step in steps)
    assert all(step.suspended.any() for step in steps if step.resets)


def misread(own):
    """Have a barcode of a run misread after two seconds; return when."""
    path = own / "Robot1_Measurement.dat"
    head, *lines = path.read_text().splitlines(keepends=True)
    at = next(k for k, line in enumerate(lines) if not line.startswith("#") and float(line.split()[0]) - CLOCK > 2)
    time, code, distance, bearing = lines[at].split()
    lines[at] = f"{time} {code} {distance} {float(bearing) + 2.5}\n"
    path.write_text("".join([head, *lines]))
    return time


def test_a_doubt_is_proved_again(folder, tmp_path, capsys):
    own, out = shutil.copytree(folder, tmp_path / "own"), tmp_path / "out"
    misread(own)
    options = [
        "--data",
        str(own),
        "--robots",
        "1,2",
        "--start",
        "1.7",
        "--duration",
        "0.5",
        "--tolerate",
        "0",
        "--certificates",
    ]
    assert main([*options, "--out", str(out)]) == 0
    assert prove.main([str(out)]) == 0
    assert "one thing alone was wrong from t = " in capsys.readouterr().out


def test_a_barcode_that_is_misread_is_in_doubt_and_the_truth_stays_inside(folder, tmp_path):
    own = shutil.copytree(folder, tmp_path / "own")
    time = misread(own)
    steps = believed(own)
    assert sum("in doubt" in word for step in steps for word in step.events) == 1
    first = next(step for step in steps if step.rejected)
    assert first.frame.time == pytest.approx(float(time) - CLOCK - Bounds().measurement_delay, abs=0.01)
    assert [(source.robot, source.kind) for source in first.rejected] == [(0, "bearing")]
    assert first.guarantee.assuming
    for step in steps:
        truth = step.frame.truth
        assert step.belief.headings.contains(truth.headings).all()
        assert all(region.outer.contains(place) for region, place in zip(step.belief.regions, truth.positions, strict=True))


def test_a_guilty_sensor_is_put_aside_by_its_name_and_headings_have_their_jitter(folder):
    (step, *_) = believed(folder)
    assert not step.put_aside
    guilty = Judged(1.0, Suspect("sensor", 1), "guilty", "proof")
    free = Judged(1.0, Suspect("sensor", 0), "acquitted", "proof")
    predicted = believed_at(folder)
    made = Step(step.frame, predicted, replace(predicted, events=(guilty, free)), 0.0)
    made = followed.believed(step.frame, made, 0.1, Team(2))
    assert made.put_aside == ("sensor of r1",)
    assert made.belief.headings.bound == pytest.approx(np.minimum(predicted.headings.bound + 0.1, np.pi))


def believed_at(folder):
    scenario = frames(read_run(folder), (1, 2))
    sets = SetMembershipFilter(scenario.team)
    headings = AngularIntervals(np.array([0.0, 3.1]), np.array([0.5, 0.2]))
    return sets.start(0.0, [known.polygon() for known in scenario.initial], headings)


@pytest.mark.parametrize("centre", [-3.1, 0.0, 3.1])
@pytest.mark.parametrize("bound", [0.0, 0.5, 3.13])
def test_initial_headings_are_wider_by_the_jitter(folder, centre, bound):
    run = read_run(folder)
    carried = Carried(Motions(run, (1, 2), Bounds().chained()))
    scenario = replace(frames(run, (1, 2)), initial=(InitialSet(None, (centre, bound)), InitialSet(None, None)))
    known, unknown = carried.scenario(scenario).initial
    assert known.heading[0] == centre
    assert known.heading[1] == pytest.approx(min(bound + carried.bounds.jitter, np.pi))
    assert known.heading[1] >= min(bound + carried.bounds.jitter, np.pi)
    assert unknown.heading is None
    (first, *_) = carried.scenario(replace(scenario, frames=iter([next(frames(run, (1, 2)).frames)]))).frames
    assert (first.measurements[0].bound == carried.bounds.bearing + carried.bounds.jitter).all()
