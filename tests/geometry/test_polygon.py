"""Polygons err outward, and never lose a point."""

import numpy as np
import pytest
import shapely
from helpers.worlds import exact_slack, offset_through, outside_hull, unit
from hypothesis import given, settings
from hypothesis import strategies as st

from filter.errors import InvalidInput
from filter.geometry.angles import wrap
from filter.geometry.convex import area_of, hull_of
from filter.geometry.many import Polygons
from filter.geometry.polygon import SIDES, Polygon, clip

# Areas and lengths of two ways to compute a polygon differ by no more than this [m, m2].
SAME = 1e-9

coordinates = st.one_of(st.floats(-10, 10), st.sampled_from([0.0, 1.0, -1.0, 1e-9, 1e-16]))
points = st.tuples(coordinates, coordinates)
seeds = st.integers(0, 2**32 - 1)


def half_planes(rng, count, degenerate):
    """Return half-planes in a box from -1 to 1; where degenerate, some are parallel, twice there, or through one point."""
    angles = rng.uniform(-np.pi, np.pi, count)
    offsets = rng.uniform(-0.3, 1.2, count)
    if degenerate:
        angles = rng.choice([0.0, np.pi / 2, np.pi, -np.pi / 2, 0.3, 0.3 + np.pi, 0.3 + 1e-12], count)
        offsets = rng.choice([0.0, 0.5, 0.5, -0.0, 1.0, 1e-13], count)
    return unit(angles), offsets


def by_shapely(normals, offsets, lower, upper):
    """Return the same set as a shapely polygon: the box less one great square for each half-plane."""
    kept = shapely.box(*lower, *upper)
    reach = 10 * (1 + np.abs([lower, upper]).max())
    for normal, offset in zip(normals, offsets, strict=True):
        across = np.array([-normal[1], normal[0]])
        foot = offset * normal
        corners = [
            foot - reach * across,
            foot + reach * across,
            foot + reach * (across + normal),
            foot + reach * (normal - across),
        ]
        kept = kept.difference(shapely.Polygon(corners))
    return kept


@pytest.mark.parametrize("degenerate", [False, True])
@pytest.mark.parametrize("seed", range(60))
def test_a_clipped_box_is_the_one_that_shapely_cuts(seed, degenerate):
    rng = np.random.default_rng(seed)
    lower, upper = -rng.uniform(0.5, 1, 2), rng.uniform(0.5, 1, 2)
    normals, offsets = half_planes(rng, rng.integers(1, 12), degenerate)
    kept, oracle = clip(normals, offsets, lower, upper), by_shapely(normals, offsets, lower, upper)
    assert (kept[0].area if kept else 0.0) == pytest.approx(oracle.area, abs=SAME)
    if kept is None:
        assert oracle.area < SAME
    elif oracle.area > SAME:
        assert shapely.Polygon(kept[0].vertices).hausdorff_distance(oracle) < 1e-6


@given(seeds, st.booleans())
def test_edges_name_the_half_planes_that_they_lie_on(seed, degenerate):
    rng = np.random.default_rng(seed)
    normals, offsets = half_planes(rng, 9, degenerate)
    kept = clip(normals, offsets, np.array([-1.0, -1.0]), np.array([1.0, 1.0]))
    if kept is None:
        return
    polygon, edges = kept
    every_normal, every_offset = np.concatenate([normals, SIDES]), np.append(offsets, np.ones(4))
    for k, edge in enumerate(edges):
        normal, offset = every_normal[edge], every_offset[edge]
        assert polygon.normals[k].tolist() == normal.tolist()
        assert polygon.offsets[k] == offset
        ends = polygon.vertices[[k, (k + 1) % len(edges)]]
        assert ends @ normal == pytest.approx(offset, abs=SAME)


def nearly_through(rng, point, count, spread):
    """Return half-planes within rounding of a point, which satisfies each of them exactly."""
    normals = unit(rng.uniform(-spread, spread, count) + rng.choice([0.0, np.pi], count))
    return normals, np.array([offset_through(normal, point) for normal in normals])


