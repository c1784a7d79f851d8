"""The Kalman filter, given bounds of zero, tiny ones, exact starts and bodies in one place: it stays a filter."""

import numpy as np
import pytest

from filter import (
    AngularIntervals,
    Bearing,
    Compass,
    CorralError,
    ExtendedKalmanFilter,
    GaussianBelief,
    InvalidInput,
    NoiseModel,
    Odometry,
    Polygon,
    Range,
    Team,
)

LANDMARKS = np.array([[0.0, 0.0], [3.0, 0.0], [0.0, 4.0]])
TEAM = Team(3, LANDMARKS, 0.5, 1.5, [[-9, -9], [9, 9]])
BOUNDS = [0.0, 5e-324, 1e-200, 1e-160, 1e-20, 1e-9, 0.05]
PLACES = np.array([[0.3, 0.4], [1.5, -0.5], [-1.0, 2.0]])


def seen(place, heading, bodies):
    away = bodies - place
    return np.arctan2(away[:, 1], away[:, 0]) - heading, np.hypot(*away.T)


def scan(rng, places, headings, time=0.0):
    """Return exact readings of everything by everybody, each record with a bound of its own."""
    bodies, records = np.concatenate([places, LANDMARKS]), [Compass(time, np.arange(3), headings, rng.choice(BOUNDS, 3))]
    for robot in range(3):
        others = np.array([body for body in range(6) if body != robot])
        bearings, ranges = seen(places[robot], headings[robot], bodies[others])
        records.append(Bearing(time, robot, others, bearings, rng.choice(BOUNDS, 5)))
        records.append(Range(time, robot, others, ranges, rng.choice(BOUNDS, 5), rng.choice([0.0, 0.05])))
    return [records[k] for k in rng.permutation(len(records))]


def sound(belief):
    """Whether all is finite and the covariance one, but for its rounding."""
    least, most = np.linalg.eigvalsh(belief.covariance)[[0, -1]]
    return np.isfinite(belief.mean).all() and least >= -1e-14 * most and (np.diagonal(belief.covariance) >= 0).all()


@pytest.mark.parametrize("seed", range(40))
def test_exact_and_tiny_bounds_leave_finite_numbers_near_the_truth(seed):
    """What is read exactly, again and again, is no contradiction: the estimate ends at the truth and stays there."""
    rng = np.random.default_rng(seed)
    places, headings = PLACES + rng.uniform(-0.1, 0.1, (3, 2)), rng.uniform(-np.pi, np.pi, 3)
    kalman = ExtendedKalmanFilter(TEAM, gate=None if seed % 2 else 1 - 1e-9)
    half = rng.choice([0.0, 1e-9, 0.02], (3, 1))
    belief = kalman.start(0.0, [Polygon.box(p - h, p + h) for p, h in zip(places, half, strict=True)])
    for step in range(6):
        belief = kalman.update(belief, [*scan(rng, places, headings, belief.time), *scan(rng, places, headings, belief.time)])
        assert sound(belief)
        bounds = dict.fromkeys(("distance_bound", "turn_bound", "direction_bound", "slip_bound"), rng.choice(BOUNDS))
        belief = kalman.predict(belief, step + 1.0, Odometry(step, step + 1.0, [0, 1, 2], distance=0.0, turn=0.0, **bounds))
        assert sound(belief)
    apart = kalman.update(belief, scan(rng, places, headings, belief.time)).mean[:, :2] - places
    assert np.abs(apart).max() < 0.2


def test_exact_ranges_twice_end_where_the_robot_is():
    kalman, place = ExtendedKalmanFilter(Team(1, LANDMARKS)), PLACES[0]
    belief = kalman.start(0.0, [Polygon.box(place - 0.1, place + 0.12)])
    for _ in range(8):
        belief = kalman.update(belief, [Range(0.0, [0, 0, 0], [1, 2, 3], seen(place, 0.0, LANDMARKS)[1], 0.0, 0.0)])
        assert sound(belief)
    assert belief.heading_deviations[0] == pytest.approx(np.pi / np.sqrt(3))
    assert np.sqrt(belief.position_covariances[0].trace()) < 1e-6


def test_an_exact_start_stays_where_it_is_whatever_is_read():
    kalman = ExtendedKalmanFilter(Team(1, LANDMARKS), gate=0.999)
    belief = kalman.start(0.0, [Polygon.box(PLACES[0], PLACES[0])], AngularIntervals([0.1], [0.0]))
    for bound in BOUNDS[:4]:
        after = kalman.update(belief, [Compass(0.0, 0, 0.1, bound), Range(0.0, 0, 2, 7.0, bound, 0.0)])
        assert after.mean == pytest.approx(belief.mean, abs=1e-12)
        assert sound(after)


