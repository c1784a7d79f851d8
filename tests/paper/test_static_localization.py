"""The paper's static case as an experiment: frames, relative regions, stopping, and what is refused."""

import json

import numpy as np
import pytest
from helpers.recordings import rows_of

from experiments.paper.formations import Searcher, draw_formation
from experiments.paper.frames import farthest_reference, localize, relative_regions, uncertain_pairs
from experiments.paper.merge_orders import spread_over_orders
from experiments.paper.reference import Unbounded
from experiments.static_localization import main
from filter.errors import InvalidInput
from filter.projection.proved import position
from filter.projection.stop import Budget, Stop

BOUND = np.radians(5)
FEW = ["--robots", "5", "--seed", "1"]
EXACT = Stop(performance_ratio=1.0, searches=60)


@pytest.fixture(scope="module")
def formation():
    return draw_formation(np.random.default_rng(4), 8, BOUND)


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    folder = tmp_path_factory.mktemp("static")
    assert main([*FEW, "--relative", "1", "2", "4", "3", "--out", str(folder)]) == 0
    return folder


def summary_in(folder):
    return json.loads((folder / "summary.json").read_text())


def test_a_run_leaves_a_summary_figures_and_a_recording(run):
    summary = summary_in(run)
    assert summary["robots"] == 5
    assert summary["variables"] == summary["alternate_variables"] == 7
    assert summary["escapes"] == 0
    assert summary["checks"] == 12
    assert 0.95 <= summary["performance_ratio_mean"] <= 1
    assert 4 <= summary["searches_mean"] <= 16
    assert summary["relative_1_2_area_m2"] > 0
    assert {path.name for path in run.glob("*.png")} == {"frames.png", "relative.png", "range_bearing.png"}
    areas = [row["value"][0] for row in rows_of(run / "static_localization.rrd", "/area/r3", "Scalars:scalars")]
    assert len(areas) == 32
    assert areas[15] <= areas[0]


def test_the_same_seed_gives_the_same_summary(run, tmp_path, monkeypatch):
    for name in ("draw_frames", "draw_relative", "draw_range_bearing", "record"):
        monkeypatch.setattr(f"experiments.static_localization.{name}", lambda *_: None)
    assert main([*FEW, "--relative", "1", "2", "4", "3", "--out", str(tmp_path)]) == 0
    assert (tmp_path / "summary.json").read_bytes() == (run / "summary.json").read_bytes()


@pytest.mark.parametrize(
    ("options", "words"),
    [
        (["--reference"], "no anchor holds"),
        (["--no-scale"], "scale"),
        (["--reference", "9"], "references among robots 0 to 4"),
        (["--alternate", "9"], "references among robots 0 to 4"),
        (["--relative", "1", "1"], "pairs of two robots"),
        (["--robots", "2"], "from 3 on"),
        (["--bearing-bound", "0"], "bearing bound"),
        (["--bearing-bound", "95"], "bearing bound"),
        (["--searches", "2"], "searches"),
        (["--seconds", "-1"], "time budget"),
        (["--solver", "none"], "a solver among"),
    ],
)
def test_what_cannot_be_done_is_refused_with_words(options, words, tmp_path, capsys):
    assert main([*FEW, *options, "--out", str(tmp_path)]) == 2
    assert words in " ".join(capsys.readouterr().err.split())
    assert not (tmp_path / "summary.json").exists()


def test_twelve_robots_have_twenty_one_variables():
    formation = draw_formation(np.random.default_rng(3), 12, BOUND)
    assert np.isnan(formation.anchors([0])).sum() == 21


