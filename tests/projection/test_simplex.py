"""The compiled simplex method: its invariants at every step, its vertices against HiGHS."""

import numpy as np
import pytest
from helpers.walks import LIMIT, begun, dense
from scipy.optimize import linprog

from filter.projection.simplex import (
    EMPTY,
    FOUND,
    LOST,
    Rows,
    become_feasible,
    combination,
    corner,
    exchange,
    locate,
    mend,
)


def consistent(rows, basis, tolerance=1e-9):
    """The inverse is one, the point is where the basic rows meet, the slacks are the rows' at the point."""
    matrix = dense(rows, len(basis.point))
    assert matrix[basis.basic] @ basis.inverse == pytest.approx(np.eye(len(basis.point)), abs=tolerance)
    assert matrix[basis.basic] @ basis.point == pytest.approx(rows.offset[basis.basic], abs=tolerance)
    assert basis.slack == pytest.approx(rows.offset - matrix @ basis.point, abs=tolerance)
    assert sorted(np.flatnonzero(basis.is_basic)) == sorted(basis.basic)


def test_the_corner_is_the_farthest_of_the_box():
    rows, basis, objective = begun(0)
    consistent(rows, basis)
    assert np.sign(basis.point).tolist() == np.sign(objective).tolist()


@pytest.mark.parametrize("seed", range(8))
def test_the_vertex_found_is_the_best_as_highs_says(seed):
    rows, basis, objective = begun(seed)
    assert become_feasible(rows, basis, np.abs(objective), LIMIT)[0] == FOUND
    consistent(rows, basis)
    assert basis.slack.min() >= -1e-11
    matrix = dense(rows, len(objective))
    best = linprog(-objective, matrix, rows.offset, bounds=(None, None), method="highs")
    assert objective @ basis.point == pytest.approx(-best.fun, abs=1e-7)


def test_a_row_is_the_combination_that_is_written():
    rows, basis, objective = begun(1)
    become_feasible(rows, basis, np.abs(objective), LIMIT)
    weights, matrix = np.empty(len(objective)), dense(rows, len(objective))
    for i in range(len(rows.offset)):
        combination(rows, basis, i, weights)
        assert weights @ matrix[basis.basic] == pytest.approx(matrix[i], abs=1e-9)


def test_exchanges_keep_the_inverse():
    rows, basis, objective = begun(2)
    rng, weights = np.random.default_rng(0), np.empty(len(objective))
    for _ in range(20):
        entering = int(rng.choice(np.flatnonzero(~basis.is_basic)))
        combination(rows, basis, entering, weights)
        exchange(basis, int(np.argmax(np.abs(weights))), 0.0, np.zeros(len(rows.offset)), entering, weights)
        locate(rows, basis)
        consistent(rows, basis)


def test_mending_squares_the_error():
    rows, basis, objective = begun(3)
    become_feasible(rows, basis, np.abs(objective), LIMIT)
    basis.inverse[:] += 1e-5 * np.random.default_rng(0).normal(size=basis.inverse.shape)
    mend(rows, basis)
    consistent(rows, basis, tolerance=1e-6)


def test_rows_that_exclude_one_another_are_told_from_a_walk_cut_short():
    column, value = np.zeros((4, 4), dtype=np.int64), np.zeros((4, 4))
    value[:, 0] = [1.0, -1.0, 1.0, -1.0]
    empty = Rows(column, value, np.array([-0.5, 0.2, 1.0, 1.0]))
    assert become_feasible(empty, corner(empty, np.ones(1)), np.ones(1), LIMIT)[0] == EMPTY
    rows, basis, objective = begun(0)
    assert become_feasible(rows, basis, np.abs(objective), 1)[0] == LOST
