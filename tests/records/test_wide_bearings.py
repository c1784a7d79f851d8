"""Bearings that may be off by a right angle and more: no rows, what they can say of headings, and nobody is ever lost."""

import json

import numpy as np
import pytest
from helpers.proved.streams import Team as Drivers
from helpers.proved.streams import in_step, written
from helpers.sensing.mounted import MountedWorld

from experiments.follow import main as follow_command
from experiments.logs import LogReader
from experiments.prove import prove as links_of
from filter import (
    AngularIntervals,
    Bearing,
    ExtendedKalmanFilter,
    Frame,
    InvalidInput,
    NoiseModel,
    Polygon,
    Range,
    RobustFilter,
    Sensor,
    SetMembershipFilter,
    Team,
    wrap,
)
from filter.sensing.rows import bearing_rows, world_arcs

HALF, MARK = np.pi / 2, [[4.0, 0.0]]
BOUNDS = [np.nextafter(HALF, 0), HALF, np.nextafter(HALF, 2), 2.0, 3.0, np.nextafter(np.pi, 0), np.pi]


class SloppyWorld(MountedWorld):
    """A mounted world whose bearings can be off by so much that it needs all of the circle."""

    def sighted(self, kind, time, bodies, sensors):
        exact = super().sighted(kind, time, bodies, sensors)
        if kind is Range:
            return exact
        half = self.rng.choice([0.02, *BOUNDS], len(exact.robot))
        half = np.minimum(half, np.pi)
        value = wrap(exact.bearing + (half - exact.bound).clip(0) * self.error(len(half)))
        return Bearing(time, exact.robot, exact.target, value, half, exact.sensor, exact.target_sensor)


@pytest.mark.parametrize("seed", range(30))
@pytest.mark.parametrize("cells", [0, 16])
def test_the_truth_is_inside_however_wide_bearings_are(seed, cells):
    rng = np.random.default_rng(seed)
    world = SloppyWorld(rng, int(rng.integers(1, 4)), reach=float(rng.choice([0.0, 0.5])), sloppy=0.02)
    filter_ = SetMembershipFilter(world.team, cells=cells)
    belief = filter_.start(0.0, *world.initial(float(rng.choice([0.2, 2.0])), float(rng.choice([0.02, 1.0, np.pi]))))
    for _ in range(2):
        belief = filter_.update(belief, world.measure(ranges=0.3))
        assert belief.regions.contains(world.positions).all()
        assert belief.headings.contains(world.headings).all()


@pytest.mark.parametrize("bound", BOUNDS)
@pytest.mark.parametrize("robot", [0, 1])
def test_the_robust_filter_loses_nobody(bound, robot):
    rng = np.random.default_rng(round(100 * bound) + robot)
    team = Team(2, MARK, arena=[[-9, -9], [9, 9]])
    places, ways = rng.uniform(-2, 2, (2, 2)), rng.uniform(-3, 3, 2)
    filter_ = RobustFilter(team)
    belief = filter_.start(0.0, [Polygon.box(place - 1, place + 1) for place in places], AngularIntervals(ways, 1.0))
    for target in (1 - robot, 2):
        away = np.vstack([places, MARK])[target] - places[robot]
        seen = np.arctan2(away[1], away[0]) - ways[robot]
        for error in (-bound, bound, 0.0):
            records = [Bearing(0.0, robot, target, seen + error, bound), Range(0.0, robot, target, np.hypot(*away), 0.1, 0.0)]
            belief = filter_.update(belief, records)
            assert all(region.outer.contains(place) for region, place in zip(belief.regions, places, strict=True))
            assert belief.headings.contains(ways).all()
            assert not belief.events


@pytest.mark.parametrize("bound", BOUNDS[1:])
def test_they_make_no_rows_and_leave_positions_as_they_are(bound):
    record = Bearing(0.0, 0, 1, 0.3, bound)
    assert not len(bearing_rows(record.robot, record.target, world_arcs(record, AngularIntervals(0.0, 0.0)), np.array([0])))
    filter_ = SetMembershipFilter(Team(1, MARK, arena=[[-9, -9], [9, 9]]))
    belief = filter_.update(filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])], AngularIntervals(0.0, 0.1)), [record])
    assert belief.regions[0].outer.area == pytest.approx(4, rel=1e-6)


