"""Lemmas 7.1 to 7.4 of the paper and its claims around them, on random polygons and polytopes, degenerate ones on purpose."""

import numpy as np
import pytest
import shapely
from helpers.worlds import random_program, unit

from experiments.paper.search_curves import corners_of, regular_polygon, trace_of_polygon
from filter.geometry.polygon import Polygon
from filter.linear.solvers import SIMPLEX, deepest_point, workspace
from filter.projection.proved import position
from filter.projection.search import project
from filter.projection.stop import Stop

# Areas are right to this share of the region's.
ROUNDING = 1e-9
SEEDS = range(6)
TO_THE_END = Stop(performance_ratio=1 - 1e-9, searches=500)


def random_vertices(rng, kind):
    """Return (k, 2) points of which the hull is of one kind."""
    along = unit(rng.uniform(-np.pi, np.pi))
    turn = np.array([along, [-along[1], along[0]]])
    if kind == "any":
        points = rng.normal(size=(rng.integers(3, 40), 2)) * 10.0 ** rng.uniform(-3, 3)
    elif kind == "thin":
        points = rng.uniform(-1, 1, (rng.integers(4, 20), 2)) * [1.0, 10.0 ** rng.uniform(-4, -1)]
    elif kind == "round":
        points = unit(np.sort(rng.uniform(-np.pi, np.pi, 80))) * [1.0, rng.uniform(0.1, 1)]
    elif kind == "parallel edges":
        half = rng.normal(size=(rng.integers(2, 10), 2))
        points = np.concatenate([half, -half])
    elif kind == "rectangle":
        return np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]) * rng.uniform(0.1, 10, 2)  # edges along the first directions
    else:  # the line between the first two points is an edge: only three vertices are found at first (Fig. 7)
        points = np.array([[-1, 0], [1, 0], *np.column_stack([rng.uniform(-0.9, 0.9, 9), -rng.uniform(0.1, 3, 9)])])
        return points * 10.0 ** rng.uniform(-2, 2)
    return points @ turn.T


KINDS = ["any", "thin", "round", "parallel edges", "rectangle", "three vertices"]


@pytest.fixture(params=[(kind, seed) for kind in KINDS for seed in SEEDS], ids=lambda param: f"{param[0]}-{param[1]}")
def polygon(request):
    kind, seed = request.param
    return Polygon.hull(random_vertices(np.random.default_rng(seed), kind))


def searched(polygon, searches, ratio=1.0):
    return trace_of_polygon(polygon, Stop(performance_ratio=ratio, searches=searches))


def supports(polygon, found, count):
    """Return the first searches' points and lines, from the polygon's vertices alone."""
    directions = found.directions[:count]
    return polygon.vertices[(directions @ polygon.vertices.T).argmax(axis=1)], directions


def inside_and_outside(polygon, found, count):
    """Return the hull of the points, and the intersection of the half-planes, as shapely sees them."""
    points, directions = supports(polygon, found, count)
    size = 100 * np.abs(polygon.vertices).max()
    outside = shapely.box(-size, -size, size, size)
    for point, direction in zip(points, directions, strict=True):
        left = np.array([-direction[1], direction[0]])
        ends = [point + 10 * size * left, point - 10 * size * left]
        outside &= shapely.Polygon([*ends, ends[1] - 20 * size * direction, ends[0] - 20 * size * direction])
    return shapely.MultiPoint(points).convex_hull, outside


def test_7_1_the_ratio_is_a_half_after_four_searches(polygon):
    found = searched(polygon, 4)
    assert found.searches == 4
    assert found.outer_areas[3] == pytest.approx(2 * found.inner_areas[3], rel=ROUNDING)
    gap = found.outer_areas[3] - found.inner_areas[3]
    assert gap <= polygon.area * (1 + ROUNDING)  # eq. 8


@pytest.mark.parametrize("seed", SEEDS)
def test_7_1_holds_when_only_three_vertices_are_found(seed):
    triangle = Polygon.hull(random_vertices(np.random.default_rng(seed), "three vertices"))
    found = searched(triangle, 4)
    points, _ = supports(triangle, found, 4)
    assert len(np.unique(points, axis=0)) == 3
    assert found.outer_areas[3] == pytest.approx(2 * found.inner_areas[3], rel=ROUNDING)


def test_the_areas_of_a_search_are_those_of_its_half_planes_and_points(polygon):
    found = searched(polygon, 9)
    for count in range(4, found.searches + 1):
        inside, outside = inside_and_outside(polygon, found, count)
        assert found.inner_areas[count - 1] == pytest.approx(inside.area, rel=1e-6)
        assert found.outer_areas[count - 1] == pytest.approx(outside.area, rel=1e-6)


def test_7_2_every_vertex_is_found_in_twice_as_many_searches(polygon):
    found = trace_of_polygon(polygon, TO_THE_END)
    assert found.searches <= max(4, 2 * len(polygon.vertices))
    assert found.inner_areas[-1] >= polygon.area * (1 - 2e-9)


