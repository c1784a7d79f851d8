"""What a robot sees of a mate's heading: headings narrow one another."""

import numpy as np
import pytest

from filter import (
    AngularIntervals,
    Compass,
    ExtendedKalmanFilter,
    Frame,
    Inconsistent,
    InvalidInput,
    Odometry,
    Polygon,
    RelativeHeading,
    Sensor,
    SetMembershipFilter,
    Team,
    wrap,
)
from filter.sensing.headings import headings_at, narrowed_headings
from filter.sensing.readings import Readings
from filter.sensing.since import Since
from filter.sensing.ties import LEAST, Ties, tie

ARENA = [[-9, -9], [9, 9]]
SENSORS = [Sensor("camera", [0.2, 0.0], angle=2.5, angle_bound=0.05), Sensor("tag", angle=-3.0, time_bound=0.1)]
NO_SPANS = AngularIntervals.circles(0)


def error(rng, count):
    """Return errors in [-1, 1], some of them at an end."""
    return np.where(rng.random(count) < 0.3, rng.choice([-1.0, 1.0], count), rng.uniform(-1, 1, count))


def drawn(rng, looks, time=0.0, count=6):
    """Return what robots that look so (n,) see of others by sensors mounted or at centres; from narrow to useless."""
    robots, angles = len(looks), np.array([2.5, -3.0, 0.0])
    robot = rng.integers(robots, size=count)
    target = (robot + rng.integers(1, robots, count)) % robots
    sensor, tag = rng.integers(-1, 2, count), rng.integers(-1, 2, count)
    bound = rng.choice([0.0, 0.02, 0.5, 2.5, np.pi], count)
    true = looks[target] + angles[tag] - looks[robot] - angles[sensor]
    return RelativeHeading(time, robot, target, wrap(true + bound * error(rng, count)), bound, sensor, tag)


@pytest.mark.parametrize("seed", range(100))
def test_the_truth_stays_and_no_reading_would_narrow_anything_more(seed):
    rng = np.random.default_rng(seed)
    robots = int(rng.integers(2, 6))
    looks, team = wrap(rng.choice([0.0, np.pi, 2.0], robots) + rng.uniform(-0.1, 0.1, robots)), Team(robots, sensors=SENSORS)
    wide = rng.choice([0.05, 1.0, 3.0, np.pi], robots)
    known = AngularIntervals(looks + 0.99 * wide * error(rng, robots), wide)
    records = [drawn(rng, looks), drawn(rng, looks), Compass(0.0, 0, looks[0], 0.01)]
    found = narrowed_headings(known, Readings.of(0.0, records, None, team.mountings), NO_SPANS)
    assert found.contains(looks).all()
    assert (found.bound <= known.bound + 1e-12).all()
    for _ in range(3):
        readings = Readings.of(0.0, records[::-1], None, team.mountings)
        arcs = np.stack([found.centre, found.bound])
        assert tie(arcs, Ties.of(readings, robots)) == -1
        assert (arcs[1] >= found.bound - 10 * LEAST).all()
        other = narrowed_headings(known, readings, NO_SPANS)
        assert (other.centre.tolist(), other.bound.tolist()) == (found.centre.tolist(), found.bound.tolist())


@pytest.mark.parametrize("order", [(0, 1, 2), (2, 1, 0), (1, 2, 0)])
def test_a_chain_hands_a_compass_on_whatever_the_numbers_of_its_robots(order):
    team, looks, bound = Team(4), np.array([3.0, -2.0, 0.5, 1.0]), 0.01
    chain = [(0, 1), (1, 2), (2, 3)]
    records = [RelativeHeading(0.0, a, b, looks[b] - looks[a], bound) for a, b in (chain[k] for k in order)]
    records.append(Compass(0.0, 3, looks[3], 0.02))
    found = narrowed_headings(AngularIntervals.circles(team.robots), Readings.of(0.0, records), NO_SPANS)
    assert found.contains(looks).all()
    assert found.bound == pytest.approx([0.05, 0.04, 0.03, 0.02], abs=1e-9)