@given(
    seeds,
    st.integers(1, 300),
    st.sampled_from([np.pi, 1e-2, 1e-6, 1e-12, 0.0]),
    st.sampled_from([0.0, 1.0, 5e6]),
    st.booleans(),
)
def test_a_point_that_satisfies_everything_is_never_lost(seed, count, spread, far, at_corner):
    rng = np.random.default_rng(seed)
    point = far + rng.uniform(-1, 1, 2)
    normals, offsets = nearly_through(rng, point, count, spread)
    lower, upper = point - rng.uniform(0, 1, 2), point + rng.uniform(0, 1, 2)
    if at_corner:
        lower = upper = point
    kept = clip(normals, offsets, lower, upper)
    assert kept is not None
    polygon, _ = kept
    assert all(exact_slack(n, o, point) >= 0 for n, o in zip(polygon.normals, polygon.offsets, strict=True))
    assert not outside_hull(polygon, point)


@given(seeds, st.integers(20, 400))
@settings(max_examples=60)
def test_a_sliver_cut_many_times_at_its_tip_keeps_its_tip(seed, count):
    """Each cut takes a little of the tip of a thin wedge; what lies before the last cut stays."""
    rng = np.random.default_rng(seed)
    thin = 10.0 ** rng.uniform(-14, -3)
    wedge = np.array([[np.sin(thin), np.cos(thin)], [np.sin(thin), -np.cos(thin)]])
    reach = np.sort(rng.uniform(0.5, 0.9, count))[::-1]
    cuts = unit(rng.uniform(-0.4, 0.4, count))
    normals, offsets = np.concatenate([wedge, cuts]), np.concatenate([np.zeros(2) + np.sin(thin), reach])
    point = np.array([0.45, 0.0])
    offsets[2:] = [max(offset, offset_through(normal, point)) for normal, offset in zip(cuts, reach, strict=True)]
    kept = clip(normals, offsets, np.array([-1.0, -1.0]), np.array([1.0, 1.0]))
    assert kept is not None
    assert not outside_hull(kept[0], point)


@pytest.mark.parametrize("seed", range(3))
def test_half_planes_of_any_length_lose_no_point(seed):
    """Edges through a point and the origin: however long their normals are, offsets do not tell."""
    rng = np.random.default_rng(seed)
    point = rng.uniform(-1, 1, 2)
    across = np.array([-point[1], point[0]]) / np.hypot(*point)
    normals = rng.choice([-1, 1], (40, 1)) * 10.0 ** rng.uniform(-3, 8, (40, 1)) * across
    offsets = np.array([offset_through(normal, point) for normal in normals])
    polygon = Polygon.from_half_planes(normals, offsets, [-1, -1], [1, 1])
    assert not outside_hull(polygon, point)


@given(seeds, st.booleans())
def test_what_is_proved_empty_has_no_point(seed, degenerate):
    rng = np.random.default_rng(seed)
    normals, offsets = half_planes(rng, 12, degenerate)
    offsets = offsets - 0.4
    if clip(normals, offsets, np.array([-1.0, -1.0]), np.array([1.0, 1.0])) is None:
        candidates = np.vstack([rng.uniform(-1, 1, (200, 2)), offsets[:, None] * normals])
        assert not (candidates @ normals.T <= offsets - 1e-12).all(axis=1).any()


def test_duplicate_and_parallel_half_planes_leave_one_edge():
    normals = np.array([[1.0, 0.0]] * 3 + [[-1.0, 0.0]] * 2)
    polygon, edges = clip(normals, np.array([0.5, 0.5, 0.7, -0.5, 0.2]), np.array([-1.0, -1.0]), np.array([1.0, 1.0]))
    assert polygon.area == pytest.approx(0, abs=SAME)
    assert sorted(edges) in ([0, 3, 6, 8], [1, 3, 6, 8])  # and the top and bottom of the box


def test_a_half_plane_beyond_the_box_cuts_nothing():
    polygon, edges = clip(np.array([[0.6, 0.8]]), np.array([7.0]), np.zeros(2), np.ones(2))
    assert edges.tolist() == [1, 2, 3, 4]
    assert polygon.area == 1.0


def test_half_planes_apart_leave_nothing():
    assert clip(np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([-0.1, -0.1]), -np.ones(2), np.ones(2)) is None
    with pytest.raises(InvalidInput, match="a point of the box in common"):
        Polygon.from_half_planes([[1.0, 0.0], [-1.0, 0.0]], [-0.1, -0.1], [-1, -1], [1, 1])


