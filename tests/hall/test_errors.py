"""Errors carry data, and their messages name what was expected and what came."""

import pytest

from filter.errors import CorralError, Inconsistent, InvalidInput, OutOfOrder


@pytest.mark.parametrize(
    "error",
    [InvalidInput("a", "b"), OutOfOrder("a record", 1.0, 2.0), Inconsistent("at 1 s", ["a"])],
    ids=lambda e: type(e).__name__,
)
def test_every_error_has_one_base(error):
    assert isinstance(error, CorralError)


@pytest.mark.parametrize("error", [InvalidInput("a", "b"), OutOfOrder("a record", 1.0, 2.0)], ids=lambda e: type(e).__name__)
def test_an_error_of_input_is_a_value_error(error):
    assert isinstance(error, ValueError)


def test_invalid_input_names_what_was_expected_and_what_came():
    error = InvalidInput("a whole number", 1.5)
    assert (error.expected, error.came) == ("a whole number", 1.5)
    assert "a whole number" in str(error)
    assert "1.5" in str(error)


def test_a_late_record_is_told_that_it_is_late():
    error = OutOfOrder("compass", 1.0, 2.0)
    assert (error.time, error.belief_time) == (1.0, 2.0)
    assert "too late" in str(error)


def test_an_early_record_is_told_to_predict_first():
    assert "predict to 3.0 s first" in str(OutOfOrder("compass", 3.0, 2.0))


def test_inconsistent_names_every_source_in_its_order():
    error = Inconsistent("at 1 s", ["one", "two"])
    assert error.sources == ("one", "two")
    assert str(error).endswith("one; two")
