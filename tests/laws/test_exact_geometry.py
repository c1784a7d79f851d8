"""Sines, angles, arcs, supports and displacements of the checker, between exact bounds."""

from fractions import Fraction

import numpy as np
import pytest
import shapely
import shapely.affinity
from helpers.worlds import unit
from hypothesis import given
from hypothesis import strategies as st

from experiments.logs.exactly import hexadecimal
from experiments.proof.cases.cone import directions, half_circle_about
from experiments.proof.cases.polygon import Polygon as ExactPolygon
from experiments.proof.cases.polygon import three
from experiments.proof.edges import plane, through_corner
from experiments.proof.exact import (
    ANYWHERE,
    CHOSEN,
    KEPT,
    PI,
    Arc,
    angle_of,
    are_apart,
    in_common,
    length,
    once_around,
    sector,
)
from experiments.proof.exact import unit as enclosed
from experiments.proof.motion import Motion, Piece
from experiments.proof.reading import Broken
from filter import AngularIntervals, Odometry, Polygon, Team
from filter.sensing.motion import displacements

seeds = st.integers(0, 2**32 - 1)


@given(seeds, st.sampled_from([0.0, 1e6]))
def test_a_row_through_a_corner_is_proved_by_the_edges_beside_it_and_no_smaller_one_is(seed, origin):
    rng = np.random.default_rng(seed)
    polygon = Polygon.from_vertices(origin + rng.normal(size=(9, 2)))
    edges = {plane(hexadecimal(n)): Fraction(float(b)) for n, b in zip(polygon.normals, polygon.offsets, strict=True)}
    normal = unit(rng.uniform(-np.pi, np.pi))
    found = through_corner(edges, plane(hexadecimal(normal)))
    assert float(found) == pytest.approx((polygon.vertices @ normal).max(), abs=1e-9 + 1e-8 * origin)


def test_no_corner_is_beyond_all_edges():
    edges = {plane(hexadecimal(unit(np.radians(angle)))): Fraction(1) for angle in (0.0, 60.0)}
    assert through_corner(edges, plane(hexadecimal(unit(np.radians(200.0))))) is None
    assert through_corner({}, plane(hexadecimal(unit(1.0)))) is None


@given(st.floats(-50, 50))
def test_sines_and_cosines_are_enclosed(angle):
    (low, high), (least, greatest) = enclosed(Fraction(angle))
    assert high - low == greatest - least == Fraction(3, 2**110)
    assert abs(float(low) - np.cos(angle)) < 1e-15
    assert abs(float(least) - np.sin(angle)) < 1e-15
    squares = [(min(a * a, b * b), max(a * a, b * b)) for a, b in ((low, high), (least, greatest))]
    assert squares[0][0] + squares[1][0] <= 1 <= squares[0][1] + squares[1][1]


def test_the_angles_of_a_triangle_are_known():
    sixty, thirty = enclosed(PI / 3), enclosed(PI / 6)
    assert sixty[0][0] < Fraction(1, 2) < sixty[0][1]
    assert thirty[1][0] < Fraction(1, 2) < thirty[1][1]
    assert length((Fraction(3), Fraction(4))) - 5 < Fraction(1, 2**100)


@given(seeds)
def test_a_displacement_is_within_its_support_and_the_filter_claims_no_less(seed):
    rng = np.random.default_rng(seed)
    heading, bound, turn, turned, skew = rng.uniform(-np.pi, np.pi), rng.uniform(0, 0.4), *rng.uniform(0, 0.3, 3)
    way, error, slip = rng.uniform(-1, 1), rng.uniform(0, 0.5), rng.uniform(0, 0.1)
    looks = Arc.between(Fraction(heading) - Fraction(bound), Fraction(heading) + Fraction(bound))
    arc = looks.widened(Fraction(turn) / 2, Fraction(turned) / 2 + Fraction(skew))
    motion = Motion.of(Piece(*map(Fraction, (way, error, turn, turned, skew, slip, 0))), looks)
    odometry = Odometry(0.0, 1.0, 0, way, error, turn, turned, skew, slip)
    moves = displacements(odometry, AngularIntervals([heading], [bound]), Team(1), 1.0)
    for angle in rng.uniform(-np.pi, np.pi, 4):
        normal = unit(angle)
        x, y = (Fraction(float(value)) for value in normal)
        support = motion.support((x, y))
        assert support <= Fraction(float(moves.support(np.array([0]), normal[None])[0]))
        for _ in range(8):
            far = Fraction(float(rng.uniform(way - error, way + error)))
            u = enclosed(arc.low + (arc.high - arc.low) * Fraction(float(rng.uniform())))
            along = far * (x * u[0][0] + y * u[1][0]) + Fraction(slip) * length((x, y))
            assert along - Fraction(1, 10**12) <= support


