"""Projections are bracketed: the inner polygon is possible, the outer one proved."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.programs import box_program, exact_bound, searched, support
from helpers.worlds import exact_slack, feasible, outside_hull, random_program, unit
from scipy.optimize import linprog

from filter.geometry.polygon import Polygon
from filter.linear.program import Candidate
from filter.projection.proved import (
    NOTHING,
    certified_offsets,
    inner_polygon,
    looseness,
    outer_polygon,
    performance_ratio,
    position,
)
from filter.projection.search import project
from filter.projection.stop import Stop


class Fake:
    """A solver that does whatever it likes."""

    def __init__(self, answer):
        self.answer = answer

    def maximize(self, objective):
        return self.answer()


@pytest.mark.parametrize("seed", range(8))
def test_inner_vertices_are_possible_and_outer_edges_are_proved_in_exact_arithmetic(seed):
    rng = np.random.default_rng(seed)
    program = random_program(rng, robots=2, rows=10)
    found = searched(program, position(0, 2), stop=Stop(searches=8))
    assert (found.edges < found.searches).sum() >= 4
    for normal, offset, edge in zip(found.outer.normals, found.outer.offsets, found.edges.tolist(), strict=True):
        if edge < found.searches:
            assert normal.tolist() == found.directions[edge].tolist()
            assert exact_bound(program, normal @ position(0, 2), *found.weights.rests_on(edge)) <= Fraction(offset)
        else:
            assert np.abs(normal).max() == 1  # a side of the box
    for vertex in found.inner.vertices:
        box = [(vertex[m], vertex[m]) for m in (0, 1)] + list(zip(program.lower[2:], program.upper[2:], strict=True))
        rest = linprog(np.zeros(4), program.A.toarray(), program.b + 1e-12, bounds=box, method="highs")
        assert rest.status == 0  # some place of the other robot goes with it


@pytest.mark.parametrize("far", [0.0, 5e6])
@pytest.mark.parametrize("solver", ["piqp", "highs"])
@pytest.mark.parametrize("shape", ["point", "segment", "slanted segment", "point by rows", "sliver"])
def test_degenerate_polytopes_have_projections(shape, solver, far):
    lower, upper, rows, b, inside = {
        "point": ([1, 2], [1, 2], [], [], [[1, 2]]),
        "segment": ([0, 2], [1, 2], [], [], [[0, 2], [0.5, 2], [1, 2]]),
        "slanted segment": ([0, 0], [1, 1], [[1, -1], [-1, 1]], [0, 0], [[0, 0], [0.5, 0.5], [1, 1]]),
        "point by rows": ([0, 0], [1, 1], [[1, 1]], [0], [[0, 0]]),
        "sliver": ([0, 0], [1, 1], [[1, -1], [-1, 1]], [1e-9, 1e-9], [[0, 0], [0.5, 0.5], [1, 1]]),
    }[shape]
    lower, upper, inside = far + np.array(lower), far + np.array(upper), far + np.array(inside)
    b = np.array(b, dtype=float) + (2 * far if shape == "point by rows" else 0.0)
    program = box_program(lower, upper, rows, b)
    found = searched(program, position(0, 1), solver, Stop())
    for point in inside:
        assert feasible(program, point)
        assert all(exact_slack(n, o, point) >= 0 for n, o in zip(found.outer.normals, found.outer.offsets, strict=True))
        assert not outside_hull(found.outer, point)
    assert found.outer.area < 1e-5


def test_without_an_interior_nothing_is_possible_for_sure():
    """On a line, rounding leaves no point of which every row holds for sure: better none than a doubtful one."""
    program = box_program([0, 0], [1, 1], [[0.6, -0.8], [-0.6, 0.8]], [0.1, -0.1])
    assert searched(program, position(0, 1), "highs", Stop()).inner is None


@pytest.mark.parametrize("far", [1.0, 1e8])
def test_any_matrix_is_projected_soundly_where_its_products_cancel(far):
    """The configuration is one point far away, D mixes its coordinates: the outer polygon has to contain its exact image."""
    for seed in range(60):
        rng = np.random.default_rng(seed)
        point = far * rng.uniform(0.5, 1, 6)
        program = box_program(point, point)
        D = rng.normal(size=(2, 6))
        D[:, 3:] = -D[:, :3] * (1 + 1e-9 * rng.normal(size=(2, 3)))
        shown = iter(rng.normal(size=(100, 6)))
        fake = Fake(lambda *_, shown=shown: Candidate(next(shown), np.zeros(0)))
        found = project(program, fake, D, point, stop=Stop(performance_ratio=1.0))
        image = [sum(Fraction(float(a)) * Fraction(float(x)) for a, x in zip(row, point, strict=True)) for row in D]
        for normal, offset in zip(found.outer.normals, found.outer.offsets, strict=True):
            assert Fraction(float(normal[0])) * image[0] + Fraction(float(normal[1])) * image[1] <= Fraction(float(offset))


def test_a_position_is_two_coordinates():
    x = np.arange(6.0)
    assert (position(1, 3) @ x).tolist() == [2, 3]


def test_ratios_without_area():
    point, box = Polygon.from_vertices([[0, 0]]), Polygon.box([0, 0], [1, 1])
    assert performance_ratio(None, box) == 0
    assert performance_ratio(point, point) == 1
    assert performance_ratio(point, box) == 0
    assert performance_ratio(box, box) == 1


def test_offsets_from_whatever_multipliers_are_never_too_small():
    rng = np.random.default_rng(3)
    program, D, directions = random_program(rng, 2, 12), position(0, 2) - position(1, 2), unit(rng.uniform(-np.pi, np.pi, 20))
    offsets = certified_offsets(program, D, directions, rng.exponential(1, (20, 12)) * 10.0 ** rng.integers(-9, 9, (20, 1)))
    true = np.array([support(program, direction @ D) for direction in directions])
    assert (offsets >= true - 1e-9).all()
    assert np.isinf(certified_offsets(program, D, directions[:1], np.full((1, 12), 1e308)))


def test_the_looseness_is_the_greatest_gap_as_a_share_of_the_box():
    program, D, directions = box_program([0, 0], [4, 2]), np.eye(2), np.array([[1.0, 0.0], [0.0, 1.0]])
    points = np.array([[4.0, 1.0], [0.0, 2.0]])
    assert looseness(program, D, directions, points, np.array([4.0, 2.0])) == 0
    assert looseness(program, D, directions, points, np.array([4.5, 2.0])) == pytest.approx(0.5 / 2)
    assert looseness(program, D, directions, points, np.array([4.0, 2.5])) == pytest.approx(0.5 / 1)
    assert looseness(program, D, directions, points, np.array([np.inf, 2.0])) == np.inf


def test_edges_are_numbered_searches_first_then_what_was_known_then_the_box():
    program = box_program([0, 0], [1, 1])
    edges, known = (np.array([[1.0, 0.0]]), np.array([0.5])), (np.array([[0.0, 1.0]]), np.array([0.25]))
    polygon, behind = outer_polygon(program, np.eye(2), edges, known)
    assert polygon.bounds[1] == pytest.approx([0.5, 0.25])
    assert sorted(behind.tolist()) == [0, 1, 4, 5]  # the box's left and bottom
    for normal, edge in zip(polygon.normals.tolist(), behind.tolist(), strict=True):
        assert normal == [[1, 0], [0, 1], None, None, [-1, 0], [0, -1]][edge]


def test_of_edges_that_leave_nothing_what_was_known_and_the_box_remain():
    program = box_program([0, 0], [1, 1])
    apart = np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([0.2, -0.8])
    known = np.array([[0.0, 1.0]]), np.array([0.25])
    polygon, behind = outer_polygon(program, np.eye(2), apart, known)
    assert polygon.area == pytest.approx(0.25)
    assert sorted(behind.tolist()) == [2, 3, 5, 6]
    polygon, behind = outer_polygon(program, np.eye(2), NOTHING, apart)
    assert polygon.area == pytest.approx(1.0)
    assert behind.tolist() == [2, 3, 4, 5]


def test_inner_points_are_pulled_to_the_interior_one_or_left_out():
    program = box_program([0, 0], [1, 1], [[0.6, 0.8]], [0.7])
    points = np.array([[0.0, 0.0], [0.0, 0.875], [1.0, 0.125], [5.0, 5.0]])
    inner = inner_polygon(program, np.eye(2), points, np.array([0.3, 0.3]))
    assert all(feasible(program, vertex) for vertex in inner.vertices)
    assert inner.area == pytest.approx(0.4375)
    assert inner_polygon(program, np.eye(2), points[1:2] + 0.01, np.array([2.0, 2.0])) is None
