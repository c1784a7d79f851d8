"""Directions of one convex set from another: none that is true is left out, whatever the sets."""

import numpy as np
import pytest
import shapely
from hypothesis import given
from hypothesis import strategies as st

from filter.geometry.angles import wrap
from filter.geometry.polygon import Polygon
from filter.poses.cone import directions

seeds = st.integers(0, 2**32 - 1)
CORNERS = {"hexagon": 6, "segment": 2, "point": 1}


@given(seeds)
def test_directions_hold_from_everywhere_that_is_not_too_near(seed):
    rng = np.random.default_rng(seed)
    cell, points = (
        np.array(shapely.MultiPoint(rng.normal(size=(6, 2))).convex_hull.exterior.coords)[:-1][::-1] for _ in range(2)
    )
    points = points * 10.0 ** rng.uniform(-3, 0) + rng.normal(size=2)
    if rng.random() < 0.3:
        points = cell[:1] + 0.0  # the target is a corner
    nearest = float(rng.choice([0.0, 0.1, 1.0]))
    centre, bound, farthest = directions(cell, len(cell), points, nearest, 1e-9)
    weights = rng.dirichlet(np.full(len(cell), 0.3), 300), rng.dirichlet(np.full(len(points), 0.3), 300)
    apart = weights[1] @ points - weights[0] @ cell
    away = np.hypot(*apart.T)
    assert (away <= farthest).all()
    seen = apart[(away >= nearest) & (away > 1e-6)]
    if bound < np.pi:
        assert (np.abs(wrap(np.arctan2(seen[:, 1], seen[:, 0]) - centre)) <= bound).all()


@given(seeds, *[st.sampled_from(sorted(CORNERS))] * 2, st.sampled_from(["apart", "overlapping", "touching"]))
def test_true_directions_are_in_the_arc_whatever_the_sets(seed, one, other, how):
    rng = np.random.default_rng(seed)
    cell, points = (Polygon.hull(rng.normal(size=(CORNERS[each], 2))).vertices for each in (one, other))
    points = points + {"apart": cell[0] + 4, "overlapping": cell.mean(0) - points.mean(0), "touching": cell[0] - points[0]}[how]
    nearest = rng.uniform(0.01, 1)
    centre, bound, farthest = directions(cell, len(cell), points, nearest, 1e-12)
    weights = [rng.dirichlet(np.full(len(each), 0.3), 400) for each in (cell, points)]
    apart = np.concatenate([weights[1] @ points - weights[0] @ cell, (points[:, None] - cell).reshape(-1, 2)])
    away = np.hypot(*apart.T)
    seen = apart[away >= nearest]
    assert (away <= farthest).all()
    assert (np.abs(wrap(np.arctan2(seen[:, 1], seen[:, 0]) - centre)) <= bound).all()
    assert bound <= np.pi


@pytest.mark.parametrize("hair", [0.0, 1e-12, -1e-12, 1e-9, -1e-9])
def test_a_mark_on_the_edge_of_a_cell_is_in_half_of_all_directions(hair):
    cell = np.array([[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]])
    _, bound, _ = directions(cell, 4, np.array([[1.0 + hair, 0.3]]), 0.5, 1e-13)
    assert bound == pytest.approx(np.pi / 2, abs=1e-6)
