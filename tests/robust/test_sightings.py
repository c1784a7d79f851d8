"""Bearings and ranges of one instant, put together by pairs."""

import numpy as np
import pytest

from filter import Bearing, Compass, Range
from filter.robust.robust_filter import sightings_in
from filter.robust.slices import FARTHEST

RECORDS = (
    Bearing(0.0, [0, 1, 0], [1, 5, 4], [0.1, 0.2, 0.3], [0.01, 0.02, 0.03]),
    Range(0.0, [0, 1, 2], [4, 5, 0], [2.0, 3.0, 1.0], 0.1, 0.0),
    Compass(0.0, [2], [1.5], [0.2]),
)


def test_a_pairs_bearing_and_range_are_one_sighting():
    sector = {(robot, target): sector for robot, target, sector in sightings_in(RECORDS, robots=3)}
    assert list(sector) == [(2, 2), (0, 4), (1, 5), (0, 1), (2, 0)]  # compass, landmarks, team mates
    assert sector[2, 2][:2] == pytest.approx([1.5, 0.2])
    assert sector[0, 4] == pytest.approx([0.3, 0.03, 1.9, 2.1], abs=1e-7)
    assert sector[0, 1][2:].tolist() == [0, FARTHEST]  # how far, nobody has measured
    assert sector[2, 0] == pytest.approx([0, np.pi, 0.9, 1.1], abs=1e-7)  # which way, nobody has measured


def test_they_err_outward():
    ((bearing, bound, least, greatest),) = [sector for _, target, sector in sightings_in(RECORDS, robots=3) if target == 5]
    assert (bearing, bound > 0.02, least < 2.9, greatest > 3.1) == (0.2, True, True, True)


def test_the_order_of_records_and_rows_makes_no_difference():
    rng, straight = np.random.default_rng(0), sightings_in(RECORDS, robots=3)
    for _ in range(5):
        order = rng.permutation(3)
        bearing = Bearing(0.0, *(getattr(RECORDS[0], name)[order] for name in ("robot", "target", "bearing", "bound")))
        mixed = sightings_in([(bearing, *RECORDS[1:])[k] for k in order], robots=3)
        assert [(*pair, *sector) for *pair, sector in mixed] == [(*pair, *sector) for *pair, sector in straight]


def test_nothing_seen_is_nothing():
    assert sightings_in([], robots=3) == []
