"""Projections are bracketed: the inner polygon is possible, the outer one proved, whatever the solver says."""

from fractions import Fraction

import numpy as np
import pytest
import shapely
from helpers.worlds import exact_slack, feasible, outside_hull, random_program, unit
from scipy import sparse
from scipy.optimize import linprog

from filter.errors import InvalidInput
from filter.geometry.polygon import Polygon
from filter.linear.program import LinearProgram
from filter.linear.solvers import Candidate, deepest_point, workspace
from filter.projection.proved import performance_ratio, position, relative_position
from filter.projection.search import project
from filter.projection.stop import Stop

# Two solvers, or two ways to compute an area, agree to this share.
SAME = 1e-6
EXACT = Stop(performance_ratio=1 - 1e-9, searches=200)


def projected(program, D, solver="piqp", stop=EXACT):
    deepest = deepest_point(program, solver)
    return project(program, workspace(program, solver), D, deepest.point, stop=stop)


def support(program, direction):
    """Return scipy's optimum [m], with the program moved to its centre."""
    box = np.stack([program.lower - program.centre, program.upper - program.centre], axis=1)
    return -linprog(-direction, program.A.toarray(), program.slack, bounds=box, method="highs").fun + direction @ program.centre


def matrices(robots, rng):
    return {
        "position": position(0, robots),
        "last": position(robots - 1, robots),
        "relative": relative_position(1, 0, robots),
        "mean": sum(position(k, robots) for k in range(robots)) / robots,
        "any": rng.normal(size=(2, 2 * robots)),
    }


@pytest.mark.parametrize("which", ["position", "last", "relative", "mean", "any"])
@pytest.mark.parametrize("seed", range(4))
def test_the_projection_is_between_the_inner_and_the_outer_polygon(seed, which):
    rng = np.random.default_rng(seed)
    program = random_program(rng, robots=3, rows=24)
    D = matrices(3, rng)[which]
    found = projected(program, D, stop=Stop(searches=10))
    for direction in unit(rng.uniform(-np.pi, np.pi, 12)):
        true = support(program, direction @ D)
        assert found.outer.support(direction[None])[0] >= true - 1e-8
        assert (found.inner.vertices @ direction).max() <= true + 1e-8
    assert found.inner.area <= found.outer.area
    assert shapely.Polygon(found.outer.vertices).buffer(1e-8).contains(shapely.Polygon(found.inner.vertices))
    assert found.performance_ratio > 0.5


@pytest.mark.parametrize("seed", range(8))
def test_inner_vertices_are_possible_and_outer_edges_are_proved_in_exact_arithmetic(seed):
    rng = np.random.default_rng(seed)
    program = random_program(rng, robots=2, rows=10)
    found = projected(program, position(0, 2), stop=Stop(searches=8))
    directions = found.directions
    multipliers = np.zeros((found.searches, len(program.b)))
    multipliers[found.weights.direction, found.weights.row] = found.weights.weight
    bounds = program.certified_bounds(directions @ position(0, 2), multipliers)
    for k, edge in enumerate(found.edges):
        if edge >= 0:
            assert found.outer.offsets[k] == bounds[edge]
            assert found.outer.normals[k].tolist() == directions[edge].tolist()
    for vertex in found.inner.vertices:
        box = [(vertex[m], vertex[m]) for m in (0, 1)] + list(zip(program.lower[2:], program.upper[2:], strict=True))
        rest = linprog(np.zeros(4), program.A.toarray(), program.b + 1e-12, bounds=box, method="highs")
        assert rest.status == 0  # some place of the other robot goes with it


@pytest.mark.parametrize("solver", ["piqp", "highs"])
@pytest.mark.parametrize("seed", range(6))
def test_the_ratio_is_exactly_a_half_after_four_searches(seed, solver):
    program = random_program(np.random.default_rng(seed), robots=3, rows=24)
    found = projected(program, position(0, 3), solver, Stop(searches=4))
    assert found.searches == 4
    assert found.inner_areas[-1] / found.outer_areas[-1] == pytest.approx(0.5, abs=SAME)
    assert found.performance_ratio >= 0.5 - SAME  # the box may cut the outer polygon further


