"""Half-planes and trapezoids around sectors: every point of a sector is within, and nothing could be nearer."""

import numpy as np
import pytest
from helpers.worlds import unit
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.convex import hull_of
from filter.geometry.polygon import Polygon
from filter.geometry.sector import HAIR, WIDEST, far_and_near, sides, trapezoid

# Rounding of sines, cosines and products, as a share of the farthest distance.
ROUNDING = 1e-14

seeds = st.integers(0, 2**32 - 1)
centres = st.one_of(st.floats(-10, 10), st.sampled_from([0.0, np.pi, -np.pi, np.nextafter(np.pi, 0), np.pi / 2, -3 * np.pi]))
bounds = st.one_of(
    st.floats(0, np.pi),
    st.sampled_from([0.0, 1e-9, 1e-300, WIDEST, np.nextafter(np.pi / 2, 0), np.pi / 2, np.nextafter(np.pi / 2, 2), np.pi]),
)
lengths = st.one_of(st.floats(1e-6, 100), st.sampled_from([0.0, 1e-9, 1.0]))
sectors = st.tuples(centres, bounds, lengths, lengths).map(lambda drawn: (*drawn[:3], drawn[2] + drawn[3]))
spacings = st.one_of(st.floats(0.01, np.pi / 2), st.sampled_from([np.pi / 6, np.pi / 12]))


def points_of(seed, centre, bound, nearest, farthest):
    """Return points (k, 2) all over a sector, its corners and the middles of both ends among them."""
    rng = np.random.default_rng(seed)
    along = np.append(rng.uniform(-1, 1, 60), [-1.0, 1.0, -1.0, 1.0, 0.0, 0.0])
    share = np.append(rng.choice([0.0, 1.0, rng.random()], 60), [0.0, 0.0, 1.0, 1.0, 0.0, 1.0])
    return (nearest + share * (farthest - nearest))[:, None] * unit(centre + bound * along)


@given(seeds, sectors.filter(lambda sector: sector[1] < np.pi / 2))
def test_a_sector_is_between_its_sides_and_reaches_both(seed, sector):
    centre, bound, nearest, farthest = sector
    normals = sides(centre, bound)
    points = points_of(seed, centre, bound, nearest, farthest)
    along = points @ normals.T
    assert along.max() <= ROUNDING * farthest
    for normal, angle in zip(normals, (centre - bound, centre + bound), strict=True):
        assert np.hypot(*normal) == pytest.approx(1)
        assert abs(unit(angle) @ normal) <= ROUNDING
        assert unit(centre) @ normal == pytest.approx(-np.sin(bound), abs=ROUNDING)


@given(seeds, sectors, spacings)
def test_a_sector_is_within_its_far_and_its_near_side(seed, sector, spacing):
    normals, offsets = far_and_near(*sector, spacing)
    assert (points_of(seed, *sector) @ normals.T - offsets).max() <= ROUNDING * sector[-1]
    assert np.hypot(*normals.T) == pytest.approx(1)


@given(sectors, spacings)
def test_each_half_plane_of_the_far_and_the_near_side_touches_the_sector(sector, spacing):
    """A tangent where its own direction is in the sector, the near side in both corners."""
    centre, bound, nearest, farthest = sector
    normals, offsets = far_and_near(centre, bound, nearest, farthest, spacing)
    near = bound < np.pi / 2 and nearest > 0
    tangents = normals[:-1] if near else normals
    off = np.arctan2(tangents @ unit(centre + np.pi / 2), tangents @ unit(centre))
    assert (np.abs(off) <= bound + ROUNDING).all()
    assert (offsets[: len(tangents)] == farthest).all()
    if near:
        corners = nearest * unit(centre + bound * np.array([-1.0, 1.0]))
        assert corners @ normals[-1] == pytest.approx(offsets[-1], abs=ROUNDING * nearest)
        assert normals[-1] == pytest.approx(-unit(centre), abs=ROUNDING)


@given(centres, bounds, spacings)
def test_tangents_are_as_near_to_one_another_as_was_asked_and_as_few_as_can_be(centre, bound, spacing):
    normals, _ = far_and_near(centre, bound, 0.0, 1.0, spacing)
    off = np.arctan2(normals @ unit(centre + np.pi / 2), normals @ unit(centre))
    assert len(off) == max(1, np.ceil(2 * bound / spacing - HAIR))
    gaps = np.diff(off)
    assert (gaps > 0).all()
    assert (gaps <= spacing + 1e-9).all()
    assert gaps == pytest.approx(2 * bound / len(off), abs=1e-9)
    # Between the ends of the arc and the tangents next to them there is half a gap: corners stand out everywhere alike.
    assert [off[0] + bound, bound - off[-1]] == pytest.approx([bound / len(off)] * 2, abs=1e-9)


@pytest.mark.parametrize("count", [4, 12, 24])
def test_a_full_circle_has_tangents_all_around(count):
    normals, offsets = far_and_near(0.3, np.pi, 1.0, 2.0, 2 * np.pi / count)
    assert len(offsets) == count
    polygon = Polygon.from_half_planes(normals, offsets, [-9, -9], [9, 9])
    assert polygon.area == pytest.approx(count * np.tan(np.pi / count) * 4)


@pytest.mark.parametrize("bound", [np.pi / 2, 2.0, np.pi])
def test_from_half_a_circle_on_there_is_no_near_side_and_neither_at_a_distance_of_0(bound):
    assert (far_and_near(0.3, bound, 1.0, 2.0, 0.5)[1] == 2.0).all()
    assert len(far_and_near(0.3, 0.1, 0.0, 2.0, 0.5)[1]) == 1
    assert far_and_near(0.3, 0.1, 1.0, 2.0, 0.5)[1].tolist() == [2.0, -np.cos(0.1)]


def across_and_along(points, centre):
    return points @ unit(centre + np.pi / 2), points @ unit(centre)


@given(seeds, sectors)
def test_a_sector_is_in_its_trapezoid_as_far_as_it_is_not_too_wide(seed, sector):
    centre, bound, nearest, farthest = sector
    corners = trapezoid(centre, bound, nearest, farthest)
    points = points_of(seed, centre, min(bound, WIDEST), nearest, farthest)
    hull = Polygon.from_vertices(corners)
    beyond = (points @ hull.normals.T - hull.offsets).max()
    assert beyond <= 20 * ROUNDING * farthest  # corners are as far aside as 14 times the distance


@given(centres, bounds, lengths, lengths)
def test_no_trapezoid_around_the_sector_is_smaller(centre, bound, nearest, more):
    """Its corners are where the sides meet the near and the far side: of the sector, each touches a point."""
    narrowed, farthest = min(bound, WIDEST), nearest + more
    corners = trapezoid(centre, bound, nearest, farthest)
    across, along = across_and_along(corners, centre)
    near, slope = nearest * np.cos(narrowed), np.tan(narrowed)
    precision = 20 * ROUNDING * farthest
    assert along == pytest.approx([near, near, farthest, farthest], abs=precision)
    assert across == pytest.approx(slope * np.array([-near, near, -farthest, farthest]), abs=precision)


def test_the_corners_of_a_trapezoid_are_its_hull():
    corners = trapezoid(2.9, 0.2, 1.0, 2.0)
    assert len(hull_of(corners)) == 4
    assert Polygon.hull(corners).area == pytest.approx(np.tan(0.2) * (4.0 - np.cos(0.2) ** 2))
    segment = trapezoid(2.9, 0.0, 1.0, 2.0)
    assert segment == pytest.approx(np.array([1.0, 1.0, 2.0, 2.0])[:, None] * unit(2.9))
