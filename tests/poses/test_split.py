"""Where a cell is split: always within it, through what it is too wide for, and only if that says something."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.angles import wrap
from filter.geometry.polygon import Polygon
from filter.poses.cell import CELL_CORNERS, Said, Scale, cut
from filter.poses.cone import directions
from filter.poses.split import OFF_THE_EDGE, where_to_split

seeds = st.integers(0, 2**32 - 1)
SQUARE = np.array([[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [0.0, 1.0]])
SCALE = Scale(10.0, 1e-10, np.empty((CELL_CORNERS + 2, 2)))


def said(points, *sectors, own=True):
    """Return what was said by one robot of one target, a set of points."""
    many = len(sectors)
    return Said(np.array(sectors), np.full(many, own), np.array([0, many]), points, np.array([0, len(points)]), np.radians(30))


def ranged(least, greatest):
    return 0.0, np.pi, least, greatest


def seen(bearing, bound):
    return bearing, bound, 0.0, np.inf


def split(cell, told, heading=(0.0, np.pi)):
    """Return how badly a cell is too wide, and the line to split it along."""
    room = np.zeros((CELL_CORNERS, 2))
    room[: len(cell)] = cell
    need, *line = where_to_split((room, np.array(heading)), len(cell), told, SCALE)
    return need, np.array(line)


def halves(cell, line):
    for side in (1.0, -1.0):
        room = np.zeros((CELL_CORNERS, 2))
        room[: len(cell)] = cell
        yield room[: cut(room, len(cell), tuple(side * line), SCALE)]


def test_a_cell_around_a_beacon_is_split_through_it_across_its_longer_side():
    need, line = split(SQUARE, said(np.array([[0.6, 0.4]]), ranged(0.5, 0.6)))
    assert need > 1
    assert line.tolist() == [1.0, 0.0, 0.6]


def test_a_cell_beside_a_beacon_is_split_along_the_middle_of_its_directions():
    mark = np.array([[-1.0, 0.5]])
    _, line = split(SQUARE, said(mark, ranged(1.5, 1.6)))
    assert np.abs(line[:2]).tolist() == pytest.approx([0, 1], abs=1e-12)
    assert abs(line[2]) == pytest.approx(0.5)
    whole = directions(SQUARE, 4, mark, 1.5, 1e-10)[1]
    for half in halves(SQUARE, line):
        assert directions(half, len(half), mark, 1.5, 1e-10)[1] == pytest.approx(whole / 2, abs=0.1)


@given(seeds)
def test_a_line_leaves_something_to_both_sides_and_halves_directions_in_time(seed):
    rng = np.random.default_rng(seed)
    cell = Polygon.hull(rng.normal(size=(7, 2))).vertices
    mark = rng.normal(size=(1, 2)) * rng.choice([0.3, 1.0, 3.0])
    need, line = split(cell, said(mark, ranged(0.9, 0.9 + 10.0 ** rng.uniform(-3, 0))))
    if need > 0:
        along = cell @ line[:2]
        hair = OFF_THE_EDGE / 2 * np.ptp(along)
        assert along.min() + hair < line[2] < along.max() - hair
        assert all(len(half) > 2 for half in halves(cell, line))


def test_what_comes_from_the_width_of_the_target_is_little_reason_to_split():
    large = np.array([[-4.0, -3.0], [-1.0, -3.0], [-1.0, 4.0], [-4.0, 4.0]])
    tiny = SQUARE * 1e-4
    point, sets = (split(tiny, said(points, ranged(1.5, 1.6)))[0] for points in (large[:1] / 3, large))
    assert max(sets, split(SQUARE, said(large, ranged(1.5, 1.6)))[0]) < 0.1
    assert split(SQUARE, said(large[:1] / 3, ranged(1.5, 1.6)))[0] > 0.3
    assert point < 0.02  # a tiny cell is no reason either
    assert split(SQUARE, said(np.array([[30.0, 0.5]]), ranged(20.0, 40.0)))[0] < 0.02


@pytest.mark.parametrize(("own", "many", "is_split"), [(True, 2, True), (True, 1, False), (False, 2, False)])
def test_a_heading_is_split_in_its_middle_for_several_bearings_of_its_own(own, many, is_split):
    told = said(np.array([[5.0, 5.0]]), *[seen(0.1 * k, 0.05) for k in range(many)], own=own)
    need, line = split(SQUARE, told, (0.7, 0.4))
    assert (need == pytest.approx(0.4 / 0.05)) == is_split
    assert wrap(line[2] - 0.7) == pytest.approx(0) if is_split else need == 0
    assert not is_split or line[:2].tolist() == [0.0, 0.0]
