"""The experiment with ranges alone: its keys, its files, its exit code, and verdicts that are what they say."""

import json
from dataclasses import replace

import numpy as np
import pytest
from helpers.recordings import rerun, rows_of

from experiments import range_only
from experiments.beacons import prices
from experiments.beacons.outcomes import followed, judged
from experiments.beacons.scenes import DRIVES, alone, team_that_stands
from experiments.beacons.summary import KINDS
from experiments.following.checks import Checks
from experiments.range_only import exit_code, main
from experiments.show.command import BAD_INPUT, SUSPENDED
from filter import Guarantee, Range, SetMembershipFilter

TINY = ["--draws", "1", "--runs", "1", "--steps", "12"]


@pytest.fixture(scope="module")
def ran(tmp_path_factory):
    folder = tmp_path_factory.mktemp("range_only")
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(prices, "STEPS", 3)
        patch.setattr(prices, "OF_TEAMS", {"moving": 1})
        code = main([*TINY, "--out", str(folder)])
    return folder, json.loads((folder / "summary.json").read_text()), code


def test_the_summary_has_all_that_is_asked_for_and_nothing_that_nobody_measures(ran):
    _, summary, code = ran
    assert code == 0
    assert summary["escapes"] == summary["heading_escapes"] == summary["not_judged"] == 0
    assert summary["checks"] == 5 + 4 * 2 + 1 + 12 * (3 + 3 + 6)
    assert 1 <= summary["area_over_exact_standing_median"] <= summary["area_over_exact_standing_p95"]
    assert summary["area_over_exact_standing_p95"] <= summary["area_over_exact_standing"]
    assert 1 <= summary["bearings_over_exact"] <= 1.5
    assert 1 <= summary["team_area_over_exact_at_most_median"] <= summary["team_area_over_exact_at_most"] < 1.2
    assert 0 < summary["judge_error_max"] < 0.01
    assert summary["exact_price_of_one_lie_any_median"] > summary["exact_price_of_one_lie_long_median"] > 1
    assert 0.9 < summary["standing_again_over_first"] <= 1 + 1e-6
    for kind in KINDS:
        assert summary[f"{kind}_area_median_m2"] > 0
        assert summary[f"{kind}_step_median_ms"] > 0
    assert 1 <= summary["tolerance_over_exact_any"] < 1.1
    assert 1 <= summary["tolerance_over_exact_long"] < 1.1
    assert summary["price_alone_pairs_any"] > summary["price_alone_pairs_long"] > 1
    assert summary["price_moving_bodies_any"] >= summary["price_moving_pairs_any"]
    assert summary["price_moving_identities_any"] > 1
    assert summary["price_moving_cameras_any_step_ms"] > 0
    assert summary["tolerant_escapes"] == summary["tolerant_heading_escapes"] == 0
    assert summary["tolerant_checks"] == 2 * 5 + 6 * 3 * 3
    assert summary["too_short"]


def test_there_are_a_figure_and_a_recording_that_can_be_read(ran):
    folder, _, _ = ran
    assert (folder / "range_only.png").read_bytes().startswith(b"\x89PNG")
    assert rerun("verify", str(folder / "range_only.rrd")).returncode == 0
    areas = rows_of(folder / "range_only.rrd", "/area/r1", "Scalars:scalars")
    assert len(areas) == 12
    assert areas[-1]["value"][0] > 0


def test_a_truth_that_is_outside_is_an_exit_code_of_1(tmp_path, monkeypatch):
    monkeypatch.setattr(prices, "OF_TEAMS", {})
    monkeypatch.setattr(range_only, "followed", lambda filter_, scene: followed(filter_, with_short_bounds(scene)))
    assert main([*TINY, "--out", str(tmp_path)]) == 1


def test_a_guarantee_that_was_suspended_is_said_by_the_exit_code():
    scene = alone(np.random.default_rng(0), 3, 0.1)
    fine = followed(SetMembershipFilter(scene.team), scene)
    lapsed = replace(fine, checks=Checks(suspended=Guarantee.full(1).suspended(0.0, "it was")))
    assert [exit_code(some) for some in ([fine], [fine, lapsed])] == [0, SUSPENDED]
    assert exit_code([lapsed, replace(fine, checks=Checks(escapes_in_force=1))]) == 1


def with_short_bounds(scene):
    """Return a scene that is measured worse than it says: most that is measured is off by twice its bound, all too long."""
    if scene.kind == "bearings":
        return scene
    frames = [
        replace(frame, measurements=tuple(replace(each, range=each.range + 0.2) for each in frame.measurements))
        for frame in scene.frames
    ]
    return replace(scene, frames=tuple(frames))


@pytest.mark.parametrize(
    "wrong",
    [["--draws", "0"], ["--runs", "0"], ["--steps", "5"], ["--range-bound", "0"], ["--range-bound", "nan"]],
    ids=" ".join,
)
def test_options_that_cannot_be_used_are_refused(tmp_path, wrong):
    assert main([*wrong, "--out", str(tmp_path)]) == BAD_INPUT


@pytest.mark.parametrize("anchors", [3, 4, 6])
@pytest.mark.parametrize("seed", range(3))
def test_the_filter_is_never_smaller_than_the_exact_hull(seed, anchors):
    scene = alone(np.random.default_rng([seed, anchors]), anchors, 0.1)
    outcome = followed(SetMembershipFilter(scene.team), scene)
    verdict = judged(outcome)
    assert outcome.last[0].contains(verdict.exact.inside).all()
    assert verdict.ratio >= 1
    assert outcome.last[0].contains(scene.frames[0].truth.positions[0])


def test_teams_are_followed_with_the_truth_inside():
    for scene in (team_that_stands(np.random.default_rng(2), 0.1), DRIVES[0].drawn([2], 12, 0.1)):
        outcome = followed(SetMembershipFilter(scene.team), scene)
        assert outcome.checks.checks == outcome.areas.size == outcome.arcs.size
        assert not outcome.checks.escapes + outcome.checks.heading_escapes
        assert isinstance(scene.frames[0].measurements[0], Range)
