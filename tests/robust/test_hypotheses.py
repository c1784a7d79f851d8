"""Slices of one robot's poses: their hull, their arc, and their polygons."""

import numpy as np
import pytest

from filter.geometry.angles import wrap
from filter.geometry.polygon import Polygon
from filter.poses.slices import AGREED, EARLIER
from filter.robust.hypotheses import Hypotheses, polygon_of, reach_of


def drawn(rng, count=6):
    """Return slices of narrow arcs within a part of the circle, anywhere in it and turns away from it."""
    first, part = rng.uniform(-np.pi, np.pi), rng.uniform(0.1, 5.5)
    low = first + rng.uniform(0, part, count)
    low += 2 * np.pi * rng.integers(-2, 3, count)
    reach = np.array([reach_of(Polygon.from_vertices(rng.normal(size=(5, 2)))) for _ in range(count)])
    return Hypotheses(rng.choice([AGREED, EARLIER, 3], count), low, low + rng.uniform(0, 0.3, count), reach)


def poses(known, rng):
    """Return a heading and a place out of each slice."""
    headings = known.low + rng.uniform(0, 1, len(known)) * (known.high - known.low)
    return headings, np.array([polygon_of(reach).centroid for reach in known.reach])


@pytest.mark.parametrize("seed", range(20))
def test_the_arc_and_the_hull_contain_every_pose(seed):
    rng = np.random.default_rng(seed)
    known = drawn(rng)
    headings, places = poses(known, rng)
    centre, bound = known.heading()
    assert (np.abs(wrap(headings - centre)) <= bound).all()
    assert polygon_of(known.hull()).contains(places).all()


@pytest.mark.parametrize("seed", range(20))
def test_the_arc_contains_slices_on_both_sides_of_zero(seed):
    """Some begin just before a full turn and some just after, and either can be the longest."""
    rng = np.random.default_rng(seed)
    low = rng.uniform(-0.02, 0.02, 8)
    high = low + rng.uniform(0, 0.04, 8)
    reach = np.repeat(drawn(rng, 1).reach, 8, axis=0)
    centre, bound = Hypotheses(np.full(8, AGREED), low, high, reach).heading()
    assert (wrap(low - centre) >= -bound).all()
    assert (wrap(high - centre) <= bound).all()
    assert bound <= (high.max() - low.min()) / 2 + 1e-9


@pytest.mark.parametrize("seed", range(20))
def test_the_arc_is_the_narrowest(seed):
    known = drawn(np.random.default_rng(seed))
    _, bound = known.heading()
    ends = np.concatenate([known.low, known.high])
    covers = [np.mod(np.concatenate([known.low, known.high]) - end + 1e-9, 2 * np.pi).max() for end in ends]
    assert bound <= min(covers) / 2 + 1e-8


@pytest.mark.parametrize("seed", range(10))
def test_cut_anew_every_pose_stays_in_a_slice_of_its_vote(seed):
    rng = np.random.default_rng(seed)
    known = drawn(rng)
    headings, places = poses(known, rng)
    anew = known.cut_anew(72)
    assert anew.refitted(72) is anew
    for vote, heading, place in zip(known.without, headings, places, strict=True):
        turns = np.arange(-4, 5) * 2 * np.pi
        within = ((anew.low[:, None] <= heading + turns) & (heading + turns <= anew.high[:, None])).any(axis=1)
        around = [bool(polygon_of(reach).contains(place)) for reach in anew.reach]
        assert (within & np.array(around) & (anew.without == vote)).any()


def test_a_circle_of_slices_says_nothing_of_the_heading():
    whole = Hypotheses.agreed(reach_of(Polygon.box([0, 0], [1, 1]))).cut_anew(72)
    assert len(whole) == 72
    assert whole.heading()[1] == np.pi


def test_a_polygon_by_its_supports_is_around_the_polygon():
    rng = np.random.default_rng(0)
    for _ in range(20):
        polygon = Polygon.from_vertices(rng.normal(size=(6, 2)))
        around = polygon_of(reach_of(polygon))
        assert (around.support(polygon.normals) >= polygon.support(polygon.normals) - 1e-12).all()
        assert reach_of(around) == pytest.approx(reach_of(polygon), abs=1e-12)
