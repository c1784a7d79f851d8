"""Every path that a record allows ends within its displacement set."""

import numpy as np
import pytest
from helpers.worlds import exact_slack, unit
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial import ConvexHull

from filter import Odometry
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import area_of, hull_of
from filter.geometry.polygon import clip
from filter.geometry.sector import WIDEST, trapezoid
from filter.linear.constraints import WORLD, Constraints
from filter.sensing.motion import CORNERS, Displacements, displacements, turned_headings
from filter.team import Team

PATHS = 400
FAR = 1e9  # no displacement is so long [m]
# Rounding of a sampled path of some metres [m].
ROUNDING = 1e-12


def odometry(rng, count, kind):
    distance = rng.uniform(0, 2, count)
    values = {
        "distance": distance,
        "distance_bound": rng.uniform(0, 0.2, count),
        "turn": rng.uniform(-1, 1, count),
        "turn_bound": rng.uniform(0, 0.2, count),
        "direction_bound": rng.uniform(0, 0.2, count),
        "slip_bound": rng.uniform(0, 0.1, count),
    }
    if kind == "backwards":
        values["distance"] = -distance
    if kind == "around 0":
        values["distance"] = rng.uniform(-0.1, 0.1, count)
        values["distance_bound"] = 0.1 + rng.uniform(0, 0.1, count)
    if kind == "on the spot":
        values |= {"distance": np.zeros(count), "distance_bound": np.zeros(count), "turn": rng.uniform(-7, 7, count)}
    if kind == "sharp":
        values["turn"] = rng.uniform(-3.1, 3.1, count)
        values["turn_bound"] = np.pi - np.abs(values["turn"])
    if kind == "wide":
        values |= {"turn_bound": rng.uniform(0, 2, count), "direction_bound": rng.uniform(0, 1.5, count)}
    if kind == "sideways":
        values["aside"] = rng.uniform(-4, 4, count)
    if kind == "exact":
        values |= {name: np.zeros(count) for name in values if name.endswith("bound")}
    return Odometry(start=0.0, time=1.0, robot=np.arange(count), **values)


KINDS = ["forwards", "backwards", "around 0", "on the spot", "sharp", "wide", "sideways", "exact"]


def ends(rng, record, robot, heading, extreme):
    """Return where paths end that the record allows from one heading, and their headings there.

    The heading goes from first to last on its way, steadily or by leaps, so that the displacement is an average of unit
    vectors; what of it is not along the middle heading is within the direction bound by the record's definition.
    """

    def error(*size):
        return rng.choice([-1.0, 1.0], size) if extreme else rng.uniform(-1, 1, size)

    length = record.distance[robot] + record.distance_bound[robot] * error(PATHS)
    turn = record.turn[robot] + record.turn_bound[robot] * error(PATHS)
    middle = heading + turn / 2 + record.aside[robot] + record.direction_bound[robot] * error(PATHS)
    share = np.linspace(-0.5, 0.5, 401)
    shape = np.where(rng.random(PATHS) < 0.5, 1.0, rng.uniform(0.2, 5, PATHS))[:, None]
    along = np.sign(share) * 0.5 * np.abs(2 * share) ** shape  # symmetric: its average is along the middle
    chord = np.cos(turn[:, None] * along).mean(axis=1)
    slip = record.slip_bound[robot] * (1.0 if extreme else rng.random(PATHS)) * unit(rng.uniform(-np.pi, np.pi, PATHS)).T
    return ((length * chord) * unit(middle).T + slip).T, heading + turn


def outside(moves, robot, points):
    """Return by how much points are outside of a displacement set, in many directions [m]."""
    directions = unit(np.linspace(-np.pi, np.pi, 721))
    support = moves.support(np.full(len(directions), robot), directions)
    return (points @ directions.T - support).max()


@pytest.mark.parametrize("extreme", [False, True])
@pytest.mark.parametrize("kind", KINDS)
def test_every_path_ends_within_the_displacement_set(kind, extreme):
    rng = np.random.default_rng(0)
    record = odometry(rng, 12, kind)
    heading = np.append(rng.uniform(-np.pi, np.pi, 10), [np.pi, -np.pi])
    known = rng.choice([0.0, 0.1, 0.5, 1.2, np.pi], 12)
    team = Team(12)
    start = AngularIntervals(heading + known * rng.choice([-1, 1], 12), known + 1e-14)
    moves = displacements(record, start, team, 1.0)
    after = turned_headings(record, start, team, 1.0)
    for robot in range(12):
        points, turned = ends(rng, record, robot, heading[robot], extreme)
        assert outside(moves, robot, points) <= ROUNDING
        assert all(after.contains(np.full(12, angle))[robot] for angle in turned[:40])


