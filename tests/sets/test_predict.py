"""A prediction is a Minkowski sum: rows through corners follow from the polytope, and the truth stays inside."""

from fractions import Fraction

import numpy as np
import pytest
import shapely
from helpers.programs import on_robot, supports
from helpers.teams import beliefs, odometry
from helpers.worlds import World, escapes, unit
from hypothesis import given
from hypothesis import strategies as st

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.guarantee import Guarantee
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Source, Sources
from filter.projection.claims import Weights
from filter.projection.window import Window
from filter.sensing.motion import displacements
from filter.sets.belief import Belief
from filter.sets.predict import moved, rows_through_corners
from filter.sets.proof import Proof
from filter.team import Team

EVERYWHERE = np.array([[-np.inf] * 2, [np.inf] * 2])


def polytope_of(polygon, room=1.0):
    lower, upper = polygon.bounds
    rows = on_robot(0, polygon.normals, polygon.offsets, np.zeros(len(polygon.offsets), dtype=int))
    return Polytope(rows, lower[None] - room, upper[None] + room)


def believed(polytope, i=(WORLD,), j=(0,)):
    """Return a belief in which something was proved of some robots or pairs."""
    robots, count = len(polytope.lower), len(i)
    sources, _ = Sources().extended("initial set", 0.0, np.arange(robots))
    none = Weights(np.zeros(0, dtype=int), np.zeros(0), np.zeros(count + 1, dtype=int))
    proof = Proof("regions", polytope, sources, np.array(i), np.array(j), np.zeros((count, 2)), np.zeros(count), none)
    return Belief(0.0, polytope, AngularIntervals.circles(robots), sources, Guarantee.full(robots), proofs=(proof,))


def motion(robots=1, distance=1.0, heading=0.3, wide=0.2, slip=0.0):
    """Return displacements along a heading, and behind."""
    record = odometry(0.0, 1.0, np.arange(robots), distance, distance_bound=0.1, direction_bound=wide, slip_bound=slip)
    return displacements(record, AngularIntervals(np.full(robots, heading), np.zeros(robots)), Team(robots), 1.0)


def exactly_most(vertices, normal):
    a, b = map(Fraction, normal)
    return max(a * x + b * y for x, y in vertices)


@given(st.integers(0, 2**32 - 1), st.sampled_from([0.0, 1e3, 5e6]), st.sampled_from([1e-6, 1.0, 1e3]))
def test_no_row_through_a_corner_cuts_the_polygon_and_each_touches_it(seed, origin, size):
    rng = np.random.default_rng(seed)
    points = origin + size * rng.normal(size=(rng.integers(3, 12), 2))
    polygon, moves = Polygon.from_vertices(points), motion(heading=rng.uniform(-np.pi, np.pi))
    rows, table = rows_through_corners(believed(polytope_of(polygon, room=size)), moves)
    wanted = moves.normals[0][np.isfinite(moves.normals[0][:, 0])]
    assert rows.normal.tolist() == wanted.tolist()
    assert 3 <= len(rows) <= 8
    inside = [[Fraction(float(x)) for x in point] for point in points]
    for normal, offset in zip(rows.normal.tolist(), rows.offset.tolist(), strict=True):
        assert exactly_most(inside, normal) <= Fraction(offset)
    angles = np.sort(np.arctan2(polygon.normals[:, 1], polygon.normals[:, 0]))
    if np.diff(np.append(angles, angles[0] + 2 * np.pi)).max() < 3:  # beside a sharp corner the two edges say little
        reached = (rows.normal @ polygon.vertices.T).max(axis=1)
        assert rows.offset == pytest.approx(reached, abs=1e-6 * size + 1e-13 * origin + 4 * polygon.margin)
    assert {table[int(k)] for k in rows.source} == {Source("region", 0.0, 0)}


@pytest.mark.parametrize(
    "polygon", [Polygon.box([1, 2], [1, 2]), Polygon.from_vertices([[0, 0], [3, 1]])], ids=["point", "segment"]
)
def test_of_a_point_and_of_a_segment_no_row_cuts_anything(polygon):
    rows, _ = rows_through_corners(believed(polytope_of(polygon)), motion())
    assert len(rows) > 2
    assert (rows.normal @ polygon.vertices.T <= rows.offset[:, None] + 1e-15).all()


