"""Rows on single robots and on pairs, normal . (x_j - x_i) <= offset, always sorted."""

import numpy as np
import pytest
from helpers.programs import on_robot
from helpers.worlds import exact_slack, unit
from hypothesis import given
from hypothesis import strategies as st

from filter.linear.constraints import WORLD, Constraints

seeds = st.integers(0, 2**32 - 1)


def some_rows(rng, robots=5, count=12):
    i, j = rng.integers(0, robots, count), rng.integers(0, robots, count)
    j = np.where(i == j, (j + 1) % robots, j)
    return Constraints.between(i, j, unit(rng.uniform(-np.pi, np.pi, count)), rng.normal(size=count), np.arange(count))


def columns(rng, robots=4, count=30):
    """Return columns of rows on robots and on pairs in any order, numbered by their sources."""
    pairs = [(i, j) for j in range(robots) for i in range(WORLD, j)]
    i, j = np.array(pairs)[rng.integers(0, len(pairs), count)].reshape(-1, 2).T
    return i, j, unit(rng.uniform(-np.pi, np.pi, count)), rng.normal(size=count), np.arange(count)


@given(seeds, st.integers(1, 6), st.integers(0, 40))
def test_rows_are_sorted_by_robots_and_pairs_whatever_order_they_come_in(seed, robots, count):
    """Single robots come first, and within a robot or a pair rows keep their order; the columns of a row stay together."""
    came = columns(np.random.default_rng(seed), robots, count)
    rows, (i, j, *_) = Constraints(*came), came
    order = sorted(range(count), key=lambda row: (i[row], j[row], row))
    for mine, theirs in zip(rows.columns, came, strict=True):
        assert mine.tolist() == theirs[order].tolist()
        assert mine.dtype == theirs.dtype


@given(seeds)
def test_joined_and_selected_rows_are_sorted_too(seed):
    """The rows of the first part come first within each robot and pair, those of one part in the order they had there."""
    rng = np.random.default_rng(seed)
    one, other = Constraints(*columns(rng, 3)), Constraints(*columns(rng, 5))
    both = Constraints.concatenate([one, other])
    every = [*zip([0] * 30, one.i, one.j, one.source, strict=True), *zip([1] * 30, other.i, other.j, other.source, strict=True)]
    expected = sorted(every, key=lambda row: (row[1], row[2], row[0], row[3]))
    assert both.source.tolist() == [source for _, _, _, source in expected]
    chosen = rng.integers(0, 30, 12)
    again = one.select(chosen)
    wanted = sorted(range(12), key=lambda place: (one.i[chosen[place]], one.j[chosen[place]], place))
    assert again.source.tolist() == one.source[chosen[wanted]].tolist()
    assert again.offset.tolist() == one.offset[chosen[wanted]].tolist()


@given(seeds, st.integers(1, 5), st.sampled_from([0, 1, 5, 30]))
def test_groups_are_the_rows_of_each_pair_and_no_others(seed, robots, count):
    """Also of robots that have no row, beyond the last one that has some, and of those that nobody has asked for before."""
    rows = Constraints(*columns(np.random.default_rng(seed), robots, count))
    asked = np.random.default_rng(seed).permutation([(i, j) for j in range(9) for i in range(WORLD, j)])
    for (i, j), some in zip(asked, map(np.arange, *rows.groups(*asked.T)), strict=True):
        slowly = [row for row in range(count) if (rows.i[row], rows.j[row]) == (i, j)]
        assert some.tolist() == rows.rows_of(i, j).tolist() == slowly
    none = np.zeros(0, dtype=np.int64)
    assert [each.tolist() for each in rows.groups(none, none)] == [[], []]


@given(seeds, st.integers(1, 5), st.sampled_from([0, 1, 5, 30]))
def test_the_groups_that_there_are_lie_end_to_end(seed, robots, count):
    rows = Constraints(*columns(np.random.default_rng(seed), robots, count))
    i, j, first = rows.grouped()
    there = sorted(set(zip(rows.i.tolist(), rows.j.tolist(), strict=True)))
    assert list(zip(i.tolist(), j.tolist(), strict=True)) == there
    assert (first[0], first[-1]) == (0, count)
    for k, pair in enumerate(there):
        assert np.arange(first[k], first[k + 1]).tolist() == rows.rows_of(*pair).tolist()


def test_rows_on_pairs_in_either_order_say_the_same():
    rng = np.random.default_rng(0)
    i, j, normal, positions = np.array([3, 0]), np.array([1, 2]), unit(np.array([0.3, 2.0])), rng.normal(size=(4, 2))
    rows = Constraints.between(i, j, normal, np.zeros(2), np.array([7, 8]))
    assert (rows.i < rows.j).all()
    assert rows.source.tolist() == [8, 7]
    came = rows.source - 7
    said = (rows.normal * (positions[rows.j] - positions[rows.i])).sum(axis=1)
    assert said.tolist() == (normal * (positions[j] - positions[i])).sum(axis=1)[came].tolist()


def test_the_matrix_gives_what_each_row_says():
    rng = np.random.default_rng(1)
    pairs = some_rows(rng)
    alone = on_robot(4, unit(np.array([1.0, -2.0])), np.zeros(2), np.zeros(2, dtype=int))
    rows = Constraints.concatenate([pairs, alone])
    positions = rng.normal(size=(6, 2))
    other = np.where((rows.i == WORLD)[:, None], 0.0, positions[rows.i])
    assert rows.matrix(6) @ positions.ravel() == pytest.approx((rows.normal * (positions[rows.j] - other)).sum(axis=1))
    assert rows.matrix(6).shape == (len(rows), 12)


def test_no_rows_make_a_matrix_without_rows():
    nothing = some_rows(np.random.default_rng(0)).select(np.zeros(0, dtype=int))
    assert nothing.matrix(3).shape == (0, 6)
    assert len(Constraints.concatenate([nothing, nothing])) == 0


def test_rows_are_selected_by_index_and_by_mask():
    rows = some_rows(np.random.default_rng(2))
    chosen = np.array([3, 5])
    assert rows.select(chosen).source.tolist() == rows.source[chosen].tolist()
    assert sorted(rows.select(rows.source > 9).source) == [10, 11]
    assert len(rows.select(rows.source > 99)) == 0


@given(st.floats(-1e9, 1e9), st.floats(-1e9, 1e9))
def test_a_shift_never_ends_below_the_exact_sum(offset, by):
    row = on_robot(0, np.array([[1.0, 0.0]]), np.array([offset]), np.array([0])).shifted(np.array([by]))
    assert exact_slack([1.0, 1.0], row.offset[0], [offset, by]) >= 0
    assert row.offset[0] == pytest.approx(offset + by, abs=1e-14 * (abs(offset) + abs(by)))


def test_rows_cannot_be_changed():
    rows = some_rows(np.random.default_rng(3))
    for name in ("i", "j", "normal", "offset", "source"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(rows, name)[0] = 0


@pytest.mark.parametrize("seed", range(5))
def test_the_rows_of_a_pair_are_those_and_no_others(seed):
    """Also of robots that have none, beyond the last robot that has some."""
    rng = np.random.default_rng(seed)
    rows = some_rows(rng, robots=int(rng.integers(2, 6)), count=int(rng.integers(0, 9)))
    rows = Constraints.concatenate([rows, on_robot(1, unit(np.array([0.5])), np.zeros(1), np.array([99]))])
    for i in range(WORLD, 9):
        for j in range(max(i, WORLD) + 1, 9):
            assert sorted(rows.rows_of(i, j)) == np.flatnonzero((rows.i == i) & (rows.j == j)).tolist()
