"""Compiled geometry against shapely; what greedy removal says of itself."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.convex import area_of, centroid_of, cut_box, hull_of, worthy
from filter.geometry.polygon import clip

CORNERS = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
seeds = st.integers(0, 2**32 - 1)


@given(seeds)
def test_the_hull_is_shapelys_also_of_points_that_coincide_or_are_in_line(seed):
    rng = np.random.default_rng(seed)
    points = rng.integers(-3, 4, (int(rng.integers(1, 12)), 2)).astype(float)
    hull = hull_of(points)
    assert area_of(hull) == pytest.approx(shapely.MultiPoint(points).convex_hull.area)
    assert {tuple(corner) for corner in hull} <= {tuple(point) for point in points}
    assert len({tuple(corner) for corner in hull}) == len(hull)


def test_the_hull_runs_counter_clockwise():
    assert shapely.Polygon(hull_of(np.random.default_rng(0).normal(size=(30, 2)))).exterior.is_ccw


def test_area_and_centre_are_those_of_the_polygon_wherever_it_is():
    for shift in (0.0, 1e7):
        assert area_of(CORNERS + shift) == pytest.approx(2.0)
        assert centroid_of(CORNERS + shift) == pytest.approx([1.0 + shift, 0.5 + shift])
    assert centroid_of(np.array([[1.0, 1.0], [3.0, 1.0]])) == (2.0, 1.0)


def test_a_box_is_cut_by_what_cuts_it_alone():
    lower, upper = np.zeros(2), np.array([2.0, 1.0])
    vertices, edges, margin = cut_box(np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([1.5, 3.0]), lower, upper)
    assert area_of(vertices) == pytest.approx(1.5)
    assert sorted(edges) == [-3, -2, -1, 0]
    assert 0 < margin < 1e-13
    assert not len(cut_box(np.array([[1.0, 0.0]]), np.array([-0.1]), lower, upper)[0])


@given(seeds, st.integers(3, 8), st.floats(0, 0.5))
def test_what_removal_says_it_adds_is_what_it_adds(seed, budget, share):
    rng = np.random.default_rng(seed)
    angles = np.sort(rng.uniform(0, 2 * np.pi, 14))
    normals, offsets = np.stack([np.cos(angles), np.sin(angles)], axis=1), rng.uniform(0.8, 1.0, 14)
    polygon, edges = clip(normals, offsets, np.full(2, -5.0), np.full(2, 5.0))
    removable = edges >= 0
    keep, spent = worthy(polygon.normals, polygon.offsets, removable, budget, share * polygon.area)
    rest = clip(polygon.normals[keep], polygon.offsets[keep], np.full(2, -1e3), np.full(2, 1e3))[0]
    assert keep[~removable].all()
    assert keep[removable].sum() <= budget
    if np.isfinite(spent):
        assert rest.area == pytest.approx(polygon.area + spent, rel=1e-6)
        assert spent <= share * polygon.area or keep[removable].sum() == min(budget, removable.sum())


def test_of_no_edges_none_are_kept():
    keep, spent = worthy(np.zeros((0, 2)), np.zeros(0), np.zeros(0, dtype=bool), 4, 1.0)
    assert (len(keep), spent) == (0, 0.0)