def test_rows_on_a_pair_are_implied_by_the_pairs_rows_and_have_the_normals_of_both():
    rng = np.random.default_rng(2)
    angles = np.sort(rng.uniform(-np.pi, np.pi, 9))
    rows = Constraints(np.full(9, 1), np.full(9, 2), unit(angles), rng.uniform(0.5, 1.0, 9), np.zeros(9, dtype=int))
    polytope, pair = Polytope(rows, np.full((3, 2), -4.0), np.full((3, 2), 4.0)), (np.array([1]), np.array([2]))
    record = odometry(0.0, 1.0, [1, 2], [1.0, 0.5], distance_bound=0.1, direction_bound=0.2)
    moves = displacements(record, AngularIntervals([0.0, 0.3, 1.9], [0.0] * 3), Team(3), 1.0)
    found, table = rows_through_corners(believed(polytope, *pair), moves)
    of_each = [moves.normals[k][np.isfinite(moves.normals[k][:, 0])] for k in (2, 1)]
    assert sorted(found.normal.tolist()) == sorted([*of_each[0].tolist(), *(-of_each[1]).tolist()])
    assert set(zip(found.i.tolist(), found.j.tolist(), strict=True)) == {(1, 2)}
    assert {str(table[int(k)]) for k in found.source} == {"region of robot 2 to 1 at 0.000 s"}
    before = polytope.of(*pair).polygons
    after = polytope.with_constraints(Constraints.concatenate([rows, found])).of(*pair).polygons
    assert after.areas == pytest.approx(before.areas, rel=1e-9)


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 3)])
@pytest.mark.parametrize(("errors", "origin"), [("uniform", 0.0), ("extreme", 0.0), ("uniform", 5e6)])
def test_rows_through_corners_follow_from_the_whole_polytope(errors, origin, scope):
    """Whatever is in the polytope satisfies them: here, its own greatest values as HiGHS has them, and the truth exactly."""
    world = World(np.random.default_rng(4), robots=4, errors=errors, origin=np.full(2, origin))
    for belief in beliefs(SetMembershipFilter(world.team, scope=scope), world, 3):
        moves = displacements(world_motion(world), belief.headings, world.team, 0.1)
        rows, sources = rows_through_corners(belief, moves)
        after = Belief(0.0, belief.polytope.with_constraints(rows), belief.headings, sources, belief.guarantee)
        assert escapes(after, world.positions) == []
    assert set(zip(rows.i.tolist(), rows.j.tolist(), strict=True)) >= {(WORLD, 0), (0, 1), (2, 3)}
    for k in range(0, len(rows), 7):
        true = supports(belief.polytope, rows.normal[k : k + 1], int(rows.j[k]), int(rows.i[k]))
        assert rows.offset[k] >= true[0] - 1e-9


def world_motion(world):
    n = world.robots
    return odometry(0.0, 0.1, np.arange(n), np.full(n, 0.04), direction_bound=0.02, distance_bound=1e-3, slip_bound=1e-3)


@pytest.mark.parametrize("seed", range(4))
def test_what_is_predicted_is_the_sum_of_polygon_and_displacements(seed):
    rng = np.random.default_rng(seed)
    polygon, moves = Polygon.from_vertices(rng.normal(size=(8, 2))), motion(heading=rng.uniform(-np.pi, np.pi))
    belief = believed(polytope_of(polygon, room=9.0))
    polytope, _ = moved(belief, 1.0, moves, EVERYWHERE, corners=True)
    after = polytope.of_robots(np.array([0])).polygons[0]
    corners, shares = moves.vertices[0], rng.exponential(1, (200, len(moves.vertices[0])))
    gone = np.concatenate([corners, shares @ corners / shares.sum(axis=1, keepdims=True)])
    gone = gone[np.hypot(*gone.T) <= moves.reach[0]]  # the corners of the sector's far side are out of reach
    assert len(gone) > 200
    inside = polygon.vertices * (1 - 1e-12) + 1e-12 * polygon.centroid
    reached = (inside[:, None] + gone[None]).reshape(-1, 2)
    assert after.contains(reached).all()
    exact = shapely.MultiPoint((polygon.vertices[:, None] + corners[None]).reshape(-1, 2)).convex_hull
    assert shapely.MultiPoint(reached).convex_hull.area <= after.area <= exact.area * (1 + 1e-9)
    alone = moves.moved(belief.constraints)
    mitred = Polytope(alone, polytope.lower, polytope.upper).of_robots(np.array([0])).polygons[0]
    assert mitred.area > after.area * 1.001


