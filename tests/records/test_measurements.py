"""Records refuse what no sensor says, and intervals contain every true value."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filter import Bearing, Compass, Odometry, Range
from filter.errors import InvalidInput
from filter.records.measurements import interval_of_measured
from filter.records.record import field_names

GOOD = {
    Compass: {"time": 0.0, "robot": 0, "heading": 0.5, "bound": 0.1},
    Bearing: {"time": 0.0, "robot": 0, "target": 1, "bearing": 0.5, "bound": 0.1},
    Range: {"time": 0.0, "robot": 0, "target": 1, "range": 2.0, "bound": 0.1, "relative_bound": 0.05},
    Odometry: {
        "start": 0.0,
        "time": 1.0,
        "robot": 0,
        "distance": 0.5,
        "distance_bound": 0.1,
        "turn": 0.1,
        "turn_bound": 0.1,
        "direction_bound": 0.1,
        "slip_bound": 0.1,
    },
}
NUMBERS = [(kind, name) for kind, values in GOOD.items() for name in values if name not in ("robot", "target")]
BOUNDS = [(kind, name) for kind, name in NUMBERS if name.endswith("bound") or name == "range"]
TOO_WIDE = [
    (Compass, "bound", np.nextafter(np.pi, 4)),
    (Bearing, "bound", np.nextafter(np.pi, 4)),
    (Range, "relative_bound", 1.0),
    (Odometry, "direction_bound", np.pi / 2),
]


def changed(kind, **values):
    return kind(**{**GOOD[kind], **values})


@pytest.mark.parametrize("kind", GOOD)
def test_a_number_is_a_column_of_one(kind):
    record = changed(kind)
    assert all(getattr(record, name).shape == (1,) for name in field_names(record))


@pytest.mark.parametrize("kind", GOOD)
def test_numbers_are_repeated_to_the_longest_column(kind):
    record = changed(kind, robot=[2, 3, 4])
    assert all(getattr(record, name).shape == (3,) for name in field_names(record))


@pytest.mark.parametrize("kind", GOOD)
def test_a_record_may_be_empty(kind):
    record = changed(kind, robot=[])
    assert all(getattr(record, name).shape == (0,) for name in field_names(record))


@pytest.mark.parametrize("kind", GOOD)
def test_a_record_cannot_be_changed(kind):
    record = changed(kind, robot=[2, 3])
    for name in field_names(record):
        with pytest.raises(ValueError, match="read-only"):
            getattr(record, name)[0] = 0


@pytest.mark.parametrize("value", [np.nan, np.inf, -np.inf, "much"])
@pytest.mark.parametrize(("kind", "name"), NUMBERS)
def test_a_value_that_is_no_finite_number_is_refused(kind, name, value):
    with pytest.raises(InvalidInput, match=f"finite numbers.*; came .*{str(value).strip('-')}"):
        changed(kind, **{name: value})


@pytest.mark.parametrize(("kind", "name"), BOUNDS)
def test_a_negative_bound_is_refused(kind, name):
    with pytest.raises(InvalidInput, match=r"within \[0, .*came .*-0\.01"):
        changed(kind, **{name: -0.01})


@pytest.mark.parametrize(("kind", "name", "value"), TOO_WIDE)
def test_a_bound_that_is_too_wide_is_refused(kind, name, value):
    with pytest.raises(InvalidInput, match=r"within \[0, "):
        changed(kind, **{name: value})
    assert getattr(changed(kind, **{name: np.nextafter(value, 0)}), name)[0] < value


@pytest.mark.parametrize("kind", GOOD)
@pytest.mark.parametrize("robot", [-1, 0.5, [0, -2], "zero"])
def test_a_robot_that_is_no_number_from_0_on_is_refused(kind, robot):
    with pytest.raises(InvalidInput, match="robot: whole numbers from 0 on"):
        changed(kind, robot=robot)


@pytest.mark.parametrize("kind", [Bearing, Range])
def test_a_robot_that_measures_itself_is_refused(kind):
    with pytest.raises(InvalidInput, match="a target other than the robot that measures; came robot 3 on itself"):
        changed(kind, robot=[2, 3], target=[1, 3])


@pytest.mark.parametrize("kind", GOOD)
def test_columns_of_unlike_lengths_are_refused_with_their_lengths(kind):
    name = next(name for name in GOOD[kind] if name not in ("robot", "start", "time"))
    value = [1, 1] if name == "target" else [0.1, 0.1]
    with pytest.raises(InvalidInput, match=r"columns of one length; came .*'robot': 3"):
        changed(kind, robot=[2, 3, 4], **{name: value})


def test_tables_are_no_columns():
    with pytest.raises(InvalidInput, match="columns; came shape"):
        changed(Compass, heading=[[0.1, 0.2]])


@pytest.mark.parametrize("kind", GOOD)
def test_a_time_that_is_no_single_number_is_refused(kind):
    with pytest.raises(InvalidInput, match="time"):
        changed(kind, time=[1.0, 2.0])


def test_odometry_that_runs_backwards_in_time_is_refused():
    with pytest.raises(InvalidInput, match=r"from 1\.0 s on; came 0\.5 s"):
        changed(Odometry, start=1.0, time=0.5)


def test_odometry_names_each_robot_once():
    with pytest.raises(InvalidInput, match=r"each robot at most once; came robots \[1, 1\]"):
        changed(Odometry, robot=[1, 1])


@given(
    st.floats(-1e3, 1e3),
    st.floats(0, 2),
    st.one_of(st.floats(0, 0.99), st.just(0.0)),
    st.floats(-1, 1),
    st.floats(-1, 1),
)
def test_an_interval_contains_every_true_value(true, bound, relative, error, relative_error):
    exact = Fraction(true)
    measured = exact * (1 + Fraction(relative) * Fraction(relative_error)) + Fraction(bound) * Fraction(error)
    low, high = interval_of_measured(np.array([float(measured)]), np.array([bound]), np.array([relative]))
    rounding = Fraction(1e-15) * (abs(exact) + Fraction(bound)) * (4 / (1 - Fraction(relative)))
    assert Fraction(float(low[0])) - rounding <= exact <= Fraction(float(high[0])) + rounding


@given(st.floats(-10, 10), st.floats(0, 2), st.floats(0, 0.9), st.sampled_from([0, 1]))
def test_the_ends_of_an_interval_are_possible_true_values(value, bound, relative, end):
    true = interval_of_measured(np.array([value]), np.array([bound]), np.array([relative]))[end][0]
    assert abs(value - true) <= (bound + relative * abs(true)) * (1 + 1e-12) + 1e-12


def test_value_plus_and_minus_the_relative_bound_would_cut_off_the_truth():
    true, relative = 1.0, 0.05
    measured = true * (1 - relative)
    assert measured * (1 + relative) < true
    assert interval_of_measured(np.array([measured]), np.zeros(1), np.array([relative]))[1][0] == pytest.approx(true)


def test_a_distance_is_never_negative():
    low, high = changed(Range, range=0.05, bound=0.2).interval()
    assert low[0] == 0
    assert high[0] == pytest.approx(0.25 / 0.95)


def test_field_names_leave_the_times_out():
    assert field_names(changed(Odometry))[:2] == ["robot", "distance"]
