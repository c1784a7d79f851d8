"""The judge of ranges: held against grids, against formulas, and in the degenerate cases that are drawn on purpose."""

import numpy as np
import pytest
from helpers.beacons.hulls import hold, is_within
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.beacons.arcs import area_of, corners_of
from experiments.beacons.rings import Rings, exact_hull, tolerant_hull
from filter import InvalidInput

seeds = st.integers(0, 2**32 - 1)
BOX = np.array([[-6.0, -6.0], [7.0, 6.0]])
ENDLESS = np.array([[-100.0, -100.0], [100.0, 100.0]])
SHAPES = ["any", "on an anchor", "on a line", "close together", "far away", "wide", "at a corner of the box"]


def drawn(rng, shape="any", bound=0.1, anchors=None):
    """Return rings of ranges measured from a place in the box, the place, and the box."""
    count = anchors or int(rng.integers(2, 9))
    place, marks = rng.uniform(*BOX), rng.uniform(BOX[0], BOX[1], (count, 2))
    if shape == "on an anchor":
        place = marks[0].copy()
    if shape == "on a line":
        marks = marks[0] + np.outer(rng.uniform(-3, 3, count), rng.normal(size=2))
    if shape == "close together":
        marks = marks[0] + rng.uniform(-0.05, 0.05, (count, 2))
    if shape == "at a corner of the box":
        place = BOX[0].copy()
    bound = 2.0 if shape == "wide" else bound
    ranges = np.maximum(0, np.hypot(*(marks - place).T) + rng.uniform(-bound, bound, count))
    far = 5e6 if shape == "far away" else 0.0
    return Rings.measured(marks + far, ranges, bound), place + far, BOX + far


def all_agree(rings):
    return lambda points: rings.contains(points).all(axis=1)


def all_but_one_agree(rings, lies):
    """Slow and obvious: count those that hold; of lies that are too long every far side has to."""

    def agree(points):
        distance = np.hypot(*(points[:, None] - rings.centres).transpose(2, 0, 1))
        far, near = distance <= rings.greatest, distance >= rings.least
        enough = (far & near).sum(axis=1) >= len(rings.least) - 1
        return enough & far.all(axis=1) if lies == "long" else enough

    return agree


@settings(max_examples=40)
@given(seeds, st.sampled_from(SHAPES))
def test_the_place_is_in_every_hull_and_hulls_are_in_one_another(seed, shape):
    rings, place, box = drawn(np.random.default_rng(seed), shape)
    slack = 1e-8 * np.abs(box).max()
    exact, long, anything = exact_hull(rings, box), *(tolerant_hull(rings, box, lies) for lies in ("long", "any"))
    for hull in (exact, long, anything):
        assert is_within(hull.around, place[None], slack).all()
        assert is_within(hull.around, hull.inside[::9], slack).all()
    for inner, outer in ((exact, long), (long, anything)):
        assert is_within(outer.around, inner.inside[::9], slack).all()
        assert inner.least <= outer.most * (1 + 1e-9)


@given(seeds, st.sampled_from(SHAPES))
def test_the_corners_inside_are_places_where_all_rings_hold(seed, shape):
    rings, _, box = drawn(np.random.default_rng(seed), shape)
    hull = exact_hull(rings, box)
    grown = rings.widened(1e-9 * np.abs(box).max())
    assert grown.contains(hull.inside).all()


@pytest.mark.parametrize("shape", ["any", "on an anchor", "on a line", "wide", "at a corner of the box"])
@pytest.mark.parametrize("seed", range(4))
def test_every_point_of_a_grid_where_all_rings_hold_is_in_the_hull(seed, shape):
    rings, _, box = drawn(np.random.default_rng([seed, 5]), shape)
    hull = exact_hull(rings, box)
    assert hull.error < 0.01
    hold(hull, box, all_agree(rings))


