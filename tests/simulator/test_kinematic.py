"""The kinematic world: its slip reaches the declared bounds and never exceeds them, and nothing touches."""

import functools
import itertools
import pickle

import numpy as np
import pytest
from helpers.driven import outside

from filter.errors import InvalidInput
from filter.geometry.angles import wrap
from sim.drive import SPEED_LIMIT, Driver
from sim.encoders import Encoders, odometry
from sim.episode import episode
from sim.errors import ERROR_KINDS
from sim.geometry import distance_to_wall
from sim.kinematic import DIRECTION_SHARE, DISTANCE_SHARE, LAG, SLIP_SHARE, KinematicWorld
from sim.layout import layout, start_poses
from sim.sensors import Sensors
from sim.world import TIMESTEP, World

SENSORS, ROBOTS, DURATION = Sensors(), 30, 12
AT_MOST = 120  # records of one kind; the shortest steps give many more
ROUNDING = 1e-12


def put(robots, kind="uniform", seed=0, sensors=SENSORS):
    generator = np.random.default_rng(seed)
    plan = layout(robots)
    return KinematicWorld(plan, *start_poses(plan, generator), sensors=sensors, errors=kind, generator=generator)


@functools.cache
def driven(kind):
    """Return positions, headings and wheel angles of a driven team at every timestep, and the world."""
    world = put(ROBOTS, kind)
    driver, states = Driver(world, np.random.default_rng(1)), []
    for _ in range(round(DURATION / TIMESTEP)):
        states.append((world.positions(), world.headings(), world.wheel_angles()))
        driver.advance(1)
    return *(np.array(column) for column in zip(*states, strict=True)), world


def motion(kind, steps, first=0):
    """Return displacements along and across (first heading + turn / 2), turns and rolled arcs, per `steps` timesteps."""
    positions, headings, angles, world = driven(kind)
    moved = np.diff(positions[first::steps], axis=0)
    turn = np.diff(np.unwrap(headings, axis=0)[first::steps], axis=0)
    middle = headings[first::steps][:-1] + turn / 2
    along = moved[..., 0] * np.cos(middle) + moved[..., 1] * np.sin(middle)
    across = moved[..., 1] * np.cos(middle) - moved[..., 0] * np.sin(middle)
    return along, across, turn, np.diff(angles[first::steps], axis=0) * world.wheel_radius


def perfect():
    """Encoders that count exactly, so that slip alone is judged."""
    return Sensors(encoder_bound=0.0, ticks=10**9)


def beyond(kind, steps, sensors, first=0):
    """Return how far displacements and turns are from what odometry says, over its bounds on them: 1 is the most allowed."""
    along, across, turn, _ = motion(kind, steps, first)
    angles, world = driven(kind)[2][first::steps], driven(kind)[3]
    encoders = Encoders(sensors, kind, angles[0], np.random.default_rng(0), wheel_radius=world.wheel_radius)
    places, turns = [], []
    for index, reading in enumerate(angles[1 : AT_MOST + 1]):
        arcs, start, time = encoders.read(reading), index * steps * TIMESTEP, (index + 1) * steps * TIMESTEP
        record = odometry(sensors, arcs, wheel_radius=world.wheel_radius, track=world.track, start=start, time=time)
        lengths = record.distance - record.distance_bound, record.distance + record.distance_bound
        places.append(outside(lengths, record.direction_bound, along[index], across[index]) / record.slip_bound)
        turns.append(np.abs(turn[index] - record.turn) / record.turn_bound)
    return np.array(places), np.array(turns)


@pytest.mark.parametrize("kind", ERROR_KINDS)
@pytest.mark.parametrize("steps", [4, 20, 25, 40, 200])
def test_the_true_motion_is_in_the_declared_set(kind, steps):
    for sensors, first in ((SENSORS, 0), (perfect(), 0), (perfect(), 7)):
        places, turns = beyond(kind, steps, sensors, first)
        assert places.max() <= 1
        assert turns.max() <= 1


def test_extreme_slip_reaches_what_is_declared():
    places, turns = beyond("extreme", 20, perfect())
    assert places.max() > 0.6
    assert turns.max() > 0.99
    along, across, _, arcs = motion("extreme", 20)
    rolled = arcs.mean(axis=2)
    fast = rolled > 0.03
    slip = SLIP_SHARE * SENSORS.slip_bound
    stretched = np.abs(np.hypot(along, across) - rolled)[fast] - DISTANCE_SHARE * SENSORS.distance_slip * rolled[fast]
    assert stretched.max() > 0.8 * slip
    aside = np.abs(across)[fast] - DIRECTION_SHARE * SENSORS.direction_slip * rolled[fast]
    assert aside.max() > 0.8 * slip


@pytest.mark.parametrize(("kind", "least"), [("uniform", 0.5), ("bias", 0.5), ("gaussian", 0.25)])
def test_slip_of_every_kind_is_of_its_size(kind, least):
    _, turns = beyond(kind, 20, perfect())
    assert np.quantile(turns, 0.9) > least


