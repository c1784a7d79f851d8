"""Robots wander without touching anything, and never stand around."""

import functools

import numpy as np
import pytest

from sim.drive import CORRIDOR, NEAREST, SPEED_LIMIT, Driver, Driving
from sim.geometry import distance_to_segment, distance_to_wall, meets_wall, nearest_on_wall
from sim.layout import Layout, layout, start_poses
from sim.sensors import Sensors
from sim.world import World

EVERY = 0.05  # [s]
RUNS = [(1, 0, 30), (6, 0, 50), (6, 1, 30), (12, 2, 20), (30, 3, 10)]


@functools.cache
def run(robots, seed, duration):
    """Return collisions and, at every 50 ms, positions and headings of a driven team; with its world."""
    generator = np.random.default_rng(seed)
    plan = layout(robots)
    world = World(plan, *start_poses(plan, generator))
    driver = Driver(world, generator)
    collisions, positions, headings = 0, [], []
    for _ in range(round(duration / EVERY)):
        driver.advance(10)
        collisions += world.collisions()
        positions.append(world.positions())
        headings.append(world.headings())
    return world, collisions, np.array(positions), np.unwrap(headings, axis=0)


def speeds(positions):
    return np.linalg.norm(np.diff(positions, axis=0), axis=2) / EVERY


@pytest.mark.parametrize("case", RUNS)
def test_nothing_ever_touches(case):
    world, collisions, positions, _ = run(*case)
    assert collisions == 0
    pairs = np.triu_indices(world.robots, k=1)
    gaps = np.linalg.norm(positions[:, pairs[0]] - positions[:, pairs[1]], axis=2) - 2 * world.robot_radius
    assert (gaps > 0.03).all()
    assert all((distance_to_wall(instant[:, None], world.walls) > world.robot_radius + 0.03).all() for instant in positions)
    beacons = np.linalg.norm(positions[:, :, None] - world.landmarks, axis=3)
    assert (beacons > world.robot_radius + 0.03).all()


@pytest.mark.parametrize("case", RUNS)
def test_every_robot_is_in_motion_most_of_the_time(case):
    _, _, positions, _ = run(*case)
    assert (speeds(positions).mean(axis=0) > 0.15).all()
    assert ((speeds(positions) > 0.05).mean(axis=0) > 0.75).all()


@pytest.mark.parametrize("case", RUNS)
def test_no_robot_is_stuck_for_long(case):
    _, _, positions, _ = run(*case)
    five_seconds = round(5 / EVERY)
    moved = np.linalg.norm(positions[five_seconds:] - positions[:-five_seconds], axis=2)
    path = np.cumsum(speeds(positions) * EVERY, axis=0)
    assert (path[five_seconds:] - path[:-five_seconds] > 0.2).all()
    assert moved.max(axis=0).min() > 0.8


@pytest.mark.parametrize("case", RUNS)
def test_robots_stay_at_home_and_within_the_declared_limits(case):
    world, _, positions, headings = run(*case)
    assert ((positions > world.homes[:, :2] - 0.8) & (positions < world.homes[:, 2:] + 0.8)).all()
    assert ((positions > world.arena[0]) & (positions < world.arena[1])).all()
    assert speeds(positions).max() < SPEED_LIMIT
    assert np.abs(np.diff(headings, axis=0)).max() / EVERY < Sensors().turn_rate


class Still:
    """A world in which everything stands where it is put."""

    track, wheel_radius, robot_radius = 0.16, 0.033, 0.105

    def __init__(self, plan, positions):
        self.robots, self.walls, self.landmarks, self.homes = len(positions), plan.walls, plan.beacons, plan.homes
        self._positions = positions

    def positions(self):
        return self._positions


def crowded(seed):
    """Return a driver and where its robots are: some so near others that they would have bumped, a dozen around one."""
    generator, plan = np.random.default_rng(seed), layout(40)
    positions = start_poses(plan, generator)[0] + generator.normal(0, 0.5, (40, 2))
    positions[:5] = positions[5:10] + generator.uniform(-0.3, 0.3, (5, 2))
    positions[10:22] = positions[22] + generator.uniform(-0.7, 0.7, (12, 2))
    return Driver(Still(plan, positions), generator), positions, generator


