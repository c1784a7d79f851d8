"""What the team's polytope says of one robot or one pair at a glance."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.programs import on_robot, random_polytope
from helpers.worlds import NO_ROWS, of_pair, of_robot, unit

from filter.geometry.polygon import SIDES
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope


def polytope(rng, robots=3, count=18):
    """Return a polytope with a point inside, and the point (n, 2)."""
    lower = rng.normal(size=(robots, 2))
    upper = lower + rng.uniform(1, 2, (robots, 2))
    inside = (lower + upper) / 2
    i, j = rng.integers(0, robots, count), rng.integers(0, robots, count)
    alone = i == j
    rows = [
        Constraints.between(
            i[~alone], j[~alone], unit(rng.uniform(-3, 3, (~alone).sum())), np.zeros((~alone).sum()), np.flatnonzero(~alone)
        ),
        *(on_robot(k, unit(rng.uniform(-3, 3, 2)), np.zeros(2), np.array([90, 91])) for k in range(robots)),
    ]
    rows = Constraints.concatenate(rows)
    A = rows.matrix(robots)
    return Polytope(rows.shifted(A @ inside.ravel() + rng.uniform(0, 0.3, len(rows))), lower, upper), inside


@pytest.mark.parametrize("seed", range(10))
def test_polygons_at_a_glance_contain_what_the_polytope_allows(seed):
    rng = np.random.default_rng(seed)
    team, inside = polytope(rng)
    program = team.program()
    points = inside + rng.normal(size=(500, 3, 2)) * rng.uniform(0, 1, (500, 1, 1))
    allowed = points[program.holds(points.reshape(500, -1))]
    assert len(allowed) > 5
    for robot in range(3):
        assert of_robot(team, robot)[0].contains(allowed[:, robot]).all()
    for i, j in ((0, 1), (0, 2), (1, 2)):
        assert of_pair(team, i, j)[0].contains(allowed[:, j] - allowed[:, i]).all()


@pytest.mark.parametrize("seed", range(10))
def test_loosened_rows_and_boxes_allow_what_the_rows_did_and_no_more_within_these(seed):
    team, _ = polytope(np.random.default_rng(seed))
    loose = team.loosened(0.01)
    assert (loose.constraints.offset > team.constraints.offset).all()
    assert (loose.lower < team.lower).all()
    assert (loose.upper > team.upper).all()
    for robot in range(3):
        allowed, known = of_robot(loose, robot)[0], of_robot(team, robot)[0]
        assert allowed.contains(known.vertices).all()
        assert allowed.area > known.area
        assert of_robot(loose.within(team), robot)[0].area == pytest.approx(known.area)


def test_edges_name_their_rows():
    team, _ = polytope(np.random.default_rng(0))
    for polygon, edges, wanted in ((*of_robot(team, 1), (-1, 1)), (*of_pair(team, 0, 2), (0, 2))):
        rows, sides = np.flatnonzero(edges < len(team.constraints)), np.flatnonzero(edges >= len(team.constraints))
        assert len(rows) >= 2
        assert polygon.normals[sides].tolist() == SIDES[edges[sides] - len(team.constraints)].tolist()
        for k in rows:
            row = edges[k]
            assert (team.constraints.i[row], team.constraints.j[row]) == wanted
            assert polygon.normals[k].tolist() == team.constraints.normal[row].tolist()
            assert polygon.offsets[k] == team.constraints.offset[row]


def test_rows_that_exclude_one_another_are_proved_to_leave_nothing():
    rows = on_robot(0, np.array([[1.0, 0.0], [-1.0, 0.0]]), np.array([-1.0, -1.0]), np.zeros(2, dtype=int))
    assert Polytope(rows, np.full((1, 2), -2.0), np.full((1, 2), 2.0)).of_robots(np.array([0])).empty[0]


def test_the_program_has_the_rows_and_the_box():
    team, inside = polytope(np.random.default_rng(1))
    program = team.program()
    assert program.A.shape == (len(team.constraints), 6)
    assert (program.lower.tolist(), program.upper.tolist()) == (team.lower.ravel().tolist(), team.upper.ravel().tolist())
    assert program.holds(inside.reshape(1, -1))[0]


def test_other_rows_go_into_the_same_box():
    team, _ = polytope(np.random.default_rng(2))
    other = team.with_constraints(NO_ROWS)
    assert len(other.constraints) == 0
    assert other.lower is team.lower


def test_the_box_cannot_be_changed():
    team, _ = polytope(np.random.default_rng(3))
    for corner in (team.lower, team.upper):
        with pytest.raises(ValueError, match="read-only"):
            corner[0] = 0


@pytest.mark.parametrize("seed", range(20))
def test_a_row_that_seems_to_hold_nowhere_in_the_box_is_seen(seed):
    """Against all corners of both boxes: the least that a row can say is at one of them."""
    rng = np.random.default_rng(seed)
    lower = rng.uniform(-1, 0, (4, 2))
    upper = lower + rng.uniform(0, 1, (4, 2))
    i, j = np.array([(i, j) for j in range(4) for i in range(WORLD, j)])[rng.integers(0, 10, 8)].T
    rows = Constraints(i, j, unit(rng.uniform(-np.pi, np.pi, 8)), np.zeros(8), np.arange(8))
    box = np.stack([lower, upper])
    least = np.full(8, np.inf)
    for corner in np.ndindex(2, 2, 2, 2):
        of_j = np.stack([box[corner[m], rows.j, m] for m in range(2)], axis=1)
        of_i = np.stack([box[corner[2 + m], rows.i, m] for m in range(2)], axis=1)
        least = np.minimum(least, (rows.normal * (of_j - np.where((rows.i == WORLD)[:, None], 0.0, of_i))).sum(axis=1))
    barely = least + 1e-9
    for broken in range(-1, 8):
        offset = np.where(np.arange(8) == broken, least - 1e-9, barely)
        assert Polytope(replace(rows, offset=offset), lower, upper).may_have_a_broken_row() == (broken >= 0)


def test_the_box_around_a_pair_holds_every_difference():
    team = random_polytope(np.random.default_rng(0), 3, 0, at=1e6)
    lower, upper = team.around(np.array([WORLD, 0]), np.array([1, 2]))
    assert (lower[0].tolist(), upper[0].tolist()) == (team.lower[1].tolist(), team.upper[1].tolist())
    assert (lower[1] <= team.lower[2] - team.upper[0]).all()
    assert (upper[1] >= team.upper[2] - team.lower[0]).all()
    assert upper[1] == pytest.approx(team.upper[2] - team.lower[0], abs=1e-9)