@pytest.mark.parametrize("seed", range(4))
def test_7_2_holds_for_projections_by_a_solver_of_vertices(seed):
    program = random_program(np.random.default_rng(seed), robots=3, rows=30)
    interior = deepest_point(program, SIMPLEX).point
    found = project(program, workspace(program, SIMPLEX), position(0, 3), interior, stop=TO_THE_END)
    assert found.searches <= 2 * len(corners_of(found))
    assert found.performance_ratio > 1 - 1e-8


def triangle_towards(polygon, found, count):
    """Return the triangle between the two supports next to the direction of search number `count`, counted from 0."""
    points, directions = supports(polygon, found, count)
    turns = np.arctan2(directions[:, 1], directions[:, 0]) - np.arctan2(*found.directions[count][::-1])
    before, after = (np.mod(-turns, 2 * np.pi)).argmin(), np.mod(turns, 2 * np.pi).argmin()
    lines = directions[[before, after]]
    apex = np.linalg.solve(lines, (lines * points[[before, after]]).sum(axis=1))
    return shapely.Polygon([points[before], apex, points[after]])


def test_7_3_a_search_leaves_a_quarter_of_its_triangle_at_most(polygon):
    found = searched(polygon, 14)
    for count in range(4, found.searches):
        triangle = triangle_towards(polygon, found, count)
        inside, outside = inside_and_outside(polygon, found, count + 1)
        assert outside.difference(inside).intersection(triangle).area <= triangle.area / 4 + 1e-7 * polygon.area


def test_7_4_the_gap_falls_with_the_square_of_the_searches(polygon):
    found = searched(polygon, 40)
    searches = np.arange(4, found.searches + 1)
    gaps = (found.outer_areas - found.inner_areas)[3:] if found.searches > 4 else np.array([found.inner_areas[3]])
    allowed = polygon.area * (1 + ROUNDING)
    assert (gaps <= 64 * allowed / searches**2).all()  # eq. 11
    assert (gaps <= 16 * allowed / 4.0 ** np.floor(np.log2(searches)) + ROUNDING * allowed).all()  # eq. 10


def test_the_ratios_promised_within_eight_and_twelve_searches_hold(polygon):
    found = searched(polygon, 12)
    ratio = found.inner_areas / np.maximum(found.outer_areas, np.finfo(float).tiny)
    for searches, promised in ((8, 0.85), (12, 0.90)):
        assert ratio[min(searches, found.searches) - 1] >= promised


def test_erratum_a_circle_takes_more_searches_than_promised():
    """0.95 within 15 and 0.99 within 30 is what formations' polygons reach; a circle takes one and two searches more."""
    found = searched(regular_polygon(3600), 32)
    ratio = found.inner_areas / found.outer_areas
    assert 0.947 < ratio[15 - 1] < 0.949
    assert ratio[16 - 1] > 0.95
    assert 0.986 < ratio[30 - 1] < 0.988
    assert ratio[32 - 1] > 0.99


def test_erratum_not_every_vertex_is_twice_outnumbered_by_those_found():
    """The paper's chain says |V| <= |V-| at any time; yet the found vertices are a part of all, so |V-| <= |V|."""
    polygon = regular_polygon(12)
    found = searched(polygon, 5)
    points, _ = supports(polygon, found, 5)
    assert len(np.unique(points, axis=0)) == 5 < len(polygon.vertices)


@pytest.mark.parametrize("end", [[0.0, 0.0], [0.0, 2.0], [3.0, 0.0], [1.0, 1e-7], [-1.0, 2.0]])
def test_erratum_a_point_and_a_segment_take_the_four_first_searches(end):
    """Two searches a vertex are too few for a point: the first four are always made."""
    found = trace_of_polygon(Polygon.hull([[0.0, 0.0], end]), TO_THE_END)
    assert found.searches == 4
    assert found.inner_areas[-1] == pytest.approx(0, abs=1e-12)
    assert found.outer_areas[-1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("solver", ["piqp", SIMPLEX])
def test_the_bounds_hold_for_points_anywhere_on_the_optimal_face(solver):
    """An interior-point solver returns no vertex where an edge is optimal; areas are bounded all the same."""
    for seed in range(6):
        program = random_program(np.random.default_rng(seed), robots=3, rows=24)
        interior = deepest_point(program, solver).point
        work = workspace(program, solver)
        found = project(program, work, position(1, 3), interior, stop=Stop(performance_ratio=1.0, searches=30))
        exact = project(program, work, position(1, 3), interior, stop=TO_THE_END).inner.area
        gaps = (found.outer_areas - found.inner_areas)[3:]
        assert found.inner_areas[3] / found.outer_areas[3] == pytest.approx(0.5, abs=1e-6)
        assert (gaps <= 64 * exact * (1 + 1e-6) / np.arange(4, found.searches + 1) ** 2).all()
