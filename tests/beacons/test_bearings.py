"""The judge of bearings without a compass: held against a grid and all headings, and where angles are flat or places close."""

import numpy as np
import pytest
from helpers.beacons.hulls import hold, is_within
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.beacons.bearings import Sights, exact_hull_of_sights
from filter import InvalidInput, wrap

seeds = st.integers(0, 2**32 - 1)
BOX = np.array([[-6.0, -6.0], [7.0, 6.0]])
SHAPES = ["any", "two", "near a landmark", "on a line", "around the robot", "wide", "precise"]


def drawn(rng, shape):
    """Return sights of two to five landmarks from a place in the box, and the place."""
    count = 2 if shape == "two" else int(rng.integers(3, 6))
    place, marks = rng.uniform(*BOX), rng.uniform(BOX[0], BOX[1], (count, 2))
    if shape == "near a landmark":
        marks[0] = place + rng.normal(size=2) * 10.0 ** rng.uniform(-4, -1)
    if shape == "on a line":  # with the robot on it, too: differences are 0 or half a circle
        marks = place + np.outer(rng.uniform(-3, 3, count), rng.normal(size=2))
    if shape == "around the robot":
        turns = np.arange(count) * 2 * np.pi / count
        marks = place + 2 * np.stack([np.cos(turns), np.sin(turns)], axis=1)
    bound = np.radians({"wide": 25.0, "precise": 0.1}.get(shape, 3.0))
    errors = np.zeros(count) if shape == "on a line" else rng.uniform(-bound, bound, count)
    return Sights(marks, directions(place[None], marks)[0] - rng.uniform(-np.pi, np.pi) + errors, bound), place


def directions(points, marks):
    apart = marks - points[:, None]
    return np.arctan2(apart[..., 1], apart[..., 0])


def some_heading_fits(sights):
    """Slow and obvious: where arcs of headings meet, one of their ends is in all of them."""

    def fits(points):
        centres = directions(points, sights.places) - sights.bearings
        ends = np.concatenate([centres - sights.bound, centres + sights.bound], axis=1)
        off = np.abs(wrap(ends[:, :, None] - centres[:, None]))
        return (off <= sights.bound + 1e-12).all(axis=2).any(axis=1)

    return fits


@settings(max_examples=40)
@given(seeds, st.sampled_from(SHAPES))
def test_the_place_is_in_the_hull_and_its_corners_fit_some_heading(seed, shape):
    sights, place = drawn(np.random.default_rng(seed), shape)
    hull = exact_hull_of_sights(sights, BOX)
    assert is_within(hull.around, place[None], 1e-8).all()
    assert is_within(hull.around, hull.inside[::9], 1e-8).all()
    if len(hull.inside):  # a corner at a landmark sees it in any direction
        moved = hull.inside[(np.hypot(*(hull.inside[:, None] - sights.places).transpose(2, 0, 1)) > 1e-6).all(axis=1)]
        assert some_heading_fits(sights.widened(1e-6))(moved).all()


@pytest.mark.parametrize("shape", SHAPES)
@pytest.mark.parametrize("seed", range(4))
def test_every_point_of_a_grid_from_which_all_can_be_seen_so_is_in_the_hull(seed, shape):
    sights, _ = drawn(np.random.default_rng([seed, 3]), shape)
    hull = exact_hull_of_sights(sights, BOX)
    assert hull.error < 0.01
    hold(hull, BOX, some_heading_fits(sights))


def test_two_places_at_a_right_angle_are_seen_from_a_circle():
    """Thales: the robot is on the circle over both places, on the side on which the first one is on the right."""
    sights = Sights(np.array([[-2.0, 0.0], [2.0, 0.0]]), np.array([0.0, np.pi / 2]), 1e-4)
    hull = exact_hull_of_sights(sights, BOX)
    assert hull.around[:, 1].min() == pytest.approx(0.0, abs=1e-3)
    assert hull.around[:, 1].max() == pytest.approx(2.0, abs=1e-3)
    assert hull.least == pytest.approx(2 * np.pi, rel=1e-3)
    mirrored = exact_hull_of_sights(Sights(sights.places, -sights.bearings, 1e-4), BOX)
    assert mirrored.around[:, 1].min() == pytest.approx(-2.0, abs=1e-3)


def test_the_robots_own_frame_does_not_matter():
    sights, _ = drawn(np.random.default_rng(1), "any")
    one = exact_hull_of_sights(sights, BOX)
    for turn in (1.0, -3.0, np.pi, 2 * np.pi):
        other = exact_hull_of_sights(Sights(sights.places, sights.bearings + turn, sights.bound), BOX)
        assert other.least == pytest.approx(one.least, rel=1e-6)


def test_bearings_that_nobody_can_have_leave_nothing():
    square = np.array([[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]])
    mixed_up = np.radians([0.0, 170.0, 20.0, 200.0])
    assert len(exact_hull_of_sights(Sights(square, mixed_up, np.radians(2)), BOX).around) == 0


@pytest.mark.parametrize(("count", "bound"), [(1, 0.1), (3, 0.0), (3, np.pi / 3), (3, np.nan)])
def test_what_the_judge_cannot_tell_is_refused(count, bound):
    with pytest.raises(InvalidInput, match="below 60 degrees"):
        Sights(np.eye(3, 2)[:count], np.zeros(count), bound)
