"""Fixes, rooms and docks: half-planes that contain whoever is there, and that leave what they should."""

from fractions import Fraction

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filter import (
    AngularIntervals,
    Compass,
    ExtendedKalmanFilter,
    Inconsistent,
    InvalidInput,
    NoiseModel,
    Polygon,
    Position,
    Range,
    SetMembershipFilter,
    Source,
    Team,
)

TEAM = Team(2, [[3.0, 0.0]], arena=[[-50, -50], [50, 50]])
BOX = Polygon.box([-3, -3], [3, 3])
coordinates, sizes = st.floats(-1e6, 1e6), st.floats(0, 1e3)


def slack(record, point):
    """Return how far inside of each half-plane a point is, in fractions."""
    x, y = map(Fraction, point)
    rows = zip(*(map(Fraction, getattr(record, name).tolist()) for name in ("normal_x", "normal_y", "offset")), strict=True)
    return [offset - across * x - up * y for across, up, offset in rows]


def updated(records, filter_=None, team=TEAM):
    filter_ = filter_ or SetMembershipFilter(team)
    return filter_.update(filter_.start(0.0, [BOX] * team.robots, AngularIntervals([0.0, 0.0], [0.1, 0.1])), records)


@given(coordinates, coordinates, sizes, sizes, st.sampled_from([(-1, -1), (-1, 1), (1, -1), (1, 1)]))
def test_a_fix_contains_its_corners(x, y, wide, high, which):
    corner = Fraction(x) + which[0] * Fraction(wide), Fraction(y) + which[1] * Fraction(high)
    assert min(slack(Position.fix(0.0, 0, [x, y], [wide, high]), corner)) >= 0


@given(coordinates, coordinates, sizes, st.integers(3, 40), st.floats(-4, 4))
def test_a_disc_contains_its_rim(x, y, radius, sides, way):
    record = Position.disc(0.0, 0, [x, y], radius, sides)
    inside = [x + 0.999999999 * radius * np.cos(way), y + 0.999999999 * radius * np.sin(way)]
    near = 1e-9 * (1 + abs(x) + abs(y))  # the point itself is rounded
    assert min(slack(record, inside)) >= -near
    beyond = [x + (1 / np.cos(np.pi / sides) + 1e-6) * radius * np.cos(way), y]
    assert radius < 1 or abs(np.sin(way)) > 0.01 or min(slack(record, beyond)) < near


@given(st.floats(-3, 3), st.floats(-3, 3), st.floats(-100, 100))
def test_a_half_plane_may_have_a_normal_of_any_length(x, y, offset):
    if np.hypot(x, y) < 1e-6:
        return
    record = Position.half_plane(0.0, 0, [x, y], offset)
    assert np.hypot(record.normal_x, record.normal_y) == pytest.approx(1, abs=1e-15)
    on_it = np.array([x, y]) * offset / (x * x + y * y)
    assert float(slack(record, on_it)[0]) == pytest.approx(0, abs=1e-12 * (1 + np.abs(on_it).max()))


def test_a_fix_leaves_what_it_has_in_common_with_what_was_known():
    belief = updated([Position.fix(0.0, 0, [1.2, -0.7], 0.3)])
    assert belief.regions[0].outer.area == pytest.approx(0.36, rel=1e-6)
    assert belief.regions[1].outer.area == pytest.approx(36, rel=1e-9)
    assert Source("position", 0.0, 0) in belief.causes(0, 0)


def test_what_one_robot_is_told_of_its_place_tells_another_where_it_is():
    known = [Compass(0.0, 0, 0.0, 0.01), Range(0.0, 0, 1, 2.0, 0.05, 0.0), Position.fix(0.0, 1, [0.0, 2.0], 0.1)]
    assert updated(known).regions[0].outer.area < 36 / 2


def test_a_room_or_one_side_of_a_line_will_do():
    room = Polygon.from_vertices([[0, 0], [2, 0], [0, 2]])
    assert updated([Position.within(0.0, 0, room)]).regions[0].outer.area == pytest.approx(2, rel=1e-6)
    assert updated([Position.half_plane(0.0, 0, [2, 0], 0.0)]).regions[0].outer.area == pytest.approx(18, rel=1e-6)


def test_two_fixes_that_exclude_one_another_are_named_once_each():
    with pytest.raises(Inconsistent) as caught:
        updated([Position.fix(0.0, 0, [1, 1], 0.1), Position.fix(0.0, 0, [-1, -1], 0.1)])
    assert caught.value.sources == (Source("position", 0.0, 0),) * 2
    with pytest.raises(Inconsistent) as caught:
        updated([Position.fix(0.0, 0, [9, 9], 0.1), Position.fix(0.0, 1, [1, 1], 0.1)])
    assert {(source.kind, source.robot) for source in caught.value.sources} == {("position", 0), ("initial set", 0)}


def test_a_fix_that_is_in_doubt_is_so_as_a_whole():
    filter_ = SetMembershipFilter(TEAM, policy="reject")
    belief = updated([Position.fix(0.0, 0, [9, 9], 0.1), Position.fix(0.0, 1, [1, 1], 0.1)], filter_)
    assert {suspect.who for suspect in belief.suspects} == {("past", 0, -1), ("sensor", 0, -1)}
    assert belief.regions[0].outer.contains([[9, 9], [-3, -3], [3, -3], [-3, 3]]).all()
    assert belief.regions[1].outer.area == pytest.approx(0.04, rel=1e-5)


def test_a_kalman_filter_takes_the_middle_of_a_fix_and_nothing_of_a_half_plane():
    kalman = ExtendedKalmanFilter(TEAM, NoiseModel.same(0.5))
    begin = updated([], kalman)
    after = updated([Position.fix(0.0, 0, [1, -1], [0.2, 0.4])], kalman)
    assert after.mean[0, :2] == pytest.approx([1, -1], abs=0.05)
    assert np.diag(after.position_covariances[0]) == pytest.approx([0.01, 0.04], rel=0.05)
    assert (updated([Position.half_plane(0.0, 0, [1, 0], 0.0)], kalman).mean == begin.mean).all()


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Position(0.0, 0, 1.0, 1.0, 0.0),
        lambda: Position.half_plane(0.0, 0, [0, 0], 0.0),
        lambda: Position.fix(0.0, 0, [1, 2, 3], 0.1),
        lambda: Position.fix(0.0, 0, [1, 2], [0.1, 0.2, 0.3]),
        lambda: Position.fix(0.0, 0, [1, 2], -0.1),
        lambda: Position.disc(0.0, 0, [1, 2], 1.0, sides=2),
        lambda: Position.within(0.0, 0, [[0, 0], [1, 1]]),
    ],
)
def test_what_is_no_place_is_refused(wrong):
    with pytest.raises(InvalidInput):
        wrong()
