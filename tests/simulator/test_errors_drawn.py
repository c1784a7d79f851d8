"""Errors of four kinds, all within their bound."""

import numpy as np
import pytest

from filter.errors import InvalidInput
from sim.errors import ERROR_KINDS, Errors

DRAWS = 2000


def drawn(kind, seed=0, channels=(5,)):
    errors = Errors(kind, channels, np.random.default_rng(seed))
    return np.array([errors.draw() for _ in range(DRAWS)])


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_no_error_is_beyond_its_bound(kind):
    for seed in range(5):
        assert np.abs(drawn(kind, seed)).max() <= 1


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_the_same_seed_gives_the_same_errors_and_another_one_others(kind):
    assert (drawn(kind, 1) == drawn(kind, 1)).all()
    assert (drawn(kind, 1) != drawn(kind, 2)).any()


def test_uniform_errors_use_the_whole_bound_evenly():
    errors = drawn("uniform")
    assert abs(errors.mean()) < 0.03
    assert abs((np.abs(errors) < 0.5).mean() - 0.5) < 0.03


def test_a_bias_does_not_average_out():
    means = drawn("bias", channels=(40,)).mean(axis=0)
    assert (np.abs(means) >= 0.84).all()
    assert (np.abs(means) <= 0.96).all()
    assert len(np.unique(np.sign(means))) == 2


def test_a_bias_is_not_quite_constant():
    assert (drawn("bias").std(axis=0) > 0.01).all()


def test_a_bias_is_the_same_for_everything_that_one_sensor_reads():
    errors = Errors("bias", (6,), np.random.default_rng(0)).draw(9)
    assert (np.sign(errors) == np.sign(errors[:, :1])).all()


def test_extreme_errors_are_at_the_bound_on_either_side():
    errors = drawn("extreme")
    assert set(errors.ravel()) == {-1.0, 1.0}
    assert (np.abs(errors.mean(axis=0)) < 0.1).all()


def test_gaussian_errors_are_a_third_of_the_bound_wide():
    errors = drawn("gaussian")
    assert abs(errors.std() - 0.329) < 0.01  # a third, less what was drawn again
    assert len(np.unique(np.abs(errors))) == errors.size  # drawn again, not cut off at the bound


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_errors_come_one_for_each_channel_or_several(kind):
    errors = Errors(kind, (4, 2), np.random.default_rng(0))
    assert errors.draw().shape == (4, 2)
    assert errors.draw(3).shape == (4, 2, 3)


def test_an_unknown_kind_is_refused_by_name():
    with pytest.raises(InvalidInput, match=r"uniform, bias, extreme, gaussian.*'pink'"):
        Errors("pink", (1,), np.random.default_rng(0))