def test_a_constant_turn_is_an_arc_of_a_circle():
    """The chord of an arc, from its closed form, is at the edge of the set when nothing else is unknown."""
    turn, length = 2.5, 3.0
    record = Odometry(0, 1, 0, length, 0.0, turn, 0.0, 0.0, 0.0)
    moves = displacements(record, AngularIntervals([0.3], [0.0]), Team(1), 1.0)
    chord = length * np.sin(turn / 2) / (turn / 2)
    assert outside(moves, 0, chord * unit(0.3 + turn / 2)[None]) <= ROUNDING
    least = -moves.support(np.array([0]), -unit(0.3 + turn / 2)[None])[0]
    assert least == pytest.approx(length * np.cos(turn / 2))


@pytest.mark.parametrize("turn", [4.0, 7.0, 9.0, -9.0, 14.0])
def test_more_than_a_whole_turn_at_one_rate_ends_within_the_displacement_set(turn):
    """From one whole turn to two, an arc of a circle ends behind the middle heading."""
    record = Odometry(0, 1, 0, 3.0, 0.0, turn, 0.0, 0.0, 0.0)
    moves = displacements(record, AngularIntervals([0.3], [0.0]), Team(1), 1.0)
    chord = 3.0 * np.sin(turn / 2) / (turn / 2)
    assert outside(moves, 0, chord * unit(0.3 + turn / 2)[None]) <= ROUNDING


def test_driving_straight_with_nothing_unknown_is_a_point():
    moves = displacements(Odometry(0, 1, 0, -2.0, 0, 0, 0, 0, 0), AngularIntervals([0.0], [0.0]), Team(1), 1.0)
    assert moves.support(np.array([0, 0]), np.array([[1.0, 0.0], [-1.0, 0.0]])) == pytest.approx([-2.0, 2.0])


def test_the_set_is_no_larger_than_the_trapezoid():
    record = Odometry(0, 1, 0, 2.0, 0.1, 0.0, 0.0, 0.1, 0.0)
    moves = displacements(record, AngularIntervals([0.0], [0.1]), Team(1), 1.0)
    near, far, slope = 1.9 * np.cos(0.1) * np.cos(0.2), 2.1, np.tan(0.2)
    assert ConvexHull(moves.vertices[0], qhull_options="QJ").volume == pytest.approx(slope * (far**2 - near**2), rel=1e-6)


@pytest.mark.parametrize("speed", [0.0, 0.5])
def test_a_robot_without_odometry_moves_within_its_limits(speed):
    team = Team(2, speed_limit=speed, turn_rate_limit=0.25)
    moves = displacements(None, AngularIntervals.circles(2), team, 2.0)
    assert moves.support(np.array([0, 1]), unit(np.array([0.3, 2.0]))) == pytest.approx(2 * speed)
    assert turned_headings(None, AngularIntervals([1.0, 2.0], [0.1, 0.0]), team, 2.0).bound == pytest.approx([0.6, 0.5])


def test_robots_that_odometry_does_not_name_move_within_their_limits():
    record = Odometry(0, 2, 1, 1.0, 0.0, 0.5, 0.0, 0.0, 0.0)
    team = Team(3, speed_limit=0.5, turn_rate_limit=0.25)
    start = AngularIntervals(np.zeros(3), np.zeros(3))
    across = np.array([[0.0, 1.0]] * 3)
    assert displacements(record, start, team, 2.0).support(np.arange(3), across) == pytest.approx([1.0, np.sin(0.25), 1.0])
    assert turned_headings(record, start, team, 2.0).bound == pytest.approx([0.5, 0.0, 0.5])


def test_a_support_covers_the_hull_and_the_disc():
    rng = np.random.default_rng(1)
    moves = Displacements(rng.normal(size=(1, 8, 2)), np.array([9.0]), np.array([0.5]))
    points = rng.dirichlet(np.ones(8), 300) @ moves.vertices[0] + 0.5 * unit(rng.uniform(-np.pi, np.pi, 300))
    assert outside(moves, 0, points) <= ROUNDING


@given(st.integers(0, 2**32 - 1), st.sampled_from([1e-3, 1.0, 1e4]), st.booleans())
def test_a_support_is_never_below_a_vertex_without_any_rounding(seed, size, upright):
    rng = np.random.default_rng(seed)
    vertices = size * rng.uniform(-1, 1, (1, CORNERS, 2)) * ([1e-6, 1.0] if upright else [1.0, 1.0])
    directions = unit(rng.uniform(-np.pi, np.pi, 12))
    support = Displacements(vertices, np.full(1, FAR), np.zeros(1)).support(np.zeros(12, dtype=int), directions)
    for direction, most in zip(directions, support, strict=True):
        assert min(exact_slack(direction, most, vertex) for vertex in vertices[0]) >= 0
    assert support == pytest.approx((vertices[0] @ directions.T).max(axis=0), abs=1e-14 * size)


