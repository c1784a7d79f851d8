"""Robots wander without touching anything, and never stand around."""

import functools

import numpy as np
import pytest

from sim.drive import SPEED_LIMIT, Driver, Driving
from sim.geometry import distance_to_walls
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
    assert all((distance_to_walls(instant, world.walls) > world.robot_radius + 0.03).all() for instant in positions)
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