def test_a_sector_reaches_as_far_as_its_corners_and_its_rim():
    arc = Arc.between(Fraction(-1, 2), Fraction(1, 2))
    for normal, most in (((1, 0), 2), ((-1, 0), -np.cos(0.5)), ((0, 1), 2 * np.sin(0.5))):
        assert sector(normal, arc, 1 << KEPT, 2 << KEPT) / (1 << 2 * KEPT) == pytest.approx(most, abs=1e-12)


@given(seeds)
def test_the_angle_of_a_vector_is_enclosed_finely(seed):
    rng = np.random.default_rng(seed)
    vector = 10.0 ** rng.uniform(-9, 9) * rng.normal(size=2) * rng.choice([0.0, 1.0], 2, p=[0.2, 0.8]) + 0.0
    if not vector.any():
        return
    low, high = (around := angle_of(plane(hexadecimal(vector)))).low, around.high
    assert 0 < high - low < Fraction(1, 2**80)
    assert abs(float(low) - np.arctan2(vector[1], vector[0])) < 1e-15
    x, y = plane(hexadecimal(vector))
    for end, turned in ((low, 1), (high, -1)):
        (cosine, _), (sine, _) = enclosed(end)
        assert turned * (cosine * y - sine * x) > 0


def test_nothing_has_no_angle():
    with pytest.raises((ValueError, ZeroDivisionError)):
        angle_of((Fraction(0), Fraction(0)))


def arcs_around(rng, angle, count):
    """Return arcs that contain an angle, each some turns away, some of them wide, and one that is anything else."""
    bounds = rng.choice([0.01, 0.5, 2.0, 3.1], count) * rng.uniform(0.1, 1, count)
    centres = angle + rng.uniform(-1, 1, count) * bounds + 2 * np.pi * rng.integers(-3, 4, count)
    return [Arc.between(Fraction(c) - Fraction(b), Fraction(c) + Fraction(b)) for c, b in zip(centres, bounds, strict=True)]


@given(seeds)
def test_what_arcs_have_in_common_contains_all_that_they_do(seed):
    rng = np.random.default_rng(seed)
    angle = rng.uniform(-np.pi, np.pi)
    arcs = arcs_around(rng, angle, int(rng.integers(1, 6)))
    found, here = in_common(arcs[0], arcs[1:]), Fraction(angle)
    assert found.covers(Arc.between(here, here))
    assert found.high - found.low <= min(arc.high - arc.low for arc in arcs)
    for other in np.linspace(-np.pi, np.pi, 50):
        point = Arc.between(Fraction(other), Fraction(other))
        assert found.covers(point) or not all(arc.covers(point) for arc in arcs)


def test_two_arcs_that_meet_behind_are_not_taken_for_what_is_in_front():
    """Lifted to one turn, they would seem to have nothing in common, and then everything would follow."""
    behind = [
        Arc.between(PI * Fraction(5, 10), PI * Fraction(13, 10)),
        Arc.between(-PI * Fraction(13, 10), -PI * Fraction(5, 10)),
    ]
    found = in_common(behind[0], behind[1:])
    assert found.covers(Arc.between(PI, PI))
    assert not found.covers(Arc.between(Fraction(0), Fraction(0)))
    assert not Arc.between(Fraction(-1, 10), Fraction(1, 10)).covers(found)


def test_two_wide_arcs_that_meet_at_both_ends_have_both_in_common():
    one, other = Arc.between(Fraction(-28, 10), Fraction(28, 10)), Arc.between(Fraction(-8, 10), Fraction(48, 10))
    for arcs in ((one, other), (other, one), (one, other.turned(2)), (one.turned(-1), other)):
        found = in_common(arcs[0], arcs[1:])
        for angle in (Fraction(0), Fraction(-26, 10), Fraction(27, 10)):
            assert found.covers(Arc.between(angle, angle))


def test_an_arc_covers_the_same_some_turns_away_and_no_wider_one():
    arc = Arc.between(Fraction(3), Fraction(4))
    for turns in (-2, 0, 1):
        assert Arc.between(Fraction(29, 10), Fraction(41, 10)).covers(arc.turned(turns))
        assert not arc.turned(turns).covers(Arc.between(Fraction(3), Fraction(401, 100)))
    assert not Arc.between(Fraction(4), Fraction(3)).covers(arc)
    assert Arc.between(Fraction(-4), Fraction(4)).covers(arc)