def limits_by_all_pairs(driver, positions, directions):
    """Weigh every robot, beacon and wall, and of these the eight that allow the least."""
    world, driving = driver._world, driver._driving
    bodies = np.concatenate([positions, world.landmarks]) - positions[:, None]
    offsets = np.concatenate([bodies, nearest_on_wall(positions[:, None], world.walls) - positions[:, None]], axis=1)
    distances = np.linalg.norm(offsets, axis=2)
    np.fill_diagonal(distances, np.inf)
    covered, count = world.robot_radius + driving.margin, len(positions)
    closing = (distances - covered) * driving.approach
    closing[:, :count] = (distances[:, :count] - covered - world.robot_radius) * driving.approach / 2
    nearest = np.argsort(closing, axis=1)[:, :NEAREST]
    towards = np.take_along_axis(offsets, nearest[:, :, None], axis=1)
    towards = towards / np.maximum(np.take_along_axis(distances, nearest, axis=1), 1e-9)[:, :, None]
    units = np.stack([np.cos(directions), np.sin(directions)], axis=2)
    share = np.maximum(units @ towards.transpose(0, 2, 1), 1e-9)
    speeds = np.maximum(np.take_along_axis(closing, nearest, axis=1), 0)
    return np.clip((speeds[:, None] / share).min(axis=2), 0, driving.speed)


@pytest.mark.parametrize("seed", range(10))
def test_speed_is_limited_as_by_everything_there_is(seed):
    driver, positions, generator = crowded(seed)
    directions = generator.uniform(-np.pi, np.pi, (40, 26))
    limits = driver._speed_limits(positions, directions)
    assert (limits == limits_by_all_pairs(driver, positions, directions)).all()
    assert (limits == 0).any() and (limits == Driving().speed).any()


def test_a_robot_far_from_everything_drives_at_full_speed():
    plan = Layout(np.array([[-9, -9], [9, 9]]), np.zeros((0, 4)), np.zeros((0, 2)), np.array([[-1.0, -1, 1, 1]]))
    driver = Driver(Still(plan, np.zeros((1, 2))), np.random.default_rng(0))
    assert (driver._speed_limits(np.zeros((1, 2)), np.zeros((1, 3))) == Driving().speed).all()


@pytest.mark.parametrize("seed", range(10))
def test_ways_are_free_as_by_everything_there_is(seed):
    driver, positions, generator = crowded(seed)
    world = driver._world
    starts = np.repeat(positions, 5, axis=0)
    ends = starts + generator.uniform(-4, 4, starts.shape)
    corridor = np.minimum(CORRIDOR, distance_to_wall(starts[:, None], world.walls) * 0.9)
    walls = world.walls + corridor[:, :, None] * np.array([-1, -1, 1, 1])
    blocked = meets_wall(starts[:, None], ends[:, None], walls).any(axis=1)
    blocked |= (distance_to_wall(ends[:, None], world.walls) < 2 * CORRIDOR).any(axis=1)
    blocked |= (distance_to_segment(world.landmarks, starts[:, None], ends[:, None]) <= CORRIDOR).any(axis=1)
    assert (driver._reachable(starts, ends) == ~blocked).all()
    assert 20 < blocked.sum() < 180


def test_robots_go_to_many_places_of_their_homes():
    world, _, positions, _ = run(6, 0, 50)
    reach = positions.max(axis=0) - positions.min(axis=0)
    assert (reach > 0.4 * (world.homes[:, 2:] - world.homes[:, :2])).all()


def test_driving_in_small_steps_makes_no_difference():
    def driven(pieces):
        generator, plan = np.random.default_rng(5), layout(3)
        world = World(plan, *start_poses(plan, generator))
        driver = Driver(world, generator)
        for piece in pieces:
            driver.advance(piece)
        return world.positions()

    assert (driven([400]) == driven([1, 7, 92, 300])).all()


def test_a_robot_that_cannot_get_where_it_wants_to_goes_elsewhere():
    homes = np.array([[-1.5, -0.01, 1.5, 0.01], [-0.01, -0.01, 0.01, 0.01]])
    plan = Layout(layout(2).arena, layout(2).walls, np.zeros((0, 2)), homes)
    world = World(plan, np.array([[-1.2, 0.0], [0.0, 0.0]]), np.zeros(2))  # the second stays on the first one's way
    driver = Driver(world, np.random.default_rng(0), Driving(arrival=0.1))
    path = []
    for _ in range(320):
        driver.advance(20)
        path.append(world.positions()[0])
    assert world.collisions() == 0
    moved = np.linalg.norm(np.diff(path, axis=0), axis=1)
    assert all(moved[start : start + 80].sum() > 0.3 for start in range(0, 320, 80))


def test_two_robots_facing_each_other_get_past():
    plan = layout(2)
    world = World(plan, np.array([[-3.4, 0.0], [-2.9, 0.0]]), np.array([0.0, np.pi]))
    driver = Driver(world, np.random.default_rng(0))
    for _ in range(200):
        driver.advance(10)
        assert world.collisions() == 0
    assert (np.abs(world.positions() - [[-3.4, 0.0], [-2.9, 0.0]]).max(axis=1) > 0.5).all()
