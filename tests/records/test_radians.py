"""Angles that can only be degrees are refused, honest ones are not; compasses in degrees become arcs with the truth inside."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from filter import Bearing, Compass, InvalidInput, Polygon, SetMembershipFilter, Team, wrap

PI = Fraction(3141592653589793238462643383279502884197169399375105820974944592307816406286, 10**75)
TWO_TURNS, FOUR_TURNS = 4 * np.pi, 8 * np.pi
BEYOND, FAR_BEYOND = np.nextafter(TWO_TURNS, 13), np.nextafter(FOUR_TURNS, 26)
ABOVE_90 = np.nextafter(np.pi / 2, 2)


def test_bearings_in_degrees_are_refused_and_the_hint_says_what_to_do():
    for value in (45.0, -45.0, 350.0, 26.0, [0.1, 90.0], [-90.0, 0.1], FAR_BEYOND, -FAR_BEYOND):
        with pytest.raises(InvalidInput, match=r"bearing \[rad\].*numpy.radians.*wrap.*; came -?(45|350|2[56]|90)\."):
            Bearing(0.0, 0, 1, value, 0.05)


@given(st.lists(st.floats(-np.pi, np.pi), min_size=3, max_size=3), st.floats(0, 1.5), st.floats(-1, 1))
@example([np.pi, -np.pi, -np.pi], 1.5, 1.0)
def test_the_difference_of_angles_that_were_wrapped_is_taken_with_any_error(angles, bound, share):
    """Direction in the world, less the heading, less how the sensor is mounted."""
    measured = angles[0] - angles[1] - angles[2] + share * bound
    assert Bearing(0.0, 0, 1, measured, bound).bearing.item() == measured


def test_four_turns_are_just_taken():
    assert len(Bearing(0.0, 0, 1, [FOUR_TURNS, -FOUR_TURNS], 0.0).bearing) == 2


def test_a_bearing_less_a_yaw_that_was_not_wrapped_for_two_turns_is_taken():
    yaw = np.linspace(0, 2 * TWO_TURNS - np.pi, 50)
    assert len(Bearing(0.0, 0, 1, np.pi - yaw, 0.05).bearing) == 50


def test_headings_in_degrees_with_bounds_in_degrees_are_refused():
    for value, bound in ((350.0, 2.0), (-350.0, 3.0), (90.0, 1.6), ([0.1, 90.0], [3.0, 3.0]), (BEYOND, ABOVE_90)):
        with pytest.raises(InvalidInput, match=r"heading \[rad\].*Compass.from_north"):
            Compass(0.0, 0, value, bound)
    with pytest.raises(InvalidInput, match=r"compass bound \[rad\]"):
        Compass(0.0, 0, 90.0, 5.0)


@given(st.floats(-1e6, 1e6), st.floats(0, np.pi / 2))
def test_a_yaw_that_was_never_wrapped_is_taken(yaw, bound):
    assert Compass(0.0, 0, yaw, bound).heading.item() == yaw


@given(st.floats(-TWO_TURNS, TWO_TURNS), st.floats(0, np.pi))
def test_a_heading_within_two_turns_is_taken_with_any_bound(heading, bound):
    assert Compass(0.0, 0, heading, bound).bound.item() == bound


def test_a_heading_that_says_nothing_is_taken_whatever_it_is_and_refuses_no_other():
    assert len(Compass(0.0, 0, [100.0, 500.0], [0.1, np.pi]).heading) == 2


@given(st.floats(-1000, 1000), st.floats(0, 180), st.floats(-180, 180), st.sampled_from([-1, 0, 1]))
@example(0.0, 0.0, 0.0, 1)
@example(270.0, 0.0, 0.0, 0)
@example(359.9999999999999, 180.0, -180.0, 1)
def test_the_true_heading_is_within_the_bound_of_a_compass_in_degrees(measured, bound, declination, side):
    """In fractions: whatever the true heading is within the declared bound, its yaw is within that of the record."""
    record = Compass.from_north(0.0, 0, measured, bound, declination)
    true = 90 - (Fraction(measured) - side * Fraction(bound) + Fraction(declination))
    off = true * PI / 180 - Fraction(record.heading.item())
    off -= 2 * PI * round(off / (2 * PI))
    assert -np.pi < record.heading.item() <= np.pi
    assert abs(off) <= Fraction(record.bound.item()) + (Fraction(1, 10**15) if bound == 180 else 0)
    assert record.bound.item() <= np.radians(bound) + 1e-12


def test_a_compass_in_degrees_has_the_columns_of_any_other():
    record = Compass.from_north(1.5, [0, 1], [0.0, 90.0], 5.0, declination=[4.0, 4.0], sensor=0)
    assert np.degrees(record.heading) == pytest.approx([86, -4])
    assert np.degrees(record.bound) == pytest.approx([5, 5])
    assert (record.time, record.robot.tolist(), record.sensor.tolist()) == (1.5, [0, 1], [0, 0])
    assert Compass.from_north(0.0, 0, 10.0, 5.0).sensor.tolist() == [-1]


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"bound": -1.0}, r"compass bound \[degrees\]"),
        ({"bound": 181.0}, r"compass bound \[degrees\]"),
        ({"degrees": np.nan}, r"heading \[degrees\]"),
        ({"declination": 200.0}, r"declination \[degrees\]"),
        ({"degrees": "north"}, r"heading \[degrees\]"),
        ({"degrees": [1.0, 2.0], "bound": [1.0, 2.0, 3.0]}, "one length"),
        ({"degrees": [1.0, 2.0], "declination": [1.0, 2.0, 3.0]}, "one length"),
    ],
)
def test_what_no_compass_says_is_refused(changed, words):
    with pytest.raises(InvalidInput, match=words):
        Compass.from_north(0.0, 0, **{"degrees": 350.0, "bound": 2.0} | changed)


def test_a_filter_takes_what_a_compass_says_in_degrees():
    filter_ = SetMembershipFilter(Team(1, [[3.0, 0.0]]))
    known = filter_.update(
        filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])]), [Compass.from_north(0.0, 0, 350.0, 2.0, declination=4.2)]
    )
    assert known.headings.centre.item() == pytest.approx(wrap(np.radians(90 - 354.2)).item())
    assert np.degrees(known.headings.bound.item()) == pytest.approx(2.0, abs=1e-6)
