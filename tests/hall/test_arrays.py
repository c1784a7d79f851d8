"""The checks that every record shares."""

import numpy as np
import pytest

from filter.arrays import finite, read_only, whole
from filter.errors import InvalidInput


@pytest.mark.parametrize("values", [np.nan, np.inf, -np.inf, [0.0, np.nan], "north", [[1.0], [1.0, 2.0]], None, 1j])
def test_what_is_no_finite_number_is_refused(values):
    with pytest.raises(InvalidInput, match=r"expected length \[m\]: finite numbers; came"):
        finite("length [m]", values)


@pytest.mark.parametrize("value", [-1e-300, np.nextafter(1.0, 2.0), 7.0])
def test_a_number_outside_its_limits_is_refused_with_the_limits(value):
    with pytest.raises(InvalidInput, match=r"within \[0, 1\]; came .*" + str(value)[:3].replace("-", r"\-")):
        finite("share", value, 0, 1)


def test_limits_themselves_are_allowed():
    assert finite("share", [0, 1], 0, 1).tolist() == [0.0, 1.0]


def test_finite_returns_a_copy():
    values = np.ones(3)
    finite("length [m]", values)[0] = 5
    assert values[0] == 1


@pytest.mark.parametrize("values", [-1, [0, -3], 1.0, [0.5], "one", None, True, np.array([2**64 - 1], dtype=np.uint64)])
def test_what_is_no_whole_number_from_0_on_is_refused(values):
    with pytest.raises(InvalidInput, match="robot: whole numbers from 0 on"):
        whole("robot", values)


@pytest.mark.parametrize("values", [[[1], [2, 3]]])
def test_columns_of_uneven_rows_are_refused(values):
    with pytest.raises(InvalidInput, match="robot: whole numbers from 0 on"):
        whole("robot", values)


def test_no_numbers_are_whole_numbers():
    assert whole("robot", []).dtype == np.int64


def test_a_read_only_array_cannot_be_written():
    with pytest.raises(ValueError, match="read-only"):
        read_only(np.zeros(2))[0] = 1


def test_a_view_is_copied_before_it_is_made_read_only():
    base = np.zeros(4)
    kept = read_only(base[:2])
    base[0] = 1
    assert kept[0] == 0
