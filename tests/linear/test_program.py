"""Bounds that are proved, whatever a solver says: checked in exact rational arithmetic."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.worlds import exact_slack, feasible, offset_through, random_program, unit
from hypothesis import given
from hypothesis import strategies as st
from scipy import sparse
from scipy.optimize import linprog

from filter.linear.program import LinearProgram
from filter.linear.solvers import deepest_point

# A certified bound from good multipliers is this close to the optimum [m].
TIGHT = 1e-7
# The oracle's own optimum is this accurate [m].
SOLVED = 1e-8
ORIGINS = (0.0, 1.0, 5e6)

seeds = st.integers(0, 2**32 - 1)


def fractions(array):
    return [Fraction(float(value)) for value in array]


def exact_bound(program, objective, y):
    """Return min over nothing: c.x0 + |c - A'y|.w + y.(b - A x0) of the box as it is, in exact arithmetic."""
    A = program.A.toarray()
    c, b, weights = fractions(objective), fractions(program.b), fractions(y)
    total = sum((weights[r] * b[r] for r in range(len(b)) if weights[r]), Fraction(0))
    for k in range(len(c)):
        rest = c[k] - sum((weights[r] * Fraction(float(A[r, k])) for r in range(len(b)) if weights[r] and A[r, k]), Fraction(0))
        total += rest * Fraction(float(program.upper[k] if rest > 0 else program.lower[k]))
    return total


def objectives(rng, program, count=4):
    """Return directions on one robot, on a pair, and nothing at all."""
    c = np.zeros((count, len(program.centre)))
    for row in c[:-1]:
        row[0:2] = unit(rng.uniform(-np.pi, np.pi))
        if rng.random() < 0.5 and len(row) > 2:
            row[2:4] = -row[0:2]
    return c


def candidates(rng, shape):
    """Return multipliers of every kind, all of them from 0 on and finite."""
    kind = rng.integers(4)
    if kind == 0:
        return np.zeros(shape)
    if kind == 1:
        return rng.uniform(0, 1, shape) * (rng.random(shape) < 0.3)
    return rng.exponential(1, shape) * 10.0 ** (rng.uniform(-300, 0) if kind == 2 else rng.uniform(0, 12))


@given(seeds, st.sampled_from(ORIGINS), st.sampled_from([0.0, 1e-12, 1.0, 1e4]))
def test_a_bound_is_never_below_its_exact_value(seed, origin, size):
    rng = np.random.default_rng(seed)
    program = random_program(rng, size=size, origin=origin)
    c = objectives(rng, program)
    y = candidates(rng, (len(c), len(program.b)))
    bounds = program.certified_bounds(c, y)
    for objective, weights, bound in zip(c, y, bounds, strict=True):
        assert Fraction(float(bound)) >= exact_bound(program, objective, weights)


@given(seeds, st.sampled_from([1e-3, 1.0, 1e4]))
def test_a_bound_from_rows_through_the_middle_is_never_below_its_exact_value(seed, size):
    """As of bearings: offsets are 0, so that all rounding is in the weights' own sums."""
    rng = np.random.default_rng(seed)
    drawn = random_program(rng, rows=30, size=size)
    program = LinearProgram(drawn.A, np.zeros(30), drawn.lower, drawn.upper)
    c = objectives(rng, program)
    y = rng.exponential(1, (len(c), 30)) * 10.0 ** rng.uniform(-3, 6)
    for objective, weights, bound in zip(c, y, program.certified_bounds(c, y), strict=True):
        assert Fraction(float(bound)) >= exact_bound(program, objective, weights)


@given(seeds, st.sampled_from(ORIGINS))
def test_a_bound_is_no_higher_than_rounding_makes_it(seed, origin):
    rng = np.random.default_rng(seed)
    program = random_program(rng, origin=origin)
    c = objectives(rng, program)
    y = rng.uniform(0, 1, (len(c), len(program.b)))
    for objective, weights, bound in zip(c, y, program.certified_bounds(c, y), strict=True):
        assert Fraction(float(bound)) <= exact_bound(program, objective, weights) + Fraction(1e-11 + 1e-12 * origin)


