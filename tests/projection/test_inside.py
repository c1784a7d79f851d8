"""Inner polygons: every point of them is possible, without any rounding, and little is left out."""

import numpy as np
import pytest
from helpers.programs import every_pair, everybody, is_possible, merged_team, on_robot, random_polytope, single
from helpers.worlds import unit
from scipy.optimize import linprog

from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.inside import LEAST_RATIO, MOST_CORNERS, slack_at
from filter.projection.stop import Stop


def star(rng, middle, robots=4, rows=8, at=0.0):
    """Return a team in which all pairs with rows have one robot in common."""
    polytope = random_polytope(rng, robots, 0, at=at)
    inside, parts = (polytope.lower + polytope.upper) / 2, []
    for robot in range(robots):
        normal, none = unit(rng.uniform(-np.pi, np.pi, rows)), np.zeros(rows, dtype=int)
        own, seen = normal @ inside[robot], normal @ (inside[robot] - inside[middle])
        if robot == middle:
            parts.append(on_robot(robot, normal, own + rng.uniform(0, 0.3, rows), none))
        else:
            from_middle = np.full(rows, middle), np.full(rows, robot)
            parts.append(Constraints.between(*from_middle, normal, seen + rng.uniform(0, 0.3, rows), none))
    return Polytope(Constraints.concatenate(parts), polytope.lower, polytope.upper)


def inside(polytope, stop=None):
    return everybody(stop or Stop()).robots(polytope).outlines


@pytest.mark.parametrize("at", [0.0, 1e3, 5e6])
@pytest.mark.parametrize("seed", range(5))
def test_every_corner_is_possible_in_exact_arithmetic(seed, at):
    middle = seed % 4
    polytope = star(np.random.default_rng(seed), middle, at=at)
    outlines = inside(polytope)
    assert outlines.inner.known.all()
    corners = outlines.inner[middle].vertices
    assert all(is_possible(polytope, middle, corner) for corner in corners)
    beyond = corners + 1e-2 * (corners - outlines.inner[middle].centroid)
    assert not any(is_possible(polytope, middle, corner) for corner in beyond)


@pytest.mark.parametrize("seed", range(3))
def test_the_others_have_a_place_for_every_corner(seed):
    polytope = merged_team(seed)
    outlines, program = inside(polytope), polytope.program()
    for robot in range(5):
        for corner in outlines.inner[robot].vertices:
            bounds = np.stack([program.lower, program.upper], axis=1)
            bounds[2 * robot : 2 * robot + 2] = np.stack([corner, corner], axis=1)
            found = linprog(np.zeros(10), program.A.toarray(), program.b + 1e-12, bounds=bounds, method="highs")
            assert found.status == 0


@pytest.mark.parametrize("seed", range(10))
def test_it_is_within_the_outer_one_and_fills_it(seed):
    outlines = inside(random_polytope(np.random.default_rng(seed), 4, 50), Stop(1.0, searches=400))
    for robot, outer in enumerate(outlines.outer):
        inner = outlines.inner[robot]
        assert outer.contains(inner.vertices).all()
        assert len(inner.vertices) <= MOST_CORNERS
        assert LEAST_RATIO - 1e-6 <= inner.area / outer.area <= 1


def test_corners_at_a_great_price_are_spared():
    polytope = single(unit(2 * np.pi * np.arange(300) / 300), np.ones(300), [-2, -2], [2, 2])
    inner = inside(polytope).inner[0]
    assert len(inner.vertices) <= MOST_CORNERS
    assert inner.area > 0.99 * np.pi


@pytest.mark.parametrize(
    ("rows", "b", "upper", "area"),
    [
        ([], [], [1, 1], 1.0),
        ([], [], [0, 0], 0.0),  # an anchored robot
        ([], [], [1, 0], 0.0),
        ([[1, 0]], [0], [1, 1], 0.0),  # the row's own rounding is none: a segment is possible
        ([[0.6, -0.8], [-0.6, 0.8]], [0.1 + 1e-12, -0.1 + 1e-12], [1, 1], 0.0),
    ],
)
def test_of_sets_without_an_interior_what_is_sure_is_inside(rows, b, upper, area):
    polytope = single(rows, b, [0, 0], upper)
    inner = inside(polytope).inner[0]
    assert inner.area == pytest.approx(area, abs=1e-9)
    assert all(is_possible(polytope, 0, corner) for corner in inner.vertices)


def test_on_a_line_nothing_is_possible_for_sure():
    """Rounding leaves no point of which every row holds for sure: better none than a doubtful one."""
    polytope = single([[0.6, -0.8], [-0.6, 0.8]], [0.1, -0.1], [0, 0], [1, 1])
    assert not inside(polytope).inner.known.any()


def test_the_slack_is_right_where_there_is_no_rounding():
    rows = Constraints(
        np.array([WORLD, WORLD, 0]), np.array([0, 0, 1]), unit(np.array([0.0, 1.0, 2.0])), np.ones(3), np.zeros(3, dtype=int)
    )
    place, point = np.arange(2), np.array([1.0, 0.0, 0.1, 0.2])
    assert slack_at(point, 0, place, rows.rows)[0] == pytest.approx(0, abs=1e-16)
    exact = on_robot(0, np.array([[-1.0, 0.0]]), np.array([-1.0]), np.zeros(1, dtype=int))
    assert slack_at(point, 0, place, exact.rows) == (0.0, 0.0)
    for row, wanted in ((1, 1 - np.cos(1)), (2, 1 - np.cos(2) * (0.1 - 1) - np.sin(2) * 0.2)):
        slack, doubt = slack_at(point, row, place, rows.rows)
        assert abs(slack - wanted) <= doubt
        assert 0 < doubt < 1e-14


def test_pairs_have_no_inner_polygon():
    outlines = everybody(Stop()).pairs(merged_team(0), every_pair(5)).outlines
    assert not outlines.inner.known.any()
