"""Arcs are sets: what an operation returns contains everything that it could give."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.worlds import unit
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.angles import AngularIntervals, wrap

# Pi to 50 digits: the float is off by 1.2e-16, and each turn by twice that.
PI = Fraction("3.14159265358979323846264338327950288419716939937510")
# Nothing is farther from what was asked than this [rad].
NEAR = 1e-12

angles = st.one_of(
    st.floats(-7, 7), st.sampled_from([0.0, np.pi, -np.pi, np.pi / 2, -np.pi / 2, np.nextafter(np.pi, 0), 1e-300])
)
bounds = st.one_of(st.floats(0, np.pi), st.sampled_from([0.0, 1e-15, np.pi / 2, np.nextafter(np.pi, 0), np.pi]))


def arc(centre, bound):
    return AngularIntervals(np.atleast_1d(centre), np.atleast_1d(bound))


def exactly_in(arcs, k, angle):
    """Return whether arc k contains an angle given as a fraction, without any rounding."""
    difference = angle - Fraction(float(arcs.centre[k]))
    turns = round(difference / (2 * PI))
    return bool(arcs.full[k]) or abs(difference - 2 * turns * PI) <= Fraction(float(arcs.bound[k]))


def spread(centre, bound, count=9):
    """Return angles all over an arc, both ends included, as fractions."""
    return [
        Fraction(float(centre)) + Fraction(2 * k, count - 1) * Fraction(float(bound)) - Fraction(float(bound))
        for k in range(count)
    ]


@given(st.floats(-1e3, 1e3))
def test_wrapping_keeps_the_direction_and_the_interval(angle):
    wrapped = float(wrap(angle))
    assert -np.pi < wrapped <= np.pi
    assert np.abs(unit(wrapped) - unit(angle)).max() < NEAR


@pytest.mark.parametrize("angle", [np.pi, -np.pi, 3 * np.pi, -3 * np.pi])
def test_the_angle_behind_is_always_plus_pi(angle):
    assert wrap(angle) == pytest.approx(np.pi)


@given(st.floats(-np.pi, np.pi, exclude_min=True), bounds)
def test_an_arc_contains_everything_that_it_was_made_of(centre, bound):
    made = arc(centre, bound)
    assert all(exactly_in(made, 0, angle) for angle in spread(centre, bound))


@given(angles, bounds, angles, st.floats(0, np.pi))
def test_a_turned_arc_contains_every_angle_after_every_turn(centre, bound, by, doubt):
    before = arc(centre, bound)
    turned = before.turned(by, doubt)
    for angle in spread(before.centre[0], before.bound[0], 5):
        for turn in spread(by, doubt, 5):
            assert exactly_in(turned, 0, angle + turn)


@given(angles, bounds, angles, bounds)
def test_an_intersection_contains_everything_in_both_arcs(centre, bound, other_centre, other_bound):
    one, other = arc(centre, bound), arc(other_centre, other_bound)
    common = one.intersection(other)
    candidates = spread(one.centre[0], one.bound[0], 33) + spread(other.centre[0], other.bound[0], 33)
    for angle in candidates:
        if exactly_in(one, 0, angle) and exactly_in(other, 0, angle):
            assert exactly_in(common, 0, angle)


@given(angles, bounds, angles, bounds)
def test_an_intersection_is_no_wider_than_either_arc(centre, bound, other_centre, other_bound):
    common = arc(centre, bound).intersection(arc(other_centre, other_bound))
    assert common.bound[0] <= min(bound, other_bound) + NEAR


@given(angles, bounds, angles, bounds)
def test_an_intersection_is_empty_exactly_when_the_arcs_are_apart(centre, bound, other_centre, other_bound):
    apart = abs(float(wrap(centre - other_centre))) - bound - other_bound
    common = arc(centre, bound).intersection(arc(other_centre, other_bound))
    if apart > NEAR:
        assert common.empty[0]
    if apart < 0:
        assert not common.empty[0]


def test_wide_arcs_that_meet_at_both_ends_keep_both_ends():
    common = arc(0.0, 2.0).intersection(arc(np.pi, 2.0))
    assert exactly_in(common, 0, Fraction(2) - Fraction(1, 1000))
    assert exactly_in(common, 0, Fraction(-2) + Fraction(1, 1000))


def test_narrow_arcs_across_plus_and_minus_pi_meet():
    common = arc(np.pi - 0.1, 0.2).intersection(arc(-np.pi + 0.1, 0.2))
    assert common.centre[0] == pytest.approx(np.pi) or common.centre[0] == pytest.approx(-np.pi)
    assert common.bound[0] == pytest.approx(0.1)


def test_a_whole_circle_changes_nothing():
    known, circle = arc([1.0, -3.0], [0.25, 3.0]), AngularIntervals.circles(2)
    for common in (known.intersection(circle), circle.intersection(known)):
        assert common.centre.tolist() == known.centre.tolist()
        assert common.bound.tolist() == known.bound.tolist()


def test_two_equal_points_have_the_point_in_common():
    common = arc(1.25, 0.0).intersection(arc(1.25, 0.0))
    assert not common.empty[0]
    assert common.contains(1.25)[0]


def test_an_empty_arc_stays_empty():
    nothing = arc(0.0, -1.0)
    assert nothing.empty[0]
    assert nothing.turned(1.0, 3.0).empty[0]
    assert nothing.intersection(AngularIntervals.circles(1)).empty[0]


@given(angles, bounds, angles)
def test_contains_agrees_with_exact_arithmetic(centre, bound, angle):
    made = arc(centre, bound)
    distance = abs(float(wrap(angle - centre))) - bound
    if abs(distance) > NEAR:
        assert made.contains(angle)[0] == (distance < 0)


def test_a_full_arc_is_never_wider_than_the_circle():
    assert arc(0.0, 3.0).turned(0.0, 3.0).full[0]
    assert arc(0.0, 100.0).bound[0] == np.pi


def test_some_arcs_are_replaced_and_the_others_stay():
    arcs = arc([0.1, 0.2, 0.3], [0.01, 0.02, 0.03]).replaced(np.array([2, 0]), arc([1.0, 2.0], [0.5, 0.6]))
    assert arcs.centre == pytest.approx([2.0, 0.2, 1.0])
    assert arcs.bound == pytest.approx([0.6, 0.02, 0.5])


@pytest.mark.parametrize(("centre", "bound"), [(np.nan, 0.1), (np.inf, 0.1), (0.0, np.nan)])
def test_an_arc_of_no_number_is_refused(centre, bound):
    with pytest.raises(ValueError, match="finite"):
        arc(centre, bound)
