"""Prediction is a Minkowski sum: everything that a motion can make of a team is within, and in the plane nothing else."""

import numpy as np
import pytest
import shapely
from helpers.worlds import NO_ROWS, World, claims_of, exact_slack, unit
from hypothesis import given
from hypothesis import strategies as st

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.geometry.sector import trapezoid
from filter.guarantee import Guarantee
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.solvers import deepest_point
from filter.linear.sources import Sources
from filter.sensing.motion import CORNERS, Displacements
from filter.sets.belief import Belief
from filter.sets.predict import moved

FAR, WIDE = 1e3, 50.0  # no displacement is so long; no set of these is so far away [m]
EVERYWHERE = np.array([[-np.inf] * 2, [np.inf] * 2])

seeds = st.integers(0, 2**32 - 1)


def believed(robots, rows, whose):
    """Return a belief of these rows, in which something was proved of some robots or pairs."""
    polytope = Polytope(rows, np.full((robots, 2), -WIDE), np.full((robots, 2), WIDE))
    i, j = np.array(whose).T
    nothing = np.zeros((len(i), 0), dtype=np.int64), np.zeros((len(i), 0))
    proof = claims_of(polytope, (i, j), (np.zeros((len(i), 2)), np.zeros(len(i))), nothing)
    sources, _ = Sources().extended("region", 0.0, np.arange(robots))
    return Belief(0.0, polytope, AngularIntervals.circles(robots), sources, Guarantee.full(robots), proofs=(proof,))


def rows_around(i, j, polygon):
    count = len(polygon.offsets)
    return Constraints(np.full(count, i), np.full(count, j), polygon.normals, polygon.offsets, np.zeros(count, dtype=int))


def some_polygon(rng, kind):
    """Return a polygon, which may have an edge or a corner as the displacements have."""
    if kind == "square":
        return Polygon.box(-rng.uniform(1, 2, 2), rng.uniform(1, 2, 2))
    if kind == "fan":  # a sector seen from the origin
        return Polygon.from_vertices(trapezoid(rng.uniform(-4, 4), 0.3, 1.0, 2.0))
    return Polygon.from_vertices(rng.normal(size=(rng.integers(3, 12), 2)))


def some_moves(rng, robots, kind):
    """Return displacements in a trapezoid ahead, or in any hull, in a segment or in a point; without slip."""
    vertices = rng.normal(size=(robots, CORNERS, 2))
    for robot in range(robots):
        if kind == "ahead":
            sector = trapezoid(rng.uniform(-4, 4), rng.uniform(0.01, 1), *np.sort(rng.uniform(0, 2, 2)))
            vertices[robot] = np.tile(sector, (2, 1))
        if kind == "segment":
            vertices[robot] = np.linspace(-1, 1, CORNERS)[:, None] * unit(rng.uniform(-4, 4))
        if kind == "point":
            vertices[robot] = vertices[robot, 0]
    return Displacements(vertices, np.full(robots, FAR), np.zeros(robots))


def sum_of(*sets):
    """Return the hull of the sums of points, one of each set."""
    total = sets[0]
    for other in sets[1:]:
        total = (total[:, None] + other[None]).reshape(-1, 2)
    return total, shapely.MultiPoint(total).convex_hull


@given(seeds, st.sampled_from(["any", "square", "fan"]), st.sampled_from(["ahead", "any", "segment", "point"]))
def test_a_robots_polygon_is_the_sum_of_what_it_was_and_of_the_motion(seed, shape, motion):
    rng = np.random.default_rng(seed)
    polygon, moves = some_polygon(rng, shape), some_moves(rng, 1, motion)
    after, _ = moved(believed(1, rows_around(WORLD, 0, polygon), [(WORLD, 0)]), 1.0, moves, EVERYWHERE, corners=True)
    found = after.of_robots(np.array([0])).polygons[0]
    points, hull = sum_of(polygon.vertices, moves.vertices[0])
    assert (points @ found.normals.T - found.offsets).max() <= 1e-12
    assert found.area == pytest.approx(hull.area, rel=1e-9)


@given(seeds, st.sampled_from(["any", "square"]), st.sampled_from(["ahead", "any", "segment", "point"]))
def test_a_pairs_polygon_is_the_sum_of_what_it_was_and_of_both_motions(seed, shape, motion):
    """x_j - x_i grows by what j moves, and by what i moves turned about."""
    rng = np.random.default_rng(seed)
    polygon, moves = some_polygon(rng, shape), some_moves(rng, 3, motion)
    after, _ = moved(believed(3, rows_around(0, 2, polygon), [(0, 2)]), 1.0, moves, EVERYWHERE, corners=True)
    found = after.of(np.array([0]), np.array([2])).polygons[0]
    points, hull = sum_of(polygon.vertices, moves.vertices[2], -moves.vertices[0])
    assert (points @ found.normals.T - found.offsets).max() <= 1e-12
    assert found.area == pytest.approx(hull.area, rel=1e-9)


