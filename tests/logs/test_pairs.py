"""Bounds that are pairs: the interval of true values contains the declared one, in exact numbers."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from experiments.logs.reading.pairs import centred, from_zero, without_pairs
from filter import Bearing, Compass, InvalidInput, Range

EDGES = [0.0, -0.0, 5e-324, 1e-16, 0.1, 1.0, -1.0, 1e16, -1e16, 1e100, -1e100]
numbers = st.one_of(st.sampled_from(EDGES), st.floats(-1e100, 1e100), st.floats(-10, 10))
triples = st.tuples(numbers, numbers, numbers).map(lambda each: (each[0], *sorted(each[1:])))


@settings(max_examples=250)
@given(triples)
def test_the_true_value_is_within_the_bound(triple):
    value, low, high = triple
    middle, bound = centred(*triple)
    assert Fraction(middle) - Fraction(bound) <= Fraction(value) - Fraction(high)
    assert Fraction(middle) + Fraction(bound) >= Fraction(value) - Fraction(low)


@settings(max_examples=250)
@given(triples)
def test_the_bound_is_no_wider_than_rounding_makes_it(triple):
    _, bound = centred(*triple)
    width = (Fraction(triple[2]) - Fraction(triple[1])) / 2
    assert Fraction(bound) - width <= 8 * Fraction(np.spacing(np.abs(triple).sum()))


@settings(max_examples=250)
@given(triples)
def test_a_distance_that_is_true_stays_true(triple):
    value, low, high = map(Fraction, triple)
    middle, bound = map(Fraction, from_zero(*centred(*triple)))
    assert middle >= 0
    assert middle + bound >= value - low
    assert middle - bound <= max(value - high, 0)


@settings(max_examples=250)
@given(st.floats(-10, 10), st.floats(0, 20))
@example(-5e-324, 1e-323)
def test_of_an_interval_what_is_at_least_0_is_left(middle, bound):
    least, most = Fraction(middle) - Fraction(bound), Fraction(middle) + Fraction(bound)
    kept, half = map(Fraction, from_zero(middle, bound))
    assert kept >= 0
    assert kept - half <= max(least, 0)
    assert kept + half >= most


@given(numbers, st.floats(0, 1e100))
def test_a_pair_around_zero_is_a_bound(value, bound):
    assert centred(value, -bound, bound) == (value, bound)


def test_what_reads_long_is_nearer():
    assert centred(2.0, 0.0, 0.5) == (1.75, 0.25)
    assert without_pairs(Range, [0.25], [(0.0, 0.75)]) == ([0.125], [0.125])
    assert without_pairs(Range, [0.25], [(0.5, 0.75)]) == ([0.0], [0.0])
    assert without_pairs(Bearing, [0.25], [(0.0, 0.75)]) == ([-0.125], [0.375])


def test_one_value_stands_for_all_and_one_bound_for_all():
    assert without_pairs(Compass, [1.0], [(0.0, 0.5), 0.1]) == ([0.75, 1.0], [0.25, 0.1])
    assert without_pairs(Compass, [1.0, 2.0], [(0.0, 0.5)]) == ([0.75, 1.75], [0.25, 0.25])
    assert without_pairs(Compass, [1.0], []) == without_pairs(Compass, [], []) == ([], [])


def test_a_pair_the_wrong_way_round_is_refused():
    with pytest.raises(InvalidInput, match=r"the lower one first; came \[0.5, 0.1\]"):
        centred(1.0, 0.5, 0.1)
