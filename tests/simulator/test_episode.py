"""Frames of a driven team: repeatable, within every bound, and the same truth whatever is measured."""

import functools
import itertools
import pickle

import numpy as np
import pytest

from filter import Bearing, Compass, Range
from filter.errors import InvalidInput
from filter.geometry.angles import wrap
from sim.episode import MEASUREMENT_CHOICES, episode
from sim.errors import ERROR_KINDS
from sim.sensors import Sensors

ROUNDING = 1e-12


@functools.cache
def frames(**arguments):
    run = episode(**arguments)
    return run, list(run)


def short(**arguments):
    return frames(**{"robots": 6, "duration": 5.0, "seed": 3, **arguments})


def told(records):
    """Return the bytes of everything in some frames."""
    return pickle.dumps(records)


def records_of(kind, records):
    return [(frame, record) for frame in records for record in frame.measurements if isinstance(record, kind)]


def test_the_same_seed_gives_the_same_bytes():
    assert told(list(episode(4, duration=3.0, seed=1))) == told(list(episode(4, duration=3.0, seed=1)))
    assert told(list(episode(4, duration=3.0, seed=1))) != told(list(episode(4, duration=3.0, seed=2)))


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_what_is_measured_changes_neither_truth_nor_errors(kind):
    whole_run, whole = short(errors=kind, measurements="all")
    for choice in ("absolute", "none"):
        run, part = short(errors=kind, measurements=choice)
        assert (run.start_centres == whole_run.start_centres).all()
        for frame, reference in zip(part, whole, strict=True):
            assert told((frame.truth, frame.odometry, frame.measurements[0])) == told(
                (reference.truth, reference.odometry, reference.measurements[0])
            )


def rows(records, kind, value):
    return {
        (frame.time, robot, target): reading
        for frame, record in records_of(kind, records)
        for robot, target, reading in zip(record.robot.tolist(), record.target.tolist(), getattr(record, value), strict=True)
    }


@pytest.mark.parametrize(("kind", "value"), [(Bearing, "bearing"), (Range, "range")])
def test_absolute_keeps_the_landmarks_of_all_and_nothing_else(kind, value):
    everything, absolute = (rows(short(measurements=choice)[1], kind, value) for choice in ("all", "absolute"))
    assert absolute == {row: reading for row, reading in everything.items() if row[2] >= 6}
    assert 0 < len(absolute) < len(everything) / 2


def test_errors_are_the_same_after_a_while_without_landmarks():
    shortsighted = Sensors(detection_range=1.7)
    everything, absolute = (
        rows(
            frames(robots=3, seed=0, duration=12.0, rate=5.0, measurements=choice, sensors=shortsighted)[1], Bearing, "bearing"
        )
        for choice in ("all", "absolute")
    )
    assert absolute == {row: reading for row, reading in everything.items() if row[2] >= 3}
    with_landmark = {time for time, _, _ in absolute}
    assert sum(time < max(with_landmark) for time in {time for time, _, _ in everything} - with_landmark) > 10


def test_none_leaves_compasses_and_odometry():
    _, records = short(measurements="none")
    assert all([type(record) for record in frame.measurements] == [Compass] for frame in records)
    assert all(frame.odometry is not None for frame in records[1:])


def test_times_are_the_same_floats_everywhere():
    _, records = short()
    assert [frame.time for frame in records] == [k / 10 for k in range(50)]
    assert records[0].odometry is None
    for before, frame in itertools.pairwise(records):
        assert (frame.odometry.start, frame.odometry.time) == (before.time, frame.time)
        assert frame.odometry.robot.tolist() == list(range(6))
    assert all(record.time == frame.time for frame in records for record in frame.measurements)


@pytest.mark.parametrize(
    ("duration", "rate", "count"), [(1.0, 10, 10), (0.3, 10, 3), (0.25, 20, 5), (4, 0.5, 2), (0.05, 200, 10)]
)
def test_a_run_has_as_many_frames_as_it_says(duration, rate, count):
    run = episode(2, duration=duration, rate=rate)
    assert len(run) == count
    assert len(list(run)) == count
    assert list(run) == []