@given(seeds, st.sampled_from([0.0, 1e6]))
def test_a_row_through_a_corner_is_that_of_the_polygon_whatever_else_is_known(seed, origin):
    rng = np.random.default_rng(seed)
    polygon = Polygon.from_vertices(origin + rng.normal(size=(6, 2)))
    edges = {plane(hexadecimal(n)): Fraction(float(b)) for n, b in zip(polygon.normals, polygon.offsets, strict=True)}
    others = [unit(angle) for angle in rng.uniform(-np.pi, np.pi, 20)]  # that cut nothing
    known = edges | {plane(hexadecimal(n)): Fraction(float(polygon.support(n[None])[0])) + 1 for n in others}
    normal = unit(rng.uniform(-np.pi, np.pi)) if rng.uniform() < 0.7 else polygon.normals[0] * (1 + 1e-16) * 3.7
    found = through_corner(known, plane(hexadecimal(normal)))
    assert float(found) == pytest.approx((polygon.vertices @ normal).max(), abs=1e-9 + 1e-8 * origin)
    assert through_corner({}, plane(hexadecimal(normal))) is None


def cut_by(rng, lines, origin):
    """Return a square of 2 m cut by some lines, exactly, or None, and the same by shapely."""
    left, right = ExactPolygon.box(exactly(origin - 1), exactly(origin + 1)), shapely.box(*origin - 1, *origin + 1)
    for _ in range(lines):
        normal, offset = unit(rng.uniform(-np.pi, np.pi)), rng.uniform(-0.3, 1.2)
        behind = shapely.Polygon(origin + np.array([[a, b] for a, b in ((9, -9), (9, 9), (-9, 9), (-9, -9))]))
        angle = np.arctan2(normal[1], normal[0])
        behind = shapely.affinity.translate(behind, xoff=offset - 9)
        behind = shapely.affinity.rotate(behind, angle, origin=tuple(origin), use_radians=True)
        left = left and left.cut(three(*plane(hexadecimal(normal)), Fraction(float(normal @ origin + offset))))
        right = right.intersection(behind)
    return left, right


def exactly(place):
    return plane(hexadecimal(np.asarray(place, dtype=float)))


@given(st.integers(-(10**22), 10**22), st.floats(0, 3), st.floats(-3, 3), st.floats(0, 3))
def test_arcs_that_meet_are_not_apart_however_many_turns_on_one_is(turns, bound, aside, other):
    """Where floats are as far apart as turns, they cannot tell how many turns on the other one is."""
    low = Fraction(aside) + 2 * PI * turns
    near, far = Arc.between(Fraction(-bound), Fraction(bound)), Arc.between(low - Fraction(other), low + Fraction(other))
    clearly = abs(bound + other - abs(aside)) > 1e-9
    if clearly and abs(aside) < bound + other:
        assert not are_apart(near, far)
        assert not are_apart(far, near)
        assert not are_apart(Arc.between(Fraction(-4), Fraction(4)), far)
    elif clearly and 2 * np.pi - abs(aside) > bound + other + 1e-9:
        assert are_apart(near, far)


def check_reach(polygon, normal):
    """Check how far a polygon reaches: no less than it does, and by less than a step more."""
    whole = tuple(int(exactly(normal)[k] * 2**CHOSEN) for k in range(2))
    most = max(Fraction(whole[0], 2**CHOSEN) * x + Fraction(whole[1], 2**CHOSEN) * y for x, y in polygon.corners)
    assert 0 <= Fraction(polygon.reach(whole), 2**KEPT) - most < Fraction(1, 2**KEPT)


@pytest.mark.parametrize("size", [1e-310, 1e-160, 1.0, 1e160, 1.7e308])
@pytest.mark.parametrize("normal", [(1.0, 0.5), (0.7, 0.7), (2.0, 1e-320), (5e-324, 1.0), (-1.0, 1.0)])
def test_what_is_behind_a_line_is_exact_where_floats_are_not(size, normal):
    corners = size * np.array([[-1, -1], [1, -0.5], [1, 1], [0.999999, 1]])
    polygon = ExactPolygon.around([exactly(corner) for corner in corners])
    most = max(exactly(normal)[0] * x + exactly(normal)[1] * y for x, y in polygon.corners)
    check_reach(polygon, normal)
    if size < 1e300:  # larger ones are refused
        assert polygon.is_behind(three(*exactly(normal), most))
        assert not polygon.is_behind(three(*exactly(normal), most - Fraction(1, 10**400)))


def test_what_is_behind_a_line_is_exact_where_floats_are_none():
    polygon = ExactPolygon.around([exactly(1.7e308 * np.array(corner)) for corner in ((0.05, 0), (1, 1), (0, 0.05))])
    normal = exactly((1.5, -1.4))
    check_reach(polygon, (1.5, -1.4))
    assert not polygon.is_behind(three(*normal, Fraction(1.4e307)))