@pytest.mark.parametrize("seed", range(4))
def test_every_frame_contains_the_truth(seed):
    rng = np.random.default_rng(seed)
    drawn = draw_formation(rng, int(rng.integers(5, 10)), np.radians([2.0, 8.0, 5.0]))  # different sensors
    assert set(np.degrees(drawn.bearings.bound).round(9)) == {2.0, 8.0, 5.0}
    for reference in {0, farthest_reference(drawn)} - {None}:
        seen = drawn.seen_from(reference)
        assert (seen.positions[reference] == 0).all()
        localized = localize(seen, seen.anchors([reference]), Stop())
        assert localized.escaped == []
        assert localized.references == [reference]
        assert len(localized.free) == len(drawn) - 2
        assert all(localized.belief.regions[robot].performance_ratio > 0.94 for robot in localized.free)


def test_another_frame_is_nothing_but_other_anchors(formation):
    other = farthest_reference(formation)
    one, two = (formation.polytope(formation.anchors([reference])) for reference in (0, other))
    for name in ("i", "j", "normal", "source"):
        assert (getattr(one.constraints, name) == getattr(two.constraints, name)).all()
    assert np.abs(one.constraints.offset - two.constraints.offset).max() < 1e-12  # rounding in the box
    assert (one.lower[0] == one.upper[0]).all()
    assert (two.lower[other] == two.upper[other]).all()


def test_the_filter_and_a_bare_projection_agree(formation):
    anchors = formation.anchors([0])
    localized, searcher = localize(formation, anchors, EXACT), Searcher(formation.polytope(anchors))
    for robot in localized.free:
        bare = searcher.project(position(robot, len(formation)), EXACT)
        assert localized.belief.regions[robot].outer.area == pytest.approx(bare.outer.area, rel=1e-4)
        assert localized.belief.regions[robot].inner.area == pytest.approx(bare.inner.area, rel=1e-4)


def test_an_anchored_robot_leaves_the_others_their_inner_polygons(formation):
    """Its own rows hold with nothing to spare; that is exact, and no reason to doubt every point."""
    localized = localize(formation.seen_from(3), formation.anchors([0]) - formation.positions[3], Stop())
    assert all(localized.belief.regions[robot].inner is not None for robot in localized.free)


def test_relative_regions_contain_the_truth_and_turn_round(formation):
    localized = localize(formation, formation.anchors([0]), Stop())
    pairs = uncertain_pairs(localized)
    assert len(pairs) == 3
    there = relative_regions(localized, pairs, EXACT)
    back = relative_regions(localized, [(j, i) for i, j in pairs], EXACT)
    for one, two in zip(there, back, strict=True):
        assert not one.escaped
        assert not two.escaped
        assert one.region.outer.area == pytest.approx(two.region.outer.area, rel=1e-3)
        assert (one.truth == -two.truth).all()


@pytest.mark.parametrize(
    ("stop", "reason"),
    [
        (Stop(performance_ratio=0.7), "performance ratio"),
        (Stop(performance_ratio=1.0, area_gap=10.0), "area gap"),
        (Stop(performance_ratio=1.0, searches=5), "searches"),
        (Stop(performance_ratio=1.0), "time"),
    ],
)
def test_the_result_says_why_the_search_ended(formation, stop, reason):
    over = Budget(0.0, iter(range(10**6)).__next__) if reason == "time" else None
    localized = localize(formation, formation.anchors([0]), stop, budget=over)
    assert {localized.belief.regions[robot].reason for robot in localized.free} == {reason}


def test_merging_in_any_order_gives_the_same_regions_and_another_ekf_estimate(formation):
    spread = spread_over_orders(formation.case(formation.anchors([0])), 3, np.random.default_rng(0))
    assert spread.set_contains
    assert spread.set_area < 1e-4
    assert spread.ekf_position > 1e-3


def test_a_frame_that_is_not_bounded_is_refused(formation):
    with pytest.raises(Unbounded):
        localize(formation, np.full((8, 2), np.nan), Stop())


def test_a_formation_that_cannot_be_bounded_is_given_up(monkeypatch):
    monkeypatch.setattr("experiments.paper.formations.SIGHT", 0.5)
    with pytest.raises(InvalidInput, match="bounded once in"):
        draw_formation(np.random.default_rng(0), 4, BOUND)