def test_the_truth_does_not_depend_on_the_rate():
    _, slow = short(rate=5.0)
    _, fast = short(rate=20.0)
    assert all((a.truth.positions == b.truth.positions).all() for a, b in zip(slow, fast[::4], strict=True))


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_every_reading_is_within_its_bound(kind):
    run, records = short(errors=kind)
    bodies_of = {frame.time: np.concatenate([frame.truth.positions, run.team.landmarks]) for frame in records}
    for frame, record in records_of(Compass, records):
        assert record.robot.tolist() == list(range(6))
        assert (np.abs(wrap(record.heading - frame.truth.headings)) <= record.bound + ROUNDING).all()
    for frame, record in records_of(Bearing, records):
        offset = bodies_of[frame.time][record.target] - bodies_of[frame.time][record.robot]
        true = np.arctan2(offset[:, 1], offset[:, 0]) - frame.truth.headings[record.robot]
        assert (np.abs(wrap(record.bearing - true)) <= record.bound + ROUNDING).all()
    for frame, record in records_of(Range, records):
        true = np.linalg.norm(bodies_of[frame.time][record.target] - bodies_of[frame.time][record.robot], axis=1)
        low, high = record.interval()
        assert ((low <= true + ROUNDING) & (true - ROUNDING <= high)).all()
        assert (true <= run.sensors.detection_range).all()


def test_extreme_errors_reach_the_declared_bounds():
    _, records = short(errors="extreme")
    for frame, record in records_of(Compass, records):
        assert np.abs(wrap(record.heading - frame.truth.headings)) == pytest.approx(record.bound)


@pytest.mark.parametrize("kind", ERROR_KINDS)
def test_robots_start_inside_their_boxes(kind):
    run, records = short(errors=kind)
    off = np.abs(records[0].truth.positions - run.start_centres) / run.start_bound
    assert off.max() <= 1
    assert off == pytest.approx(1) if kind == "extreme" else (off < 0.999).all()


def test_the_team_is_what_the_filter_starts_from():
    run, records = short()
    team = run.team
    assert (team.robots, team.landmarks.shape) == (6, (1, 2))
    assert team.arena.tolist() == [[-6, -4], [6, 4]]
    positions = np.array([frame.truth.positions for frame in records])
    assert ((positions > team.arena[0]) & (positions < team.arena[1])).all()
    assert (np.linalg.norm(np.diff(positions, axis=0), axis=2) <= team.speed_limit * 0.1).all()
    assert all(
        (np.abs(frame.odometry.turn) - frame.odometry.turn_bound <= team.turn_rate_limit * 0.1).all() for frame in records[1:]
    )
    for frame in records[1:]:
        team.check(frame.odometry)
        for record in frame.measurements:
            team.check(record)


def test_only_the_left_robots_see_the_beacon_and_the_chain_holds():
    sight = np.zeros((6, 7))
    runs = [frames(robots=6, duration=30.0, rate=1.0, seed=seed)[1] for seed in range(3)]
    for records in runs:
        for _, record in records_of(Range, records):
            sight[record.robot, record.target] += 1 / sum(map(len, runs))
    assert (sight[:2, 6] > 0.3).all()
    assert sight[2, 6] < 0.3
    assert (sight[3:, 6] < 0.01).all()
    neighbours = sight[np.arange(5), np.arange(1, 6)]
    assert (neighbours > 0.4).all()
    assert (sight[[0, 1], [5, 5]] < 0.02).all()


def test_sensors_can_be_better_or_worse():
    _, sharp = short(sensors=Sensors(compass_bound=0.0, detection_range=0.0))
    assert all(len(frame.measurements) == 1 for frame in sharp)
    assert all((frame.measurements[0].heading == frame.truth.headings).all() for frame in sharp)


def test_a_robot_alone_has_compass_beacon_and_odometry():
    run, records = frames(robots=1, duration=5.0)
    assert len(records) == 50
    assert {type(record) for frame in records for record in frame.measurements} == {Compass, Bearing, Range}
    assert run.start_centres.shape == (1, 2)


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        ({"robots": 0}, "robots from 1 on; came 0"),
        ({"robots": -2}, "robots from 1 on; came -2"),
        ({"duration": -1.0}, r"duration \[s\].*came .*-1"),
        ({"duration": float("nan")}, r"duration \[s\].*nan"),
        ({"duration": 0.0}, "at least one frame.*0.1 s; came 0.0 s"),
        ({"rate": -10.0}, r"rate \[Hz\].*came .*-10"),
        ({"rate": 0.0}, r"rate \[Hz\].*came .*0"),
        ({"rate": 0.4}, r"rate \[Hz\].*0.4"),
        ({"rate": 30.0}, "divides 200 Hz.*came 30.0 Hz"),
        ({"rate": 400.0}, "divides 200 Hz.*came 400.0 Hz"),
        ({"errors": "pink"}, "uniform, bias, extreme, gaussian; came 'pink'"),
        ({"measurements": "some"}, "all, absolute, none; came 'some'"),
        ({"seed": -1}, "seed.*came -1"),
        ({"seed": 0.5}, "seed.*came 0.5"),
    ],
)
def test_a_run_that_cannot_be_is_refused_with_a_reason(arguments, says):
    with pytest.raises(InvalidInput, match=says):
        episode(**arguments)


def test_the_choices_are_the_documented_ones():
    assert MEASUREMENT_CHOICES == ("all", "absolute", "none")
