"""The judge is never wrong where every bound holds, and notices nearly every large fault at once."""

import numpy as np
import pytest

from experiments.broken.boxes import Boxes
from experiments.broken.episodes import Episode
from experiments.broken.fault import KINDS
from experiments.broken.judge import Judge
from experiments.broken.past import NORMALS, Past
from filter import AngularIntervals, Bearing, Compass, Frame, Odometry, Polygon, Range, Team

RNG = np.random.default_rng


def around(truth, rng, metres=0.3, radians=0.1):
    """Return regions and arcs that hold the truth, often on their edge."""
    off = rng.choice([-1, -1 + 1e-9, 0.3, 1 - 1e-9], (len(truth.headings), 3))
    boxes = [Polygon.box(place - metres, place + metres) for place in truth.positions + metres * off[:, :2]]
    return boxes, AngularIntervals(truth.headings + radians * off[:, 2], np.full(len(off), radians))


@pytest.mark.parametrize("landmarks", [4, 2])
@pytest.mark.parametrize("seed", range(6))
def test_nothing_is_proved_where_every_bound_holds(seed, landmarks):
    """Each pose of each robot, some hundred frames a test: the true one is left, so the answer is known before it is asked."""
    rng = RNG([seed, landmarks])
    for _ in range(4):
        episode = Episode.drawn(rng, None, landmarks)
        begin = int(rng.integers(0, 6))
        judge = Judge.of(episode.team, *around(episode.frames[begin].truth, rng))
        for frame in episode.frames[begin + 1 :]:
            judge = judge.after(frame)
            places = judge.places()
            for robot, past in enumerate(judge.pasts):
                truth = np.array([[*frame.truth.positions[robot], frame.truth.headings[robot]]])
                pose = Boxes(truth, np.zeros((1, 3)))
                assert past.allows(pose).all()
                assert judge.instant(frame, robot, places).allows(pose).all()


@pytest.mark.parametrize("landmarks", [4, 2])
def test_asked_outright_it_proves_nothing_either(landmarks):
    rng = RNG([7, landmarks])
    for _ in range(3):
        episode = Episode.drawn(rng, None, landmarks)
        judge = Judge.of(episode.team, *around(episode.frames[0].truth, rng))
        for number, frame in enumerate(episode.frames[:24]):
            judge = judge.after(frame)
            assert number % 6 or not judge.proves(frame)


@pytest.mark.parametrize("seed", range(40))
def test_a_box_with_a_good_pose_is_never_excluded(seed):
    """Boxes of any size around a pose of which everything holds, at angles on both sides of pi."""
    rng = RNG(seed)
    pose = np.array([*rng.uniform(-3, 3, 2), rng.choice([-np.pi, np.pi, np.pi / 2, *rng.uniform(-4, 4, 3)])])
    half = 10.0 ** rng.uniform(-3, 0.7, (30, 3)) * rng.choice([0, 1], (30, 3), p=[0.2, 0.8])
    half[:, 2] = np.minimum(half[:, 2], np.pi)
    boxes = Boxes(pose + half * rng.choice([-1, 1, 0, 0.9], (30, 3)) * (1 - 1e-12), half)
    bodies, reach = rng.uniform(-4, 4, (5, 2)), 10.0 ** rng.uniform(-3, 0.3, (5, 2)) * rng.choice([0, 1], (5, 1))
    corners = bodies - reach * rng.uniform(0, 1, (5, 1)), bodies + reach
    apart = bodies - pose[:2]
    away, way = np.hypot(*apart.T), np.arctan2(apart[:, 1], apart[:, 0])
    bound = rng.uniform(0, 0.1, 5)
    said = way - pose[2] + bound * rng.choice([-1, 1], 5) + 2 * np.pi * rng.integers(-1, 2, 5)
    assert boxes.within_range(corners, np.stack([away - bound, away + bound], axis=1)).all()
    assert boxes.within_bearing(corners, np.stack([said, bound], axis=1)).all()
    assert boxes.within_direction(corners, np.stack([way + np.pi + bound, bound], axis=1)).all()
    assert boxes.within_heading(np.array([[pose[2] + 0.1 - 2 * np.pi, 0.1]])).all()
    assert boxes.within_supports(NORMALS, NORMALS @ pose[:2] * np.ones((30, 1))).all()