@pytest.mark.parametrize("lies", ["any", "long"])
@pytest.mark.parametrize("seed", range(6))
def test_what_one_lie_leaves_is_in_the_hull_and_the_corners_are_of_it(seed, lies):
    rings, _, box = drawn(np.random.default_rng([seed, 6]), anchors=3 + seed % 4)
    hull = tolerant_hull(rings, box, lies)
    assert hull.error < 0.01
    hold(hull, box, all_but_one_agree(rings, lies))
    assert all_but_one_agree(rings.widened(1e-8), lies)(hull.inside).all()


def lens(one, other, distance):
    """Return the area that two discs have in common, by the formula of books."""
    a, b = ((distance**2 + p**2 - q**2) / (2 * distance * p) for p, q in ((one, other), (other, one)))
    kite = np.sqrt((-distance + one + other) * (distance + one - other) * (distance - one + other) * (distance + one + other))
    return one**2 * np.arccos(a) + other**2 * np.arccos(b) - kite / 2


@pytest.mark.parametrize(
    ("rings", "box", "area"),
    [
        (Rings(np.zeros((1, 2)), np.array([-1.0]), np.array([2.0])), ENDLESS, 4 * np.pi),
        (Rings(np.zeros((1, 2)), np.array([1.5]), np.array([2.0])), ENDLESS, 4 * np.pi),  # the hole does not count
        (Rings(np.zeros((1, 2)), np.array([0.0]), np.array([2.0])), np.array([[0.0, -9.0], [9.0, 9.0]]), 2 * np.pi),
        (Rings(np.zeros((1, 2)), np.array([0.0]), np.array([50.0])), BOX, 13.0 * 12.0),  # the whole box
        (Rings(np.array([[0.0, 0.0], [2.0, 0.0]]), np.zeros(2), np.array([1.5, 1.0])), ENDLESS, lens(1.5, 1.0, 2.0)),
        (Rings(np.array([[0.0, 0.0], [0.0, 0.0]]), np.array([0.0, 0.5]), np.array([2.0, 1.0])), ENDLESS, np.pi),
        (Rings(np.array([[0.0, 0.0], [0.0, 0.0]]), np.array([1.0, 1.0]), np.array([2.0, 2.0])), ENDLESS, 4 * np.pi),
        (Rings(np.array([[0.0, 0.0], [0.5, 0.0]]), np.array([-1.0, -1.0]), np.array([2.0, 1.5])), ENDLESS, 2.25 * np.pi),
    ],
    ids=["disc", "ring", "half a disc", "box", "lens", "ring in ring", "the same twice", "touching from inside"],
)
def test_areas_that_books_know(rings, box, area):
    hull = exact_hull(rings, box)
    assert hull.least <= area <= hull.most
    assert hull.error < 1e-3


def test_what_excludes_itself_is_empty_and_what_just_touches_is_a_point_at_most():
    apart = Rings(np.array([[0.0, 0.0], [4.0, 0.0]]), np.zeros(2), np.array([1.9, 1.9]))
    hull = exact_hull(apart, ENDLESS)
    assert len(hull.around) == 0
    assert hull.least == hull.most == 0.0
    assert hull.error == np.inf
    touching = exact_hull(Rings(apart.centres, apart.least, np.array([2.0, 2.0])), ENDLESS)
    assert len(touching.inside) == 0
    assert np.abs(touching.around - [2.0, 0.0]).max() < 1e-3
    inside = Rings(np.zeros((2, 2)), np.array([0.0, 2.0]), np.array([1.0, 3.0]))  # around one another
    assert len(exact_hull(inside, ENDLESS).around) == 0
    outside = Rings(np.array([[20.0, 0.0]]), np.array([1.0]), np.array([2.0]))  # none of it in the box
    assert len(exact_hull(outside, BOX).around) == 0