@pytest.mark.parametrize("seed", range(6))
def test_a_vertex_solver_needs_two_searches_a_vertex_at_most(seed):
    program = random_program(np.random.default_rng(seed), robots=2, rows=16)
    found = projected(program, position(0, 2), "highs", Stop(performance_ratio=1.0, searches=1000))
    corners = len(shapely.Polygon(found.inner.vertices).simplify(1e-7).exterior.coords) - 1
    assert found.searches <= 2 * corners + 4
    assert found.performance_ratio > 1 - SAME


@pytest.mark.parametrize("seed", range(6))
def test_areas_close_in_with_every_search(seed):
    program = random_program(np.random.default_rng(seed), robots=3, rows=24)
    found = projected(program, position(0, 3))
    assert len(found.inner_areas) == len(found.outer_areas) == found.searches
    assert (np.diff(found.inner_areas) >= -1e-9).all()
    assert (np.diff(found.outer_areas[3:]) <= 1e-9).all()
    assert found.inner_areas[-1] == pytest.approx(found.inner.area, rel=1e-5)
    assert found.outer_areas[-1] == pytest.approx(found.outer.area, rel=1e-5)


def test_one_robots_projection_is_its_polygon():
    rng = np.random.default_rng(5)
    program = random_program(rng, robots=1, rows=9)
    found = projected(program, position(0, 1))
    own = Polygon.from_half_planes(program.A.toarray(), program.b, program.lower, program.upper)
    assert found.outer.area == pytest.approx(own.area, rel=SAME)
    assert found.inner.area == pytest.approx(own.area, rel=SAME)


def test_reasons_to_stop():
    program = random_program(np.random.default_rng(6), robots=3, rows=24)
    D = position(0, 3)
    assert projected(program, D, stop=Stop(searches=5)).reason == "searches"
    assert projected(program, D, stop=Stop(performance_ratio=0.4)).reason == "performance ratio"
    assert projected(program, D, stop=Stop(performance_ratio=1.0, area_gap=100.0)).reason == "area gap"
    stopped = projected(program, D, stop=Stop(performance_ratio=0.9))
    assert stopped.reason == "performance ratio"
    assert stopped.performance_ratio >= 0.9 - SAME
    exact = projected(program, D, "highs", Stop(performance_ratio=1.0, searches=1000))
    assert exact.reason in ("exact", "performance ratio")


@pytest.mark.parametrize(
    "wrong",
    [
        {"performance_ratio": 1.1},
        {"performance_ratio": np.nan},
        {"area_gap": -1.0},
        {"area_gap": np.inf},
        {"searches": 3},
        {"searches": np.nan},
        {"seconds": -1.0, "clock": float},
        {"seconds": np.nan, "clock": float},
        {"seconds": 1.0},  # without a clock
    ],
)
def test_a_stop_out_of_its_range_is_refused(wrong):
    with pytest.raises(InvalidInput):
        Stop(**wrong)


def box_program(lower, upper, rows=(), b=()):
    A = sparse.csr_array(np.array(rows, dtype=float).reshape(len(rows), len(lower)))
    return LinearProgram(A, np.array(b, dtype=float), np.array(lower, dtype=float), np.array(upper, dtype=float))


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
    found = projected(program, position(0, 1), solver, Stop())
    for point in inside:
        assert feasible(program, point)
        assert all(exact_slack(n, o, point) >= 0 for n, o in zip(found.outer.normals, found.outer.offsets, strict=True))
        assert not outside_hull(found.outer, point)
    assert found.outer.area < 1e-5


def test_without_an_interior_nothing_is_possible_for_sure():
    """On a line, rounding leaves no point of which every row holds for sure: better none than a doubtful one."""
    program = box_program([0, 0], [1, 1], [[0.6, -0.8], [-0.6, 0.8]], [0.1, -0.1])
    assert projected(program, position(0, 1), "highs", Stop()).inner is None