def test_how_far_a_polygon_reaches_is_exact_where_products_are_rounded_to_whole_denormals():
    polygon = ExactPolygon.around([exactly(5e-324 * np.array(corner)) for corner in ((1, 1), (2, 0), (0, 0))])
    check_reach(polygon, (0.56, 0.55))
    assert not polygon.is_behind(three(*exactly((0.56, 0.55)), Fraction(0)))


@given(seeds, st.sampled_from([0.0, 1e4]))
def test_a_polygon_is_cut_to_the_intersection_with_half_planes(seed, far):
    rng = np.random.default_rng(seed)
    left, right = cut_by(rng, int(rng.integers(1, 9)), np.full(2, far))
    if left is None or right.area < 1e-9:
        assert right.area < 1e-9
        assert left is None or shapely.Polygon(left.floats + left.floats[:2]).area < 1e-6
        return
    assert shapely.Polygon([*left.floats, left.floats[0]]).area == pytest.approx(right.area, abs=1e-7)
    normal = unit(rng.uniform(-np.pi, np.pi))
    most = float(max(normal[0] * x + normal[1] * y for x, y in left.floats))
    check_reach(left, normal)
    assert most == pytest.approx(max(normal @ corner for corner in right.exterior.coords), abs=1e-9)
    assert left.is_behind(three(*plane(hexadecimal(normal)), Fraction(most) + Fraction(1, 10**6)))
    assert not left.is_behind(three(*plane(hexadecimal(normal)), Fraction(most) - Fraction(1, 10**6)))


def test_a_polygon_may_be_a_line_or_a_point_and_a_line_through_a_corner_cuts_nothing_off():
    one, no = Fraction(1), Fraction(0)
    square = ExactPolygon.box((no, no), (one, one))
    assert square.cut(three(one, one, Fraction(2))) is square
    corner = square.cut(three(-one, -one, Fraction(-2)))
    assert set(corner.corners) == {(one, one)}
    assert corner.cut(three(one, no, one)) is corner
    assert corner.cut(three(one, no, one - Fraction(1, 10**40))) is None
    side = square.cut(three(-one, no, -one))
    assert set(side.corners) == {(one, no), (one, one)}
    assert set(side.cut(three(no, one, one / 2)).corners) == {(one, no), (one, one / 2)}
    with pytest.raises(Broken, match="without a point"):
        ExactPolygon.box((one, no), (no, one))


@given(seeds, st.sampled_from(["apart", "one in the other", "a point", "a corner"]))
def test_no_direction_from_far_enough_is_left_out(seed, shape):
    rng = np.random.default_rng(seed)
    cell, _ = cut_by(rng, 2, np.zeros(2))
    if cell is None:
        return
    apart = unit(rng.uniform(-np.pi, np.pi)) * (3 if shape == "apart" else 0.4)
    places, _ = cut_by(rng, 2, apart)
    if shape in ("a point", "a corner") or places is None:
        places = ExactPolygon.around([cell.corners[0] if shape == "a corner" else exactly(apart)])
    nearest = Fraction(float(rng.choice([0.0, 0.5, 2.0])))
    arc = directions(cell, places, nearest)
    weights = rng.dirichlet(np.full(len(cell.floats), 0.3), 200), rng.dirichlet(np.full(len(places.floats), 0.3), 200)
    between = weights[1] @ np.array(places.floats) - weights[0] @ np.array(cell.floats)
    away = np.hypot(*between.T)
    seen = between[(away >= float(nearest)) & (away > 1e-9)]
    for angle in np.arctan2(seen[:, 1], seen[:, 0]).tolist():
        assert arc is ANYWHERE or arc.covers(
            Arc.between(Fraction(angle), Fraction(angle)).widened(Fraction(0), Fraction(-1, 10**12))
        )


@given(st.floats(-3.2, 3.2), st.floats(0, 1))
def test_half_a_circle_is_what_is_behind_its_normal(angle, share):
    normal, arc = half_circle_about(angle)
    ends = enclosed(arc.low), enclosed(arc.high)
    for (x, _), (y, _) in ends:
        assert float(normal[0] * x + normal[1] * y) / 2**CHOSEN == pytest.approx(0, abs=1e-12)
    assert float(once_around(Arc.between(arc.low - 9, arc.high + 9)).high - arc.high) == pytest.approx(np.pi / 2, abs=1e-9)
    beyond = Arc.between(arc.high + Fraction(share) + Fraction(1, 100), arc.high + Fraction(share) + Fraction(2, 100))
    assert are_apart(arc, beyond)
    assert not are_apart(arc, Arc.between(arc.high, arc.high))
