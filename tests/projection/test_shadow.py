"""Turning the objective: it arrives where it should, and what it passes is a convex polygon."""

import numpy as np
import pytest
from helpers.walks import LIMIT, begun

from filter.projection.shadow import LONGEST, no_trace, simplified, turn
from filter.projection.simplex import FOUND, LOST, become_feasible


def walked(seed):
    """Return rows and a basis that is optimal for the first coordinate, and the plane of the first two."""
    rows, basis, objective = begun(seed)
    variables = len(objective)
    become_feasible(rows, basis, np.abs(objective), LIMIT)
    first, second = np.eye(variables)[0], np.eye(variables)[1]
    assert turn(rows, basis, objective, first, np.pi / 2, no_trace(0, variables), LIMIT) == FOUND
    return rows, basis, first, second


def full_turn(seed):
    rows, basis, first, second = walked(seed)
    trace = no_trace(LONGEST, len(first))
    assert turn(rows, basis, first, second, 2 * np.pi, trace, LIMIT) == FOUND
    count = int(trace.filled[0])
    return basis, trace.normal[:count], trace.point[:count, :2], trace


@pytest.mark.parametrize("seed", range(6))
def test_half_of_a_right_angle_after_another_is_a_right_angle(seed):
    rows, basis, first, second = walked(seed)
    nothing, middle = no_trace(0, len(first)), (first + second) / np.sqrt(2)
    other = walked(seed)[1]
    assert turn(rows, basis, first, second, np.pi / 2, nothing, LIMIT) == FOUND
    assert turn(rows, other, first, second, np.pi / 4, nothing, LIMIT) == FOUND
    assert turn(rows, other, middle, (second - first) / np.sqrt(2), np.pi / 4, nothing, LIMIT) == FOUND
    assert second @ other.point == pytest.approx(second @ basis.point, abs=1e-9)


@pytest.mark.parametrize("seed", range(6))
def test_a_full_turn_ends_where_it_began_and_passes_a_convex_polygon(seed):
    basis, normals, vertices, _ = full_turn(seed)
    assert basis.point[0] == pytest.approx(vertices[0, 0], abs=1e-9)
    angles = np.unwrap(np.arctan2(normals[:, 1], normals[:, 0]))
    assert (np.diff(angles) >= -1e-9).all()
    assert np.diff(np.append(angles, angles[0] + 2 * np.pi)).max() <= np.pi / 2 + 1e-6
    reached = (vertices * normals).sum(axis=1)
    assert (vertices @ normals.T <= reached + 1e-9).all()


@pytest.mark.parametrize("seed", range(3))
def test_the_prices_combine_the_rows_to_the_normal(seed):
    rows, _, _, _ = walked(seed)
    _, normals, _, trace = full_turn(seed)
    for normal, prices, basic in zip(normals, trace.prices, trace.basic, strict=False):
        total = np.zeros(trace.point.shape[1])
        for price, row in zip(prices, basic, strict=True):
            np.add.at(total, rows.column[row], price * rows.value[row])
        assert total[:2] == pytest.approx(normal, abs=1e-9)
        assert total[2:] == pytest.approx(0, abs=1e-9)
        assert prices.min() > -1e-9


def test_a_walk_that_has_strayed_or_takes_too_long_is_lost():
    rows, basis, first, second = walked(0)
    assert turn(rows, basis, first, second, 2 * np.pi, no_trace(0, len(first)), 1) == LOST
    for wrong in (-1e-3, np.nan):
        rows, basis, first, second = walked(0)
        basis.slack[np.flatnonzero(~basis.is_basic)[0]] = wrong
        assert turn(rows, basis, first, second, 2 * np.pi, no_trace(0, len(first)), LIMIT) == LOST


def test_edges_of_one_direction_are_one_and_flat_corners_go_first():
    angles = np.array([0.0, 0.0, 0.5, 1.0, 1.5, 1.52]) * np.pi
    normals = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    vertices = np.array([[1.0, 0.5], [1.0, 1.0], [0.0, 1.0], [0.0, 0.0], [0.99, 0.0], [1.0, 6e-4]])
    kept, why = simplified(normals, vertices, 1.0, (0.99, 0.0, 32))
    assert kept.tolist() == [1, 2, 3, 4]
    assert why == 1
    assert simplified(normals, vertices, 1.0, (1.0, 0.0, 32))[0].tolist() == [1, 2, 3, 4, 5]