@pytest.mark.parametrize("bound", BOUNDS)
def test_a_body_in_the_same_place_tells_nothing(bound):
    """There is no direction to it: before, a bearing of it turned the robot to some direction of the world."""
    kalman = ExtendedKalmanFilter(Team(2, LANDMARKS))
    belief = kalman.start(0.0, [Polygon.box([-1, -1], [1, 1])] * 2, AngularIntervals([1.0, 2.0], [0.3, 0.3]))
    for target in (1, 2):  # the other robot, the first landmark
        after = kalman.update(belief, [Bearing(0.0, 0, target, 0.3, bound), Range(0.0, 0, target, 0.0, 0.0, bound)])
        assert np.array_equal(after.mean, belief.mean)
        assert np.array_equal(after.covariance, belief.covariance)


@pytest.mark.parametrize("size", [1e20, 1e49, 1e99])
def test_what_is_too_large_to_be_weighed_is_refused_or_finite(size):
    ranges = Range(0.0, [0, 0], [1, 2], [size, size], [0.0, 1e-200], 0.0)
    for gate in (None, 0.99):
        kalman = ExtendedKalmanFilter(Team(1, [[size, 0.0], [0.0, size]]), gate=gate)
        try:
            belief = kalman.start(0.0, [Polygon.box([-size, -size], [size, size])])
            assert sound(kalman.update(belief, [ranges, ranges]))
        except CorralError as error:
            assert "finite" in str(error)


def test_a_covariance_that_is_none_is_refused():
    belief = GaussianBelief(0.0, np.zeros((1, 3)), np.diag([0.0, 0.0, -1.0]))
    with pytest.raises(InvalidInput, match="covariance without negative variances"):
        ExtendedKalmanFilter(Team(1), NoiseModel.same(1.0)).update(belief, [Compass(0.0, 0, 0.0, 1.0)])


def test_what_rounding_has_taken_below_zero_is_none():
    belief = GaussianBelief(0.0, np.zeros((1, 3)), np.diag([1.0, 1.0, -1e-40]))
    after = ExtendedKalmanFilter(Team(1)).update(belief, [Compass(0.0, 0, 0.5, 0.1)])
    assert after.heading_deviations.tolist() == [0.0]
    assert sound(after)


@pytest.mark.parametrize("bound", [1e-4, 0.05])
def test_ordinary_bounds_are_weighed_as_declared(bound, monkeypatch):
    """To the last bit: the floor is far below them."""
    kalman = ExtendedKalmanFilter(TEAM)
    belief = kalman.start(0.0, [Polygon.box(place - 2.0, place + 2.0) for place in PLACES])
    records = [Compass(0.0, [0, 1, 2], 0.1, bound), Range(0.0, [0, 1, 2], [3, 4, 5], [1.0, 2.0, 3.0], bound, 0.0)]
    floored = kalman.update(belief, records)
    monkeypatch.setattr("filter.ekf.FINEST", 0.0)
    monkeypatch.setattr("filter.ekf.ROUNDING", 0.0)
    assert kalman.update(belief, records).covariance.tobytes() == floored.covariance.tobytes()


def contradictory(rng, bodies, headings):
    """Return a record of one kind: the same things read several times, exactly or nearly so, and half of the times wrongly."""
    robot, target = rng.integers(0, len(headings), 7), rng.integers(0, len(bodies), 7)
    robot, target = robot[robot != target], target[robot != target]
    away, count, wrong = bodies[target] - bodies[robot], len(robot), rng.integers(0, 2) * rng.normal(size=7)[: len(robot)]
    bounds = rng.choice(BOUNDS, count)
    if (kind := rng.integers(3)) == 0:
        return Compass(0.0, robot, headings[robot] + wrong, bounds)
    if kind == 1:
        return Bearing(0.0, robot, target, np.arctan2(away[:, 1], away[:, 0]) - headings[robot] + wrong, bounds)
    return Range(0.0, robot, target, np.hypot(*away.T) * (1 + np.abs(wrong)), bounds, rng.choice([0.0, 1e-20, 0.05]))


@pytest.mark.parametrize("seed", range(6))
def test_exact_readings_that_contradict_one_another_leave_finite_numbers(seed):
    for trial in range(50):
        rng = np.random.default_rng([seed, trial])
        scale, headings = 10.0 ** rng.integers(-3, 5), rng.uniform(-3, 3, 3)
        places, marks = rng.uniform(-scale, scale, (3, 2)), rng.uniform(-scale, scale, (2, 2))
        half, bounds = rng.choice([0.0, 1e-12, 1.0], (3, 1)) * scale, rng.choice([0.0, 1e-12, 0.1, np.pi], 3)
        kalman = ExtendedKalmanFilter(Team(3, marks), gate=rng.choice([None, 0.99]))
        boxes = [Polygon.box(place - size, place + size) for place, size in zip(places, half, strict=True)]
        belief = kalman.start(0.0, boxes, AngularIntervals(headings, bounds))
        rounding = 1e-14 * np.linalg.eigvalsh(belief.covariance)[-1]
        for _ in range(12):
            belief = kalman.update(belief, [contradictory(rng, np.concatenate([places, marks]), headings)])
            assert np.isfinite(belief.mean).all()
            assert (np.diagonal(belief.covariance) >= 0).all()
            assert np.linalg.eigvalsh(belief.covariance)[0] >= -rounding
