"""The search strategy over formations: curves against oracles, and the experiment's files."""

import json

import numpy as np
import pytest
import shapely

from experiments.paper.formations import Searcher, draw_formation
from experiments.paper.search_curves import LAST, SEARCHES, curves_of, regular_polygon, uniform_areas
from experiments.paper.search_figures import gaps, ratios
from experiments.search_strategy import hardest_of, main
from filter.linear.solvers import SIMPLEX
from filter.projection.proved import position

BOUND = np.radians(5)


@pytest.fixture(scope="module")
def formation():
    return draw_formation(np.random.default_rng(2), 6, BOUND)


@pytest.fixture(scope="module")
def curves(formation):
    return curves_of(formation)


def test_uniform_areas_are_those_of_points_and_half_planes():
    rng = np.random.default_rng(0)
    for count in (3, 4, 7, 30):
        hull = shapely.MultiPoint(rng.normal(size=(12, 2))).convex_hull
        corners = np.array(shapely.orient_polygons(hull).exterior.coords)[:-1]
        turn = 2 * np.pi * np.arange(count) / count
        directions = np.stack([np.cos(turn), np.sin(turn)], axis=1)
        outside = shapely.box(-99, -99, 99, 99)
        for direction in directions:
            point, left = corners[(corners @ direction).argmax()], np.array([-direction[1], direction[0]])
            ends = [point + 999 * left, point - 999 * left]
            outside &= shapely.Polygon([*ends, ends[1] - 999 * direction, ends[0] - 999 * direction])
        points = corners[(directions @ corners.T).argmax(axis=1)]
        inner, outer = uniform_areas(corners, count)
        assert inner == pytest.approx(shapely.MultiPoint(points).convex_hull.area)
        assert outer == pytest.approx(outside.area)


def test_uniform_searches_of_the_exact_polygon_are_those_by_linear_programs(formation, curves):
    """Their supports are read off the exact polygon; here a solver finds them anew."""
    program = Searcher(formation.polytope(formation.anchors([0])), SIMPLEX)
    for each in curves[:2]:
        D = position(each.robot, len(formation))
        for count in (5, 9):
            turn = 2 * np.pi * np.arange(count) / count
            found = [program._workspace.maximize(np.array([np.cos(t), np.sin(t)]) @ D) for t in turn]
            points = np.array([D @ candidate.point for candidate in found])
            area = shapely.Polygon(points).area if len(np.unique(points.round(9), axis=0)) > 2 else 0.0
            assert area == pytest.approx(each.uniform[count - 4, 0], rel=1e-6)


def test_a_circle_is_searched_as_geometry_says():
    circle = regular_polygon(7200)
    for count in (4, 8, 16):
        inner, outer = uniform_areas(circle.vertices, count)
        assert inner == pytest.approx(count / 2 * np.sin(2 * np.pi / count), rel=1e-5)
        assert outer == pytest.approx(count * np.tan(np.pi / count), rel=1e-5)


def test_curves_keep_the_papers_bounds_and_bracket_the_exact_area(formation, curves):
    assert len(curves) == len(formation) - 2
    for each in curves:
        assert not each.escaped
        assert each.variables == 2 * len(formation) - 3
        assert each.searches_to_the_end <= 2 * each.vertices
        for areas in (each.adaptive, each.uniform):
            assert areas.shape == (LAST - 3, 2)
            assert (areas[:, 0] <= each.area * (1 + 1e-6)).all()
            assert (areas[:, 1] >= each.area * (1 - 1e-6)).all()
        ratio = ratios(each.adaptive)
        assert ratio[0] == pytest.approx(0.5, abs=1e-6)
        assert (np.diff(ratio) > -1e-6).all()
        assert each.performance_ratio == pytest.approx(ratio[-1], abs=1e-3)
    gap = gaps(np.array([each.adaptive for each in curves]), np.array([each.area for each in curves]))
    assert (gap * SEARCHES**2 <= 64).all()
    assert ratios(curves[hardest_of(curves)].adaptive)[4] == min(ratios(each.adaptive)[4] for each in curves)


def test_a_run_leaves_a_summary_figures_and_a_recording(tmp_path):
    assert main(["--formations", "2", "--robots", "5", "6", "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["formations"] == 2
    assert summary["escapes"] == 0
    assert summary["projections"] >= 6
    for name in ("adaptive_pr_mean", "adaptive_pr_worst", "uniform_pr_mean"):
        assert len(summary[name]) == 27
    assert summary["adaptive_pr_mean"][0] == pytest.approx(0.5, abs=1e-5)
    assert summary["worst_after_8"] == summary["adaptive_pr_worst"][4]
    assert summary["area_gap_bound_max"] <= 64
    assert summary["searches_over_vertices_max"] <= 2
    assert {path.name for path in tmp_path.glob("*.png")} == {"convergence.png", "worst_case.png", "searches.png"}
    assert (tmp_path / "search_strategy.rrd").stat().st_size > 10_000


@pytest.mark.parametrize(
    "options", [["--formations", "0"], ["--robots", "4", "9"], ["--robots", "9", "5"], ["--bearing-bound", "0"]]
)
def test_what_cannot_be_done_is_refused(options, tmp_path):
    assert main([*options, "--out", str(tmp_path)]) == 2