def test_halves_are_all_of_a_box():
    rng = RNG(0)
    boxes = Boxes(rng.uniform(-3, 3, (20, 3)), rng.uniform(0, 1, (20, 3)))
    halves = boxes.split(4.0)
    assert len(halves) == 40
    points = boxes.middle + boxes.half * rng.uniform(-1, 1, (200, 20, 3))
    within = np.abs(points[:, None] - halves.middle.reshape(2, 20, 3)) <= halves.half.reshape(2, 20, 3) + 1e-12
    assert within.all(axis=3).any(axis=1).all()
    assert halves.half.sum() < 2 * boxes.half.sum()


@pytest.mark.parametrize("seed", range(60))
def test_the_past_holds_every_way_that_can_have_been_driven(seed):
    """Backwards, hardly at all, sideways and in half circles: what is drawn within the bounds is allowed."""
    rng = RNG(seed)
    place, heading = rng.uniform(-1, 1, 2), rng.uniform(-np.pi, np.pi)
    past = Past.of(Polygon.box(place - 0.1, place + 0.1), AngularIntervals([heading + 0.05], [0.05 + 1e-12]), 0)
    for k in range(6):
        bounds = {"distance_bound": rng.uniform(0, 0.1), "turn_bound": rng.uniform(0, 0.2)}
        bounds |= {
            "direction_bound": rng.uniform(0, 0.2),
            "slip_bound": rng.uniform(0, 0.05),
            "aside": rng.choice([0, 1.5, -3]),
        }
        length, turn = rng.choice([0.5, -0.5, 0.02]), rng.uniform(-2, 2)
        told = Odometry(k, k + 1, 0, distance=length, turn=turn, **bounds)
        signs, ends = rng.choice([-1, 1], 3), rng.uniform(-np.pi, np.pi)
        driven, turned = length + signs[0] * bounds["distance_bound"], turn + signs[1] * bounds["turn_bound"]
        way = heading + turned / 2 + bounds["aside"] + signs[2] * bounds["direction_bound"]
        chord = driven * np.sinc(turned / (2 * np.pi))
        slip = bounds["slip_bound"] * np.array([np.cos(ends), np.sin(ends)])
        place, heading = place + chord * np.array([np.cos(way), np.sin(way)]) + slip, heading + turned
        past = past.moved(told, 0)
        assert past.allows(Boxes(np.array([[*place, heading]]), np.zeros((1, 3)))).all()
        half = np.array([[*10.0 ** rng.uniform(-3, 0, 2), rng.uniform(0, 0.3)]])
        assert past.allows(Boxes(np.array([[*place, heading]]) + half * rng.choice([-1, 1], 3), half)).all()


@pytest.mark.parametrize("length", [0.5, -0.5])
@pytest.mark.parametrize("turn", [2.0, -2.0, 3.15, 0.0])
def test_a_path_that_bends_gets_less_far_than_it_is_long_and_no_farther(length, turn):
    still = AngularIntervals([0.0], [0.0])
    told = Odometry(0, 1, 0, distance=length, distance_bound=0, turn=turn, turn_bound=0, direction_bound=0, slip_bound=0)
    past, way = Past.of(Polygon.box([0, 0], [0, 0]), still, 0).moved(told, 0), turn / 2

    def is_allowed(chord):
        pose = np.array([[chord * np.cos(way), chord * np.sin(way), turn]])
        return bool(past.allows(Boxes(pose, np.zeros((1, 3)))))

    assert is_allowed(length * np.sinc(turn / (2 * np.pi)))
    assert not is_allowed(1.1 * length)
    assert is_allowed(0.0) == (abs(turn) > 3)
    assert not is_allowed(-0.5 * length)


