from dataclasses import replace
from functools import partial

import numpy as np
import pytest
from helpers.sensing.mounted import MountedWorld
from helpers.worlds import World
from scipy.stats import chi2

from filter import Bearing, Compass, Odometry, Range, Sensor
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.ekf import UNIFORM, ExtendedKalmanFilter, GaussianBelief, NoiseModel
from filter.errors import InvalidInput, OutOfOrder
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.team import Team

TEAM = Team(3, landmarks=[[4.0, 1.0]], speed_limit=0.5, turn_rate_limit=1.0)
SENSORS = Sensor("camera", [0.4, -0.1], 0.02, 0.6, 0.03), Sensor("tag", [-0.3, 0.5])
MEAN = np.array([[0.3, -0.2, 0.7], [2.0, 1.0, -2.9], [-1.0, 2.5, 3.1]])
STEP = 1e-6  # of finite differences
SAME = 1e-7  # what they are right to


def belief_at(mean=MEAN, covariance=None, time=0.0):
    return GaussianBelief(time, mean.copy(), np.eye(mean.size) * 0.01 if covariance is None else covariance)


def moved(state):
    return belief_at(MEAN + state.reshape(-1, 3))


def driven(**changes):
    columns = {"distance": [0.4, -0.2, 0.0], "turn": [0.3, 0.5, -0.8]}
    bounds = {"distance_bound": 0.0, "turn_bound": 0.0, "direction_bound": 0.0, "slip_bound": 0.0}
    return Odometry(start=0.0, time=1.0, robot=[0, 1, 2], **{**columns, **bounds, **changes})


def differences(function, size):
    """Return the (k, size) derivatives of a function of a (size,) vector at 0, angles not wrapped."""
    return np.column_stack([(function(STEP * e) - function(-STEP * e)) / (2 * STEP) for e in np.eye(size)])


def boxes(positions, half):
    return [Polygon.box(place - half, place + half) for place in positions]


def test_the_jacobian_of_a_prediction_is_that_of_finite_differences():
    kalman = ExtendedKalmanFilter(TEAM)
    numeric = differences(lambda state: kalman.predict(moved(state), 1.0, driven()).mean.ravel(), 9)
    for k, direction in enumerate(np.eye(9)):
        covariance = kalman.predict(belief_at(covariance=np.outer(direction, direction)), 1.0, driven()).covariance
        assert covariance == pytest.approx(np.outer(numeric[:, k], numeric[:, k]), abs=SAME)


@pytest.mark.parametrize("column", ["distance", "turn"])
def test_what_an_error_of_odometry_adds_is_that_of_finite_differences(column):
    kalman, bound = ExtendedKalmanFilter(TEAM, NoiseModel.same(0.5)), 0.02

    def after(errors):
        odometry = driven()
        return kalman.predict(belief_at(), 1.0, replace(odometry, **{column: getattr(odometry, column) + errors})).mean.ravel()

    numeric = differences(after, 3)
    certain = belief_at(covariance=np.zeros((9, 9)))
    added = kalman.predict(certain, 1.0, driven(**{f"{column}_bound": bound})).covariance
    assert added == pytest.approx((0.5 * bound) ** 2 * numeric @ numeric.T, abs=SAME)


def test_an_error_of_direction_moves_a_robot_across_its_way_and_slip_moves_it_anywhere():
    kalman, certain = ExtendedKalmanFilter(TEAM, NoiseModel.same(0.5)), belief_at(covariance=np.zeros((9, 9)))
    way = MEAN[0, 2] + 0.3 / 2
    across = 0.4 * np.array([-np.sin(way), np.cos(way)])
    added = kalman.predict(certain, 1.0, driven(direction_bound=0.1)).position_covariances
    assert added[0] == pytest.approx((0.5 * 0.1) ** 2 * np.outer(across, across), abs=1e-12)
    slipped = kalman.predict(certain, 1.0, driven(slip_bound=0.1))
    assert slipped.position_covariances == pytest.approx(np.array([np.eye(2) * (0.5 * 0.1) ** 2] * 3), abs=1e-12)
    assert slipped.heading_deviations.tolist() == [0, 0, 0]


