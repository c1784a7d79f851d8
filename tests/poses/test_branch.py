"""Branch and prune: no pose that agrees is lost, what is left is hardly larger than its exact hull, and the tree is a tree."""

import numpy as np
import pytest
import shapely
from hypothesis import assume, given
from hypothesis import strategies as st

from filter import Bearing, Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.poses.cells import ByCases, Most, Scene, Told
from filter.poses.slices import Slices
from filter.sensing.readings import Readings
from filter.team import Team

seeds = st.integers(0, 2**32 - 1)
WHERE = ["anywhere", "corner", "edge", "beside an edge", "beside a corner"]
COARSE, MIDDLE, FINE = np.radians(30), np.radians(15), np.radians(3)
CIRCLE = np.linspace(0, 2 * np.pi, 4001)[:-1]


def left(box, marks, records, heading=(0.0, np.pi), *, cells=64, spacing=COARSE) -> ByCases | None:
    """Return what cells leave of one robot's poses in a box (2, 2), of all that was measured to landmarks."""
    arc = AngularIntervals(*np.array(heading)[:, None])
    team = Team(1, marks, 0.5, 1.0)
    belief = SetMembershipFilter(team).start(0.0, [Polygon.box(*box)], arc)
    told = Told.of(Readings.of(0.0, records), arc, spacing)
    scene = Scene(belief.polytope, belief.sources, told, team.landmarks, Slices.none())
    found, nowhere = scene.in_cells(np.array([0]), Most(cells, 0))
    return found[0] if nowhere < 0 else None


def beside(rng, box, where):
    """Return a place in or near a box, on its rim, or a hair within or beyond that."""
    corner, inside = rng.choice(box, axis=0), rng.uniform(*box)
    hair = rng.choice([-1, 1], 2) * 10.0 ** rng.uniform(-12, -6, 2)
    return {
        "anywhere": rng.uniform(box[0] - 2, box[1] + 2),
        "corner": corner,
        "edge": np.array([corner[0], inside[1]]),
        "beside an edge": np.array([corner[0] + hair[0], inside[1]]),
        "beside a corner": corner + hair,
    }[where]


def ranged(rng, wheres):
    """Return a box, beacons in or near it, the truth in it, and its ranges to them with their bounds."""
    low = rng.uniform(-3, 0, 2)
    box = np.array([low, low + 10.0 ** rng.uniform(-0.7, 1, 2)])
    marks, truth = np.array([beside(rng, box, where) for where in wheres]), rng.uniform(*box)
    bounds = 10.0 ** rng.uniform(-2.5, 0, len(marks))
    values = np.maximum(0, np.hypot(*(marks - truth).T) + rng.uniform(-1, 1, len(marks)) * bounds)
    return box, marks, truth, values, bounds


def to_beacons(values, bounds):
    return Range(0.0, 0, 1 + np.arange(len(values)), values, bounds, 0.0)


def area_left(box, case):
    return Polygon.from_half_planes(case.rows[:, :2], case.rows[:, 2], *box).area


def area_of_hull(box, marks, values, bounds):
    """Return the area of the convex hull of what all annuli have in common with a box, drawn with thousands of corners."""
    region = shapely.box(*box.ravel())
    for mark, value, bound in zip(marks, values, bounds, strict=True):
        outer, inner = (mark + each * np.stack([np.cos(CIRCLE), np.sin(CIRCLE)], 1) for each in (value + bound, value - bound))
        hole = shapely.Polygon(inner) if value > bound else shapely.Polygon()
        region = region.intersection(shapely.Polygon(outer).difference(hole))
    return region.convex_hull.area


@given(seeds, st.lists(st.sampled_from(WHERE), min_size=1, max_size=2), st.sampled_from([COARSE, MIDDLE]))
def test_what_ranges_leave_is_hardly_larger_than_its_exact_hull(seed, wheres, spacing):
    """Where coarse tangents meet is beyond the far side: of a slim cap of a disc that is a seventh, so they count as exact."""
    box, marks, truth, values, bounds = ranged(np.random.default_rng(seed), wheres)
    exact, most = area_of_hull(box, marks, values, bounds), 1.02 if len(wheres) == 1 else 1.05
    assume(exact > 1e-3 * np.prod(box[1] - box[0]))
    least, greatest = np.maximum(0, values - bounds), (values + bounds) / np.cos(spacing / 2)
    with_corners = area_of_hull(box, marks, (greatest + least) / 2, (greatest - least) / 2)
    case = left(box, marks, [to_beacons(values, bounds)], spacing=spacing)
    assert (case.rows[:, :2] @ truth <= case.rows[:, 2]).all()
    assert (1 - 1e-3) * exact <= area_left(box, case) <= most * with_corners
    if spacing == MIDDLE and exact > 0.05 * np.prod(box[1] - box[0]):
        assert area_left(box, case) <= most * exact