class Fake:
    """A solver that does whatever it likes."""

    def __init__(self, answer):
        self.answer, self.calls = answer, 0

    def maximize(self, objective):
        self.calls += 1
        return self.answer(self.calls, objective)


def fakes(program, rng):
    rows, variables = len(program.b), len(program.centre)
    true = workspace(program, "piqp")

    def after(count, otherwise):
        return lambda call, c: true.maximize(c) if call <= count else otherwise(call, c)

    def nothing(*_):
        return None

    def noise(*_):
        return Candidate(program.centre + rng.normal(size=variables), rng.exponential(1, rows) * 10.0 ** rng.uniform(-6, 6))

    def numberless(*_):
        return Candidate(np.full(variables, np.nan), np.full(rows, np.nan))

    return {
        "gives up": nothing,
        "gives up after 1": after(1, nothing),
        "gives up after 3": after(3, nothing),
        "gives up after 6": after(6, nothing),
        "noise": noise,
        "noise after 5": after(5, noise),
        "no number": numberless,
        "no number after 6": after(6, numberless),
        "one point": lambda *_: Candidate(program.centre, np.zeros(rows)),
        "far away": lambda *_: Candidate(program.centre + 1e9 * rng.normal(size=variables), np.zeros(rows)),
        "negative": lambda *_: Candidate(program.lower, np.full(rows, -1.0)),
        "huge": lambda *_: Candidate(program.upper, np.full(rows, 1e30)),
        "no number in multipliers": after(4, lambda _, c: Candidate(true.maximize(c).point, np.full(rows, np.nan))),
    }


NAMES = list(fakes(random_program(np.random.default_rng(0)), np.random.default_rng(0)))


@pytest.mark.parametrize("name", NAMES)
def test_whatever_a_solver_says_the_outer_polygon_stays_sound(name):
    for seed in range(4):
        rng = np.random.default_rng(seed)
        program = random_program(rng, robots=2, rows=12)
        found = project(program, Fake(fakes(program, rng)[name]), position(0, 2), program.centre, stop=Stop())
        points = program.centre + rng.uniform(-1, 1, (4000, 4))
        allowed = points[program.holds(points)][:, :2]
        assert len(allowed)
        assert found.outer.contains(allowed).all()
        assert not any(outside_hull(found.outer, point) for point in allowed[:50])
        if found.inner is not None:
            assert shapely.Polygon(found.outer.vertices).buffer(1e-9).contains(shapely.MultiPoint(found.inner.vertices))
        assert found.searches <= 16


def test_a_solver_that_gives_up_is_the_reason():
    program = random_program(np.random.default_rng(0))
    found = project(program, Fake(lambda *_: None), position(0, 2), program.centre, stop=Stop())
    assert found.reason == "solver"
    assert found.outer.area == pytest.approx(4.0)
    assert found.inner is None


def test_what_a_solver_proved_before_it_lost_its_numbers_is_kept():
    rng = np.random.default_rng(1)
    program = random_program(rng, robots=2, rows=12)
    before = project(program, Fake(fakes(program, rng)["gives up after 6"]), position(0, 2), program.centre, stop=Stop())
    after = project(program, Fake(fakes(program, rng)["no number after 6"]), position(0, 2), program.centre, stop=Stop())
    assert after.outer.area == pytest.approx(before.outer.area)


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


def test_positions_and_relative_positions():
    x = np.arange(6.0)
    assert (position(1, 3) @ x).tolist() == [2, 3]
    assert (relative_position(2, 0, 3) @ x).tolist() == [4, 4]


def test_ratios_without_area():
    point, box = Polygon.from_vertices([[0, 0]]), Polygon.box([0, 0], [1, 1])
    assert performance_ratio(None, box) == 0
    assert performance_ratio(point, point) == 1
    assert performance_ratio(point, box) == 0
    assert performance_ratio(box, box) == 1