@pytest.mark.parametrize(
    "record",
    [
        Compass(0.0, [0, 2], [0.5, -3.0], 0.05),
        Bearing(0.0, [0, 1, 2, 0], [1, 0, 3, 3], [0.1, 0.2, 0.3, 0.4], 0.05),
        Range(0.0, [0, 1, 2, 1], [1, 2, 3, 3], [2.0, 3.0, 5.0, 2.0], 0.1, 0.05),
        Compass(0.0, [0, 2], [0.5, -3.0], 0.05, [0, 1]),
        Bearing(0.0, [0, 1, 2, 0], [1, 0, 3, 3], [0.1, 0.2, 0.3, 0.4], 0.05, [0, 1, 0, -1], [1, 0, -1, -1]),
        Range(0.0, [0, 1, 2, 1], [1, 2, 3, 3], [2.0, 3.0, 5.0, 2.0], 0.1, 0.05, [-1, 1, 0, 0], [0, 1, -1, -1]),
    ],
    ids=lambda record: type(record).__name__,
)
def test_the_jacobian_of_a_measurement_is_that_of_finite_differences(record):
    kalman = ExtendedKalmanFilter(replace(TEAM, sensors=SENSORS))
    numeric = differences(lambda state: -kalman._linearised(moved(state), record)[0], 9)
    assert kalman._linearised(belief_at(), record)[1] == pytest.approx(numeric, abs=SAME)


@pytest.mark.parametrize("seed", range(5))
def test_exact_readings_of_mounted_sensors_are_as_expected(seed):
    world = MountedWorld(np.random.default_rng(seed), robots=3, bound=0.0, sloppy=0.0)
    kalman, mean = ExtendedKalmanFilter(world.team), np.column_stack([world.positions, world.headings])
    for record in world.measure():
        assert kalman._linearised(belief_at(mean), record)[0] == pytest.approx(0, abs=1e-9)


