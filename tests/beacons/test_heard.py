"""A real team that stands: bounds that its first seconds tell, lies as they are meant, frames with each range in its place."""

from dataclasses import replace

import numpy as np
import pytest

from experiments.beacons.heard import Heard, bounds_of, lied, scene_of
from filter import InvalidInput

PLACES = np.array([[0.0, 0.0], [6.0, 0.0], [1.0, 5.0], [4.0, 3.0], [7.0, 6.0]])
ANCHORS = (0, 1, 4)
FIRST = 10.0


def said(seed=0, duration=20.0, rate=5.0):
    """Return what five robots say: every ordered pair some times a second, each pair with a bias of its own, never short."""
    rng, count = np.random.default_rng(seed), len(PLACES)
    pairs = [(i, j) for i in range(count) for j in range(count) if i != j]
    times = np.arange(0, duration, 1 / rate)
    robot, target = np.tile(np.array(pairs), (len(times), 1)).T
    time = np.repeat(times, len(pairs)) + np.tile(np.linspace(0, 0.1, len(pairs)), len(times))
    bias = rng.uniform(0.1, 0.6, len(pairs))
    length = np.hypot(*(PLACES[target] - PLACES[robot]).T) + np.tile(bias, len(times)) + rng.uniform(-0.05, 0.05, len(time))
    return Heard(tuple("abcde"), PLACES, time, robot, target, length)


@pytest.mark.parametrize("bounds", ["common", "pair"])
def test_bounds_hold_in_the_first_seconds_and_are_as_wide_as_said(bounds):
    heard = said()
    tight, wide = bounds_of(heard, FIRST, 0.0, bounds), bounds_of(heard, FIRST, 0.25, bounds)
    first = heard.time <= FIRST
    assert ((tight[:, 0] <= heard.error) & (heard.error <= tight[:, 1]))[first].all()
    assert np.ptp(wide, axis=1) == pytest.approx(1.5 * np.ptp(tight, axis=1))
    of_pair = (heard.robot == 2) & (heard.target == 3) & first if bounds == "pair" else first
    row = tight[np.flatnonzero(of_pair)[0]]
    assert row.tolist() == [heard.error[of_pair].min(), heard.error[of_pair].max()]
    assert len(np.unique(tight, axis=0)) == (20 if bounds == "pair" else 1)


def test_bounds_need_ranges_of_every_pair_they_are_for():
    heard = said()
    silent = (heard.robot == 2) & (heard.target == 3) & (heard.time <= FIRST)
    rest = Heard(heard.names, PLACES, *(column[~silent] for column in (heard.time, heard.robot, heard.target, heard.length)))
    assert len(bounds_of(rest, FIRST, 0.1, "common")) == len(rest.time)
    with pytest.raises(InvalidInput, match="every pair"):
        bounds_of(rest, FIRST, 0.1, "pair")


def test_a_longer_range_is_one_for_five_seconds():
    heard = said()
    added = lied(heard, "longer", (2, 0), 12.0).length - heard.length
    lies = added > 0
    assert added[lies] == pytest.approx(1.5)
    assert set(zip(heard.robot[lies].tolist(), heard.target[lies].tolist(), strict=True)) == {(2, 0)}
    assert heard.time[lies].min() > 12.0
    assert heard.time[lies].max() <= 17.0
    assert lies.sum() == 25
    assert lied(heard, "none", (2, 0), 12.0) is heard


@pytest.mark.parametrize("lie", ["longer", "moved"])
def test_a_lie_that_nobody_would_hear_is_refused(lie):
    with pytest.raises(InvalidInput, match="ranges of c to a after 30 s, for a lie"):
        lied(said(), lie, (2, 0), 30.0)


def test_one_that_was_moved_is_measured_where_it_is_and_known_where_it_was():
    heard = said()
    moved = lied(heard, "moved", (2, 0), 12.0)
    concerned = (heard.robot == 0) | (heard.target == 0)
    before = heard.time <= 12.0
    assert (moved.length == heard.length)[~concerned | before].all()
    there = replace(moved, places=PLACES + np.array([[1.0, 0.0]] + 4 * [[0.0, 0.0]]))
    assert there.error[concerned & ~before] == pytest.approx(heard.error[concerned & ~before])
    assert (moved.places == PLACES).all()


@pytest.mark.parametrize("bounds", ["common", "pair"])
def test_frames_have_the_newest_range_of_each_pair_and_the_truth_within_its_bounds(bounds):
    heard = said()
    limits = bounds_of(heard, 20.0, 0.0, bounds)
    scene = scene_of(heard, ANCHORS, limits, FIRST, 0.5)
    assert scene.team.names == ("c", "d", "a", "b", "e")
    assert [frame.time for frame in scene.frames] == pytest.approx(np.arange(10.5, 19.9, 0.5))
    bodies = np.concatenate([PLACES[[2, 3]], PLACES[list(ANCHORS)]])
    for frame in scene.frames:
        (record,) = frame.measurements
        assert len(record.robot) == 2 * 2 * 3 + 2  # with each anchor both ways, and c and d both ways
        assert (record.robot < 2).all()
        distance = np.hypot(*(bodies[record.target] - bodies[record.robot]).T)
        low, high = record.interval()
        assert ((low <= distance + 1e-9) & (distance <= high + 1e-9)).all()
        assert frame.truth.positions.tolist() == PLACES[[2, 3]].tolist()
    newest = (heard.robot == 2) & (heard.target == 3) & (heard.time <= scene.frames[3].time)
    middle = limits[newest][-1].mean()
    (record,) = scene.frames[3].measurements
    assert heard.length[newest][-1] - middle in record.range[(record.robot == 0) & (record.target == 1)]


def test_what_makes_no_scene_is_refused():
    heard = said(duration=10.2)
    limits = bounds_of(heard, FIRST, 0.1, "common")
    for anchors, since in ((range(5), 5.0), ((), 5.0), (ANCHORS, 10.0)):
        with pytest.raises(InvalidInput, match="anchors, other robots"):
            scene_of(heard, list(anchors), limits, since, 0.5)
    with pytest.raises(InvalidInput, match="a robot among a, b"):
        heard.number("z")
