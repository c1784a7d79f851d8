"""The arena, the robots in it, and the truth that MuJoCo tells."""

import subprocess
import sys

import mujoco
import numpy as np
import pytest

from filter.errors import InvalidInput
from sim.geometry import distance_to_wall
from sim.layout import START_CLEARANCE, layout, start_poses
from sim.rendering import CannotRender
from sim.visibility import visible
from sim.world import World


def world_of(robots, seed=0):
    plan = layout(robots)
    return World(plan, *start_poses(plan, np.random.default_rng(seed)))


@pytest.mark.parametrize("robots", [1, 6, 7, 12, 30, 100])
def test_the_arena_grows_with_the_team_and_stays_as_crowded(robots):
    plan = layout(robots)
    tiles = -(-robots // 6)
    area = np.prod(plan.arena[1] - plan.arena[0])
    assert len(plan.beacons) == tiles
    assert len(plan.homes) == robots
    assert 96 * tiles <= area <= 96 * tiles * 1.35
    assert (plan.walls[:, :2] < plan.walls[:, 2:]).all()


def test_six_robots_or_fewer_have_twelve_by_eight_metres():
    for robots in range(1, 7):
        assert layout(robots).arena.tolist() == [[-6, -4], [6, 4]]


@pytest.mark.parametrize("robots", [6, 18, 40])
def test_walls_close_the_arena(robots):
    plan = layout(robots)
    outside = plan.arena[1] + 5
    around = np.linspace(0, 2 * np.pi, 721)
    ring = outside.max() * 2 * np.stack([np.cos(around), np.sin(around)], axis=1)
    looking, seen = visible(np.array([[0.3, 0.2]]), ring, plan.walls, body_radius=0.0, detection_range=1e3)
    assert len(looking) == len(seen) == 0


@pytest.mark.parametrize(
    ("line", "hidden"),
    [
        ([[-0.3, 1.0], [0.3, 1.0]], True),
        ([[-0.3, 4.0], [0.3, 4.0]], False),
        ([[-9.0, -0.3], [-9.0, 0.3]], True),
        ([[-2.0, -0.3], [-2.0, 0.3]], False),
    ],
)
def test_four_tiles_are_joined_by_openings_in_their_walls(line, hidden):
    looking, _ = visible(np.array(line), np.zeros((0, 2)), layout(24).walls, body_radius=0.0, detection_range=1.0)
    assert (len(looking) == 0) is hidden


@pytest.mark.parametrize(("robots", "seed"), [(1, 0), (6, 1), (6, 2), (50, 3)])
def test_robots_start_apart_from_walls_and_from_each_other(robots, seed):
    plan = layout(robots)
    positions, headings = start_poses(plan, np.random.default_rng(seed))
    bodies = np.concatenate([positions, plan.beacons])
    apart = np.linalg.norm(bodies[:, None] - bodies, axis=2) + 10 * np.eye(len(bodies))
    assert apart[:robots].min() >= 2 * START_CLEARANCE
    assert distance_to_wall(positions[:, None], plan.walls).min() >= START_CLEARANCE
    assert ((positions >= plan.homes[:, :2]) & (positions <= plan.homes[:, 2:])).all()
    assert (np.abs(headings) <= np.pi).all()


@pytest.mark.parametrize("robots", [0, -3, 2.5])
def test_a_team_without_robots_has_no_arena(robots):
    with pytest.raises(InvalidInput, match=f"robots from 1 on; came {robots}"):
        layout(robots)


def test_robots_come_to_rest_where_they_were_put():
    plan = layout(6)
    positions, headings = start_poses(plan, np.random.default_rng(4))
    world = World(plan, positions, headings)
    assert np.abs(world.positions() - positions).max() < 0.002
    assert np.abs(np.sin(world.headings() - headings)).max() < 0.002
    before = world.positions()
    world.step(200)
    assert np.abs(world.positions() - before).max() < 1e-5
    assert world.time == pytest.approx(1.0)


def test_the_truth_is_up_to_date_with_the_last_step():
    world = world_of(4)
    world.command(np.tile([3.0, 7.0], (4, 1)))
    for _ in range(50):
        world.step()
        told = world.positions(), world.headings(), world.wheel_angles()
        copy = mujoco.MjData(world.model)
        mujoco.mj_copyState(world.model, world.data, copy, mujoco.mjtState.mjSTATE_INTEGRATION)
        mujoco.mj_forward(world.model, copy)
        world.data, kept = copy, world.data
        again = world.positions(), world.headings(), world.wheel_angles()
        world.data = kept
        assert all((a == b).all() for a, b in zip(told, again, strict=True))


def test_looking_at_the_truth_does_not_change_it():
    often, seldom = world_of(5), world_of(5)
    for speeds in np.random.default_rng(0).uniform(-8, 8, (20, 5, 2)):
        often.command(speeds)
        seldom.command(speeds)
        seldom.step(20)
        for _ in range(20):
            often.step()
    assert (often.positions() == seldom.positions()).all()
    assert (often.headings() == seldom.headings()).all()


def test_the_compass_shows_the_yaw():
    world = world_of(6, seed=7)
    for robot, heading in enumerate(world.headings()):
        forward = world.data.body(f"r{robot}/base").xmat[[0, 3]]
        assert heading == pytest.approx(np.arctan2(forward[1], forward[0]), abs=1e-4)


def test_equal_wheel_speeds_drive_straight_ahead_and_opposite_ones_turn_left():
    world = world_of(2, seed=1)
    start, first = world.positions(), world.headings()
    world.command(np.array([[4.0, 4.0], [-4.0, 4.0]]))
    world.step(100)
    moved, turned = world.positions() - start, np.sin(world.headings() - first)
    assert moved[0] @ [np.cos(first[0]), np.sin(first[0])] == pytest.approx(4 * 0.033 * 0.5, rel=0.1)
    assert np.linalg.norm(moved[1]) < 0.001
    assert turned[0] == pytest.approx(0, abs=1e-3)
    assert turned[1] > 0.5
    assert (world.wheel_angles()[0] > 1.5).all()


def test_a_bump_is_counted_as_a_collision():
    plan = layout(1)
    world = World(plan, np.array([[5.7, -2.0]]), np.array([0.0]))
    assert world.collisions() == 0
    world.command(np.full((1, 2), 8.0))
    world.step(300)
    assert world.collisions() > 0
    assert world.positions()[0, 0] < 6 - 0.06


def test_a_robot_drives_through_nothing_but_the_beacon():
    plan = layout(1)
    world = World(plan, plan.beacons - [0.3, 0.0], np.array([0.0]))
    world.command(np.full((1, 2), 8.0))
    world.step(300)
    assert world.collisions() == 0
    assert world.positions()[0, 0] > plan.beacons[0, 0] + 0.04


def test_a_hundred_robots_fit():
    world = world_of(100)
    world.step(20)
    assert world.positions().shape == (100, 2)
    assert world.collisions() == 0


def test_without_opengl_rendering_says_so(monkeypatch):
    def fail(*_):
        raise RuntimeError("no display")

    monkeypatch.setattr(mujoco, "Renderer", fail)
    with pytest.raises(CannotRender, match=r"no display.*MUJOCO_GL=egl"):
        world_of(1).render()


PICTURE = """
import numpy as np
from sim.layout import layout, start_poses
from sim.rendering import CannotRender
from sim.world import World
plan = layout(6)
world = World(plan, *start_poses(plan, np.random.default_rng(0)))
try:
    image = world.render()
except CannotRender:
    raise SystemExit(77)
assert image.dtype == np.uint8 and image.shape == (640, 960, 3)
red = (image[..., 0] > 120) & (image[..., 1] < 60)
assert red.sum() > 20
assert np.argwhere(red)[:, 1].mean() < 300
"""


def test_the_overview_shows_the_beacon_on_the_left(monkeypatch):
    monkeypatch.setenv("MUJOCO_GL", "egl")  # read once, when MuJoCo is imported: hence another process
    ended = subprocess.run([sys.executable, "-c", PICTURE], check=False, capture_output=True, text=True, timeout=60)
    if ended.returncode == 77 or "GL" in ended.stderr:
        pytest.skip("no OpenGL here")
    assert ended.returncode == 0, ended.stderr
