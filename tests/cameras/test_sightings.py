"""Bearings of landmarks and their ranges, put together by pairs."""

import numpy as np
import pytest

from filter import Bearing, Compass, Range
from filter.cameras.sightings import FARTHEST, Sightings

RECORDS = (
    Bearing(0.0, [0, 1, 0, 2], [1, 5, 4, 3], [0.1, 0.2, 0.3, 0.4], [0.01, 0.02, 0.03, 0.04]),
    Range(0.0, [0, 1, 2], [4, 5, 0], [2.0, 3.0, 1.0], 0.1, 0.0),
    Compass(0.0, [2], [1.5], [0.2]),
)


def columns(records):
    return [column.tolist() for column in Sightings.of(records, 3).columns]


def test_a_landmarks_bearing_and_range_are_one_sighting():
    robot, landmark, bearing, bound, distance, half = columns(RECORDS)
    assert (robot, landmark) == ([0, 1, 2], [1, 2, 0])
    assert (bearing, bound) == ([0.3, 0.2, 0.4], [0.03, 0.02, 0.04])
    assert distance == pytest.approx([2.0, 3.0, FARTHEST / 2])  # how far the last is, nobody has measured
    assert half == pytest.approx([0.1, 0.1, FARTHEST / 2])


def test_the_second_bearing_of_a_pair_goes_with_its_second_range():
    records = [
        Bearing(0.0, [0, 0, 0], 3, [0.1, 0.2, 0.3], 0.1),
        Range(0.0, 0, 3, 1.0, 0.1, 0.0),
        Range(0.0, 0, 3, 2.0, 0.1, 0.0),
    ]
    assert columns(records)[4] == pytest.approx([1.0, 2.0, FARTHEST / 2])


def test_the_order_of_records_and_rows_makes_no_difference():
    rng = np.random.default_rng(0)
    for _ in range(5):
        order, some = rng.permutation(4), rng.permutation(3)
        bearing = Bearing(0.0, *(getattr(RECORDS[0], name)[order] for name in ("robot", "target", "bearing", "bound")))
        assert columns([(bearing, *RECORDS[1:])[k] for k in some]) == columns(RECORDS)


def test_what_says_nothing_of_a_landmark_is_left_out():
    away = [Bearing(0.0, 0, 3, 0.1, 0.1, sensor=0), Bearing(0.0, 0, 3, 0.1, np.pi), Bearing(0.0, 0, 1, 0.1, 0.1)]
    assert columns(away) == columns([]) == [[]] * 6