def test_the_bounds_of_mountings_are_added_to_those_of_readings():
    kalman = ExtendedKalmanFilter(replace(TEAM, sensors=SENSORS), NoiseModel.same(1.0))
    belief = belief_at(np.array([[2.4, 1.1, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]))  # its camera is 1.2 m from the landmark
    records = Compass(0.0, 0, 0.0, 0.05, 0), Range(0.0, 0, 1, 2.0, 0.1, 0.0, 0, 0), Bearing(0.0, 0, 3, 0.0, 0.05, 0)
    variances = [kalman._linearised(belief, record)[2] for record in records]
    expected = [0.05 + 0.03, 0.1 + 2 * 0.02, 0.05 + 0.03 + 0.02 / 1.2]
    assert np.sqrt(np.concatenate(variances)) == pytest.approx(expected)


class Exact:
    """Robots that move and measure as the filter's model says, without any error."""

    def __init__(self, seed):
        self.rng = np.random.default_rng(seed)
        self.positions, self.headings = self.rng.uniform(0, 4, (3, 2)), self.rng.uniform(-np.pi, np.pi, 3)
        self.time = 0.0

    def move(self):
        distance, turn = self.rng.uniform(0, 0.05, 3), self.rng.uniform(-0.2, 0.2, 3)
        way = self.headings + turn / 2
        self.positions = self.positions + distance[:, None] * np.column_stack([np.cos(way), np.sin(way)])
        self.headings = wrap(self.headings + turn)
        start, self.time = self.time, self.time + 0.1
        return Odometry(start, self.time, np.arange(3), distance, np.full(3, 1e-3), turn, 0.01, 0.01, 1e-3)

    def measure(self):
        bodies = np.concatenate([self.positions, TEAM.landmarks])
        robot, target = np.nonzero(~np.eye(3, 4, dtype=bool))
        away = bodies[target] - self.positions[robot]
        bearing = wrap(np.arctan2(away[:, 1], away[:, 0]) - self.headings[robot])
        return [
            Compass(self.time, np.arange(3), self.headings, 0.05),
            Bearing(self.time, robot, target, bearing, 0.05),
            Range(self.time, robot, target, np.hypot(*away.T), 0.0, 0.05),
        ]

    def error(self, belief):
        turned = wrap(belief.mean[:, 2] - self.headings)
        return max(np.abs(belief.mean[:, :2] - self.positions).max(), np.abs(turned).max())


def test_a_noiseless_run_gives_no_error():
    world, kalman = Exact(1), ExtendedKalmanFilter(TEAM)
    belief = kalman.start(0.0, boxes(world.positions, 0.3), AngularIntervals(world.headings, np.full(3, 0.2)))
    for _ in range(100):
        odometry = world.move()
        belief = kalman.update(kalman.predict(belief, world.time, odometry), world.measure())
        assert world.error(belief) < 1e-11


def test_exact_measurements_mend_a_wrong_start():
    world, kalman = Exact(2), ExtendedKalmanFilter(TEAM)
    belief = kalman.start(0.0, boxes(world.positions + np.array([0.2, -0.1]), 0.3))
    belief = kalman.update(belief, world.measure())
    first = world.error(belief)
    for _ in range(300):
        odometry = world.move()
        belief = kalman.update(kalman.predict(belief, world.time, odometry), world.measure())
    assert first > 0.01
    assert world.error(belief) < 0.001


def numerically(function, at, size):
    return np.column_stack([(function(at + STEP * e) - function(at - STEP * e)) / (2 * STEP) for e in np.eye(size)])


class Model:
    """The same motion and measurements written once more, robot by robot and reading by reading, without Jacobians."""

    def __init__(self, team, noise):
        self.team, self.noise = team, noise

    def motion(self, state, errors, odometry):
        after = state.copy()
        for k, robot in enumerate(odometry.robot):
            heading = state[3 * robot + 2]
            read = np.array([odometry.distance[k], odometry.turn[k], 0, 0, 0])
            distance, turn, swerve, *slip = errors[5 * k : 5 * k + 5] + read
            way = heading + turn / 2 + swerve
            after[3 * robot] += distance * np.cos(way) + slip[0]
            after[3 * robot + 1] += distance * np.sin(way) + slip[1]
            after[3 * robot + 2] += turn
        return after

    def motion_deviations(self, odometry):
        noise = self.noise
        columns = [
            noise.distance * odometry.distance_bound,
            noise.turn * odometry.turn_bound,
            noise.direction * odometry.direction_bound,
            noise.slip * odometry.slip_bound,
            noise.slip * odometry.slip_bound,
        ]
        return np.column_stack(columns).ravel()

    def place(self, state, body):
        robots = self.team.robots
        return state[3 * body : 3 * body + 2] if body < robots else self.team.landmarks[body - robots]

    def reading(self, record, k, state):
        robot = record.robot[k]
        if isinstance(record, Compass):
            return state[3 * robot + 2]
        x, y = self.place(state, record.target[k]) - self.place(state, robot)
        return np.sqrt(x * x + y * y) if isinstance(record, Range) else np.arctan2(y, x) - state[3 * robot + 2]

    def deviation(self, record, k, state):
        if isinstance(record, Range):
            distance = self.reading(record, k, state)
            return self.noise.range * (record.bound[k] + record.relative_bound[k] * distance)
        return (self.noise.compass if isinstance(record, Compass) else self.noise.bearing) * record.bound[k]


def take(other, after, _):
    other.x = after


def followed_by_filterpy(model, belief, log):
    """Yield mean and covariance of filterpy's filter after each step of a log."""
    from filterpy.kalman import ExtendedKalmanFilter as Other

    other = Other(belief.mean.size, 1)
    other.x, other.P = belief.mean.ravel().copy(), belief.covariance.copy()
    for odometry, records in log:
        size, state = len(other.x), other.x.copy()
        still = np.zeros(5 * len(odometry.robot))
        motion = partial(model.motion, odometry=odometry)
        other.F = numerically(partial(motion, errors=still), state, size)
        G = numerically(partial(motion, state), still, len(still))
        other.Q = G @ np.diag(model.motion_deviations(odometry) ** 2) @ G.T
        other.predict_x = partial(take, other, motion(state, still))
        other.predict()
        for record in records:
            count, seen = len(record.robot), other.x.copy()
            readings = record.heading if isinstance(record, Compass) else getattr(record, type(record).__name__.lower())
            angular = not isinstance(record, Range)

            def expected(x, record=record, count=count):
                return np.array([model.reading(record, k, x) for k in range(count)])

            other.dim_z = count
            other.update(
                readings,
                HJacobian=lambda x, expected=expected, size=size: numerically(expected, x, size),
                Hx=expected,
                R=np.diag([model.deviation(record, k, seen) ** 2 for k in range(count)]),
                residual=lambda a, b, angular=angular: wrap(a - b) if angular else a - b,
            )
        yield other.x.reshape(-1, 3), other.P


def test_the_whole_filter_agrees_with_filterpys_on_the_same_log():
    world = World(np.random.default_rng(5), robots=3, landmarks=2)
    noise = NoiseModel(0.5, 0.4, 0.6, distance=0.3, turn=0.7, direction=0.2, slip=0.1)
    kalman = ExtendedKalmanFilter(world.team, noise)
    belief = kalman.start(0.0, world.initial_sets(), world.initial_headings())
    belief = kalman.update(belief, world.measure())
    log = list(world.steps(25))
    others = followed_by_filterpy(Model(world.team, noise), belief, log)
    for (odometry, records), (mean, covariance) in zip(log, others, strict=True):
        belief = kalman.update(kalman.predict(belief, odometry.time, odometry), records)
        assert belief.mean[:, :2] == pytest.approx(mean[:, :2], abs=1e-6)
        assert wrap(belief.mean[:, 2] - mean[:, 2]) == pytest.approx(np.zeros(3), abs=1e-6)
        assert belief.covariance == pytest.approx(covariance, abs=1e-7)


def test_the_first_belief_has_the_moments_of_what_is_known():
    arcs = AngularIntervals(np.array([0.1, 0.2, 0.3]), np.array([0.1, 0.2, np.pi]))
    belief = ExtendedKalmanFilter(TEAM).start(2.0, [Polygon.box([0, 0], [2, 4])] * 3, arcs)
    assert belief.time == 2.0
    assert belief.mean.tolist() == [[1.0, 2.0, 0.1], [1.0, 2.0, 0.2], [1.0, 2.0, 0.3]]
    assert belief.position_covariances[1] == pytest.approx(np.diag([1 / 3, 4 / 3]))
    assert belief.heading_deviations == pytest.approx(UNIFORM * arcs.bound)


def test_headings_are_wrapped_after_a_turn_and_corrected_the_short_way_round():
    kalman = ExtendedKalmanFilter(TEAM)
    before = belief_at(np.array([[0.0, 0.0, 3.1], [1.0, 0.0, -3.1], [2.0, 0.0, 0.0]]))
    turned = kalman.predict(before, 1.0, driven(turn=[0.2, -0.2, 0.0])).mean[:, 2]
    assert turned == pytest.approx([3.3 - 2 * np.pi, 2 * np.pi - 3.3, 0.0])
    shown = kalman.update(before, [Compass(0.0, [0, 1], [-3.1, 3.1], 0.1)]).mean[:, 2]
    assert (shown[0] > 3.1 or shown[0] < -3.1) and (shown[1] > 3.1 or shown[1] < -3.1)


def test_a_bearing_across_the_seam_is_a_small_innovation():
    behind = belief_at(np.array([[0.0, 0.0, 0.0], [-2.0, 1e-3, 0.0], [5.0, 5.0, 0.0]]))
    after = ExtendedKalmanFilter(TEAM).update(behind, [Bearing(0.0, [0], [1], [-np.pi + 1e-3], 0.05)])
    assert np.abs(after.mean - behind.mean).max() < 0.01


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
def test_covariances_stay_symmetric_and_positive(errors):
    world = World(np.random.default_rng(3), robots=4, errors=errors)
    kalman = ExtendedKalmanFilter(world.team, NoiseModel.same(0.01))
    belief = kalman.update(kalman.start(0.0, world.initial_sets()), world.measure())
    for odometry, records in world.steps(200):
        belief = kalman.update(kalman.predict(belief, odometry.time, odometry), records)
        assert np.array_equal(belief.covariance, belief.covariance.T)
        assert np.linalg.eigvalsh(belief.covariance).min() > 0


def test_a_gate_rejects_an_outlier_and_takes_the_rest():
    readings = Compass(0.0, [0, 1, 2], [MEAN[0, 2] + 0.02, MEAN[1, 2] + 2.0, MEAN[2, 2] - 0.02], 0.05)
    gated = ExtendedKalmanFilter(TEAM, gate=0.999).update(belief_at(), [readings])
    assert gated.rejected == 1
    assert gated.mean[1].tolist() == MEAN[1].tolist()
    assert gated.mean[0, 2] > MEAN[0, 2]
    assert gated.mean[2, 2] < MEAN[2, 2]
    open_to_all = ExtendedKalmanFilter(TEAM).update(belief_at(), [readings])
    assert open_to_all.rejected == 0
    assert open_to_all.mean[1, 2] != MEAN[1, 2]


@pytest.mark.parametrize("gate", [1e-6, 0.3, 0.95, 0.999, 1 - 1e-12])
def test_a_gate_is_a_quantile_of_the_chi_square_distribution(gate):
    largest = np.sqrt(chi2.ppf(gate, 1) * (0.01 + (UNIFORM * 0.05) ** 2))  # of an innovation, with the mean's variance
    for factor, rejected in ((1 - 1e-3, 0), (1 + 1e-3, 1)):
        reading = Compass(0.0, [0], [MEAN[0, 2] + factor * largest], 0.05)
        assert ExtendedKalmanFilter(TEAM, gate=gate).update(belief_at(), [reading]).rejected == rejected


def test_what_a_gate_rejected_is_counted_on():
    kalman = ExtendedKalmanFilter(TEAM, gate=0.99)
    belief = belief_at()
    for _ in range(3):
        belief = kalman.update(belief, [Compass(0.0, [0], [MEAN[0, 2] + 2.0], 0.05)])
    assert kalman.predict(belief, 1.0).rejected == 3
    assert belief.covariance.tolist() == belief_at().covariance.tolist()


def test_a_range_weighs_the_same_whether_it_reads_short_or_long():
    """At the measured range, short readings would weigh more, and every distance would come out too short."""
    kalman = ExtendedKalmanFilter(TEAM)
    short, long = (kalman.update(belief_at(), [Range(0.0, [0], [1], [reading], 0.0, 0.2)]) for reading in (1.8, 2.6))
    assert np.array_equal(short.covariance, long.covariance)


def test_a_robot_without_odometry_is_somewhere_within_its_limits():
    odometry = Odometry(0.0, 2.0, [1], [0.1], 0.0, [0.0], 0.0, 0.0, 0.0)
    after = ExtendedKalmanFilter(TEAM).predict(belief_at(covariance=np.zeros((9, 9))), 2.0, odometry)
    assert after.position_covariances[1].tolist() == np.zeros((2, 2)).tolist()
    assert after.position_covariances[0] == pytest.approx(np.eye(2) * (UNIFORM * 0.5 * 2.0) ** 2)
    assert after.heading_deviations[2] == pytest.approx(UNIFORM * 1.0 * 2.0)
    assert after.mean[[0, 2]].tolist() == MEAN[[0, 2]].tolist()


def test_a_relative_position_has_the_covariance_of_the_difference():
    rng = np.random.default_rng(4)
    root = rng.normal(size=(9, 9))
    mean, covariance = belief_at(covariance=root @ root.T).relative(2, 0)
    draws = rng.normal(size=(200_000, 9)) @ root.T
    assert mean == pytest.approx(MEAN[2, :2] - MEAN[0, :2])
    assert covariance == pytest.approx(np.cov((draws[:, 6:8] - draws[:, :2]).T), rel=0.03, abs=0.3)


def test_a_larger_deviation_makes_larger_ellipses():
    world = World(np.random.default_rng(8))
    beliefs = []
    for share in (1 / 3, 1.0):
        kalman = ExtendedKalmanFilter(world.team, NoiseModel.same(share))
        beliefs.append(kalman.start(0.0, world.initial_sets()))
        beliefs[-1] = kalman.update(beliefs[-1], world.measure())
    assert (np.linalg.det(beliefs[1].position_covariances) > np.linalg.det(beliefs[0].position_covariances)).all()


def test_an_update_leaves_the_belief_that_went_in_as_it_was():
    belief = belief_at()
    ExtendedKalmanFilter(TEAM).update(belief, [Compass(0.0, [0], [0.0], 0.05)])
    assert belief.mean.tolist() == MEAN.tolist()
    with pytest.raises(ValueError, match="read-only"):
        belief.mean[0, 0] = 1.0


WRONG = {
    "a prediction into the past": (OutOfOrder, lambda each, belief: each.predict(belief, -1.0)),
    "odometry of another start": (
        OutOfOrder,
        lambda each, belief: each.predict(belief, 1.0, Odometry(0.5, 1.0, [0], [0.1], 0.1, [0.0], 0.1, 0.1, 0.1)),
    ),
    "odometry of another end": (
        InvalidInput,
        lambda each, belief: each.predict(belief, 1.0, Odometry(0.0, 0.5, [0], [0.1], 0.1, [0.0], 0.1, 0.1, 0.1)),
    ),
    "odometry of a robot too many": (
        InvalidInput,
        lambda each, belief: each.predict(belief, 1.0, Odometry(0.0, 1.0, [3], [0.1], 0.1, [0.0], 0.1, 0.1, 0.1)),
    ),
    "a measurement of another time": (OutOfOrder, lambda each, belief: each.update(belief, [Compass(1.0, [0], [0.0], 0.1)])),
    "an unknown robot": (InvalidInput, lambda each, belief: each.update(belief, [Compass(0.0, [3], [0.0], 0.1)])),
    "an unknown landmark": (InvalidInput, lambda each, belief: each.update(belief, [Bearing(0.0, [0], [4], [0.0], 0.1)])),
    "something that is no record": (InvalidInput, lambda each, belief: each.update(belief, ["compass"])),
    "something that is no sequence": (InvalidInput, lambda each, belief: each.update(belief, 3)),
    "too few initial sets": (InvalidInput, lambda each, _: each.start(0.0, boxes(MEAN[:2, :2], 0.5))),
    "too few initial headings": (
        InvalidInput,
        lambda each, _: each.start(0.0, boxes(MEAN[:, :2], 0.5), AngularIntervals.circles(2)),
    ),
    "an empty initial heading": (
        InvalidInput,
        lambda each, _: each.start(0.0, boxes(MEAN[:, :2], 0.5), AngularIntervals(np.zeros(3), np.array([1.0, -1.0, 1.0]))),
    ),
}


@pytest.mark.parametrize("kind", [SetMembershipFilter, ExtendedKalmanFilter])
@pytest.mark.parametrize("what", WRONG)
def test_wrong_input_is_refused_as_by_the_set_membership_filter(kind, what):
    error, use = WRONG[what]
    each = kind(TEAM)
    belief = each.start(0.0, boxes(MEAN[:, :2], 0.5))
    with pytest.raises(error):
        use(each, belief)


@pytest.mark.parametrize("gate", [0.0, 1.0, -0.1, np.nan])
def test_a_gate_outside_of_0_to_1_is_refused(gate):
    with pytest.raises(InvalidInput, match="gate"):
        ExtendedKalmanFilter(TEAM, gate=gate)


@pytest.mark.parametrize("name", list(NoiseModel.__dataclass_fields__))
@pytest.mark.parametrize("value", [0.0, -1.0, np.inf])
def test_a_deviation_that_is_not_above_0_is_refused(name, value):
    with pytest.raises(InvalidInput, match=name):
        NoiseModel(**{name: value})