@pytest.mark.parametrize("shape", ["square", "any"])
def test_without_rows_through_the_corners_it_would_be_larger(shape):
    rng = np.random.default_rng(1)
    polygon, moves = some_polygon(rng, shape), some_moves(rng, 1, "ahead")
    rows = rows_around(WORLD, 0, polygon)
    after, _ = moved(believed(1, rows, [(WORLD, 0)]), 1.0, moves, EVERYWHERE, corners=True)
    mitred, _ = moved(believed(1, rows, [(WORLD, 0)]), 1.0, moves, EVERYWHERE, corners=False)
    assert mitred.constraints.offset.tolist() == moves.moved(rows).offset.tolist()
    areas = [each.of_robots(np.array([0])).polygons.areas[0] for each in (after, mitred)]
    assert areas[0] < 0.999 * areas[1]


def test_where_nothing_was_proved_rows_are_moved_and_no_more_are_made():
    rng = np.random.default_rng(2)
    rows, moves = rows_around(WORLD, 0, some_polygon(rng, "any")), some_moves(rng, 2, "ahead")
    belief = believed(2, rows, [(WORLD, 1)])
    after, _ = moved(belief, 1.0, moves, EVERYWHERE, corners=True)
    own = after.constraints.rows_of(WORLD, 0)
    assert len(own) == len(rows)
    assert after.constraints.offset[own].tolist() == moves.moved(rows).offset.tolist()
    nobody = Belief(0.0, belief.polytope, belief.headings, belief.sources, belief.guarantee)
    assert len(moved(nobody, 1.0, moves, EVERYWHERE, corners=True)[0].constraints) == len(rows)
    free = believed(2, NO_ROWS, [(WORLD, 0), (WORLD, 1), (0, 1)])
    assert (moved(free, 1.0, moves, EVERYWHERE, corners=True)[0].constraints.offset > WIDE / 2).all()


@pytest.mark.parametrize("seed", range(6))
def test_no_configuration_is_lost_whatever_the_motion(seed):
    """Of a team that the filter has projected: possible points, each moved by any displacement of each robot."""
    rng = np.random.default_rng(seed)
    world = World(rng, robots=3, errors="extreme" if seed % 2 else "uniform")
    estimator = SetMembershipFilter(world.team)
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    moves = some_moves(rng, 3, ("ahead", "any", "segment")[seed % 3])
    moves = Displacements(moves.vertices, moves.reach, rng.uniform(0, 0.3, 3))
    after, _ = moved(belief, 1.0, moves, EVERYWHERE, corners=True)
    rows, i, j = after.constraints, after.constraints.i, after.constraints.j
    assert len(rows) > len(belief.constraints)
    program = belief.polytope.program()
    near = world.positions.ravel() + rng.normal(size=(400, 6)) * 10.0 ** rng.uniform(-3, 0, (400, 1))
    possible = program.pulled(near, deepest_point(program, "piqp").point)
    assert program.holds(possible).all()
    for positions in possible.reshape(400, 3, 2):
        slipped = moves.slip[:, None] * unit(rng.uniform(-np.pi, np.pi, 3))
        there = positions + moves.vertices[np.arange(3), rng.integers(0, CORNERS, 3)] + slipped
        said = (rows.normal * (there[j] - np.where((i == WORLD)[:, None], 0.0, there[i]))).sum(axis=1)
        assert (said <= rows.offset + 1e-12).all()
        assert (after.lower <= there).all()
        assert (there <= after.upper).all()


@given(seeds)
def test_a_point_that_goes_from_corner_to_corner_is_within_without_any_rounding(seed):
    """Coordinates are eighths, so that sums of them are exact."""
    rng = np.random.default_rng(seed)
    corners, steps = rng.integers(-16, 17, (6, 2)) / 8, rng.integers(-16, 17, (1, CORNERS, 2)) / 8
    moves = Displacements(steps, np.full(1, FAR), np.zeros(1))
    polygon = Polygon.from_vertices(corners)
    after, _ = moved(believed(1, rows_around(WORLD, 0, polygon), [(WORLD, 0)]), 1.0, moves, EVERYWHERE, corners=True)
    points, _ = sum_of(corners, steps[0])
    for normal, offset in zip(after.constraints.normal, after.constraints.offset, strict=True):
        farthest = points[np.argsort(points @ normal)[-3:]]
        assert all(exact_slack(normal, offset, point) >= 0 for point in farthest)
