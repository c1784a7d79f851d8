"""The scene keeps its promises: every bound holds but the culprit's, and that one is broken when it is said to be."""

import numpy as np
import pytest
from helpers.drawn.promises import broken_promises

from experiments.broken.episodes import BEFORE, NEVER, Episode
from experiments.broken.fault import HARDLY, KINDS, LARGE, LASTING, OF_NAMES, SMALL, TURNED, checked_kind
from experiments.broken.outcome import Case
from experiments.broken.scene import HALF, ROBOTS, Scene
from filter import Bearing, Compass, InvalidInput

DRAWN = [(kind, landmarks) for kind in KINDS for landmarks in (4, 2)]


def drawn(seed, kind, landmarks=4):
    return Episode.drawn(np.random.default_rng([seed, landmarks]), kind, landmarks)


def blamed(fault):
    """Return the promises that a fault may break, as a test of a broken one."""
    pair = {fault.robot, fault.body}
    return {
        "slip": lambda kind, robot, _: (kind, robot) == ("odometry", fault.robot),
        "kidnap": lambda kind, robot, _: (kind, robot) == ("odometry", fault.robot),
        "start": lambda kind, robot, _: (kind, robot) == ("start", fault.robot),
        "compass": lambda kind, robot, _: (kind, robot) == ("compass", fault.robot),
        "swap": lambda kind, _, target: kind == "sighting" and target in pair,
        "misread": lambda kind, robot, target: (kind, robot, target) == ("sighting", fault.robot, fault.read),
        "biased": lambda kind, robot, _: (kind, robot) == ("sighting", fault.robot),
        "moved": lambda kind, _, target: (kind, target) == ("sighting", fault.body),
    }[fault.kind]


@pytest.mark.parametrize("landmarks", [4, 2, 1])
def test_every_bound_holds_where_nothing_is_wrong(landmarks):
    for seed in range(8):
        episode = drawn(seed, None, landmarks)
        assert episode.fault is NEVER
        assert list(broken_promises(episode)) == []


@pytest.mark.parametrize(("kind", "landmarks"), DRAWN)
def test_only_the_culprits_bounds_are_broken_and_only_while_it_is_said(kind, landmarks):
    for seed in range(4):
        fault = (episode := drawn(seed, kind, landmarks)).fault
        broken, may_be = list(broken_promises(episode)), blamed(fault)
        assert all(may_be(what, robot, target) for _, what, robot, target in broken)
        frames = {frame for frame, *_ in broken}
        assert all(fault.when <= frame < fault.until for frame in frames)
        if not fault.below and kind not in ("swap", "misread", "biased", "moved"):
            assert frames == set(range(fault.when, int(fault.until)))
        if not fault.below and landmarks == 4:  # nothing is out of view
            assert fault.when in frames


@pytest.mark.parametrize(("kind", "landmarks"), DRAWN)
def test_faults_are_as_large_as_they_say(kind, landmarks):
    faults = [drawn(seed, kind, landmarks).fault for seed in range(16)]
    if kind in OF_NAMES:
        assert not any(fault.below for fault in faults)
        return
    assert 0 < sum(fault.below for fault in faults) < 10
    for fault in faults:
        metres, radians = np.hypot(*fault.offset), abs(fault.turn)
        if fault.below:
            assert metres < LARGE
            assert radians < TURNED
            assert metres >= SMALL - 1e-12 or radians >= HARDLY
        else:
            assert metres >= LARGE - 1e-12 or radians >= TURNED


@pytest.mark.parametrize("kind", KINDS)
def test_episodes_go_on_after_the_fault_and_robots_stay_inside(kind):
    for seed in range(4):
        episode = drawn(seed, kind)
        fault, count = episode.fault, len(episode.frames)
        assert count - fault.settled in range(25, 31)
        assert (fault.when == 0) == (kind == "start") or kind == "compass"
        assert fault.when in (0, BEFORE)
        assert fault.lasts == (kind in LASTING)
        assert fault.lasts or fault.until - fault.when == (fault.until - fault.when if kind in ("compass", "misread") else 1)
        assert max(np.abs(frame.truth.positions).max() for frame in episode.frames) < HALF
        assert [frame.time for frame in episode.frames] == list(range(count))


def test_wheels_that_tell_too_little_have_slid_and_none_tells_of_a_way_back():
    for seed in range(12):
        for frame in drawn(seed, "slip").frames[1:]:
            assert (frame.odometry.distance > 0.2).all()


def test_all_landmarks_are_in_view_of_all_or_some_of_some():
    count = {landmarks: [] for landmarks in (4, 2)}
    for landmarks, counts in count.items():
        for frame in drawn(0, None, landmarks).frames:
            seen = [record for record in frame.measurements if isinstance(record, Bearing)]
            counts.append(sum(int((record.target >= ROBOTS).sum()) for record in seen))
    assert min(count[4]) >= 4 * ROBOTS - 2  # one is not seen from less than NEAREST
    assert 0 < np.mean(count[2]) < 2 * ROBOTS


def test_half_of_the_episodes_have_compasses_and_all_with_a_bad_one():
    def compasses(kind):
        return [any(isinstance(each, Compass) for each in drawn(seed, kind).frames[0].measurements) for seed in range(12)]

    assert 2 <= sum(compasses("slip")) <= 10
    assert all(compasses("compass"))


@pytest.mark.parametrize("kind", KINDS)
def test_the_same_seed_is_the_same_episode(kind):
    first, again, other = (Case(seed, kind, 1, 4).episode() for seed in (3, 3, 4))
    assert first.fault == again.fault
    for one, two in zip(first.frames, again.frames, strict=True):
        assert (one.truth.positions == two.truth.positions).all()
        for told, retold in zip(one.measurements, two.measurements, strict=True):
            assert all((getattr(told, name) == getattr(retold, name)).all() for name in ("robot", "bound"))
    assert (first.frames[0].truth.positions != other.frames[0].truth.positions).all()


@pytest.mark.parametrize("landmarks", [0, 9])
def test_a_scene_without_landmarks_or_with_too_many_is_refused(landmarks):
    with pytest.raises(InvalidInput, match="number of landmarks"):
        Scene.drawn(np.random.default_rng(0), landmarks, compass=False)


def test_a_kind_that_nobody_knows_is_refused():
    with pytest.raises(InvalidInput, match="slip, kidnap"):
        checked_kind("flood")
