"""Compiled geometry against shapely."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.angles import wrap
from filter.geometry.convex import area_of, centroid_of, clip_box, hull_of, line_behind, span_of
from filter.geometry.polygon import Polygon, clip

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


def cut(normals, offsets, lower, upper):
    """Return vertices, what is behind the edges, and the margin."""
    vertices, behind = np.empty((len(offsets) + 4, 2)), np.empty(len(offsets) + 4, dtype=np.int64)
    size, margin = clip_box((vertices, behind), (normals, offsets), lower, upper)
    return vertices[:size], behind[:size], margin


def test_a_box_is_cut_by_what_cuts_it_alone():
    lower, upper = np.zeros(2), np.array([2.0, 1.0])
    vertices, behind, margin = cut(np.array([[1.0, 0.0], [0.0, 1.0]]), np.array([1.5, 3.0]), lower, upper)
    assert area_of(vertices) == pytest.approx(1.5)
    assert sorted(behind) == [0, 3, 4, 5]  # the cut for the right side; then top, left and bottom, numbered after the lines
    assert 0 < margin < 1e-13
    vertices, behind, _ = cut(np.array([[1.0, 0.0]]), np.array([-0.1]), lower, upper)
    assert (len(vertices), len(behind)) == (0, 0)


def test_the_sides_of_a_box_are_numbered_right_top_left_bottom():
    lower, upper = np.array([-1.0, 2.0]), np.array([3.0, 7.0])
    box = Polygon.box(lower, upper)
    nothing = np.zeros((0, 2)), np.zeros(0)
    _, behind, _ = cut(*nothing, lower, upper)
    assert behind.tolist() == [0, 1, 2, 3]
    for side in range(4):
        x, y, offset = line_behind(side, nothing, lower, upper)
        assert ([x, y], offset) == (box.normals[side].tolist(), box.offsets[side])
        ends = box.vertices[[side, (side + 1) % 4]]
        assert (ends @ [x, y]).tolist() == [offset, offset]


@given(seeds)
def test_a_polygon_is_the_box_that_is_cut(seed):
    """One after the other or all at once: `clip` adds the lines behind the edges to what `clip_box` writes."""
    rng = np.random.default_rng(seed)
    angles, offsets = rng.uniform(-np.pi, np.pi, 6), rng.uniform(-0.3, 1.0, 6)
    normals, lower, upper = np.stack([np.cos(angles), np.sin(angles)], axis=1), -np.ones(2), np.ones(2)
    vertices, behind, margin = cut(normals, offsets, lower, upper)
    kept = clip(normals, offsets, lower, upper)
    assert (kept is None) == (len(vertices) == 0)
    if kept is not None:
        assert (kept[0].vertices.tolist(), kept[0].margin, kept[1].tolist()) == (vertices.tolist(), margin, behind.tolist())


@pytest.mark.parametrize("turn", range(5))
def test_a_span_is_the_same_wherever_the_vertices_begin(turn):
    corners = np.roll(np.array([[2.0, -1.0], [3.0, 0.0], [3.0, 1.0], [2.0, 1.0], [1.5, 0.0]]), turn, axis=0)
    centre, bound = span_of(corners, 0.0)
    centre, low, high = float(wrap(centre)), np.arctan2(-1.0, 2.0), np.arctan2(1.0, 2.0)
    assert (centre - bound, centre + bound) == (pytest.approx(low), pytest.approx(high))
    assert centre - bound <= low < high <= centre + bound