@given(seeds, st.sampled_from(ORIGINS))
def test_no_feasible_point_is_beyond_a_bound_whatever_the_multipliers(seed, origin):
    rng = np.random.default_rng(seed)
    program = random_program(rng, origin=origin)
    c = objectives(rng, program)
    shape = (len(c), len(program.b))
    lies = rng.choice([-1.0, -1e9, np.nan, np.inf, -np.inf, 0.0, 1.0, 1e-300, 1e9, 1e100], shape)
    bounds = program.certified_bounds(c, lies)
    points = program.centre + rng.uniform(-1, 1, (20, len(program.centre))) * program.radius * rng.uniform(0, 1, (20, 1))
    inside = [program.centre, *(point for point in points if feasible(program, point))]
    assert np.isfinite(bounds).all()
    for objective, bound in zip(c, bounds, strict=True):
        nearest = inside[int(np.argmax([objective @ point for point in inside]))]
        assert exact_slack(objective, bound, nearest) >= 0


@pytest.mark.filterwarnings("ignore:overflow:RuntimeWarning", "ignore:invalid:RuntimeWarning")
def test_multipliers_that_overflow_bound_nothing():
    program = random_program(np.random.default_rng(0))
    bounds = program.certified_bounds(objectives(np.random.default_rng(0), program), np.full((4, 12), 1e308))
    assert not (bounds < np.inf).any()
    assert not program.proves_empty(np.full(12, 1e308))


@pytest.mark.parametrize("wrong", [-1.0, np.nan, np.inf, -np.inf])
def test_multipliers_that_are_none_count_as_nothing(wrong):
    program = random_program(np.random.default_rng(1))
    c = objectives(np.random.default_rng(1), program)
    assert (
        program.certified_bounds(c, np.full((4, 12), wrong)).tolist() == program.certified_bounds(c, np.zeros((4, 12))).tolist()
    )


@given(seeds, st.integers(20, 300))
def test_a_bound_of_a_dense_direction_is_never_below_its_exact_value(seed, variables):
    rng = np.random.default_rng(seed)
    middle = rng.uniform(-1, 1, variables) * 1e8
    program = LinearProgram(sparse.csr_array((0, variables)), np.zeros(0), middle, middle)
    c = np.full((1, variables), 0.1)
    assert Fraction(float(program.certified_bounds(c, np.zeros((1, 0)))[0])) >= exact_bound(program, c[0], np.zeros(0))


@pytest.mark.parametrize("origin", [0.0, 5e6])
@pytest.mark.parametrize("seed", range(12))
def test_good_multipliers_give_a_bound_next_to_the_optimum(seed, origin):
    rng = np.random.default_rng(seed)
    program = random_program(rng, robots=4, rows=30, origin=origin)
    middle, c = program.centre, objectives(rng, program)
    for objective in c[:-1]:
        box = np.stack([program.lower - middle, program.upper - middle], axis=1)
        found = linprog(-objective, program.A.toarray(), program.slack, bounds=box, method="highs")
        optimum = -found.fun + objective @ middle
        bound = program.certified_bounds(objective[None], -found.ineqlin.marginals[None])[0]
        assert optimum - SOLVED <= bound <= optimum + TIGHT + 1e-12 * origin


def test_a_program_without_rows_is_bounded_by_its_box():
    program = LinearProgram(sparse.csr_array((0, 2)), np.zeros(0), np.array([-1.0, 2.0]), np.array([3.0, 2.0]))
    assert program.certified_bounds(np.array([[0.6, 0.8]]), np.zeros((1, 0)))[0] == pytest.approx(0.6 * 3 + 0.8 * 2)
    assert program.radius[1] == 0
    assert not program.proves_empty(np.zeros(0))
    assert program.holds(np.array([[0.0, 2.0], [0.0, 2.1]])).tolist() == [True, False]


