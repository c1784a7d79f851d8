"""Solvers give candidates; which solver it is makes no difference but time."""

import numpy as np
import pytest
from helpers.worlds import random_program, unit
from scipy import sparse
from scipy.optimize import linprog

from filter.errors import InvalidInput
from filter.linear import solvers
from filter.linear.program import LinearProgram
from filter.linear.solvers import SIMPLEX, check_solver, deepest_point, workspace

# Solvers agree to this [m].
SAME = 1e-6
EACH = pytest.mark.parametrize("solver", ["piqp", "highs", SIMPLEX])


def greatest(program, objective):
    """Return scipy's optimum [m]."""
    box = np.stack([program.lower, program.upper], axis=1)
    return -linprog(-objective, program.A.toarray(), program.b, bounds=box, method="highs").fun


@EACH
@pytest.mark.parametrize("seed", range(6))
def test_a_workspace_answers_one_direction_after_the_other(solver, seed):
    rng = np.random.default_rng(seed)
    program = random_program(rng, robots=3, rows=20, size=10.0 ** rng.uniform(-4, 4))
    size = program.radius.max()
    work = workspace(program, solver)
    for angle in rng.uniform(-np.pi, np.pi, 6):
        objective = np.zeros(6)
        objective[2:4] = unit(angle)
        found = work.maximize(objective)
        optimum = greatest(program, objective)
        assert objective @ found.point == pytest.approx(optimum, abs=SAME * size)
        bound = program.certified_bounds(objective[None], found.multipliers[None])[0]
        assert optimum - 1e-12 * size <= bound <= optimum + SAME * size


@EACH
def test_anchored_coordinates_stay_where_they_are(solver):
    program = random_program(np.random.default_rng(0), robots=3, rows=12)
    anchored = LinearProgram(program.A, program.b, np.append(program.centre[:2], program.lower[2:]), program.upper.copy())
    anchored.upper[:2] = anchored.lower[:2]
    objective = np.array([0.0, 0, 0.6, 0.8, 0, 0])
    found = workspace(anchored, solver).maximize(objective)
    assert found.point[:2].tolist() == anchored.lower[:2].tolist()
    assert objective @ found.point == pytest.approx(greatest(anchored, objective), abs=SAME)


@EACH
@pytest.mark.parametrize("slack", [0.0, 1.0, -1e-16, -1.0])
def test_a_program_without_a_free_coordinate_has_an_answer(solver, slack):
    middle = np.array([1.0, 2.0])
    program = LinearProgram(sparse.csr_array([[1.0, 0.0]]), np.array([1.0 + slack]), middle, middle)
    found = workspace(program, solver).maximize(np.array([0.6, 0.8]))
    assert found.point.tolist() == middle.tolist()
    assert program.certified_bounds(np.array([[0.6, 0.8]]), found.multipliers[None])[0] >= 2.2


@EACH
@pytest.mark.parametrize("slack", [1e-17, 0.0, -1e-16])
def test_a_row_on_anchored_coordinates_alone_is_no_trouble(solver, slack):
    lower, upper = np.array([0.0, 0.0, -1.0, -1.0]), np.array([0.0, 0.0, 1.0, 1.0])
    A = sparse.csr_array([[1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]])
    program = LinearProgram(A, np.array([slack, 0.5]), lower, upper)
    objective = np.array([0.0, 0.0, 1.0, 0.0])
    found = workspace(program, solver).maximize(objective)
    assert found is not None
    assert program.certified_bounds(objective[None], found.multipliers[None])[0] == pytest.approx(0.5, abs=SAME)


@EACH
def test_the_deepest_point_keeps_as_far_from_every_row_as_can_be(solver):
    A = sparse.csr_array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
    program = LinearProgram(A, np.array([1.0, 1.0, 2.0, 0.0]), np.full(2, -9.0), np.full(2, 9.0))
    assert deepest_point(program, solver).point == pytest.approx([0.0, 1.0], abs=1e-5)


@EACH
def test_the_deepest_point_of_no_rows_is_in_the_box(solver):
    program = LinearProgram(sparse.csr_array((0, 2)), np.zeros(0), np.zeros(2), np.ones(2))
    assert np.abs(deepest_point(program, solver).point - 0.5).max() <= 0.5 + SAME


def test_an_unknown_solver_is_refused_with_those_installed():
    for refuse in (check_solver, lambda name: workspace(random_program(np.random.default_rng(0)), name)):
        with pytest.raises(InvalidInput, match=r"among highs.*piqp; came 'simplex'"):
            refuse("simplex")


def test_nothing_that_a_solver_throws_escapes(monkeypatch):
    def thrown(*_, **__):
        raise RuntimeError("out of luck")

    monkeypatch.setattr("qpsolvers.solve_problem", thrown)
    assert workspace(random_program(np.random.default_rng(0)), "highs").maximize(np.ones(4)) is None


@EACH
def test_a_program_without_a_point_is_no_answer_or_a_candidate(solver):
    program = LinearProgram(
        sparse.csr_array([[1.0, 0.0], [-1.0, 0.0]]), np.array([-1.0, -1.0]), np.full(2, -5.0), np.full(2, 5.0)
    )
    found = workspace(program, solver).maximize(np.array([0.0, 1.0]))
    assert found is None or np.isfinite(found.point).all()


def test_a_solver_that_is_not_installed_is_told_with_those_that_are(monkeypatch):
    check_solver("piqp")
    monkeypatch.setitem(solvers.PACKAGES, "piqp", ("not_installed",))
    monkeypatch.setattr("qpsolvers.available_solvers", ["highs"])
    for solver in ("piqp", "nobody's", ["piqp"], None):
        with pytest.raises(InvalidInput, match="a solver among highs, highs-simplex"):
            check_solver(solver)
    check_solver("highs")