@pytest.mark.parametrize("lower, upper", [([1, 0], [0, 1]), ([0, 0], [1]), ([np.nan, 0], [1, 1]), ([0, 0], [np.inf, 1])])
def test_a_box_without_a_point_is_refused(lower, upper):
    with pytest.raises(InvalidInput, match=r"lower corner|upper corner"):
        Polygon.box(lower, upper)


def test_a_box_may_be_a_point():
    box = Polygon.box([2, 3], [2, 3])
    assert box.area == 0
    assert box.contains([2.0, 3.0])
    assert box.centroid.tolist() == [2, 3]


@given(st.lists(points, min_size=1, max_size=30))
def test_the_half_planes_of_a_hull_hold_every_point_exactly(given_points):
    hull = Polygon.from_vertices(given_points)
    for point in given_points:
        assert all(exact_slack(n, o, point) >= 0 for n, o in zip(hull.normals, hull.offsets, strict=True))


@pytest.mark.parametrize("far", [0.0, 5e6])
@pytest.mark.parametrize("bend", [0.0, 1e-17, 1e-15, 1e-12])
def test_a_hull_of_many_points_on_one_line_holds_them_all(bend, far):
    rng = np.random.default_rng(0)
    along = np.sort(rng.uniform(-1, 1, 2000))
    line = far + np.stack([along, 0.3 * along + bend * along**2], axis=1)
    hull = Polygon.from_vertices(line)
    for normal, offset in zip(hull.normals, hull.offsets, strict=True):
        worst = line[np.argsort(-(line @ normal))[:20]]
        assert all(exact_slack(normal, offset, point) >= 0 for point in worst)


@given(st.lists(st.tuples(st.integers(-9, 9), st.integers(-9, 9)), min_size=3, max_size=30))
def test_a_hull_is_the_one_of_shapely(given_points):
    expected = shapely.MultiPoint(given_points).convex_hull.area
    assert Polygon.from_vertices(given_points).area == pytest.approx(expected, abs=SAME)


@pytest.mark.parametrize("ends", [[[1.0, 2.0]], [[0.0, 0.0], [1.0, 2.0]], [[3.0, 1.0], [3.0, 1.0], [3.0, -1.0]]])
def test_points_and_segments_are_polygons(ends):
    hull = Polygon.from_vertices(ends)
    assert Polygon.hull(ends).area == 0
    assert hull.area == pytest.approx(0, abs=SAME)
    assert hull.contains(ends).all()
    assert hull.centroid == pytest.approx((np.min(ends, axis=0) + np.max(ends, axis=0)) / 2)
    around = np.mean(ends, axis=0) + 5 * unit(np.linspace(-np.pi, np.pi, 25))
    assert not hull.contains(around).any()


@pytest.mark.parametrize("wrong", [[], [[1.0, 2.0, 3.0]], [[np.nan, 0.0]], [1.0, 2.0], np.zeros((0, 2))])
def test_vertices_that_are_none_are_refused(wrong):
    with pytest.raises(InvalidInput, match=r"vertices|at least one point"):
        Polygon.from_vertices(wrong)


def test_edges_and_vertices_go_around_together():
    hull = Polygon.from_vertices(np.random.default_rng(0).normal(size=(40, 2)))
    ends = np.stack([hull.vertices, np.roll(hull.vertices, -1, axis=0)], axis=1)
    assert np.einsum("kem,km->ke", ends, hull.normals) == pytest.approx(np.stack([hull.offsets] * 2, axis=1), abs=SAME)
    turns = np.diff(np.unwrap(np.arctan2(*hull.normals.T[::-1])))
    assert (turns > 0).all()


@given(seeds)
def test_the_centroid_is_the_one_of_shapely(seed):
    hull = Polygon.from_vertices(1e5 + np.random.default_rng(seed).normal(size=(8, 2)))
    centre = shapely.Polygon(hull.vertices - 1e5).centroid
    assert hull.centroid - 1e5 == pytest.approx([centre.x, centre.y], abs=1e-8)


