"""Pruning drops rows, never adds or changes one, and drops what matters least."""

import numpy as np
import pytest
from helpers.programs import on_robot
from helpers.worlds import NO_ROWS, of_robot, unit

from filter.geometry.polygon import clip
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope, prune


def polytope(rng, robots=3, each=20):
    """Return a polytope with `each` rows on every robot and every pair, around a point."""
    groups = [(WORLD, j) for j in range(robots)] + [(i, j) for j in range(robots) for i in range(j)]
    i, j = np.repeat(groups, each, axis=0).T
    rows = Constraints(i, j, unit(rng.uniform(-np.pi, np.pi, len(i))), rng.uniform(0.3, 1, len(i)), np.arange(len(i)))
    return Polytope(rows, np.full((robots, 2), -2.0), np.full((robots, 2), 2.0))


def worthy(normals, offsets, half, budget):
    """Return the rows to keep of the part of a box that lies in some half-planes."""
    rows = on_robot(0, normals, offsets, np.arange(len(offsets)))
    return prune(Polytope(rows, np.full((1, 2), -half), np.full((1, 2), half)), budget, 0).source


def groups_of(rows):
    return np.unique(np.stack([rows.i, rows.j]), axis=1, return_counts=True)


@pytest.mark.parametrize("budgets", [(4, 4), (4, 9), (12, 5), (100, 100)])
@pytest.mark.parametrize("seed", range(4))
def test_no_more_rows_than_the_budget_are_left_and_all_of_them_were_there(seed, budgets):
    team = polytope(np.random.default_rng(seed))
    left = prune(team, *budgets)
    groups, counts = groups_of(left)
    assert (counts <= np.where(groups[0] == WORLD, *budgets)).all()
    assert (np.diff(left.source) > 0).all()
    for name in ("i", "j", "normal", "offset"):
        assert getattr(left, name).tolist() == getattr(team.constraints, name)[left.source].tolist()


@pytest.mark.parametrize("seed", range(10))
def test_pruning_never_shrinks_and_hardly_grows(seed):
    rng = np.random.default_rng(seed)
    team = polytope(rng, each=40)
    pruned = team.with_constraints(prune(team, 8, 8))
    points = rng.uniform(-2, 2, (3000, 3, 2)) * rng.uniform(0, 1, (3000, 1, 1))
    inside = points[team.program().holds(points.reshape(3000, 6))]
    assert len(inside) > 20
    assert pruned.program().holds(inside.reshape(-1, 6)).all()
    for robot in range(3):
        assert 1 - 1e-9 <= of_robot(pruned, robot)[0].area / of_robot(team, robot)[0].area < 1.25


def test_rows_that_others_imply_go_first():
    normals = unit(np.linspace(-np.pi, np.pi, 8, endpoint=False))
    rows = Constraints.concatenate(
        [on_robot(0, normals, np.full(8, offset), np.arange(8) + 8 * k) for k, offset in enumerate((3.0, 1.0, 2.0))]
    )
    team = Polytope(rows, np.full((1, 2), -9.0), np.full((1, 2), 9.0))
    assert prune(team, 8, 8).source.tolist() == list(range(8, 16))
    assert prune(team, 20, 8).source.tolist() == list(range(8, 16))


def test_the_edge_whose_removal_adds_least_goes_first():
    box = np.array([[1.0, 0], [0, 1], [-1, 0], [0, -1]])
    corner = unit(np.pi / 4)[None]
    kept = worthy(np.vstack([box, corner]), np.append(np.ones(4), 1.4), 9.0, 4)
    assert sorted(kept) == [0, 1, 2, 3]


def test_greedy_pruning_is_as_good_as_trying_every_single_edge():
    rng = np.random.default_rng(3)
    for _ in range(20):
        normals = unit(np.sort(rng.uniform(-np.pi, np.pi, 9)))
        offsets, lower, upper = rng.uniform(0.5, 1, 9), np.full(2, -20.0), np.full(2, 20.0)
        edges = clip(normals, offsets, lower, upper)[1]
        rows = edges[edges < 9]
        kept = worthy(normals, offsets, 20.0, len(rows) - 1)
        areas = {
            gone: clip(np.delete(normals, gone, 0), np.delete(offsets, gone), lower, upper)[0].area for gone in rows.tolist()
        }
        (gone,) = set(rows.tolist()) - set(kept.tolist())
        bounded = {row: area for row, area in areas.items() if area < 100}
        assert areas[gone] <= min(bounded.values(), default=np.inf) + 1e-9


def test_the_box_stays_and_counts_nothing():
    assert worthy(np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([0.0, 0.5]), 1.0, 1).tolist() == [0]
    assert worthy(np.zeros((0, 2)), np.zeros(0), 1.0, 4).tolist() == []


@pytest.mark.parametrize("width", [0.0, 1e-12])
def test_slivers_points_and_duplicates_are_pruned_too(width):
    normals = np.tile(unit(np.array([0.0, np.pi, 0.3, 0.3 + np.pi])), (6, 1))
    rows = on_robot(0, normals, np.full(24, width), np.arange(24))
    team = Polytope(rows, np.full((1, 2), -1.0), np.full((1, 2), 1.0))
    left = prune(team, 4, 4)
    assert len(left) <= 4
    assert of_robot(team.with_constraints(left), 0)[0].contains([0.0, 0.0])


def test_a_polytope_without_rows_has_nothing_to_prune():
    assert len(prune(Polytope(NO_ROWS, np.zeros((2, 2)), np.ones((2, 2))), 4, 4)) == 0
