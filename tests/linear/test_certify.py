"""Bounds in loops: proved in exact arithmetic whatever the multipliers, and the same as those of the whole program."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.worlds import claims_of, exact_claim, unit
from hypothesis import given
from hypothesis import strategies as st

from filter.linear.certify import certified, members_at
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope

ROBOTS, ROWS = 5, 24
ORIGINS = (0.0, 1.0, 5e6)

seeds = st.integers(0, 2**32 - 1)


def team(rng, origin=0.0, size=1.0):
    """Return a polytope of rows on robots and pairs, of which one robot is anchored."""
    pairs = np.array([(i, j) for j in range(ROBOTS) for i in range(WORLD, j)])[rng.integers(0, 15, ROWS)]
    lower = origin + size * rng.uniform(-1, 0, (ROBOTS, 2))
    upper = lower + size * rng.uniform(0, 1, (ROBOTS, 2))
    upper[2] = lower[2]
    rows = Constraints(*pairs.T, unit(rng.uniform(-np.pi, np.pi, ROWS)), np.zeros(ROWS), np.arange(ROWS))
    middle = ((lower + upper) / 2).ravel()
    offsets = rows.matrix(ROBOTS) @ middle + size * rng.uniform(0, 1, ROWS)
    return Polytope(Constraints(rows.i, rows.j, rows.normal, offsets, rows.source), lower, upper)


def among(polytope, members):
    """Return the places of some robots, and the rows that are on them alone."""
    place, box, rows = np.full(ROBOTS, -1), (polytope.lower, polytope.upper), polytope.constraints
    inside = np.isin(rows.j, members) & ((rows.i == WORLD) | np.isin(rows.i, members))
    return members_at(np.asarray(members), place, box), np.flatnonzero(inside)


def drawn(seed, origin, size=1.0):
    """Return a team, who is asked of, the direction, everybody's places, and some rows."""
    rng = np.random.default_rng(seed)
    polytope, j = team(rng, origin, size), int(rng.integers(1, ROBOTS))
    members, number = among(polytope, rng.permutation(ROBOTS))
    return rng, polytope, (int(rng.integers(WORLD, j)), j), unit(rng.uniform(-np.pi, np.pi)), members, number


def excess(polytope, pair, normal, offset, used):
    """Return by how much a claim is below what its multipliers prove, without any rounding."""
    whose = np.array([pair[0]]), np.array([pair[1]])
    proof = claims_of(polytope, whose, (normal[None], np.array([offset])), (used[0][None], used[1][None]))
    return exact_claim(proof, 0)


@given(seeds, st.sampled_from(ORIGINS), st.sampled_from([1e-9, 1.0, 1e4]), st.sampled_from(["few", "tiny", "huge", "none"]))
def test_an_offset_is_never_below_what_the_multipliers_prove_and_hardly_above(seed, origin, size, kind):
    rng, polytope, pair, normal, members, number = drawn(seed, origin, size)
    prices = {
        "few": rng.uniform(0, 1, ROWS) * (rng.random(ROWS) < 0.3),
        "tiny": rng.exponential(1, ROWS) * 10.0 ** rng.uniform(-300, 0, ROWS),
        "huge": rng.exponential(1, ROWS) * 10.0 ** rng.uniform(0, 6),
        "none": np.zeros(ROWS),
    }[kind]
    offset = certified(*pair, normal, prices, number, members, polytope.constraints.rows)
    below = excess(polytope, pair, normal, offset, (number, prices))
    scale = (1 + prices.sum()) * (size + polytope.upper.max() - polytope.lower.min() + np.abs(polytope.lower).max())
    assert below <= 0
    assert float(-below) <= 1e-12 * scale + 1e-290


@given(seeds, st.sampled_from([0.0, 5e6]))
def test_it_is_the_bound_of_the_whole_program(seed, origin):
    rng, polytope, (i, j), normal, members, number = drawn(seed, origin)
    prices = rng.exponential(0.3, ROWS) * (rng.random(ROWS) < 0.5)
    offset = certified(i, j, normal, prices, number, members, polytope.constraints.rows)
    program, objective, multipliers = polytope.program(), np.zeros(2 * ROBOTS), np.zeros(ROWS)
    objective[2 * j : 2 * j + 2], multipliers[number] = normal, prices
    if i != WORLD:
        objective[2 * i : 2 * i + 2] = -normal
    assert offset == pytest.approx(program.certified_bounds(objective[None], multipliers[None])[0], abs=1e-10 + 1e-13 * origin)


def test_multipliers_that_are_none_and_rows_that_are_none_count_nothing():
    rng, polytope, pair, normal, members, number = drawn(7, 0.0)
    prices, rows = rng.uniform(0.1, 1, ROWS), polytope.constraints.rows
    good = certified(*pair, normal, prices[:20], number[:20], members, rows)
    for wrong in (0.0, -1.0, np.nan, np.inf, -np.inf):
        prices[20:] = wrong
        assert certified(*pair, normal, prices, number, members, rows) == pytest.approx(good, abs=1e-12)
    number[20:] = ROWS + np.arange(4)
    prices[20:] = 1.0
    assert certified(*pair, normal, prices, number, members, rows) == pytest.approx(good, abs=1e-12)


@given(seeds)
def test_members_alone_prove_what_they_prove_among_all(seed):
    """The places of members are theirs, in whatever order; the others have to do with nothing."""
    rng = np.random.default_rng(seed)
    polytope, chosen = team(rng), rng.permutation(ROBOTS)[:3]
    few, number = among(polytope, chosen)
    everybody, _ = among(polytope, np.arange(ROBOTS))
    prices, normal = rng.exponential(1, len(number)), unit(rng.uniform(-np.pi, np.pi))
    pair = WORLD, int(chosen[0])
    offsets = [certified(*pair, normal, prices, number, where, polytope.constraints.rows) for where in (few, everybody)]
    assert offsets[0] == pytest.approx(offsets[1], abs=1e-12)
    assert excess(polytope, pair, normal, offsets[0], (number, prices)) <= 0


numbers = st.one_of(st.floats(-1e9, 1e9), st.sampled_from([0.0, 1e-300, 1.0, np.nextafter(1.0, 2)]))


@given(numbers, numbers)
def test_a_reach_covers_both_ends_of_an_interval(one, other):
    low, high = min(one, other), max(one, other)
    box = np.full((1, 2), low), np.full((1, 2), high)
    _, (middle, _), (reach, _) = members_at(np.array([0]), np.zeros(1, dtype=int), box)
    assert Fraction(middle) - Fraction(reach) <= Fraction(low)
    assert Fraction(high) <= Fraction(middle) + Fraction(reach)
    assert reach <= (high - low) / 2 * (1 + 1e-14) + 4 * np.spacing(max(abs(low), abs(high)))
    assert (reach == 0) == (low == high)


def test_members_are_in_the_order_in_which_they_were_named():
    polytope = team(np.random.default_rng(3))
    (place, centre, radius), _ = among(polytope, [4, 1])
    assert place.tolist() == [-1, 1, -1, -1, 0]
    middle = (polytope.lower + polytope.upper) / 2
    assert centre == pytest.approx(middle[[4, 1]].ravel())
    assert radius == pytest.approx(((polytope.upper - polytope.lower) / 2)[[4, 1]].ravel())
    (_, _, radius), _ = among(polytope, [2])
    assert radius.tolist() == [0.0, 0.0]
