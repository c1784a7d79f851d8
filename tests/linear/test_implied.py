"""What two neighbouring edges prove of any other direction: in exact arithmetic, and all that the polygon allows."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.programs import on_robot
from helpers.worlds import claims_of, exact_claim, unit
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.polygon import SIDES, Polygon
from filter.linear.certify import WORTHLESS, imply
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope

NOBODY, FIRST = np.array([WORLD]), np.array([0])
ALL_AROUND = unit(np.linspace(-np.pi, np.pi, 49))

seeds = st.integers(0, 2**32 - 1)
origins = st.sampled_from([0.0, 1e3, 5e6])
sizes = st.sampled_from([1e-6, 1.0, 1e3])


def polytope_of(polygon, room=1.0):
    """Return the polytope of one robot that is in a polygon."""
    lower, upper = polygon.bounds
    rows = on_robot(0, polygon.normals, polygon.offsets, np.zeros(len(polygon.offsets), dtype=int))
    return Polytope(rows, lower[None] - room, upper[None] + room)


def implied(polytope, directions, i=NOBODY, j=FIRST):
    """Return claims on each of (g) robots or pairs, on the polygons of their own rows, in each of (k, 2) directions."""
    clipped, whose = polytope.of(i, j), np.repeat(np.arange(len(j)), len(directions))
    asked = whose, np.tile(directions, (len(j), 1))
    offsets, rows, prices = np.empty(len(whose)), np.empty((len(whose), 2), dtype=np.int64), np.empty((len(whose), 2))
    outlines = clipped.polygons.normals, clipped.polygons.vertices, clipped.behind, clipped.polygons.first
    box = polytope.lower, polytope.upper
    imply((offsets, rows, prices), (i, j), outlines, asked, polytope.constraints.rows, box)
    return claims_of(polytope, (i[whose], j[whose]), (asked[1], offsets), (rows, prices)), clipped.polygons


def check(claims):
    """Every claim is proved without any rounding, by the rows on its own robot or pair."""
    rows = claims.polytope.constraints
    for claim in range(len(claims)):
        assert exact_claim(claims, claim) <= 0
        used, prices = claims.rests_on(claim)
        assert len(used) <= 2
        assert (prices > WORTHLESS).all()
        assert (rows.i[used] == claims.i[claim]).all()
        assert (rows.j[used] == claims.j[claim]).all()


def reaches(claims, polygons):
    """Return how far the vertices of each claim's polygon are in its direction."""
    reached = [polygon.vertices @ claims.normal.T for polygon in polygons]
    whose = np.repeat(np.arange(len(polygons)), len(claims) // max(len(polygons), 1))
    return np.array([reached[g][:, claim].max() for claim, g in enumerate(whose)])


@given(seeds, origins, sizes)
def test_no_half_plane_cuts_the_polygon_and_each_touches_it(seed, origin, size):
    rng = np.random.default_rng(seed)
    points = origin + size * rng.normal(size=(rng.integers(3, 12), 2))
    polygon = Polygon.from_vertices(points)
    claims, polygons = implied(polytope_of(polygon, size), unit(rng.uniform(-np.pi, np.pi, 9)))
    check(claims)
    inside = [[Fraction(float(x)) for x in point] for point in points]
    for normal, offset in zip(claims.normal.tolist(), claims.offset.tolist(), strict=True):
        a, b = map(Fraction, normal)
        assert max(a * x + b * y for x, y in inside) <= Fraction(offset)
    assert claims.offset == pytest.approx(reaches(claims, polygons), abs=1e-9 * size + 1e-13 * origin + 4 * polygon.margin)


@given(seeds, origins, sizes)
def test_the_sides_of_a_box_are_proved_and_touch_the_polygon(seed, origin, size):
    """Along the axes, where an edge may lie in the very direction; a side of the polytope's own box takes part, too."""
    rng = np.random.default_rng(seed)
    lower = origin + size * rng.uniform(-1, 0, (1, 2))
    upper = lower + size
    normals = unit(rng.choice([0.0, np.pi / 2, 1.0, -2.0, 3.0, rng.uniform(-np.pi, np.pi)], rng.integers(1, 5)))
    middle = (lower + upper)[0] / 2
    rows = on_robot(0, normals, normals @ middle + size * rng.uniform(0.1, 0.4, len(normals)), np.arange(len(normals)))
    claims, polygons = implied(Polytope(rows, lower, upper), SIDES)
    check(claims)
    assert claims.offset == pytest.approx(reaches(claims, polygons), abs=1e-9 * size + 1e-13 * origin)


@pytest.mark.parametrize("count", [3, 4, 7, 40])
def test_in_the_direction_of_an_edge_its_own_row_proves_it(count):
    polygon = Polygon.hull(unit(2 * np.pi * np.arange(count) / count + 0.1))
    claims, _ = implied(polytope_of(polygon), polygon.normals)
    check(claims)
    assert claims.offset == pytest.approx(polygon.offsets, abs=1e-12)
    for claim in range(len(claims)):
        used, prices = claims.rests_on(claim)
        own = polygon.normals[used] @ claims.normal[claim] > 1 - 1e-12
        assert prices[own] == pytest.approx(1.0)
        assert prices[~own] == pytest.approx(0.0, abs=1e-9)


@pytest.mark.parametrize("far", [0.0, 5e6])
@pytest.mark.parametrize("size", [0.0, 1e-9, 1.0])
@pytest.mark.parametrize("ends", [[[0, 0]], [[0, 0], [3, 1]], [[0, 0], [0, 2]], [[-1, 0], [1, 0]]])
def test_of_a_point_and_of_a_segment_no_half_plane_cuts_anything(ends, size, far):
    points = far + size * np.array(ends, dtype=float)
    polygon = Polygon.from_vertices(points)
    claims, polygons = implied(polytope_of(polygon), ALL_AROUND)
    check(claims)
    reached = (points @ ALL_AROUND.T).max(axis=0)
    assert (claims.offset >= reached - 1e-15 * (1 + far)).all()
    assert (claims.offset >= reaches(claims, polygons) - 1e-15 * (1 + far)).all()
    assert claims.offset == pytest.approx(reached, abs=1e-6 + 1e-13 * far)


def test_of_a_polygon_as_small_as_its_rounding_nothing_is_cut():
    """Its edges turn back and forth: in all by more than once around."""
    normals = unit(
        np.array([2.7116643128302638, 1.1667476516313764, 0.5999219218150889, 0.0517619873700772, 0.4377276253787197])
    )
    offsets = -np.array(
        [4.378770442643793e-17, 1.40231231064620e-16, 1.15297521810965e-16, 1.0028962617185e-16, 1.931938105630e-16]
    )
    rows = on_robot(0, normals, offsets, np.zeros(5, dtype=int))
    claims, polygons = implied(Polytope(rows, np.full((1, 2), -1.0), np.full((1, 2), 1.0)), ALL_AROUND)
    a = polygons[0].normals
    b = np.roll(a, -1, axis=0)
    turned = np.arctan2(a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0], (a * b).sum(axis=1))
    assert turned[turned > 0].sum() > 2 * np.pi
    check(claims)
    assert (claims.offset >= reaches(claims, polygons) - 1e-15).all()


