"""Slices of heading: no pose is ever lost that the operation could leave, and what is impossible goes."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from filter.geometry.polygon import Polygon
from filter.geometry.sector import WIDEST, far_and_near, sides, trapezoid
from filter.robust.hypotheses import Hypotheses
from filter.robust.slices import (
    COUNT,
    DIRECTIONS,
    TANGENT_ANGLE,
    move,
    narrow,
    sector_supports,
    see_body,
    see_place,
    seen_from,
    stay_within,
    tighten,
)

SEEDS = range(40)


def supports(points):
    return (np.atleast_2d(points) @ DIRECTIONS.T).max(axis=0)


def slices_around(rng, position, heading, width=0.1):
    """Some slices, the first of which holds the pose; now and then a point, a thin arc, or one across the half turn."""
    count, size, width = 3, 0.5 * rng.integers(0, 2), width * rng.choice([0.0, 1.0, 3.0])
    reach = [supports(position + size * rng.uniform(-1, 1, (6, 2))) for _ in range(count)]
    reach[0] = np.maximum(reach[0], supports(position))
    low = heading - width * rng.uniform(0, 1, count)
    low += np.r_[0.0, rng.uniform(-3, 3, count - 1)]
    high = np.maximum(low + width, np.r_[heading, low[1:]])
    turns = 2 * np.pi * rng.integers(-1, 2)
    return low + turns, high + turns, np.array(reach)


def holds(low, high, reach, position, heading):
    """Whether some slice contains a pose, by more than rounding would spoil."""
    turns = 2 * np.pi * np.arange(-4, 5)[:, None]
    inside = (DIRECTIONS @ position <= reach + 1e-12 * (1 + np.abs(position).max())).all(axis=1)
    within = ((low - 1e-12 <= heading + turns) & (heading + turns <= high + 1e-12)).any(axis=0)
    return bool((inside & within).any())


def pose(rng):
    return rng.uniform(-5, 5, 2), rng.choice([rng.uniform(-np.pi, np.pi), np.pi, -np.pi, 0.0])


def direction(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def test_the_axes_are_among_the_directions_exactly():
    quarter = COUNT // 4
    assert DIRECTIONS[::quarter].tolist() == [[1, 0], [0, 1], [-1, 0], [0, -1]]


@given(st.floats(-4, 4), st.floats(0, 3.2), st.floats(0, 3), st.floats(0, 5), st.tuples(st.floats(0, 1), st.floats(-1, 1)))
def test_the_support_of_a_sector_is_beyond_all_its_points(centre, bound, nearest, more, within):
    point = (nearest + within[0] * more) * direction(centre + within[1] * min(bound, np.pi))
    assert (DIRECTIONS @ point <= sector_supports(centre, bound, nearest, nearest + more) + 1e-12).all()


@given(st.floats(-4, 4), st.floats(0, 3.2), st.floats(0, 3), st.floats(0.1, 5))
def test_a_sector_reaches_no_farther_than_its_trapezoid_and_its_disc(centre, bound, nearest, more):
    farthest = nearest + more
    corners = trapezoid(centre, bound, nearest, farthest)
    reach = np.minimum(supports(corners), farthest) if bound < WIDEST else np.full(COUNT, farthest)
    assert sector_supports(centre, bound, nearest, farthest) == pytest.approx(reach, abs=1e-11)


@settings(max_examples=40)
@given(st.floats(-4, 4), st.sampled_from([0.01, 0.3, 1.0, 2.0, np.pi]), st.floats(0, 2), st.floats(0.1, 2), st.floats(-1, 1))
def test_a_place_is_seen_from_where_the_half_planes_of_the_sector_say(way, bound, nearest, more, aside):
    """Those of `filter.geometry.sector`, turned round: the place is in the sector of whoever sees it."""
    place, heading = np.array([0.3, aside]), 0.7
    around, reach = far_and_near(way, bound, nearest, nearest + more, TANGENT_ANGLE)
    beside = sides(way, bound) if bound < np.pi / 2 else np.zeros((0, 2))
    normals, offsets = -np.concatenate([around, beside]), np.append(reach, np.zeros(len(beside)))
    square = supports([[-9, -9], [9, 9], [-9, 9], [9, -9]])
    lines = np.concatenate([DIRECTIONS, normals]), np.append(square, offsets + normals @ place)
    expected = Polygon.from_half_planes(*lines, [-9, -9], [9, 9]).support(DIRECTIONS)
    low, high, mine = np.array([heading]), np.array([heading]), square[None].copy()
    assert see_place(place, np.array([way - heading, bound, nearest, nearest + more]), low, high, mine)[0]
    assert mine[0] == pytest.approx(np.minimum(square, expected), abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_no_motion_within_the_bounds_leaves_the_slices(seed):
    rng = np.random.default_rng(seed)
    position, heading = pose(rng)
    low, high, reach = slices_around(rng, position, heading)
    distance, turn = np.sort(rng.uniform(-1, 1, 2)), np.sort(rng.uniform(-2, 2, 2))
    aside, slip, sideways = rng.uniform(0, 0.3), rng.uniform(0, 0.1), rng.choice([0.0, rng.uniform(-4, 4)])
    driven, turned = rng.choice([*distance, distance.mean()]), rng.choice([*turn, turn.mean()])
    way = heading + turned / 2 + sideways + aside * rng.choice([-1, 0, 1])
    moved = position + driven * np.sinc(turned / 2 / np.pi) * direction(way) + slip * direction(rng.uniform(-4, 4))
    anywhere = supports([[-99, -99], [99, 99], [-99, 99], [99, -99]])
    assert move(distance, turn, np.array([aside, slip, sideways]), anywhere, low, high, reach).all()
    assert holds(low, high, reach, moved, heading + turned)


@pytest.mark.parametrize("seed", SEEDS)
def test_seeing_a_place_or_a_body_keeps_the_true_pose(seed):
    rng = np.random.default_rng(seed)
    position, heading = pose(rng)
    place = position + rng.uniform(0.1, 5) * direction(rng.uniform(-4, 4))
    way, distance = np.arctan2(*(place - position)[::-1]), np.hypot(*(place - position))
    bound, slack = rng.choice([1e-9, 0.1, 1.4, np.pi]), rng.choice([0.0, 0.2])
    side, end = rng.choice([-1, 0, 1]), rng.choice([0.0, 1.0])
    sector = np.array(
        [way - heading + side * bound * (1 - 1e-9), bound, max(0, distance - slack * end), distance + slack + 1e-9]
    )
    low, high, reach = slices_around(rng, position, heading)
    kept = [column.copy() for column in (low, high, reach)]
    left = see_place(place, sector, *kept)
    assert holds(*(column[left] for column in kept), position, heading)
    body = supports(np.append(place + rng.uniform(-0.5, 0.5, (4, 2)), [place], axis=0))
    kept = [column.copy() for column in (low, high, reach)]
    left = see_body(body, sector, *kept)
    assert holds(*(column[left] for column in kept), position, heading)
    assert (DIRECTIONS @ place <= seen_from(sector, low, high, reach) + 1e-12).all()


def test_seeing_a_place_cuts_position_and_heading():
    low, high, reach = np.array([-0.1]), np.array([0.1]), supports([[-1, -1], [1, 1], [-1, 1], [1, -1]])[None]
    seen = np.array([0.0, 0.01, 2.0, 2.1])
    place = np.array([3.0, 0.0])
    assert see_place(place, seen, low, high, reach).all()
    assert reach[0, 0] == pytest.approx(1.0)
    assert -reach[0, COUNT // 2] == pytest.approx(0.9, abs=0.01)  # at 2.1 m at most
    assert reach[0, COUNT // 4] == pytest.approx(2.1 * np.tan(0.11), abs=0.01)
    assert not see_place(place, np.array([np.pi, 0.1, 2, 2.1]), low.copy(), high.copy(), reach.copy())[0]
    point = supports([0.0, 0.0])[None]
    assert see_place(place, np.array([0.05, 0.01, 2.9, 3.1]), low, high, point).all()
    assert [low[0], high[0]] == pytest.approx([-0.06, -0.04])


def test_arcs_narrow_across_the_half_turn():
    low, high = np.array([3.0, 0.0]), np.array([3.3, 0.3])
    assert narrow(np.array([-np.pi + 0.05, 0.02]), low, high, np.zeros((2, COUNT))).tolist() == [True, False]
    assert [low[0], high[0]] == pytest.approx([np.pi + 0.03, np.pi + 0.07])
    low, high = np.array([-3.0]), np.array([3.0])
    assert narrow(np.array([np.pi, 1.0]), low, high, np.zeros((1, COUNT))).all()  # they meet at both ends: all is left
    assert [low[0], high[0]] == [-3.0, 3.0]


def test_staying_within_a_polygon_drops_what_is_wholly_outside():
    reach = np.array([supports([[0, 0], [1, 1]]), supports([[5, 5], [6, 6]])])
    within = supports([[0.5, -1], [0.5, 2], [2, 0]])
    assert stay_within(within, np.zeros(2), np.zeros(2), reach).tolist() == [True, False]
    assert -reach[0, COUNT // 2] == pytest.approx(0.5)


@pytest.mark.parametrize("seed", SEEDS)
def test_the_grid_keeps_every_pose_and_is_stable(seed):
    rng = np.random.default_rng(seed)
    position, heading = pose(rng)
    low, high, reach = slices_around(rng, position, heading, width=rng.choice([0.1, 1.0, 2.5]))
    anew = Hypotheses(np.array([0, 1, 1]), low, high, reach).cut_anew(24)
    first = anew.without == 0
    assert holds(anew.low[first], anew.high[first], anew.reach[first], position, heading)
    again = anew.cut_anew(24)
    assert (again.without == anew.without).all()
    np.testing.assert_allclose(again.low, anew.low, atol=1e-12)
    np.testing.assert_allclose(again.high, anew.high, atol=1e-12)
    np.testing.assert_array_equal(again.reach, anew.reach)


def test_more_than_a_circle_is_a_circle():
    anew = Hypotheses.agreed(np.zeros(COUNT), 1.0, 40.0).cut_anew(12)
    assert len(anew) == 12
    assert (anew.high - anew.low).sum() == pytest.approx(2 * np.pi, abs=1e-9)


@pytest.mark.parametrize("seed", SEEDS)
def test_a_tight_polygon_is_that_of_its_half_planes(seed):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-1, 1, (5, 2))
    normal, reach = direction(rng.uniform(-4, 4)), supports(points)
    offset = normal @ points.mean(axis=0)
    box = Polygon.from_half_planes(np.append(DIRECTIONS, [normal], 0), np.append(reach, offset), [-2, -2], [2, 2])
    vertices, _ = tighten(reach, normal[None], np.array([offset]))
    assert len(vertices)
    np.testing.assert_allclose(reach, box.support(DIRECTIONS), atol=1e-9)
    assert len(tighten(reach, np.stack([normal, -normal]), np.array([offset, -offset - 0.1]))[0]) == 0
