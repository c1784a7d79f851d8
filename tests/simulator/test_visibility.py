"""Line of sight, by hand and against MuJoCo's rays."""

import mujoco
import numpy as np
import pytest

from sim.geometry import distance_to_segment, distance_to_wall, meets_wall, near, near_walls
from sim.layout import Layout, layout, start_poses
from sim.visibility import visible
from sim.world import World

NO_WALLS = np.zeros((0, 4))
NO_LANDMARKS = np.zeros((0, 2))
FAR = 100.0


def sees(positions, landmarks=NO_LANDMARKS, walls=NO_WALLS, body_radius=0.1, detection_range=FAR):
    positions, landmarks, walls = (np.asarray(array, dtype=float) for array in (positions, landmarks, walls))
    looking, seen = visible(positions, landmarks, walls, body_radius=body_radius, detection_range=detection_range)
    return set(zip(looking.tolist(), seen.tolist(), strict=True))


def test_two_robots_in_the_open_see_each_other_and_not_themselves():
    assert sees([[0, 0], [1, 2]]) == {(0, 1), (1, 0)}


def test_a_robot_sees_a_landmark_and_a_landmark_sees_nothing():
    assert sees([[0, 0]], landmarks=[[1, 0], [0, 1]]) == {(0, 1), (0, 2)}


def test_a_robot_hides_the_one_behind_it():
    assert sees([[0, 0], [1, 0], [2, 0]]) == {(0, 1), (1, 0), (1, 2), (2, 1)}


def test_a_landmark_hides_the_robot_behind_it():
    assert sees([[0, 0], [2, 0]], landmarks=[[1, 0]]) == {(0, 2), (1, 2)}


@pytest.mark.parametrize(("sideways", "hidden"), [(0.099, True), (0.101, False), (-0.099, True), (-0.101, False)])
def test_a_robot_hides_as_far_as_its_body_reaches(sideways, hidden):
    assert ((0, 2) not in sees([[0, 0], [1, sideways], [2, 0]])) is hidden


def test_bodies_that_nearly_touch_still_see_each_other():
    assert (0, 1) in sees([[0, 0], [0.05, 0]])


def test_nothing_is_seen_beyond_the_detection_range():
    assert sees([[0, 0], [4, 0]], detection_range=4.0) == {(0, 1), (1, 0)}
    assert sees([[0, 0], [np.nextafter(4, 5), 0]], detection_range=4.0) == set()


@pytest.mark.parametrize(
    ("target", "hidden"),
    [
        ([2, 0], True),
        ([0, 2], False),
        ([0.9, 0], False),
        ([2, 1.9], True),
        ([2, 2.3], False),
        ([-2, 0], False),
        ([1.05, 2], False),
    ],
)
def test_a_wall_hides_what_is_behind_it(target, hidden):
    assert ((0, 1) not in sees([[0, 0], target], walls=[[1, -1, 1.1, 1]])) is hidden


def test_who_sees_whom_comes_in_order():
    positions = np.random.default_rng(0).uniform(-3, 3, (20, 2))
    pairs = np.stack(visible(positions, NO_LANDMARKS, NO_WALLS, body_radius=0.03, detection_range=FAR), axis=1)
    assert pairs.tolist() == sorted(pairs.tolist())
    assert len(np.unique(pairs, axis=0)) == len(pairs)


def test_a_line_along_the_side_of_a_wall_does_not_divide_by_zero():
    assert sees([[0, 0], [3, 0]], walls=[[1, 0.5, 2, 1]]) == {(0, 1), (1, 0)}
    assert sees([[0, 0], [3, 0]], walls=[[1, -0.5, 2, 1]]) == set()
    assert sees([[0, 0], [3, 0]], walls=[[1, 0, 2, 1]]) == set()
    assert sees([[0, 0], [0, 3]], walls=[[-1, 1, 0, 2]]) == set()


def sees_by_all_pairs(positions, landmarks, walls, body_radius, detection_range):
    """Look at every pair, and for each at every body and every wall."""
    robots, bodies = len(positions), np.concatenate([positions, landmarks])
    within = np.linalg.norm(bodies[:robots, None] - bodies[None], axis=2) <= detection_range
    first, second = np.nonzero(np.triu(within, k=1))
    starts, ends = bodies[first], bodies[second]
    hides = distance_to_segment(bodies, starts[:, None], ends[:, None]) <= body_radius
    every = np.arange(len(first))
    hides[every, first] = hides[every, second] = False
    clear = ~hides.any(axis=1) & ~meets_wall(starts[:, None], ends[:, None], walls).any(axis=1)
    pairs = set(zip(first[clear].tolist(), second[clear].tolist(), strict=True))
    return pairs | {(j, i) for i, j in pairs if j < robots}


@pytest.mark.parametrize("seed", range(40))
def test_sight_is_the_same_as_by_all_pairs(seed):
    generator = np.random.default_rng(seed)
    at, size = generator.choice([0.0, 1e5]), generator.choice([1.0, 4.0, 20.0])
    robots, landmarks = (at + generator.uniform(-size, size, (count, 2)) for count in generator.integers([1, 0], [60, 20]))
    corners = at + generator.uniform(-size, size, (generator.integers(0, 20), 2))
    walls = np.concatenate([corners, corners + generator.uniform(0, size / 2, corners.shape) ** 2], axis=1)
    rest = generator.choice([0.0, 0.03, 0.5]), generator.choice([0.0, 1.0, 4.0, 1e3])
    assert sees(robots, landmarks, walls, *rest) == sees_by_all_pairs(robots, landmarks, walls, *rest)