@pytest.mark.parametrize("seed", range(40))
def test_the_truth_stays_at_several_instants(seed):
    rng = np.random.default_rng(seed)
    team, looks = Team(3, sensors=SENSORS), rng.uniform(-np.pi, np.pi, 3)
    start, truth, frames, records = looks, [looks], [], []
    for k in range(1, 5):
        turn = rng.uniform(-1, 1, 3)
        driven = Odometry(k - 1.0, float(k), [0, 1, 2], 0.0, 0.1, turn + 0.04 * error(rng, 3), 0.041, 0.1, 0.1)
        looks = wrap(looks + turn)
        truth.append(looks)
        seen = drawn(rng, looks, float(k), 3)
        frames.append(Frame(float(k), driven, [seen]))
        records.append(seen)
    records.append(Compass(4.0, 0, looks[0], 0.01))
    since = Since.of(team, AngularIntervals(start, np.full(3, 0.5)), 0.0, frames)
    found = headings_at(since, Readings.of(4.0, records, since, team.mountings), NO_SPANS)
    assert found.contains(np.concatenate(truth)).all()


def test_an_arc_of_one_robot_at_an_instant_narrows_others_at_all_instants():
    team = Team(2)
    driven = [Odometry(k - 1.0, float(k), [0, 1], 0.0, 0.0, 0.3, 0.01, 0.0, 0.0) for k in (1, 2)]
    records = [RelativeHeading(1.0, 0, 1, 1.0, 0.02), Compass(2.0, 1, 1.6, 0.05)]
    frames = [Frame(1.0, driven[0], records[:1]), Frame(2.0, driven[1], records[1:])]
    since = Since.of(team, AngularIntervals.circles(2), 0.0, frames)
    found = headings_at(since, Readings.of(2.0, records, since), NO_SPANS)
    assert found.contains([0.0, 1.0, 0.3, 1.3, 0.6, 1.6]).all()
    assert found.bound == pytest.approx([0.09, 0.07, 0.08, 0.06, 0.09, 0.05], abs=1e-9)


def started(team, filter_):
    return filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])] * team.robots)


EXCHANGED = ("exchange", 1, 2)


def test_who_disagrees_is_named():
    team = Team(3, arena=ARENA)
    lies = [Compass(0.0, 0, 0.0, 0.1), Compass(0.0, 1, 1.0, 0.1), RelativeHeading(0.0, 0, 1, 2.0, 0.1)]
    filter_ = SetMembershipFilter(team)
    with pytest.raises(Inconsistent) as caught:
        filter_.update(started(team, filter_), [*lies, Compass(0.0, 2, 0.0, 0.1)])
    named = {(source.kind, source.robot, source.target) for source in caught.value.sources}
    assert named == {("compass", 0, None), ("compass", 1, None), ("relative heading", 0, 1)}
    filter_ = SetMembershipFilter(team, policy="reject")
    belief = filter_.update(started(team, filter_), lies)
    found = {suspect.who for suspect in belief.suspects}
    assert found == {("compass", 0, -1), ("compass", 1, -1), ("sensor", 0, -1), ("body", -1, 1), ("sighting", 0, 1), EXCHANGED}


def test_the_kalman_filter_turns_by_it_across_half_a_turn():
    team = Team(2, arena=ARENA, sensors=[Sensor("back", angle=3.0)])
    filter_ = ExtendedKalmanFilter(team)
    known = filter_.start(0.0, [Polygon.box([-1, -1], [1, 1])] * 2, AngularIntervals([3.1, -3.0], [0.01, 0.5]))
    seen = RelativeHeading(0.0, 0, 1, wrap(2 * np.pi - 6.2 + 0.3 - 3.0), 0.01, 0)
    belief = filter_.update(known, [seen])
    assert wrap(belief.mean[1, 2] - belief.mean[0, 2] - (2 * np.pi - 6.2 + 0.3)) == pytest.approx(0, abs=1e-2)
    assert belief.heading_deviations[1] < 0.02
    useless = filter_.update(known, [RelativeHeading(0.0, 0, 1, 2.0, np.pi)])
    assert useless.mean.tolist() == known.mean.tolist()


def test_what_is_refused():
    team = Team(2, [[3.0, 0.0]], arena=ARENA)
    for wrong in (90.0, -26.0):
        with pytest.raises(InvalidInput, match=r"relative heading \[rad\]: no more than four turns"):
            RelativeHeading(0.0, 0, 1, wrong, 0.1)
    with pytest.raises(InvalidInput, match="relative heading: a target other than the robot"):
        RelativeHeading(0.0, 0, 0, 1.0, 0.1)
    with pytest.raises(InvalidInput, match="a target among robots 0 to 1"):
        team.check(RelativeHeading(0.0, 0, 2, 1.0, 0.1))