def test_mirror_images_are_in_one_hull():
    """Two anchors leave two places; a third one on their line does not tell them apart, one aside does."""
    marks = np.array([[-1.0, 0.0], [1.0, 0.0], [3.0, 0.0], [0.0, 2.0]])
    place = np.array([0.5, 2.0])
    ranges = np.hypot(*(marks - place).T)
    for count in (2, 3):
        hull = exact_hull(Rings.measured(marks[:count], ranges[:count], 0.05), BOX)
        assert hull.around[:, 1].max() == pytest.approx(2.0, abs=0.15)
        assert hull.around[:, 1].min() == pytest.approx(-2.0, abs=0.15)
        assert is_within(hull.inside, place[None] * [[1, 0]], 1e-9).all()
    rings = Rings.measured(marks, ranges, 0.05)
    assert exact_hull(rings, BOX).around[:, 1].min() > 1.5
    # The one that tells them apart may be the one that lies; with its far side kept it still tells.
    assert tolerant_hull(rings, BOX, "any").around[:, 1].min() < -1.5
    assert tolerant_hull(rings, BOX, "long").around[:, 1].min() > -0.5


def test_a_lie_is_survived_and_a_second_one_is_not():
    marks, place = np.array([[0.0, 0.0], [5.0, 0.0], [0.0, 5.0], [5.0, 5.0]]), np.array([1.5, 2.0])
    ranges = np.hypot(*(marks - place).T)
    for off, lies, is_kept in (([1.5], "any", True), ([1.5], "long", True), ([-0.5], "any", True), ([-0.5], "long", False)):
        wrong = ranges + np.array([*off, 0, 0, 0])
        hull = tolerant_hull(Rings.measured(marks, wrong, 0.1), BOX, lies)
        assert (len(hull.around) > 0 and bool(is_within(hull.around, place[None])[0])) == is_kept
        assert len(exact_hull(Rings.measured(marks, wrong, 0.1), BOX).around) == 0
    two = tolerant_hull(Rings.measured(marks, ranges + np.array([1.5, 1.5, 0, 0]), 0.1), BOX, "any")
    assert len(two.around) == 0 or not is_within(two.around, place[None])[0]


def test_a_single_range_that_may_lie_says_nothing_or_how_near_it_is():
    rings = Rings.measured(np.array([[0.0, 0.0]]), np.array([2.0]), 0.1)
    assert tolerant_hull(rings, BOX, "any").least == pytest.approx(13.0 * 12.0)
    assert tolerant_hull(rings, BOX, "long").least == pytest.approx(np.pi * 2.1**2, rel=1e-3)


@settings(max_examples=15)
@given(seeds)
def test_it_does_not_matter_where_the_origin_is_how_all_is_turned_and_in_which_units(seed):
    rng = np.random.default_rng(seed)
    rings, _, _ = drawn(rng, anchors=4)
    angle, scale, shift = rng.uniform(-np.pi, np.pi), rng.uniform(0.5, 2), rng.uniform(-20, 20, 2)
    turned = scale * rings.centres @ np.array([[np.cos(angle), np.sin(angle)], [-np.sin(angle), np.cos(angle)]]) + shift
    other = Rings(turned, scale * rings.least, scale * rings.greatest)
    one, two = tolerant_hull(rings, ENDLESS, "any"), tolerant_hull(other, ENDLESS, "any")
    assert two.least <= scale**2 * one.most * (1 + 1e-6)
    assert scale**2 * one.least <= two.most * (1 + 1e-6)


def test_corners_and_areas_of_few_points():
    assert corners_of(np.zeros((0, 2))).shape == (0, 2)
    assert area_of(corners_of(np.array([[1.0, 2.0]]))) == 0.0
    assert area_of(corners_of(np.array([[0.0, 0.0], [1.0, 1.0], [2.0, 2.0]]))) == 0.0
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0], [0.5, 0.5], [0.0, 0.5]])
    assert area_of(corners_of(square)) == 1.0
    assert len(corners_of(square)) == 4


@pytest.mark.parametrize("centres", [[[np.nan, 0.0]], np.zeros((0, 2))], ids=["no number", "none"])
def test_what_makes_no_rings_is_refused(centres):
    with pytest.raises(InvalidInput, match="one ring or more"):
        Rings(np.array(centres), np.zeros(len(centres)), np.ones(len(centres)))
