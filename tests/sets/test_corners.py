"""Rows through corners: implied by the two edges that meet there, and dense enough."""

from fractions import Fraction

import numpy as np
import pytest
from filter.sets.corners import corner_rows
from helpers.worlds import World, escapes, unit
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.sets.set_membership import SetMembershipFilter

SPACING = np.radians(7.5)
NOBODY, FIRST, NUMBERS = np.array([WORLD]), np.array([0]), np.array([7])


def polytope_of(polygon, room=1.0):
    lower, upper = polygon.bounds
    rows = Constraints.on_robot(0, polygon.normals, polygon.offsets, np.zeros(len(polygon.offsets), dtype=int))
    return Polytope(rows, lower[None] - room, upper[None] + room)


def angles_of(normals):
    return np.sort(np.arctan2(normals[:, 1], normals[:, 0]))


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e3, 5e6]), st.sampled_from([1e-6, 1.0, 1e3]))
def test_no_row_cuts_the_polygon_and_each_touches_it(seed, origin, size):
    rng = np.random.default_rng(seed)
    points = origin + size * rng.normal(size=(rng.integers(3, 12), 2))
    polygon = Polygon.from_vertices(points)
    found = corner_rows(polytope_of(polygon, room=size), NOBODY, FIRST, SPACING, NUMBERS)
    inside = [[Fraction(float(x)) for x in point] for point in points]
    for normal, offset in zip(found.normal.tolist(), found.offset.tolist(), strict=True):
        a, b = map(Fraction, normal)
        assert max(a * x + b * y for x, y in inside) <= Fraction(offset)
    reached = (found.normal @ polygon.vertices.T).max(axis=1)
    sharp = np.abs(np.diff(np.append(angles_of(polygon.normals), angles_of(polygon.normals)[0] + 2 * np.pi))).max() > 3
    if not sharp:  # beside an edge to either side the corner is where they meet
        assert found.offset == pytest.approx(reached, abs=1e-6 * size + 1e-13 * origin + 4 * polygon.margin)


@pytest.mark.parametrize("count", [3, 4, 7, 40, 200])
def test_neighbours_turn_by_no_more_than_the_spacing(count):
    polygon = Polygon.from_vertices(unit(2 * np.pi * np.arange(count) / count + 0.1))
    found = corner_rows(polytope_of(polygon), NOBODY, FIRST, SPACING, NUMBERS)
    every = angles_of(np.concatenate([polygon.normals, found.normal]))
    assert np.diff(np.append(every, every[0] + 2 * np.pi)).max() <= SPACING + 1e-9
    assert np.hypot(*found.normal.T) == pytest.approx(1)
    assert (len(found) == 0) == (count == 200)
    assert set(found.source.tolist()) <= {7}


@pytest.mark.parametrize(
    "polygon", [Polygon.box([1, 2], [1, 2]), Polygon.from_vertices([[0, 0], [3, 1]])], ids=["point", "segment"]
)
def test_of_a_point_and_of_a_segment_no_row_cuts_anything(polygon):
    found = corner_rows(polytope_of(polygon), NOBODY, FIRST, SPACING, NUMBERS)
    assert (found.normal @ polygon.vertices.T <= found.offset[:, None] + 1e-15).all()


def test_a_polygon_as_small_as_its_rounding_may_turn_back_and_forth():
    normals = unit(
        np.array([2.7116643128302638, 1.1667476516313764, 0.5999219218150889, 0.0517619873700772, 0.4377276253787197])
    )
    offsets = -np.array(
        [4.378770442643793e-17, 1.40231231064620e-16, 1.15297521810965e-16, 1.0028962617185e-16, 1.931938105630e-16]
    )
    rows = Constraints.on_robot(0, normals, offsets, np.zeros(5, dtype=int))
    polytope = Polytope(rows, np.full((1, 2), -1.0), np.full((1, 2), 1.0))
    a = polytope.of(NOBODY, FIRST).polygons[0].normals
    b = np.roll(a, -1, axis=0)
    turned = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
    turned = turned[(turned > 0) & (turned < np.pi - 1e-9)]
    assert turned.sum() > 2 * np.pi
    assert len(corner_rows(polytope, NOBODY, FIRST, 0.01, NUMBERS)) == (np.ceil(turned / 0.01) - 1).sum()


def test_rows_on_a_pair_are_implied_by_the_pairs_rows():
    rng = np.random.default_rng(2)
    angles = np.sort(rng.uniform(-np.pi, np.pi, 9))
    rows = Constraints(np.full(9, 1), np.full(9, 2), unit(angles), rng.uniform(0.5, 1.0, 9), np.zeros(9, dtype=int))
    polytope = Polytope(rows, np.full((3, 2), -4.0), np.full((3, 2), 4.0))
    pair = np.array([1]), np.array([2])
    found = corner_rows(polytope, *pair, SPACING, NUMBERS)
    assert len(found) > 20
    assert set(zip(found.i.tolist(), found.j.tolist(), strict=True)) == {(1, 2)}
    before = polytope.of(*pair).polygons
    after = polytope.with_constraints(Constraints.concatenate([rows, found])).of(*pair).polygons
    assert after.areas == pytest.approx(before.areas, rel=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_after_a_motion_corners_are_round_and_regions_no_larger(seed):
    def followed(spacing):
        world = World(np.random.default_rng(seed), robots=3, errors="extreme" if seed else "uniform")
        estimator = SetMembershipFilter(world.team, corner_spacing=spacing)
        belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
        for motion, records in world.steps(10):
            predicted = estimator.predict(belief, motion.time, motion)
            assert escapes(predicted, world.positions, world.headings) == []
            belief = estimator.update(predicted, records)
            assert escapes(belief, world.positions, world.headings) == []
        return predicted.regions.outer.areas, belief.regions.outer.areas

    for fine, none in zip(followed(SPACING), followed(None), strict=True):
        assert (fine <= none * 1.003 + 1e-12).all()
        assert fine.sum() < none.sum()
