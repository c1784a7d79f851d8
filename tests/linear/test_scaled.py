"""A scaled program says the same as the program."""

import numpy as np
import pytest
from helpers.worlds import random_program
from scipy import sparse

from filter.linear.program import LinearProgram
from filter.linear.solvers import ScaledProgram


@pytest.mark.parametrize("at", [0.0, 1e6])
@pytest.mark.parametrize("seed", range(5))
def test_points_multipliers_and_objectives_mean_the_same(seed, at):
    rng = np.random.default_rng(seed)
    program = random_program(rng, 3, 30, origin=at)
    scaled = ScaledProgram(program)
    z, y, objectives = rng.uniform(-1, 1, (4, 6)), rng.exponential(1, (4, len(scaled.live))), rng.normal(size=(4, 6))
    for k, objective in enumerate(objectives):
        asked = []
        found = scaled.maximize(objective, lambda c, k=k, asked=asked: asked.append(c) or (z[k], y[k]))
        x, multipliers = found.point, found.multipliers
        assert (x >= program.lower - 1e-9).all() and (x <= program.upper + 1e-9).all()
        slack = (program.b - program.A @ x)[scaled.live]
        assert (scaled.h - scaled.G @ z[k]) * scaled.size == pytest.approx(slack, abs=1e-8 * max(1.0, at))
        scale = np.abs(objective * program.radius).max()
        assert np.abs(asked[0]).max() == 1
        assert (z[k] @ asked[0]) * scale == pytest.approx((x - program.centre) @ objective, abs=1e-8 * max(1.0, at))
        combined = multipliers @ program.A.toarray() * program.radius
        assert combined[scaled.free] == pytest.approx(y[k] @ scaled.G.toarray() * scale)
    assert scaled.maximize(objective, lambda c: None) is None


def test_every_row_adds_up_to_one():
    scaled = ScaledProgram(random_program(np.random.default_rng(0), 4, 50))
    assert abs(scaled.G).sum(axis=1) == pytest.approx(1)


def test_anchored_coordinates_and_rows_that_the_box_implies_are_left_out():
    A = sparse.csr_array([[1.0, 0.0], [0.0, 1.0], [1.0, 1.0]])
    program = LinearProgram(A, np.array([0.5, 9.0, 5.5]), np.array([0.0, 5.0]), np.array([1.0, 5.0]))
    scaled = ScaledProgram(program)
    assert scaled.free.tolist() == [0]
    assert scaled.live.tolist() == [0, 2]
