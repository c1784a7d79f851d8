"""The arena: tiles of one kind side by side, with homes and beacons within, and room to start from."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filter.errors import InvalidInput
from sim.geometry import distance_to_wall
from sim.layout import ATTEMPTS, HOMES, TILE, WALL_THICKNESS, Layout, layout, start_poses

teams = st.integers(1, 150)


@given(teams)
def test_homes_and_beacons_are_within_the_arena_and_clear_of_walls(robots):
    plan = layout(robots)
    low, high = plan.arena
    assert ((low < plan.homes[:, :2]) & (plan.homes[:, :2] < plan.homes[:, 2:]) & (plan.homes[:, 2:] < high)).all()
    assert ((low < plan.beacons) & (plan.beacons < high)).all()
    assert distance_to_wall(plan.beacons[:, None], plan.walls).min() > WALL_THICKNESS
    assert len({tuple(beacon) for beacon in plan.beacons.tolist()}) == len(plan.beacons)


@given(teams)
def test_no_grid_of_whole_tiles_has_less_of_a_rim(robots):
    tiles, size = -(-robots // 6), layout(robots).arena[1] - layout(robots).arena[0]
    columns, rows = np.round(size / TILE)
    assert size == pytest.approx(TILE * [columns, rows])
    assert columns * rows >= tiles
    shapes = [(c, r) for c in range(1, tiles + 1) for r in range(1, tiles + 1) if c * r >= tiles]
    assert size.sum() == pytest.approx(min(TILE @ shape for shape in shapes))


@given(teams)
def test_all_walls_are_as_thick_and_the_arena_is_what_the_outer_ones_enclose(robots):
    plan = layout(robots)
    assert (plan.walls[:, 2:] - plan.walls[:, :2]).min(axis=1) == pytest.approx(WALL_THICKNESS)
    outer = plan.walls[:4]
    assert outer[0, 3] == pytest.approx(plan.arena[0, 1])
    assert outer[1, 1] == pytest.approx(plan.arena[1, 1])
    assert outer[2, 2] == pytest.approx(plan.arena[0, 0])
    assert outer[3, 0] == pytest.approx(plan.arena[1, 0])


@given(teams, st.integers(0, 5))
def test_another_robot_in_the_same_tiles_changes_nothing_for_the_others(robots, more):
    tiles = -(-robots // 6)
    fewer, full = layout(robots), layout(min(robots + more, 6 * tiles))
    assert (full.homes[:robots] == fewer.homes).all()
    assert (full.walls == fewer.walls).all()
    assert (full.beacons == fewer.beacons).all()


def test_home_zones_overlap_along_the_chain():
    for one, following in pairwise(HOMES):
        overlap = np.minimum(one[2:], following[2:]) - np.maximum(one[:2], following[:2])
        assert (overlap > 1).all()


@pytest.mark.parametrize("robots", [1, 7, 40])
def test_the_same_seed_starts_the_same_and_another_one_otherwise(robots):
    plan = layout(robots)
    one, again, other = (start_poses(plan, np.random.default_rng(seed)) for seed in (3, 3, 4))
    assert one[0].tobytes() == again[0].tobytes()
    assert one[1].tobytes() == again[1].tobytes()
    assert (one[0] != other[0]).all()


def test_a_zone_without_room_for_one_more_is_named():
    home = [0.0, 0.0, 0.5, 0.5]
    plan = Layout(np.array([[-6, -4], [6, 4]]), np.zeros((0, 4)), np.zeros((0, 2)), np.array([home, home]))
    assert ATTEMPTS < 1e6
    with pytest.raises(InvalidInput, match=r"room for one more robot; came zone \[0.0, 0.0, 0.5, 0.5\]"):
        start_poses(plan, np.random.default_rng(0))
