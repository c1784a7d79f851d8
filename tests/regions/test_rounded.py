"""A polygon in float32 contains what it stands for, in exact arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.regions.rounded import LARGEST, rounded_outward
from filter import InvalidInput, Polygon

FLOATS = st.floats(-1e7, 1e7, allow_subnormal=True)
POINTS = st.lists(st.tuples(FLOATS, FLOATS), min_size=1, max_size=8)


def exact(point):
    return tuple(Fraction(float(value)) for value in point)


def turn(a, b, c):
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])


def contains(polygon, point):
    """Return whether a convex polygon, counter-clockwise, contains a point, a side or a point that it has come down to, too."""
    corners, p = [exact(corner) for corner in polygon], exact(point)
    edges = zip(corners, [*corners[1:], corners[0]], strict=True)
    within = all(min(c[k] for c in corners) <= p[k] <= max(c[k] for c in corners) for k in range(2))
    return within and all(turn(a, b, p) >= 0 for a, b in edges)


def widened(corners, margin):
    margin = Fraction(margin)
    for x, y in map(exact, corners):
        yield from ((x + i * margin, y + j * margin) for i in (-1, 1) for j in (-1, 1))


def contains_exactly(polygon, point):
    corners = [exact(corner) for corner in polygon]
    edges = zip(corners, [*corners[1:], corners[0]], strict=True)
    return all(turn(a, b, point) >= 0 for a, b in edges)


@given(POINTS, st.sampled_from([0.0, 5e-324, 1e-15, 1e-9, 0.1]))
def test_it_contains_every_corner_with_its_margin(points, margin):
    corners = Polygon.from_vertices(points).vertices.tolist()
    outward = rounded_outward(corners, margin)
    assert all(contains(outward, corner) for corner in corners)
    if margin:
        assert all(contains_exactly(outward, point) for point in widened(corners, margin))


@given(POINTS, st.sampled_from([0.0, 1e-15, 0.1]))
def test_its_corners_are_float32_go_round_once_and_are_near(points, margin):
    corners = Polygon.from_vertices(points).vertices.tolist()
    outward = rounded_outward(corners, margin)
    assert all(float(np.float32(value)) == value for corner in outward for value in corner)
    around = zip(outward, [*outward[1:], outward[0]], [*outward[2:], *outward[:2]], strict=True)
    assert len(outward) < 3 or all(turn(*map(exact, three)) > 0 for three in around)
    farthest = max(abs(value) for corner in corners for value in corner) + margin
    step = 2 * float(np.spacing(np.float32(farthest)))
    for k in range(2):
        beyond = max(corner[k] for corner in outward) - max(corner[k] for corner in corners) - margin
        assert beyond <= step


def test_what_is_float32_already_stays_as_it_is():
    square = [(-1.5, 0.25), (2.0, 0.25), (2.0, 3.0), (-1.5, 3.0)]
    assert rounded_outward(square, 0.0) == square
    assert rounded_outward([(0.5, -2.0)], 0.0) == [(0.5, -2.0)]
    assert rounded_outward([(0.0, 0.0), (1.0, 0.0)] * 2, 0.0) == [(0.0, 0.0), (1.0, 0.0)]


@pytest.mark.parametrize("thin", [1e-3, 1e-9, 1e-13])
def test_a_thin_region_far_from_the_origin_stays_inside(thin):
    along, across, middle = np.array([0.6, 0.8]), np.array([-0.8, 0.6]), np.array([4e5, -3e5])
    corners = [middle + a * along + b * thin * across for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))]
    outward = rounded_outward([corner.tolist() for corner in corners], 1e-10)
    assert all(contains(outward, corner) for corner in corners)


def test_what_float32_cannot_hold_is_refused():
    with pytest.raises(InvalidInput, match="float32"):
        rounded_outward([(LARGEST, 0.0)], 0.0)