def test_robots_do_drive_and_turn():
    along, _, turn, _ = motion("extreme", 20)
    assert along.max() > 0.03
    assert turn.min() < -0.1
    assert turn.max() > 0.1
    assert (along.mean(axis=0) > 0.01).all()


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_nothing_ever_touches_and_limits_hold(kind):
    positions, headings, _, world = driven(kind)
    bodies = np.concatenate([positions, np.broadcast_to(world.landmarks, (len(positions), *world.landmarks.shape))], axis=1)
    i, j = np.triu_indices(world.robots, k=1)
    assert (np.linalg.norm(positions[:, i] - positions[:, j], axis=2) > 2 * world.robot_radius + 0.03).all()
    beacons = np.linalg.norm(positions[:, :, None] - bodies[:, None, world.robots :], axis=3)
    assert (beacons > world.robot_radius + 0.03).all()
    assert (distance_to_wall(positions[::10, :, None], world.walls) > world.robot_radius + 0.03).all()
    assert ((positions > world.arena[0]) & (positions < world.arena[1])).all()
    assert np.linalg.norm(np.diff(positions, axis=0), axis=2).max() < SPEED_LIMIT * TIMESTEP
    assert np.abs(wrap(np.diff(headings, axis=0))).max() < SENSORS.turn_rate * TIMESTEP


def test_a_robot_is_as_large_as_in_mujoco():
    plan = layout(2)
    poses = start_poses(plan, np.random.default_rng(0))
    world, light = World(plan, *poses), put(2)
    for name in ("robots", "track", "wheel_radius", "robot_radius", "mast_radius", "wall_height"):
        assert getattr(light, name) == getattr(world, name)
    assert (light.track, light.wheel_radius, light.mast_radius) == (0.16, 0.033, 0.03)
    assert light.robot_radius == pytest.approx(0.105)


def test_wheels_follow_commands_with_a_lag():
    world = put(3)
    world.command(np.full((3, 2), 5.0))
    world.step(round(LAG / TIMESTEP))
    before = world.wheel_angles()
    world.step()
    assert (world.wheel_angles() - before) / TIMESTEP == pytest.approx(5 * (1 - np.exp(-1 - TIMESTEP / LAG)))
    world.step(200)
    before = world.wheel_angles()
    world.step()
    assert (world.wheel_angles() - before) / TIMESTEP == pytest.approx(5.0)
    assert world.time == pytest.approx(1.03)


def test_a_robot_at_rest_creeps_by_its_slip_and_no_more():
    world = put(20, "extreme")
    before = world.positions()
    world.step(20)
    moved = np.linalg.norm(world.positions() - before, axis=1)
    assert moved == pytest.approx(SLIP_SHARE * SENSORS.slip_bound)
    assert (world.wheel_angles() == 0).all()


def test_without_slip_a_robot_drives_the_circle_that_its_wheels_say():
    world = put(1, sensors=Sensors(distance_slip=0.0, direction_slip=0.0, slip_bound=0.0, turn_slip=0.0))
    start, heading = world.positions()[0], world.headings()[0]
    world.command(np.array([[6.0, 8.0]]))
    for _ in range(400):
        world.step()
        arcs = world.wheel_angles()[0] * world.wheel_radius
        turn = (arcs[1] - arcs[0]) / world.track
        radius = arcs.mean() / turn  # of a circle, as both wheels lag alike
        chord = radius * np.array([np.sin(heading + turn) - np.sin(heading), np.cos(heading) - np.cos(heading + turn)])
        assert world.positions()[0] - start == pytest.approx(chord, abs=1e-6)
        assert wrap(world.headings()[0] - heading - turn) == pytest.approx(0, abs=ROUNDING)
    assert turn > 0.8


def test_what_is_told_is_a_copy():
    world = put(2)
    told = world.positions(), world.headings(), world.wheel_angles()
    before = [array.copy() for array in told]
    world.command(np.full((2, 2), 5.0))
    world.step(50)
    assert all((array == kept).all() for array, kept in zip(told, before, strict=True))


def run(**arguments):
    return list(episode(**{"robots": 8, "duration": 1.0, "seed": 3, "world": "kinematic", **arguments}))


def test_the_same_seed_gives_the_same_bytes():
    assert pickle.dumps(run()) == pickle.dumps(run())
    assert pickle.dumps(run()) != pickle.dumps(run(seed=4))
    assert pickle.dumps(run()) != pickle.dumps(run(world="mujoco"))


def test_what_is_measured_does_not_change_the_truth():
    for frame, reference in zip(run(measurements="none"), run(measurements="all"), strict=True):
        assert pickle.dumps((frame.truth, frame.odometry)) == pickle.dumps((reference.truth, reference.odometry))


def test_both_worlds_start_with_the_same_team_at_the_same_places():
    light, physical = (episode(8, duration=0.1, seed=5, world=world) for world in ("kinematic", "mujoco"))
    assert (light.team.landmarks == physical.team.landmarks).all()
    assert light.world.positions() == pytest.approx(physical.world.positions(), abs=0.002)


def test_five_hundred_robots_start_and_drive():
    frames = run(robots=500, duration=0.5)
    moved = frames[-1].truth.positions - frames[0].truth.positions
    assert np.linalg.norm(moved, axis=1).max() > 0.02
    for before, frame in itertools.pairwise(frames):
        assert frame.odometry.start == before.time
        assert len(frame.odometry.robot) == 500


def test_there_is_no_third_world():
    with pytest.raises(InvalidInput, match="a world among mujoco, kinematic; came 'flat'"):
        episode(2, world="flat")