@pytest.mark.parametrize("seed", range(3))
def test_regions_are_no_larger_than_by_moving_rows_alone(seed):
    world = World(np.random.default_rng(seed), robots=3, errors="extreme" if seed else "uniform")
    estimator = SetMembershipFilter(world.team)
    *_, belief = beliefs(estimator, world, 4)
    record = world.move()
    moves = displacements(record, belief.headings, world.team, 0.1)
    predicted = estimator.predict(belief, record.time, record)
    assert escapes(predicted, world.positions, world.headings) == []
    alone = Polytope(moves.moved(belief.constraints), predicted.polytope.lower, predicted.polytope.upper)
    for i, j in ((np.full(3, WORLD), np.arange(3)), np.triu_indices(3, 1)):
        with_corners, without = (each.of(i, j).polygons.areas for each in (predicted.polytope, alone))
        assert (with_corners <= without * (1 + 1e-9) + 1e-15).all()
        assert with_corners.sum() < without.sum() * (1 - 1e-6)


@pytest.mark.parametrize("seed", range(3))
def test_following_with_rows_through_corners_is_tighter(seed):
    def followed(corners):
        world = World(np.random.default_rng(seed), robots=3, errors="extreme" if seed else "uniform")
        *_, belief = beliefs(SetMembershipFilter(world.team, corners=corners), world, 10)
        return belief.regions.outer.areas

    fine, none = followed(corners=True), followed(corners=False)
    assert (fine <= none * 1.003 + 1e-12).all()
    assert fine.sum() < none.sum() * (1 - 1e-3 if seed == 0 else 1 + 1e-6)  # the others end as points


def test_without_a_proof_rows_are_moved_alone():
    belief = believed(polytope_of(Polygon.box([0, 0], [1, 1])))
    bare = Belief(0.0, belief.polytope, belief.headings, belief.sources, belief.guarantee)
    rows, sources = rows_through_corners(bare, motion())
    assert len(rows) == 0
    assert len(sources) == len(bare.sources)


def test_a_box_that_does_not_move_stays_to_the_last_bit_and_others_move_outward():
    polytope = Polytope(
        on_robot(0, np.zeros((0, 2)), np.zeros(0), np.zeros(0, dtype=int)),
        np.array([[0.1, 0.2], [0.3, 0.4]]),
        np.array([[0.1, 0.2], [0.5, 0.6]]),
    )
    still = Team(2, speed_limit=0.0)
    record = odometry(0.0, 1.0, 1, 1.0)
    moves = displacements(record, AngularIntervals([0.0, 0.0], [0.0, 0.0]), still, 1.0)
    after, _ = moved(believed(polytope), 1.0, moves, EVERYWHERE, corners=True)
    assert (after.lower[0].tolist(), after.upper[0].tolist()) == ([0.1, 0.2], [0.1, 0.2])
    assert after.lower[1] == pytest.approx([1.3, 0.4])
    assert (after.lower[1] <= [1.3, 0.4]).all()
    assert (after.upper[1] >= [1.5, 0.6]).all()


def test_the_arena_cuts_the_box_and_who_has_left_it_is_named():
    polytope, moves = polytope_of(Polygon.box([0, 0], [1, 1]), room=0.0), motion(distance=2.0, heading=0.0)
    after, _ = moved(believed(polytope), 1.0, moves, np.array([[-9.0, -9.0], [2.5, 9.0]]), corners=True)
    assert after.upper[0, 0] == 2.5
    with pytest.raises(Inconsistent, match=r"robot 0 has left the arena by 1\.0 s"):
        moved(believed(polytope), 1.0, moves, np.array([[-9.0, -9.0], [1.5, 9.0]]), corners=True)