@given(seeds)
def test_a_support_is_an_upper_bound_and_no_more(seed):
    rng = np.random.default_rng(seed)
    hull = Polygon.from_vertices(rng.normal(size=(rng.integers(1, 9), 2)))
    directions = unit(rng.uniform(-np.pi, np.pi, 7))
    support = hull.support(directions)
    for direction, bound in zip(directions, support, strict=True):
        assert all(exact_slack(direction, bound, vertex) >= 0 for vertex in hull.vertices)
    assert support == pytest.approx((directions @ hull.vertices.T).max(axis=1), abs=SAME)


def seen_from_the_origin(polygons):
    still = np.zeros((len(polygons), 2))
    return polygons.spans(np.ones(len(polygons)), still, still, np.zeros(len(polygons)))


@given(seeds, st.sampled_from(["around", "near", "away", "thin"]))
def test_a_span_holds_the_direction_of_every_point(seed, where):
    rng = np.random.default_rng(seed)
    corners = rng.normal(size=(rng.integers(1, 9), 2))
    if where != "around":
        corners += {"near": 2.0, "away": 30.0, "thin": 1.0}[where] * unit(rng.uniform(-np.pi, np.pi))
    if where == "thin":
        corners = corners[:1] * rng.uniform(0.01, 1, (5, 1))
    hull = Polygon.from_vertices(corners)
    spans = seen_from_the_origin(Polygons.of([hull]))
    centre, bound = spans.centre[0], spans.bound[0]
    shares = rng.dirichlet(np.ones(len(hull.vertices)), 40)
    inside = np.vstack([hull.vertices, shares @ hull.vertices])
    off = np.abs(wrap(np.arctan2(inside[:, 1], inside[:, 0]) - centre))
    assert (off <= bound + 4e-15).all()
    if bound < np.pi:  # and it is no wider than it has to be
        assert off.max() >= bound - 1e-9
        assert bound < np.pi / 2 + 1e-9


@pytest.mark.parametrize(
    "polygon", [Polygon.box([-1, -1], [1, 1]), Polygon.box([0, 0], [1, 1]), Polygon.from_vertices([[0, 0]])]
)
def test_nothing_is_known_of_the_direction_from_within(polygon):
    assert seen_from_the_origin(Polygons.of([polygon])).bound[0] == np.pi


def test_spans_across_plus_and_minus_pi_are_narrow():
    spans = seen_from_the_origin(Polygons.of([Polygon.box([-3, -0.1], [-2, 0.1]), Polygon.box([2, -0.1], [3, 0.1])]))
    assert spans.bound == pytest.approx(np.arctan2(0.1, 2), abs=SAME)
    assert spans.contains([np.pi, 0.0]).all()
    assert len(seen_from_the_origin(Polygons.of([]))) == 0


@given(seeds)
def test_an_intersection_is_the_one_of_shapely(seed):
    rng = np.random.default_rng(seed)
    one, other = (Polygon.from_vertices(rng.normal(size=(6, 2))) for _ in range(2))
    common = one.intersection(other)
    expected = shapely.Polygon(one.vertices).intersection(shapely.Polygon(other.vertices)).area
    assert (common.area if common else 0.0) == pytest.approx(expected, abs=SAME)


def test_polygons_apart_have_nothing_in_common():
    assert Polygon.box([0, 0], [1, 1]).intersection(Polygon.box([2, 0], [3, 1])) is None


def test_polygons_that_touch_have_the_touching_point_in_common():
    touching = Polygon.box([0, 0], [1, 1]).intersection(Polygon.box([1, 1], [2, 2]))
    assert touching is not None
    assert touching.contains([1.0, 1.0])


def test_area_and_hull_of_next_to_nothing():
    assert area_of(np.array([[1.0, 2.0]])) == 0
    assert hull_of(np.array([[1.0, 2.0], [1.0, 2.0]])).tolist() == [[1.0, 2.0]]
    assert len(hull_of(np.array([[0.0, 0.0], [1.0, 0.0], [2.0, 0.0], [1.0, 1.0]]))) == 3


def test_a_polygon_cannot_be_changed():
    box = Polygon.box([0, 0], [1, 1])
    for array in (box.normals, box.offsets, box.vertices):
        with pytest.raises(ValueError, match="read-only"):
            array[0] = 9
