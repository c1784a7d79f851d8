"""Cuts of slices: a pose from which something is seen stays, whoever of several it was."""

from functools import partial

import numpy as np
import pytest

from filter.geometry.polygon import Polygon
from filter.robust.hypotheses import Hypotheses, polygon_of, reach_of
from filter.robust.slices import see_any, see_body

SECTOR = np.array([0.4, 0.1, 1.5, 2.5])  # bearing, its bound, least and greatest range


def known(half=3.0):
    return Hypotheses.agreed(reach_of(Polygon.box([-half, -half], [half, half])), 0.0, 0.6).cut_anew(72)


def holds(slices, position, heading):
    """Return whether a pose is in one of the slices."""
    there = [bool(polygon_of(reach).contains(position)) for reach in slices.reach]
    return bool((there & (slices.low <= heading) & (heading <= slices.high)).any())


def body(rng):
    centre = rng.uniform(-2, 2, 2)
    return centre, reach_of(Polygon.box(centre - 0.2, centre + 0.2))


@pytest.mark.parametrize("seed", range(10))
def test_a_pose_from_which_one_of_several_is_seen_stays(seed):
    rng = np.random.default_rng(seed)
    places, bodies = zip(*(body(rng) for _ in range(3)), strict=True)
    left = known().cut(partial(see_any, bodies, SECTOR))
    for place in places:
        heading, distance = rng.uniform(0, 0.6), rng.uniform(1.5, 2.5)
        way = heading + SECTOR[0] + rng.uniform(-0.1, 0.1)
        position = place - distance * np.array([np.cos(way), np.sin(way)])
        if np.abs(position).max() < 3:
            assert holds(left, position, heading)


def test_of_one_body_it_is_the_same_as_seeing_it():
    rng = np.random.default_rng(1)
    _, reach = body(rng)
    one, any_ = known().cut(partial(see_body, reach, SECTOR)), known().cut(partial(see_any, [reach], SECTOR))
    np.testing.assert_array_equal(one.reach, any_.reach)
    np.testing.assert_array_equal(one.low, any_.low)
    np.testing.assert_array_equal(one.high, any_.high)


def test_what_sees_none_of_them_goes():
    far = reach_of(Polygon.box([20, 20], [21, 21]))
    assert len(known().cut(partial(see_any, [far, far], SECTOR))) == 0