@pytest.mark.parametrize("seed", range(20))
def test_sight_is_the_same_where_everything_touches(seed):
    """Bodies on a grid, some twice: lines graze walls and bodies, and ranges are reached exactly."""
    generator = np.random.default_rng(seed)
    robots, landmarks = (generator.integers(-3, 4, (count, 2)).astype(float) for count in (20, 6))
    corners = generator.integers(-3, 4, (8, 2)).astype(float)
    walls = np.concatenate([corners, corners + generator.integers(0, 3, corners.shape)], axis=1)
    for body_radius, detection_range in ((0.0, 2.0), (1.0, 5.0), (0.5, 3.0), (np.sqrt(0.5), 1.0)):
        arguments = robots, landmarks, walls, body_radius, detection_range
        assert sees(*arguments) == sees_by_all_pairs(*arguments)


def test_a_large_team_sees_the_same_as_by_all_pairs():
    plan = layout(120)
    positions, _ = start_poses(plan, np.random.default_rng(0))
    arguments = positions, plan.beacons, plan.walls, 0.03, 4.0
    assert len(sees(*arguments)) > 200
    assert sees(*arguments) == sees_by_all_pairs(*arguments)


@pytest.mark.parametrize("seed", range(5))
def test_what_is_near_is_found(seed):
    generator = np.random.default_rng(seed)
    points, centres = generator.integers(-4, 5, (30, 2)).astype(float), generator.integers(-4, 5, (12, 2)).astype(float)
    reach = generator.integers(0, 4, 12).astype(float)
    true = np.nonzero(np.linalg.norm(points - centres[:, None], axis=2) <= reach[:, None])
    centre, point = near(points, centres, reach)
    assert (np.diff(centre) >= 0).all()
    assert set(zip(centre.tolist(), point.tolist(), strict=True)) == set(zip(*(each.tolist() for each in true), strict=True))
    walls = np.concatenate([points, points + generator.integers(0, 5, points.shape)], axis=1)
    true = np.nonzero(distance_to_wall(centres[:, None], walls) <= reach[:, None])
    centre, wall = near_walls(centres, walls, reach)
    assert set(zip(centre.tolist(), wall.tolist(), strict=True)) == set(zip(*(each.tolist() for each in true), strict=True))


@pytest.mark.parametrize(("points", "centres"), [(0, 3), (3, 0), (0, 0)])
def test_nothing_is_near_nothing(points, centres):
    assert [len(found) for found in near(np.ones((points, 2)), np.ones((centres, 2)), np.ones(centres))] == [0, 0]
    assert [len(found) for found in near_walls(np.ones((centres, 2)), np.ones((points, 4)), np.ones(centres))] == [0, 0]


def crowd(seed):
    """A dense world: robots on a loose grid around the beacon, among the usual walls and some more."""
    generator = np.random.default_rng(seed)
    grid = np.stack(np.meshgrid(np.linspace(-5.5, 5.5, 10), np.linspace(-3.5, 3.5, 6)), axis=2).reshape(-1, 2)
    positions = grid + generator.uniform(-0.3, 0.3, grid.shape)
    plan = layout(6)
    away = np.linalg.norm(positions - plan.beacons[0], axis=1) > 0.3
    corners = generator.uniform(-4, 4, (6, 2))
    more = np.concatenate([corners, corners + generator.uniform(0.05, 0.4, (6, 2))], axis=1)
    walls = np.concatenate([plan.walls, more])
    free = (np.abs(positions[:, None] - (walls[:, :2] + walls[:, 2:]) / 2) > (walls[:, 2:] - walls[:, :2]) / 2 + 0.15).any(
        axis=2
    )
    positions = positions[away & free.all(axis=1)]
    world = World(Layout(plan.arena, walls, plan.beacons, plan.homes), positions, generator.uniform(-3, 3, len(positions)))
    mujoco.mj_forward(world.model, world.data)
    return world


def seen_by_rays(world):
    """Every pair that MuJoCo's rays connect, at the height of the masts."""
    model, data, pairs, hit = world.model, world.data, set(), np.zeros(1, dtype=np.int32)
    heads = [data.site(f"r{robot}/head").xpos.copy() for robot in range(world.robots)]
    beacons = [np.array([*beacon, heads[0][2]]) for beacon in world.landmarks]
    owner = {model.body(f"r{robot}/base").id: robot for robot in range(world.robots)}
    for robot, head in enumerate(heads):
        for target, goal in enumerate(heads + beacons):
            if target != robot:
                mujoco.mj_ray(model, data, head, goal - head, None, True, model.body(f"r{robot}/base").id, hit)
                name = model.geom(hit[0]).name
                met = owner.get(model.geom_bodyid[hit[0]], -1)
                if met == target or name == f"beacon{target - world.robots}":
                    pairs.add((robot, target))
    return pairs


@pytest.mark.parametrize("seed", range(4))
def test_sight_agrees_with_the_rays_of_mujoco(seed):
    world, grazing = crowd(seed), 0.001  # robots lean by less
    by_rays = seen_by_rays(world)
    least, most = (
        sees(world.positions(), world.landmarks, world.walls, world.mast_radius + extra) for extra in (grazing, -grazing)
    )
    assert least <= by_rays <= most
    assert len(most - least) < 0.02 * len(most)
    everybody = world.robots * (world.robots - 1)
    assert 0.1 * everybody < len(least) < 0.9 * everybody
