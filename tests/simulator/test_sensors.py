"""Odometry, slip and readings keep what they promise, measured on the simulated robots themselves."""

import functools
import itertools

import numpy as np
import pytest
from helpers.driven import outside

from filter.errors import InvalidInput
from sim.drive import Driver
from sim.encoders import Encoders, odometry
from sim.errors import ERROR_KINDS
from sim.layout import layout, start_poses
from sim.sensors import Sensors
from sim.world import TIMESTEP, World

SENSORS = Sensors()
ROBOTS, DURATION, SEEDS = 6, 20, (0, 1, 2)
AT_MOST = 400  # records of one kind; the shortest steps give many more


@functools.cache
def driven(seed):
    """Return positions, headings and wheel angles of a driven team at every timestep, and the world."""
    plan, generator = layout(ROBOTS), np.random.default_rng(seed)
    world = World(plan, *start_poses(plan, generator))
    driver, states = Driver(world, generator), []
    for _ in range(round(DURATION / TIMESTEP)):
        states.append((world.positions(), world.headings(), world.wheel_angles()))
        driver.advance(1)
    return *(np.array(column) for column in zip(*states, strict=True)), world


def motion(seed, steps):
    """Return displacements along and across (first heading + turn / 2), turns and rolled arcs, per `steps` timesteps."""
    positions, headings, angles, world = driven(seed)
    moved = np.diff(positions[::steps], axis=0)
    turn = np.diff(np.unwrap(headings, axis=0)[::steps], axis=0)
    middle = headings[::steps][:-1] + turn / 2
    along = moved[..., 0] * np.cos(middle) + moved[..., 1] * np.sin(middle)
    across = moved[..., 1] * np.cos(middle) - moved[..., 0] * np.sin(middle)
    return along, across, turn, np.diff(angles[::steps], axis=0) * world.wheel_radius


@pytest.mark.parametrize("seed", SEEDS)
def test_slip_in_a_tenth_of_a_second_is_far_below_what_is_declared(seed):
    along, across, turn, arcs = motion(seed, 20)
    rolled, quick = arcs.mean(axis=2), arcs.mean(axis=2) > 0.01
    assert np.abs(np.hypot(along, across) / rolled - 1)[quick].max() < 0.7 * SENSORS.distance_slip
    assert np.abs(np.arctan2(across, along))[quick].max() < 0.7 * SENSORS.direction_slip
    assert np.abs(across).max() < SENSORS.slip_bound
    assert np.abs(along - rolled).max() < 0.2 * SENSORS.slip_bound
    assert np.abs(turn - (arcs[..., 1] - arcs[..., 0]) / 0.16).max() < 0.5 * SENSORS.turn_slip


@pytest.mark.parametrize("seed", SEEDS)
def test_robots_do_drive_and_turn_while_slip_is_measured(seed):
    along, _, turn, _ = motion(seed, 20)
    assert along.max() > 0.03
    assert turn.min() < -0.1
    assert turn.max() > 0.1


def said(kind, seed, steps, sensors=SENSORS):
    """Yield every odometry record that encoders with errors of one kind give, with the number of its interval."""
    _, _, angles, world = driven(seed)
    encoders = Encoders(sensors, kind, angles[0], np.random.default_rng(seed), wheel_radius=world.wheel_radius)
    for index, reading in enumerate(angles[::steps][1:]):
        arcs = encoders.read(reading)
        start, time = index * steps * TIMESTEP, (index + 1) * steps * TIMESTEP
        yield index, odometry(sensors, arcs, wheel_radius=world.wheel_radius, track=world.track, start=start, time=time)


@pytest.mark.parametrize("seed", SEEDS)
@pytest.mark.parametrize(
    ("kind", "steps"),
    [*((kind, 20) for kind in ERROR_KINDS), *(("extreme", steps) for steps in (1, 4, 40, 100, 200, 400)), ("uniform", 200)],
)
def test_the_true_motion_is_in_the_declared_set_with_room_to_spare(kind, seed, steps):
    along, across, turn, _ = motion(seed, steps)
    for index, record in itertools.islice(said(kind, seed, steps), AT_MOST):
        lengths = record.distance - record.distance_bound, record.distance + record.distance_bound
        beyond = outside(lengths, record.direction_bound, along[index], across[index])
        assert (beyond < 0.5 * record.slip_bound).all()
        spare = SENSORS.turn_slip * steps * TIMESTEP / SENSORS.slip_step
        assert (np.abs(turn[index] - record.turn) < record.turn_bound - 0.5 * spare).all()