def test_rows_that_exclude_one_another_leave_what_the_box_says():
    apart = on_robot(0, np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([-0.5, -0.5]), np.arange(2))
    polytope = Polytope(apart, np.full((1, 2), -1.0), np.full((1, 2), 2.0))
    assert polytope.of(NOBODY, FIRST).empty[0]
    claims, _ = implied(polytope, ALL_AROUND)
    check(claims)
    assert (claims.weights.counts == 0).all()
    assert claims.offset == pytest.approx(Polygon.box([-1, -1], [2, 2]).support(ALL_AROUND))


def team(rng, robots=4, each=9):
    """Return a polytope with rows on every robot and pair, and these (g) and (g)."""
    i, j = np.array([(i, j) for j in range(robots) for i in range(WORLD, j)]).T
    count = len(i) * each
    angles = np.sort(rng.uniform(-np.pi, np.pi, (len(i), each)), axis=1).ravel()
    rows = np.repeat(i, each), np.repeat(j, each), unit(angles), rng.uniform(0.3, 1.0, count), np.arange(count)
    return Polytope(Constraints(*rows), np.full((robots, 2), -2.0), np.full((robots, 2), 2.0)), i, j


@given(seeds)
def test_of_many_robots_and_pairs_each_is_proved_by_its_own_rows(seed):
    polytope, i, j = team(np.random.default_rng(seed))
    order = np.random.default_rng(seed).permutation(len(i))
    claims, polygons = implied(polytope, ALL_AROUND[:7], i[order], j[order])
    check(claims)
    assert claims.offset == pytest.approx(reaches(claims, polygons), abs=1e-9)


def test_rows_through_corners_leave_every_polygon_as_it_is():
    polytope, i, j = team(np.random.default_rng(2))
    claims, _ = implied(polytope, ALL_AROUND, i, j)
    through = Constraints(claims.i, claims.j, claims.normal, claims.offset, np.zeros(len(claims), dtype=int))
    before = polytope.of(i, j).polygons
    after = polytope.with_constraints(Constraints.concatenate([polytope.constraints, through])).of(i, j).polygons
    assert after.areas == pytest.approx(before.areas, rel=1e-9)
