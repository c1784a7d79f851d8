"""Positions that are seen, as bearings and ranges that hold all of their boxes."""

import numpy as np
import pytest

from filter import InvalidInput, seen_position, wrap


def test_every_place_in_the_box_is_within_what_is_seen():
    rng, behind, around = np.random.default_rng(0), 0, 0
    for _ in range(10_000):
        scale = 10.0 ** rng.integers(-6, 5)
        middle, half = scale * rng.choice([-1.0, 0.0, 1.0, 0.3], 2), scale * rng.choice([0.0, 0.25, 1.0, 1e-9], 2)
        bearing, reach = seen_position(0.0, 0, 1, middle, half)
        place = middle + half * rng.choice([-1.0, 1.0, rng.uniform(-1, 1)], 2)
        (least,), (greatest,) = reach.interval()
        assert least <= np.hypot(*place) <= greatest
        off = abs(float(wrap(np.arctan2(place[1], place[0]) - bearing.bearing[0])))
        assert off <= bearing.bound[0]
        around += bool((bearing.bound == np.pi).all())
        behind += bool(np.abs(bearing.bearing[0]) + bearing.bound[0] > np.pi and bearing.bound[0] < 2)
    assert min(behind, around) > 500


def test_what_is_seen_is_hardly_more_than_the_box():
    bearing, reach = seen_position(0.0, 0, 1, [-2.0, 0.0], [0.5, 0.3], 0, 1)
    (least,), (greatest,) = reach.interval()
    assert (least, greatest) == pytest.approx((1.5, np.hypot(2.5, 0.3)), abs=1e-12)
    assert bearing.bound[0] == pytest.approx(np.arctan2(0.3, 1.5), abs=1e-12)
    assert abs(bearing.bearing[0]) == pytest.approx(np.pi)
    assert (bearing.sensor[0], bearing.target_sensor[0]) == (reach.sensor[0], reach.target_sensor[0]) == (0, 1)
    with pytest.raises(InvalidInput, match="one ahead and one to the left"):
        seen_position(0.0, 0, 1, [1, 1], [1, 1, 1])
