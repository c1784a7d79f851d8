"""Encoders count whole ticks and lose none; what an odometry record declares holds for every motion that counts so."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from filter.errors import InvalidInput
from sim.encoders import Encoders, odometry
from sim.errors import ERROR_KINDS
from sim.sensors import Sensors

seeds = st.integers(0, 2**32 - 1)
RADIUS, TRACK = 0.033, 0.16
FAULTLESS = Sensors(encoder_bound=0.0, ticks=360)
TICK = 2 * np.pi / 360 * RADIUS


def begun(sensors=FAULTLESS, kind="uniform", seed=0, at=0.0):
    return Encoders(sensors, kind, np.full((3, 2), at), np.random.default_rng(seed), wheel_radius=RADIUS)


def record_of(sensors, arcs, time=0.1):
    return odometry(sensors, np.asarray(arcs), wheel_radius=RADIUS, track=TRACK, start=0.0, time=time)


@given(seeds)
def test_arcs_are_whole_ticks_and_none_is_lost(seed):
    rng = np.random.default_rng(seed)
    angles = np.cumsum(rng.uniform(-0.1, 0.3, (50, 3, 2)), axis=0)
    encoders = begun()
    arcs = np.array([encoders.read(each) for each in angles])
    assert np.abs(arcs / TICK - np.round(arcs / TICK)).max() < 1e-9
    assert (np.abs(arcs.sum(axis=0) - angles[-1] * RADIUS) <= TICK / 2 + 1e-12).all()
    assert arcs.sum(axis=0) == pytest.approx(begun().read(angles[-1]), abs=1e-12)


@given(seeds, st.sampled_from(ERROR_KINDS))
def test_a_wheel_that_stands_still_counts_nothing_wherever_it_began(seed, kind):
    encoders = begun(Sensors(), kind, seed, at=7.0)
    assert not np.any([encoders.read(np.full((3, 2), 7.0)) for _ in range(20)])
    assert (encoders.read(np.full((3, 2), 9.0)) > 0).all()


@given(seeds, st.sampled_from(ERROR_KINDS))
def test_the_same_seed_counts_the_same(seed, kind):
    angles = np.random.default_rng(seed).uniform(0, 5, (3, 2))
    assert begun(Sensors(), kind, seed).read(angles).tobytes() == begun(Sensors(), kind, seed).read(angles).tobytes()


def test_there_is_no_other_kind_of_errors():
    with pytest.raises(InvalidInput, match="a kind of errors among"):
        begun(kind="pessimistic")


@given(seeds, st.sampled_from(ERROR_KINDS))
def test_the_turn_and_the_path_of_wheels_that_roll_are_declared(seed, kind):
    rng = np.random.default_rng(seed)
    sensors = Sensors(encoder_bound=rng.uniform(0, 0.2), ticks=int(rng.integers(20, 5000)))
    encoders, before = begun(sensors, kind, seed), np.zeros((3, 2))
    for _ in range(20):
        angles = before + rng.uniform(-1, 2, (3, 2))
        record, rolled = record_of(sensors, encoders.read(angles)), (angles - before) * RADIUS
        assert (np.abs(rolled.mean(axis=1) - record.distance) <= record.distance_bound).all()
        assert (np.abs((rolled[:, 1] - rolled[:, 0]) / TRACK - record.turn) <= record.turn_bound).all()
        before = angles


@given(seeds)
def test_backwards_is_the_mirror_of_forwards_and_left_that_of_right(seed):
    arcs = np.random.default_rng(seed).uniform(-0.1, 0.1, (5, 2))
    ahead, back, mirrored = (record_of(Sensors(), each) for each in (arcs, -arcs, arcs[:, ::-1]))
    assert back.distance == pytest.approx(-ahead.distance, abs=1e-15)
    assert back.turn == pytest.approx(-ahead.turn, abs=1e-13)
    assert mirrored.distance == pytest.approx(ahead.distance, abs=1e-15)
    assert mirrored.turn == pytest.approx(-ahead.turn, abs=1e-13)
    for name in ("distance_bound", "turn_bound", "direction_bound", "slip_bound"):
        assert getattr(back, name) == pytest.approx(getattr(ahead, name))
        assert getattr(mirrored, name) == pytest.approx(getattr(ahead, name))


def test_a_step_that_may_have_led_anywhere_is_refused():
    longest = 0.1 + 2 * (np.pi / 2 - np.radians(2.5)) / 1.6
    assert record_of(Sensors(), [[0.1, 0.1]], time=longest - 1e-6).direction_bound < np.pi / 2
    with pytest.raises(InvalidInput):
        record_of(Sensors(), [[0.1, 0.1]], time=longest + 1e-6)
