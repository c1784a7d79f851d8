"""Scenes: what is measured and driven keeps its bounds, and each draw is its own."""

import numpy as np
import pytest

from experiments.beacons.scenes import ARENA, BEARING_BOUND, DRIVES, alone, bearings_alone, moved, team_that_stands
from filter import Bearing, Odometry, Range, wrap

BOUND = 0.1


def scenes(seed):
    generator = np.random.default_rng(seed)
    yield alone(generator, 5, BOUND)
    yield team_that_stands(generator, BOUND)
    yield bearings_alone(generator)
    yield from (drive.drawn([seed], 40, BOUND) for drive in DRIVES)


@pytest.mark.parametrize("seed", range(3))
def test_everything_measured_is_within_its_bound_of_the_truth(seed):
    for scene in scenes(seed):
        for frame in scene.frames:
            bodies = np.concatenate([frame.truth.positions, scene.team.landmarks])
            for record in frame.measurements:
                apart = bodies[record.target] - bodies[record.robot]
                if isinstance(record, Range):
                    assert (np.abs(np.hypot(*apart.T) - record.range) <= record.bound + 1e-12).all()
                    assert (record.range >= 0).all()
                if isinstance(record, Bearing):
                    way = np.arctan2(apart[:, 1], apart[:, 0]) - frame.truth.headings[record.robot]
                    assert (np.abs(wrap(way - record.bearing)) <= BEARING_BOUND + 1e-12).all()


def test_ranges_alone_are_what_there_is_but_for_one_kind():
    kinds = {scene.kind: {type(record) for frame in scene.frames for record in frame.measurements} for scene in scenes(0)}
    assert kinds.pop("bearings") == {Bearing}
    assert set(kinds) == {"alone", "standing", "moving", "moving_known", "moving_six"}
    assert all(records == {Range} for records in kinds.values())


def test_everybody_is_where_the_start_says_and_drives_for_some_metres():
    for scene in scenes(4):
        where = scene.frames[0].truth.positions
        for robot, polygon in enumerate(scene.initial):
            if polygon is None:
                assert ((where[robot] >= ARENA[0]) & (where[robot] <= ARENA[1])).all()
            else:
                assert np.abs(where[robot] - polygon.centroid).max() <= 0.5 + 0.06
        if scene.headings is not None:
            first = scene.frames[0]
            assert (np.abs(wrap(first.truth.headings - first.odometry.turn - scene.headings.centre)) <= np.radians(10.5)).all()
        way = scene.frames[-1].truth.positions - where
        assert (np.hypot(*way.T) > 0.3).all() == scene.kind.startswith("moving")


def test_what_drives_keeps_the_bounds_of_its_odometry_and_uses_them():
    count = 20_000
    told = Odometry(0.0, 1.0, np.arange(count), 0.5, 0.02, 0.3, 0.05, 0.1, 0.01)
    headings = np.full(count, 0.7)
    places, after = moved(np.random.default_rng(0), np.zeros((count, 2)), headings, told)
    turn, length = after - headings, np.hypot(*places.T)
    aside = np.abs(wrap(np.arctan2(places[:, 1], places[:, 0]) - headings - turn / 2))
    assert np.abs(turn - 0.3).max() == pytest.approx(0.05, rel=0.01)
    assert 0.52 < length.max() <= 0.53
    assert (0.5 - 0.02) * np.sinc(0.35 / 2 / np.pi) - 0.01 <= length.min() < 0.485
    assert 0.1 < aside.max() <= 0.1 + np.arcsin(0.01 / 0.47)


def test_two_drives_with_the_same_seed_differ_in_what_is_known_alone():
    one, other, six = (drive.drawn([3], 5, BOUND) for drive in DRIVES)
    assert (one.frames[-1].measurements[0].range == other.frames[-1].measurements[0].range).all()
    assert one.headings is None
    assert other.headings is not None
    assert (six.team.robots, len(six.team.landmarks)) == (6, 2)
    assert (one.frames[0].truth.positions != DRIVES[0].drawn([4], 5, BOUND).frames[0].truth.positions).any()
