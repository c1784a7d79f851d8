"""Cells: no pose that agrees with what was measured is lost, whatever the geometry; what is proved empty is."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from filter import Bearing, Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.linear.sources import Source
from filter.poses.cell import CELL_CORNERS, Scale, cut
from filter.poses.cells import Most, Scene, Told, as_sets
from filter.poses.slices import Slices
from filter.sensing.readings import Readings
from filter.team import Team

seeds = st.integers(0, 2**32 - 1)
SPACING = np.radians(30)
SHAPES = ["any", "far away", "target at a corner", "near", "a point"]


def scene(rng, shape):
    """Return a team of two robots among landmarks, where they can be, and where they are."""
    origin = 5e6 if shape == "far away" else 0.0
    positions, headings = origin + rng.uniform(-3, 3, (2, 2)), rng.uniform(-np.pi, np.pi, 2)
    marks = origin + rng.uniform(-5, 5, (3, 2))
    if shape == "target at a corner":
        marks[0] = positions[0] + rng.uniform(0.3, 1, 2)
    if shape == "near":
        marks[0] = positions[0] + rng.normal(size=2) * 10.0 ** rng.uniform(-6, -1)
    low, high = rng.uniform(0, 4, (2, 2, 2)) * (0 if shape == "a point" else 1)
    if shape == "target at a corner":
        high[0] = marks[0] - positions[0]
    boxes = [Polygon.box(place - a, place + b) for place, a, b in zip(positions, low, high, strict=True)]
    return Team(2, marks, 0.5, 1.0), boxes, positions, headings


def measured(rng, team, positions, headings, tight):
    bodies, who, whom = np.concatenate([positions, team.landmarks]), [], []
    for robot in range(2):
        for target in rng.permutation([k for k in range(5) if k != robot])[: rng.integers(0, 4)].tolist():
            who.append(robot)
            whom.append(target)
    apart = bodies[whom] - positions[who]
    count, size = len(who), 0.0 if tight else 1.0
    angle_bound, bound = size * rng.uniform(0.01, 0.2, count), size * rng.uniform(0.01, 0.3, count)
    bearings = np.arctan2(apart[:, 1], apart[:, 0]) - headings[who] + rng.choice([-1, 1], count) * angle_bound
    ranges = np.maximum(0, np.hypot(*apart.T) + rng.choice([-1, 1], count) * bound)
    some, others = rng.random(count) < 0.6, rng.random(count) < 0.6
    who, whom = np.array(who, dtype=int), np.array(whom, dtype=int)
    return [
        Bearing(0.0, who[some], whom[some], bearings[some], angle_bound[some] + 1e-12),
        Range(0.0, who[others], whom[others], ranges[others], bound[others] + 1e-9 * (1 + np.abs(positions).max()), 0.0),
    ]


def found(team, boxes, headings, records, robot=0):
    belief = SetMembershipFilter(team).start(0.0, boxes, headings)
    told = Told.of(Readings.of(0.0, records), headings, SPACING)
    if not (told.robot == robot).any():
        return None
    scene = Scene(belief.polytope, belief.sources, told, team.landmarks, Slices.none())
    cases, nowhere = scene.in_cells(np.array([robot]), Most(64, 0))
    return cases[0] if nowhere < 0 else None


@given(
    seeds,
    st.sampled_from(["any", "far away", "target at a corner", "near", "a point"]),
    st.sampled_from([0.0, 0.05, 0.5, np.pi]),
)
def test_the_truth_is_never_cut_off(seed, shape, wide):
    rng = np.random.default_rng(seed)
    team, boxes, positions, headings = scene(rng, shape)
    arcs = AngularIntervals(headings + rng.uniform(-1, 1, 2) * wide, np.full(2, min(np.pi, wide + 1e-9)))
    records = measured(rng, team, positions, headings, tight=bool(rng.random() < 0.2))
    for robot in range(2):
        if not any((record.robot == robot).any() or (record.target == robot).any() for record in records):
            continue
        case = found(team, boxes, arcs, records, robot)
        assert case is not None
        assert (case.rows[:, :2] @ positions[robot] <= case.rows[:, 2]).all()
        assert AngularIntervals(*case.heading[:, None]).contains(headings[robot])[0]


@pytest.mark.parametrize("seed", range(12))
def test_no_pose_that_agrees_with_everything_is_lost(seed):
    """The slow way: poses drawn at random, those kept that agree with every reading; the mate is anywhere it can be."""
    rng = np.random.default_rng(seed)
    team, boxes, positions, headings = scene(rng, "any")
    arcs = AngularIntervals(headings, np.full(2, 0.3))
    records = measured(rng, team, positions, headings, tight=False)
    bearings, ranges = records
    if not len(bearings.robot) + len(ranges.robot):
        return
    case = found(team, boxes, arcs, records)
    count = 40_000
    bodies = np.empty((5, count, 2))
    spread = 10.0 ** rng.uniform(-2, 0.5, count)[:, None]
    for k in range(2):
        near = positions[k] + spread * rng.normal(size=(count, 2))
        bodies[k] = np.clip(near, boxes[k].bounds[0], boxes[k].bounds[1])
    bodies[2:] = team.landmarks[:, None]
    turned = headings[:, None] + rng.uniform(-0.3, 0.3, (2, count))
    agrees = np.ones(count, dtype=bool)
    for who, whom, value, bound in zip(bearings.robot, bearings.target, bearings.bearing, bearings.bound, strict=True):
        apart = bodies[whom] - bodies[who]
        agrees &= np.abs(wrap(np.arctan2(apart[:, 1], apart[:, 0]) - turned[who] - value)) <= bound
    for who, whom, value, bound in zip(ranges.robot, ranges.target, ranges.range, ranges.bound, strict=True):
        agrees &= np.abs(np.hypot(*(bodies[whom] - bodies[who]).T) - value) <= bound
    if case is None:
        assert not any((record.robot == 0).any() or (record.target == 0).any() for record in records)
        return
    assert (bodies[0][agrees] @ case.rows[:, :2].T <= case.rows[:, 2]).all()
    assert AngularIntervals(np.full(agrees.sum(), case.heading[0]), case.heading[1]).contains(turned[0][agrees]).all()


def test_readings_that_exclude_one_another_leave_nothing():
    team = Team(1, [[3.0, 0.0], [-3.0, 0.0]], 0.5, 1.0)
    box, circle = [Polygon.box([-5, -5], [5, 5])], AngularIntervals.circles(1)
    apart = Range(0.0, 0, [1, 2], [2.0, 2.0], 0.1, 0.0)  # two rings that do not meet
    assert found(team, box, circle, [apart]) is None
    meet = Range(0.0, 0, [1, 2], [3.0, 3.05], 0.1, 0.0)
    assert found(team, box, circle, [meet]) is not None


def test_the_filter_names_all_that_leaves_a_robot_no_place():
    team = Team(1, [[3.0, 0.0], [-3.0, 0.0]], 0.5, 1.0, [[-9, -9], [9, 9]])
    estimator = SetMembershipFilter(team)
    belief = estimator.start(0.0, [Polygon.box([-5, -5], [5, 5])], AngularIntervals.circles(1))
    with pytest.raises(Inconsistent) as caught:
        estimator.update(belief, [Range(0.0, 0, [1, 2], [2.0, 2.0], 0.1, 0.0)])
    assert {Source("range", 0.0, 0, 1), Source("range", 0.0, 0, 2)} <= set(caught.value.sources)


@given(seeds)
def test_a_cut_is_the_intersection_with_a_half_plane(seed):
    rng = np.random.default_rng(seed)
    corners = Polygon.hull(rng.normal(size=(8, 2))).vertices
    angle, offset = rng.uniform(-np.pi, np.pi), rng.normal()
    x, y = np.cos(angle), np.sin(angle)
    cell = np.empty((CELL_CORNERS, 2))
    cell[: len(corners)] = corners
    size = cut(cell, len(corners), (x, y, offset), Scale(10.0, 1e-9, np.empty((CELL_CORNERS + 2, 2))))
    beside = [(offset * x + a * y - b * x, offset * y - a * x - b * y) for a, b in ((9, 0), (9, 20), (-9, 20), (-9, 0))]
    left = shapely.Polygon(corners).intersection(shapely.Polygon(beside)).area
    assert (shapely.Polygon(cell[:size]).area if size > 2 else 0.0) == pytest.approx(left, abs=1e-9)


def test_mates_as_sets_contain_what_their_rows_leave():
    rng = np.random.default_rng(3)
    polygons = [Polygon.from_vertices(rng.normal(size=(40, 2))) for _ in range(3)]
    belief = SetMembershipFilter(Team(3, np.zeros((0, 2)), 0.5, 1.0)).start(0.0, polygons)
    for few, polygon in zip(as_sets(belief.polytope, np.arange(3), 8), polygons, strict=True):
        assert len(few.vertices) <= 12
        assert few.contains(polygon.vertices * (1 - 1e-9) + 1e-9 * polygon.centroid).all()