def poses(box, across=40, around=60):
    """Return (k, 2) places and (k,) headings, everywhere in a box and all around."""
    x, y, heading = np.meshgrid(*np.linspace(box[0], box[1], across).T, np.linspace(-np.pi, np.pi, around), indexing="ij")
    return np.stack([x.ravel(), y.ravel()], axis=1), heading.ravel()


@given(seeds, st.sampled_from([0, 1, 2, 4, 64]))
def test_every_pose_that_agrees_with_all_readings_is_left(seed, more):
    rng, count = np.random.default_rng(seed), 3
    box, marks, truth, values, bounds = ranged(rng, rng.choice(WHERE, count))
    bounds, facing, half = bounds + 0.1, rng.uniform(-np.pi, np.pi), rng.uniform(0.1, 1, count)
    way = np.arctan2(*(marks - truth).T[::-1]) - facing + rng.uniform(-1, 1, count) * half
    seen = Bearing(0.0, 0, 1 + np.arange(count), way, half)
    case = left(box, marks, [seen, to_beacons(values, bounds)], (facing, 2.0), cells=max(1, more))
    places, headings = poses(box)
    agrees = np.abs(wrap(headings - facing)) <= 2.0
    for mark, value, bound, angle, wide in zip(marks, values, bounds, way, half, strict=True):
        apart = mark - places
        agrees &= np.abs(np.hypot(*apart.T) - value) <= bound
        agrees &= np.abs(wrap(np.arctan2(apart[:, 1], apart[:, 0]) - headings - angle)) <= wide
    assert (places[agrees] @ case.rows[:, :2].T <= case.rows[:, 2]).all()
    assert AngularIntervals(np.full(agrees.sum(), case.heading[0]), case.heading[1]).contains(headings[agrees]).all()
    assert (case.rows[:, :2] @ truth <= case.rows[:, 2]).all()


@given(seeds, st.sampled_from([1, 2, 4, 16, 64]))
def test_the_tree_is_a_tree_of_no_more_leaves_than_cells(seed, cells):
    rng = np.random.default_rng(seed)
    box, marks, truth, *measured = ranged(rng, rng.choice(WHERE, 2))
    case = left(box, marks, [to_beacons(*measured)], cells=cells)
    child, rounds = case.tree.child, case.tree.rounds
    parents = np.flatnonzero(child)
    assert sorted([*child[parents], *(child[parents] + 1)]) == list(range(1, 2 * len(parents) + 1))
    assert (child[parents] > parents).all()
    assert 1 + len(parents) <= cells
    assert (rounds[parents] > 0).all()
    assert (case.tree.line[child == 0] == 0).all()
    assert (case.rows[:, :2] @ truth <= case.rows[:, 2]).all()


@given(seeds, st.sampled_from(["a point", "wide bands", "far beacons"]))
def test_nothing_is_split_where_nothing_is_wide(seed, why):
    rng = np.random.default_rng(seed)
    place = rng.uniform(-3, 3, 2)
    box = place + (0.0 if why == "a point" else 1.0) * np.array([[-1, -1], [1, 1]])
    away = {"a point": 2.0, "wide bands": 2.5, "far beacons": 1e4}[why]
    marks = place + away * np.stack([np.cos([0, 2.5]), np.sin([0, 2.5])], axis=1)
    case = left(box, marks, [to_beacons(np.full(2, away), np.full(2, 50.0 if why == "wide bands" else 0.1))])
    assert not case.tree.child.any()


def test_a_heading_is_split_for_two_bearings_and_not_for_one():
    box, marks = np.array([[-1.0, -1.0], [1.0, 1.0]]), np.array([[4.0, 0.0], [0.0, 4.0]])
    seen = Bearing(0.0, 0, [1, 2], [0.0, np.pi / 2], 0.05)
    one, two = Bearing(0.0, 0, [1], [0.0], 0.05), seen
    trees = [left(box, marks, [some], (0.0, 1.5)).tree for some in (one, two)]
    of_headings = [(tree.child > 0) & ~tree.line[:, :2].any(axis=1) for tree in trees]
    assert not of_headings[0].any()
    assert of_headings[1].any()
    assert left(box, marks, [two], (0.0, 1.5)).heading[1] < left(box, marks, [one], (0.0, 1.5)).heading[1]


@pytest.mark.parametrize(("mark", "distance"), [([1.5, 2.5], 1.0), ([3.0, 2.5], 2.8)])
def test_finer_tangents_never_leave_more(mark, distance):
    box, marks = np.array([[0.0, 0.0], [3.0, 5.0]]), np.array([mark])
    ranges = [to_beacons(np.array([distance]), np.array([0.01]))]
    coarse, fine = (area_left(box, left(box, marks, ranges, spacing=spacing)) for spacing in (MIDDLE, FINE))
    assert fine <= 1.02 * coarse