def test_they_narrow_headings_by_what_they_exclude():
    filter_ = SetMembershipFilter(Team(1, MARK, arena=[[-9, -9], [9, 9]]))
    start = filter_.start(0.0, [Polygon.box([0, 0], [0, 0])])
    heading = filter_.update(start, [Bearing(0.0, 0, 1, 0.5, 2.0)]).headings
    assert (heading.centre[0], heading.bound[0]) == pytest.approx((-0.5, 2.0), abs=1e-6)
    assert filter_.update(start, [Bearing(0.0, 0, 1, 0.5, np.pi)]).headings.full.all()
    both = filter_.update(start, [Bearing(0.0, 0, 1, [1.5, -1.5], 2.0)]).headings
    assert both.contains(0.4).all() and both.contains(np.pi).all()  # they meet at both ends


def test_a_sensor_that_may_look_anywhere_says_nothing_of_directions():
    team = Team(1, MARK, arena=[[-9, -9], [9, 9]], sensors=[Sensor("loose", angle_bound=np.pi)])
    filter_ = SetMembershipFilter(team)
    start = filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])], AngularIntervals(0.0, 0.1))
    belief = filter_.update(start, [Bearing(0.0, 0, 1, 3.0, HALF, 0)])
    assert belief.headings.bound == pytest.approx(0.1)


@pytest.mark.parametrize("bound", BOUNDS)
def test_a_kalman_filter_weighs_them_as_wide_and_nothing_of_what_is_any_direction(bound):
    kalman = ExtendedKalmanFilter(Team(1, MARK), NoiseModel.same(0.5))
    belief = kalman.start(0.0, [Polygon.box([-1, -1], [1, 1])], AngularIntervals(0.0, 0.5))
    after = kalman.update(belief, [Bearing(0.0, 0, 1, 0.4, bound)])
    if bound == np.pi:
        assert (after.mean == belief.mean).all()
        assert np.allclose(after.covariance, belief.covariance)
    else:
        assert -0.4 < after.mean[0, 2] < 0
        assert kalman._linearised(belief, Bearing(0.0, 0, 1, 0.4, bound))[2] == pytest.approx((0.5 * bound) ** 2)


@pytest.mark.parametrize("version", [1, 2])
def test_logs_have_them(tmp_path, version):
    head = {"record": "header", "format": "corral-log", "version": version, "robots": 1, "landmarks": MARK, "start": 0.0}
    head |= {"arena": [[-9, -9], [9, 9]], "speed_limit": 1, "turn_rate_limit": 1, "rate": None}
    known = {"record": "initial", "robot": 0, "vertices": [[0, 0]], "heading": None}
    seen = {"record": "bearing", "time": 0.0, "robot": 0, "landmark": 0, "bearing": 0.1, "bound": 3.0}
    lines = [head, known, seen, {"record": "frame", "time": 0.0}]
    (tmp_path / "log.jsonl").write_text("".join(json.dumps(line) + "\n" for line in lines))
    (frame,) = LogReader(tmp_path / "log.jsonl").frames()
    assert isinstance(frame, Frame)
    assert frame.measurements[0].bound.tolist() == [3.0]


@pytest.mark.parametrize("seed", [1, 4])
def test_a_run_with_them_is_proved(tmp_path, seed):
    rng, lines = np.random.default_rng(seed), in_step(Drivers(np.random.default_rng(seed)))
    for line in lines:
        if line["record"] == "bearing" and rng.uniform() < 0.6:
            line["bound"] = float(rng.choice(BOUNDS))
            line["bearing"] += rng.uniform(-1, 1) * (line["bound"] - 0.1)
    log = written(tmp_path / "given.jsonl", lines)
    assert follow_command([str(log), "--certificates", "--out", str(tmp_path / "run")]) == 0
    assert links_of(tmp_path / "run", lambda _: None)["rows of bearings, from the log"] > 0


def test_more_than_half_a_turn_is_refused():
    with pytest.raises(InvalidInput, match=r"bearing bound \[rad\]: finite numbers within \[0, 3.14159\]"):
        Bearing(0.0, 0, 1, 0.0, np.nextafter(np.pi, 4))
