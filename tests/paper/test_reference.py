"""Anchors bound a team, or the error tells who can go where: proved boxes, and directions that arithmetic confirms."""

import numpy as np
import pytest
from helpers.worlds import NO_ROWS

from experiments.paper.formations import draw_formation
from experiments.paper.reference import Unbounded, bounded_box, free_coordinates
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import Constraints
from filter.linear.solvers import SIMPLEX
from filter.sensing.rows import bearing_rows

BOUND = np.radians(5)
SQUARE = np.array([[0.0, 0.0], [2.0, 0.3], [2.2, 2.0], [0.1, 2.1]])


def rows_of(positions, pairs, bound=BOUND):
    """Return the rows of exact bearings between pairs of robots."""
    robot, target = np.array(pairs).T
    away = positions[target] - positions[robot]
    arcs = AngularIntervals(np.arctan2(away[:, 1], away[:, 0]), np.full(len(robot), bound))
    return bearing_rows(robot, target, arcs, np.arange(len(robot)))


def anchored(positions, *coordinates):
    """Return anchors at the true values of (robot, axis)."""
    anchors = np.full(positions.shape, np.nan)
    for place in coordinates:
        anchors[place] = positions[place]
    return anchors


EVERY = [(i, j) for i in range(4) for j in range(4) if i != j]
FRAME = ((0, 0), (0, 1), (1, 0))  # robot 0, and the scale


@pytest.mark.parametrize("solver", ["piqp", "highs", SIMPLEX])
@pytest.mark.parametrize("far", [0.0, 1e5])
@pytest.mark.parametrize("size", [1e-2, 1.0, 1e4])
def test_the_box_contains_the_truth_and_is_of_the_formations_size(size, far, solver):
    positions = far + size * SQUARE
    lower, upper = bounded_box(rows_of(positions, EVERY), anchored(positions, *FRAME), solver)
    assert (lower <= positions).all()
    assert (positions <= upper).all()
    assert (upper - lower).max() < 2 * size
    assert (lower == upper).sum() == 3


@pytest.mark.parametrize("seed", range(3))
def test_solvers_find_the_same_box(seed):
    formation = draw_formation(np.random.default_rng(seed), 7, BOUND)
    anchors = formation.anchors([0])
    rows = formation.polytope(anchors).constraints
    boxes = [np.array(bounded_box(rows, anchors, solver)) for solver in ("piqp", SIMPLEX)]
    size = np.ptp(boxes[0]).max()
    assert boxes[0] == pytest.approx(boxes[1], abs=1e-4 * size)


def unbounded(rows, anchors):
    """Return the error, with its direction confirmed: no row holds it back, no anchor moves, and who is named moves."""
    with pytest.raises(Unbounded) as caught:
        bounded_box(rows, anchors)
    error = caught.value
    direction = error.direction
    moved = np.array([normal @ (direction[j] - direction[i]) for i, j, normal in zip(rows.i, rows.j, rows.normal, strict=True)])
    assert (moved <= 1e-6).all()
    assert (direction[~np.isnan(anchors)] == 0).all()
    assert np.abs(direction).max() == pytest.approx(1)
    assert error.robots == tuple(np.flatnonzero(direction.any(axis=1)))
    for robot in error.robots:
        assert f"{robot}" in str(error)
    return error


def test_without_any_anchor_the_whole_team_is_adrift():
    error = unbounded(rows_of(SQUARE, EVERY), anchored(SQUARE))
    assert error.robots == (0, 1, 2, 3)
    assert np.ptp(error.direction, axis=0).max() == 0  # a translation
    assert "no anchor" in str(error)


def test_without_the_scale_the_team_can_grow():
    error = unbounded(rows_of(SQUARE, EVERY), anchored(SQUARE, *FRAME[:2]))
    assert error.robots == (1, 2, 3)
    assert "scale" in str(error)


def test_a_part_that_nobody_sees_is_adrift():
    positions = np.concatenate([SQUARE, SQUARE + 9])
    pairs = EVERY + [(i + 4, j + 4) for i, j in EVERY]
    error = unbounded(rows_of(positions, pairs), anchored(positions, *FRAME))
    assert error.robots == (4, 5, 6, 7)


def test_a_part_with_its_own_reference_is_held():
    positions = np.concatenate([SQUARE, SQUARE + 9])
    rows = rows_of(positions, EVERY + [(i + 4, j + 4) for i, j in EVERY])
    lower, upper = bounded_box(rows, anchored(positions, *FRAME, (4, 0), (4, 1), (6, 1)))
    assert (lower <= positions).all()
    assert (positions <= upper).all()
    error = unbounded(rows, anchored(positions, *FRAME, (4, 0), (4, 1)))
    assert error.robots == (5, 6, 7)


def test_a_part_of_which_one_axis_is_anchored_slides_along_the_other():
    error = unbounded(rows_of(SQUARE, EVERY), anchored(SQUARE, (0, 0), (1, 0)))
    assert error.direction.tolist() == [[0, 1]] * 4


def test_a_robot_seen_by_one_neighbour_alone_can_be_anywhere_along_the_ray():
    positions = np.concatenate([SQUARE, [[4.0, 4.0]]])
    error = unbounded(rows_of(positions, [*EVERY, (2, 4), (4, 2)]), anchored(positions, *FRAME))
    assert error.robots == (4,)
    way = error.direction[4] / np.hypot(*error.direction[4])
    ray = (positions[4] - positions[2]) / np.hypot(*(positions[4] - positions[2]))
    assert way @ ray > np.cos(BOUND)


def test_rows_that_exclude_one_another_are_left_to_the_filter():
    """It names the measurements; here there is a box, if an empty one."""
    rows = rows_of(SQUARE, EVERY)
    wrong = rows_of(SQUARE[[0, 3, 2, 1]], [(0, 1)])
    lower, upper = bounded_box(Constraints.concatenate([rows, wrong]), anchored(SQUARE, *FRAME))
    assert (lower <= upper).all()


def test_a_team_of_anchors_alone_has_their_box():
    lower, upper = bounded_box(NO_ROWS, SQUARE)
    assert lower.tolist() == upper.tolist() == SQUARE.tolist()


@pytest.mark.parametrize("wrong", [np.zeros(3), np.zeros((0, 2)), [[0.0, np.inf]], np.zeros((2, 3))])
def test_anchors_that_are_none_are_refused(wrong):
    with pytest.raises(InvalidInput):
        free_coordinates(wrong)