@pytest.mark.parametrize("size", [0.0, 1e-9, 1.0, 1e6])
@pytest.mark.parametrize("origin", ORIGINS)
def test_no_lie_proves_a_program_empty_that_has_a_point(size, origin):
    rng = np.random.default_rng(0)
    for _ in range(20):
        program = random_program(rng, size=size, origin=origin)
        if not feasible(program, program.centre):
            continue  # rounding of the row's own offset, at a size of 0
        for _ in range(40):
            y = candidates(rng, len(program.b)) * rng.choice([-1.0, 1.0, 1.0], len(program.b))
            assert not program.proves_empty(y)


def on_a_point(rng, origin, rows=12):
    """Return a program whose rows all just hold at one point, which every certificate has to respect."""
    point = origin + rng.uniform(-1, 1, 4)
    A = random_program(rng, rows=rows).A
    b = np.array([offset_through(row, point) for row in A.toarray()])
    program = LinearProgram(A, b, point - 1, point + 1)
    assert feasible(program, point)
    return program


@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("seed", range(10))
def test_a_program_of_next_to_one_point_is_never_proved_empty(seed, origin):
    rng = np.random.default_rng(seed)
    program = on_a_point(rng, origin)
    deepest = deepest_point(program, "piqp")
    tried = [candidates(rng, 12) for _ in range(50)] + ([deepest.multipliers] if deepest else [])
    for y in tried:
        for scale in (1.0, 1e-9, 1e9):
            assert not program.proves_empty(y * scale)


@pytest.mark.parametrize("solver", ["piqp", "highs"])
@pytest.mark.parametrize("origin", ORIGINS)
@pytest.mark.parametrize("gap", [1e-6, 1e-2, 1.0])
def test_a_program_without_a_point_is_proved_empty(solver, origin, gap):
    for seed in range(8):
        rng = np.random.default_rng(seed)
        program = random_program(rng, origin=origin)
        way = np.zeros((2, 4))
        way[0, :2] = unit(rng.uniform(-np.pi, np.pi))
        way[1] = -way[0]
        level = float(way[0] @ program.centre)
        A, b = (
            sparse.csr_array(np.vstack([program.A.toarray(), way])),
            np.append(program.b, [level - gap / 2, -level - gap / 2]),
        )
        empty = LinearProgram(A, b, program.lower, program.upper)
        assert empty.proves_empty(deepest_point(empty, solver).multipliers)


@given(seeds, st.sampled_from(ORIGINS))
def test_a_point_that_holds_is_feasible_in_exact_arithmetic(seed, origin):
    rng = np.random.default_rng(seed)
    program = random_program(rng, origin=origin)
    points = program.centre + rng.normal(size=(8, 4))
    for k in range(8):  # from the middle up to the first row or side, to rounding
        way = points[k] - program.centre
        towards = program.A @ way
        reach = np.concatenate([program.slack[towards > 0] / towards[towards > 0], program.radius / np.abs(way)])
        points[k] = program.centre + reach.min() * way * (1 + rng.integers(-8, 9) * np.finfo(float).eps)
    for point, holds in zip(points, program.holds(points), strict=True):
        assert not holds or feasible(program, point)


@given(seeds, st.sampled_from(ORIGINS))
def test_a_point_well_inside_holds(seed, origin):
    program = random_program(np.random.default_rng(seed), origin=origin)
    assert program.holds(program.centre[None])[0]


@given(seeds, st.sampled_from(ORIGINS))
def test_a_pulled_point_is_feasible_where_there_is_an_interior(seed, origin):
    rng = np.random.default_rng(seed)
    program = random_program(rng, origin=origin)
    outside = program.centre + rng.uniform(-1.5, 1.5, (6, 4))
    pulled = program.pulled(outside, program.centre)
    assert program.holds(pulled).all()
    assert all(feasible(program, point) for point in pulled)


def test_a_point_that_holds_already_is_hardly_pulled():
    program = random_program(np.random.default_rng(3))
    point = program.centre[None] + 1e-3
    assert program.pulled(point, program.centre).tolist() == point.tolist()