@pytest.mark.parametrize("kind", KINDS)
def test_nearly_every_large_fault_is_proved_at_once_where_four_landmarks_are_in_view(kind):
    rng, found = RNG(5), []
    while len(found) < 6:
        episode = Episode.drawn(rng, kind, 4)
        fault = episode.fault
        if fault.below:
            continue
        regions, headings = episode.positions, episode.headings
        if fault.when:
            regions, headings = around(episode.frames[fault.when - 1].truth, rng, 0.1, 0.05)
        judge = Judge.of(episode.team, regions, headings).after(episode.frames[fault.when])
        found.append(judge.proves(episode.frames[fault.when]))
    assert sum(found) >= 5


def seen(place, heading, marks):
    """Return exact sightings of landmarks from a pose."""
    apart = marks - place
    told = 0.0, [0] * len(marks), range(1, 1 + len(marks))
    return Bearing(*told, np.arctan2(apart[:, 1], apart[:, 0]) - heading, 0.01), Range(*told, np.hypot(*apart.T), 0.01, 0.0)


MARKS = np.array([[2.0, 0.0], [0.0, 3.0]])


@pytest.mark.parametrize(("x", "proved"), [(0.0, False), (0.1, False), (0.125, True), (-0.13, True)])
def test_a_gap_is_proved_from_its_width_on(x, proved):
    """A robot in a box of +-0.1 m, seen from elsewhere to 1 cm: what is left in between decides."""
    judge = Judge.of(Team(1, MARKS), [Polygon.box([-0.1, -0.1], [0.1, 0.1])], AngularIntervals([0.0], [0.1]))
    assert judge.proves(Frame(0.0, None, seen(np.array([x, 0.0]), 0.0, MARKS))) == proved


@pytest.mark.parametrize(("x", "proved"), [(0.1, False), (0.13, True)])
def test_bearings_that_each_could_be_true_are_cut_until_they_exclude_one_another(x, proved):
    """The heading is hardly known, so that no bearing alone says anything of the place."""
    marks = np.array([[2.0, 0.0], [0.0, 3.0], [-2.0, -1.0], [0.5, -2.0]])
    judge = Judge.of(Team(1, marks), [Polygon.box([-0.1, -0.1], [0.1, 0.1])], AngularIntervals([0.2], [0.5]))
    (bearings, _) = seen(np.array([x, 0.0]), 0.0, marks)
    assert judge.proves(Frame(0.0, None, (bearings,))) == proved


@pytest.mark.parametrize(("turn", "proved"), [(3.1, False), (-3.1, False), (0.5, True)])
def test_headings_meet_across_the_back(turn, proved):
    judge = Judge.of(Team(1, MARKS), [Polygon.box([-0.1, -0.1], [0.1, 0.1])], AngularIntervals([np.pi], [0.1]))
    assert judge.proves(Frame(0.0, None, seen(np.zeros(2), turn, MARKS))) == proved
    assert judge.proves(Frame(0.0, None, (Compass(0.0, 0, turn, 0.01),))) == proved


@pytest.mark.parametrize(("y", "proved"), [(0.0, False), (0.3, False), (1.0, True)])
def test_mates_count_wherever_they_can_be_and_whoever_sees_whom(y, proved):
    regions = [Polygon.box([-0.1, -0.1], [0.1, 0.1]), Polygon.box([1.9, -0.2], [2.1, 0.2])]
    for one, other in ((0, 1), (1, 0)):
        judge = Judge.of(Team(2), regions, AngularIntervals([0.0, np.pi], [0.05, 0.05]))
        bearing, range_ = np.arctan2(y, 2.0), np.hypot(y, 2.0)
        frame = Frame(0.0, None, (Bearing(0.0, one, other, bearing, 0.01), Range(0.0, one, other, range_, 0.01, 0.0)))
        assert judge.proves(frame) == proved


def test_nothing_is_proved_by_a_frame_that_says_nothing():
    judge = Judge.of(Team(1, MARKS), [Polygon.box([-0.1, -0.1], [0.1, 0.1])], None)
    assert not judge.proves(Frame(0.0))