def test_extreme_encoder_errors_use_the_whole_declared_bound():
    _, _, _, arcs = motion(0, 20)
    shares = []
    for index, record in said("extreme", 0, 20):
        fast = arcs[index].mean(axis=1) > 0.02
        shares.append((np.abs(record.distance - arcs[index].mean(axis=1)) / record.distance_bound)[fast])
    assert np.concatenate(shares).max() > 0.7


def counted(kind, readings=400):
    """Return the (readings, 20, 2) relative errors of the arcs of wheels that turn by a radian between readings."""
    encoders = Encoders(Sensors(ticks=10**9), kind, np.zeros((20, 2)), np.random.default_rng(0), wheel_radius=0.5)
    return np.array([encoders.read(np.full((20, 2), reading + 1.0)) for reading in range(readings)]) / 0.5 - 1


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_radius_and_encoder_errors_together_stay_within_the_bound(kind):
    errors = np.abs(counted(kind))
    assert errors.max() <= 0.01 + 1e-8
    assert errors.max() > {"gaussian": 0.005}.get(kind, 0.009)


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_a_wheel_of_the_wrong_size_stays_so(kind):
    errors = counted(kind)
    own = errors.mean(axis=0)
    assert own.std() > 5 * np.abs(errors[:200].mean(axis=0) - own).max()
    assert (errors.std(axis=0) > 1e-5).all()


def test_a_biased_wheel_does_not_average_out():
    assert np.abs(counted("bias").mean(axis=0)).min() > 0.007


def test_coarse_ticks_are_within_their_bound_and_do_not_add_up():
    coarse = Sensors(encoder_bound=0.0, ticks=60, distance_slip=0.0)
    _, _, _, arcs = motion(1, 20)
    tick = 2 * np.pi * 0.033 / 60
    errors = []
    for index, record in said("uniform", 1, 20, coarse):
        errors.append(record.distance - arcs[index].mean(axis=1))
        assert (np.abs(errors[-1]) <= record.distance_bound).all()
        assert record.distance_bound == pytest.approx(tick)
    assert np.abs(np.sum(errors, axis=0)).max() < 1.01 * tick
    assert np.abs(errors).max() > 0.5 * tick


def still(sensors, arcs, start=0.0, time=0.1):
    return odometry(sensors, np.array([arcs]), wheel_radius=0.033, track=0.16, start=start, time=time)


def test_a_record_says_how_far_and_how_much_the_robot_turned():
    record = still(Sensors(encoder_bound=0.0, distance_slip=0.0, ticks=10**9), [0.02, 0.04])
    assert record.distance == pytest.approx(0.03, abs=1e-9)
    assert record.turn == pytest.approx(0.125, abs=1e-7)
    assert record.distance_bound == pytest.approx(0, abs=1e-9)
    assert record.turn_bound == pytest.approx(0.0005, abs=1e-7)


@pytest.mark.parametrize("arcs", [[0.03, 0.03], [-0.03, -0.03]])
def test_a_relative_error_divides_the_measured_arc(arcs):
    record = still(Sensors(encoder_bound=0.5, distance_slip=0.0, ticks=10**9), arcs)
    farthest = np.abs(record.distance) + record.distance_bound
    nearest = np.abs(record.distance) - record.distance_bound
    assert farthest == pytest.approx(0.06, rel=1e-6)
    assert nearest == pytest.approx(0.02, rel=1e-6)


def test_bounds_on_slip_grow_with_the_time_step():
    tenth, half = still(SENSORS, [0.03, 0.03]), still(SENSORS, [0.15, 0.15], time=0.5)
    assert tenth.slip_bound == pytest.approx(SENSORS.slip_bound)
    assert tenth.direction_bound == pytest.approx(np.radians(2.5))
    assert half.slip_bound == pytest.approx(5 * SENSORS.slip_bound)
    assert half.direction_bound == pytest.approx(np.radians(2.5) + 1.6 * 0.4 / 2)
    assert still(SENSORS, [0.003, 0.003], time=0.01).slip_bound == pytest.approx(SENSORS.slip_bound / 10)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("compass_bound", -0.1),
        ("bearing_bound", np.pi / 2),
        ("range_bound", 1.0),
        ("encoder_bound", np.nan),
        ("ticks", 0),
        ("ticks", 0.5),
        ("detection_range", -1.0),
        ("slip_step", 0.0),
        ("turn_slip", np.inf),
    ],
)
def test_a_bound_that_bounds_nothing_is_refused(field, value):
    with pytest.raises(InvalidInput, match=field.split("_")[0]):
        Sensors(**{field: value})