def test_moved_rows_hold_after_every_displacement():
    rng = np.random.default_rng(2)
    count, robots = 30, 4
    i = rng.integers(-1, robots - 1, count)
    j = np.array([rng.integers(k + 1, robots) for k in i])
    positions = rng.normal(size=(robots, 2))
    normal = unit(rng.uniform(-np.pi, np.pi, count))
    other = np.where((i == WORLD)[:, None], 0.0, positions[i])
    rows = Constraints(i, j, normal, (normal * (positions[j] - other)).sum(axis=1), np.arange(count))
    i, j, normal, _ = rows.rows
    moves = Displacements(rng.normal(size=(robots, 8, 2)), np.full(robots, 9.0), rng.uniform(0, 0.3, robots))
    moved = moves.moved(rows)
    reached = np.full(count, -np.inf)
    for _ in range(2000):
        step = moves.vertices[np.arange(robots), rng.integers(0, 8, robots)] + moves.slip[:, None] * unit(
            rng.uniform(-3.2, 3.2, robots)
        )
        after = positions + step
        said = (normal * (after[j] - np.where((i == WORLD)[:, None], 0.0, after[i]))).sum(axis=1)
        assert (said <= moved.offset + ROUNDING).all()
        reached = np.maximum(reached, said)
    assert (moved.offset - reached < 0.5).all()
    assert moved.source.tolist() == rows.source.tolist()


def some_vertices(rng, kind):
    """Return (CORNERS, 2) vertices, of which some coincide, lie on one line, or are all the same."""
    if kind == "point":
        return np.tile(rng.normal(size=2), (CORNERS, 1))
    if kind == "segment":
        return rng.normal(size=2) + rng.integers(-2, 3, (CORNERS, 1)) * rng.integers(1, 4, 2)
    if kind == "whole numbers":
        return rng.integers(-2, 3, (CORNERS, 2)).astype(float)
    return rng.normal(size=(CORNERS, 2)) * 10.0 ** rng.uniform(-6, 3)


@given(st.integers(0, 2**32 - 1), st.sampled_from(["any", "whole numbers", "segment", "point"]))
def test_normals_are_those_of_the_hulls_edges_and_there_are_no_others(seed, kind):
    rng = np.random.default_rng(seed)
    vertices = np.stack([some_vertices(rng, kind), rng.normal(size=(CORNERS, 2))])
    normals = Displacements(vertices, np.full(2, 9.0), np.zeros(2)).normals
    assert normals.shape == (2, CORNERS, 2)
    for corners, every in zip(vertices, normals, strict=True):
        hull = hull_of(corners)
        edges = 0 if len(hull) == 1 else len(hull)
        mine, rest = every[:edges], every[edges:]
        assert np.isnan(rest).all()
        assert np.hypot(*mine.T) == pytest.approx(1.0)
        along = corners @ mine.T
        most, size = along.max(axis=0), np.abs(corners).max()
        touching = [np.unique(corners[near], axis=0) for near in (along >= most - 1e-12 * size).T]
        assert all(len(ends) >= 2 for ends in touching)
        if edges > 2:
            bounded = clip(mine, most, np.full(2, -9 * size), np.full(2, 9 * size))[0]
            assert bounded.area == pytest.approx(area_of(hull), rel=1e-6, abs=1e-9 * size**2)


def test_odometry_is_a_sector_of_ones_own_past():
    """Forwards, backwards, and both: where the vertices are is for the sector to say."""
    distance, bound = np.array([2.0, -2.0, 0.1, 2.0]), np.array([0.5, 0.5, 0.3, 0.5])
    record = Odometry(0, 1, np.arange(4), distance, bound, 0.0, 0.0, 0.1, 0.0)
    heading, known = np.array([0.4, 3.0, -2.0, 1.0]), np.array([0.2, 0.0, 0.3, 0.2])
    vertices = displacements(record, AngularIntervals(heading, known), Team(4), 1.0).vertices
    wide, chord = known + 0.1, np.cos(0.1)
    for robot, (ahead, behind) in enumerate(
        [((1.5, 2.5), None), (None, (1.5, 2.5)), ((0.0, 0.4), (0.0, 0.2)), ((1.5, 2.5), None)]
    ):
        parts = [(heading[robot], ahead), (heading[robot] + np.pi, behind)]
        expected = [trapezoid(way, wide[robot], reach[0] * chord, reach[1]) for way, reach in parts if reach]
        assert hull_of(vertices[robot]) == pytest.approx(hull_of(np.concatenate(expected)), abs=1e-9)


def test_where_the_direction_is_hardly_known_the_motion_is_in_a_square_and_its_length_is_known():
    record = Odometry(0, 1, 0, 2.0, 0.1, 0.0, 0.0, 0.1, 0.0)
    moves = displacements(record, AngularIntervals([0.3], [WIDEST]), Team(1), 1.0)
    assert hull_of(moves.vertices[0]) == pytest.approx(2.1 * np.array([[-1, -1], [1, -1], [1, 1], [-1, 1]]))
    directions = unit(np.linspace(-np.pi, np.pi, 25))
    assert moves.support(np.zeros(25, dtype=int), directions) == pytest.approx(2.1)
