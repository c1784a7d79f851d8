"""The baseline: one joint extended Kalman filter over all robots' x, y and heading, with every cross-covariance.

The collective form of S. I. Roumeliotis and G. A. Bekey, Distributed multirobot localization, IEEE Transactions on
Robotics and Automation 18(5), 2002. It promises nothing: its regions hold with a probability, if its noise model is right.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, fields, replace
from math import erfc

import numpy as np

from filter.arrays import Array, Frozen, Integers, checked, finite, instance, positive, settle, whole_number
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon, clip
from filter.guarantee import Guarantee
from filter.records.measurements import Bearing, Compass, Measurement, Position
from filter.records.odometry import Odometry
from filter.records.presence import Change, Left
from filter.records.record import BELOW_1, TIME
from filter.records.relative import RelativeHeading
from filter.team import Team

STATES = 3  # x, y, heading
UNIFORM = 1 / np.sqrt(3)  # standard deviation of a uniform error, relative to its bound
MOST_OVER_BOUND = 1e6  # a larger deviation over a bound is a slip
ENDLESS = 1e9  # a position that reaches so far from where a robot is believed to be has no end [m]
NEAREST = 1e-6  # nearer than this no target has a direction [m]
FINEST = 1e-15  # no deviation of a reading counts as smaller [m], [rad], ...
ROUNDING = 2.0**-42  # ... and no variance as a smaller share of the one that the belief expects of the reading
QUIET = np.errstate(over="ignore", invalid="ignore")  # what overflows is no belief: that is an error of ours


@dataclass(frozen=True)
class NoiseModel:
    """Standard deviations of the errors, each relative to the declared bound: the one place where the filter is tuned.

    They are those of headings, bearings, ranges, positions on each axis, driven distances, turns, the motion's direction,
    slip on each axis, and mates' headings. Raises `InvalidInput` unless all are above 0 and up to 1e6.
    """

    compass: float = UNIFORM
    bearing: float = UNIFORM
    range: float = UNIFORM
    position: float = UNIFORM
    distance: float = UNIFORM
    turn: float = UNIFORM
    direction: float = UNIFORM
    slip: float = UNIFORM
    relative_heading: float = UNIFORM

    def __post_init__(self) -> None:
        for name, value in vars(self).items():
            settle(self, **{name: positive(f"{name} deviation over bound", value, MOST_OVER_BOUND)})

    @classmethod
    def same(cls, share: float) -> NoiseModel:
        """Return a model with one deviation over bound for all errors; 1/3 takes a bound for three deviations."""
        return cls(*[share] * len(fields(cls)))


@dataclass(frozen=True, eq=False)
class GaussianBelief(Frozen):
    """What the Kalman filter believes at one time. Raises `InvalidInput` if a value is not finite, or of another type or shape.

    Attributes:
        time: When [s].
        mean: (n, 3) x [m], y [m], heading in (-pi, pi] [rad].
        covariance: (3n, 3n) of (x_0, y_0, heading_0, x_1, ...).
        rejected: Number of measurements that the gate has turned away so far.
        away: Robots that have left, whose estimates mean nothing.
    """

    time: float = field(metadata=TIME)
    mean: Array = field(metadata=checked(finite, "mean"))
    covariance: Array = field(metadata=checked(finite, "covariance"))
    rejected: int = field(default=0, metadata=checked(whole_number, "rejected"))
    away: frozenset[int] = field(default=frozenset(), metadata=checked(instance, "robots that are away", frozenset))

    def __post_init__(self) -> None:
        super().__post_init__()
        mean, covariance, size = self.mean.shape, self.covariance.shape, self.mean.size
        if len(mean) != 2 or mean[1] != STATES or covariance != (size, size):
            raise InvalidInput("a mean (n, 3) and a covariance (3n, 3n)", f"shapes {mean} and {covariance}")

    @property
    def guarantee(self) -> Guarantee:
        """There never is one."""
        robots, why = len(self.mean), "it holds with a probability, if the noise model is right"
        return Guarantee(np.full(robots, -np.inf), (why,) * robots, self.away)

    @property
    def position_covariances(self) -> Array:
        """(n, 2, 2) of each robot's position [m2]."""
        n = len(self.mean)
        blocks = self.covariance.reshape(n, STATES, n, STATES)
        return np.asarray(blocks[np.arange(n), :2, np.arange(n), :2])

    @property
    def heading_deviations(self) -> Array:
        """(n,) standard deviation of each heading [rad]."""
        return np.asarray(np.sqrt(np.diagonal(self.covariance)[2::STATES]))

    def relative(self, i: int, j: int) -> tuple[Array, Array]:
        """Return mean (2,) [m] and covariance (2, 2) [m2] of x_i - x_j; `InvalidInput` if there is no such robot."""
        i, j = (whole_number("robot", robot, 0, len(self.mean) - 1) for robot in (i, j))
        D = np.zeros((2, self.mean.size))
        D[:, STATES * i : STATES * i + 2], D[:, STATES * j : STATES * j + 2] = np.eye(2), -np.eye(2)
        return D @ self.mean.ravel(), D @ self.covariance @ D.T


@dataclass(frozen=True, eq=False)
class ExtendedKalmanFilter(Frozen):
    """The joint extended Kalman filter of a team: a `Filter`, which also refuses what is too large to be weighed.

    A reading whose declared bound is zero, or finer than doubles can tell beside what is known, counts as exact as they can:
    its variance is no less than a thousand roundings of the variance that the belief expects of it, so that covariances stay
    positive. All others are weighed as declared. A target expected nearer than 1e-6 m has no direction, and tells nothing; nor
    does a bearing that may be off by half a turn. A position is weighed as the box around it; one without an end on all sides,
    as a half-plane, tells nothing, nor does one with nothing in it. Sensors and antennas are where they are mounted, as the
    mean has it; the bounds of mountings are added to those of their readings, and so is how far robots can get, and turn,
    within the time that a sensor's clock can be off.

    Raises `InvalidInput` if an attribute is of another type, or the gate out of its range.

    Attributes:
        team: The robots, the landmarks and their limits.
        noise: How the declared bounds become standard deviations.
        gate: Measurements whose normalised innovation squared lies above this quantile of its chi-square distribution
            are rejected, in (0, 1); None to take all.
    """

    team: Team = field(metadata=checked(instance, "team", Team))
    noise: NoiseModel = field(default_factory=NoiseModel, metadata=checked(instance, "noise", NoiseModel))
    gate: float | None = field(default=None, metadata=checked(positive, "gate quantile", BELOW_1, optional=True))

    def start(
        self, time: float, positions: Sequence[Polygon | None], headings: AngularIntervals | None = None
    ) -> GaussianBelief:
        """Return the belief before any measurement: the moments of uniform distributions over the bounds of the sets."""
        polygons, arcs = self.team.initial(positions, headings)
        corners = np.array([polygon.bounds for polygon in polygons])
        deviations = UNIFORM * np.column_stack([(corners[:, 1] - corners[:, 0]) / 2, arcs.bound])
        mean = np.column_stack([corners.mean(axis=1), arcs.centre])
        return GaussianBelief(time, mean, np.diag(deviations.ravel() ** 2))

    def changed(self, belief: GaussianBelief, change: Change) -> GaussianBelief:
        """Return the belief in which a robot starts anew, tied to no other, or has left: see `SetMembershipFilter.changed`."""
        self.team.check_belief(belief, GaussianBelief, "mean")
        robot = self.team.checked_change(change, belief.time).robot
        if isinstance(change, Left):
            return replace(belief, away=belief.away | {robot})
        alone = replace(self, team=Team(1, arena=self.team.arena)).start(belief.time, [change.polygon], change.heading)
        mean, covariance, block = belief.mean.copy(), belief.covariance.copy(), slice(STATES * robot, STATES * robot + STATES)
        mean[robot], covariance[block], covariance[:, block] = alone.mean[0], 0, 0
        covariance[block, block] = alone.covariance
        return GaussianBelief(belief.time, mean, covariance, belief.rejected, belief.away - {robot})

    @QUIET
    def predict(self, belief: GaussianBelief, time: float, odometry: Odometry | None = None) -> GaussianBelief:
        """Return the belief at a later time [s]; a robot without odometry is taken to stand, within its limits of motion."""
        self.team.check_belief(belief, GaussianBelief, "mean")
        time = self.team.check_motion(belief.time, time, odometry)
        duration, moved, F = time - belief.time, belief.mean.copy(), np.eye(belief.mean.size)
        reach, swing = UNIFORM * self.team.speed_limit * duration, UNIFORM * self.team.turn_rate_limit * duration
        Q = np.diag(np.stack([reach, reach, swing], axis=1).ravel() ** 2)
        if odometry is not None:
            for k, robot in enumerate(odometry.robot):
                block = slice(STATES * robot, STATES * robot + STATES)
                moved[robot], F[block, block], Q[block, block] = self._driven(belief.mean[robot], odometry, k)
        moved[:, 2] = wrap(moved[:, 2])
        covariance = F @ belief.covariance @ F.T + Q
        return GaussianBelief(time, moved, (covariance + covariance.T) / 2, belief.rejected, belief.away)

    def update(self, belief: GaussianBelief, measurements: Sequence[Measurement] = ()) -> GaussianBelief:
        """Return the belief after merging measurements taken at its time, record after record in the order given."""
        self.team.check_belief(belief, GaussianBelief, "mean")
        for record in self.team.checked(belief.time, measurements, belief.away):
            belief = self._merged(belief, record)
        return belief

    def _driven(self, state: Array, odometry: Odometry, k: int) -> tuple[Array, Array, Array]:
        """Return a robot's state after the k-th motion, its Jacobian and the covariance of what the motion adds, (3, 3)."""
        distance, turn, F = odometry.distance[k], odometry.turn[k], np.eye(STATES)
        way = state[2] + turn / 2 + odometry.aside[k]
        along, across = np.array([np.cos(way), np.sin(way)]), np.array([-np.sin(way), np.cos(way)])
        F[:2, 2] = distance * across
        # Columns: errors of distance, of turn (half of which bends the way), of direction, and slip on both axes.
        G = np.zeros((STATES, 5))
        G[:2, 0], G[:2, 1], G[:2, 2], G[:2, 3:] = along, distance / 2 * across, distance * across, np.eye(2)
        G[2, 1] = 1
        errors = ("distance", "turn", "direction", "slip", "slip")
        spread = G * [getattr(self.noise, name) * getattr(odometry, f"{name}_bound")[k] for name in errors]
        return state + np.append(distance * along, turn), F, spread @ spread.T

    @QUIET
    def _merged(self, belief: GaussianBelief, record: Measurement) -> GaussianBelief:
        innovation, H, variance = self._linearised(belief, record)
        count = len(innovation)
        known = np.abs(H) @ np.sqrt(np.abs(np.diagonal(belief.covariance)))
        variance = np.maximum(variance, FINEST**2 + ROUNDING * known**2)
        if self.gate is not None:
            spread = np.einsum("ki,ij,kj->k", H, belief.covariance, H) + variance
            sizes = np.abs(innovation) / np.sqrt(2 * np.maximum(spread, variance))
            kept = np.array([erfc(size) for size in sizes]) >= 1 - self.gate
            innovation, H, variance = innovation[kept], H[kept], variance[kept]
        rejected, P = belief.rejected + count - len(innovation), belief.covariance
        try:
            K = np.linalg.solve(H @ P @ H.T + np.diag(variance), H @ P).T
        except np.linalg.LinAlgError:
            raise InvalidInput("a covariance without negative variances", "one in which readings have no spread") from None
        mean = belief.mean + (K @ innovation).reshape(-1, STATES)
        mean[:, 2] = wrap(mean[:, 2])
        keep = np.eye(len(P)) - K @ H
        covariance = keep @ P @ keep.T + (K * variance) @ K.T  # Joseph's form: stays positive, ...
        gone = np.diagonal(covariance) <= 0  # ... but for rounding: so little is left that it is none
        covariance[gone], covariance[:, gone] = 0, 0
        return GaussianBelief(belief.time, mean, (covariance + covariance.T) / 2, rejected, belief.away)

    def _linearised(self, belief: GaussianBelief, record: Measurement) -> tuple[Array, Array, Array]:
        """Return innovations (k,), Jacobian (k, 3n) and variances (k,) of a record at the mean."""
        if isinstance(record, Position):
            return self._placed(belief, record)
        robot, sensor, rows, mountings = record.robot, record.sensor, np.arange(len(record.robot)), self.team.mounted
        H = np.zeros((len(rows), belief.mean.size))
        turned = mountings.angle_bound[sensor] + mountings.swing[sensor, robot]
        if isinstance(record, Compass):
            H[rows, STATES * robot + 2] = 1
            innovation = wrap(record.heading - mountings.angle[sensor] - belief.mean[robot, 2])
            return innovation, H, (self.noise.compass * (record.bound + turned)) ** 2
        if isinstance(record, RelativeHeading):
            turned += mountings.angle_bound[record.target_sensor] + mountings.swing[sensor, record.target]
            return self._related(belief, record, record.bound + turned)
        ends, sensors = (robot, record.target), (sensor, record.target_sensor)
        arms, tags = (_arms(belief, body, mountings.position[each]) for body, each in zip(ends, sensors, strict=True))
        places = np.concatenate([belief.mean[:, :2], self.team.landmarks])[record.target] + tags
        away = places - belief.mean[robot, :2] - arms
        distance, off = np.maximum(np.hypot(away[:, 0], away[:, 1]), NEAREST), mountings.off(ends, sensors)
        towards, nothing = away / distance[:, None], distance <= NEAREST
        moving = np.flatnonzero(record.target < len(belief.mean))
        if isinstance(record, Bearing):
            nothing |= record.bound + turned >= np.pi
            slope = np.column_stack([-towards[:, 1], towards[:, 0]]) / distance[:, None]
            H[rows, STATES * robot + 2] = -1
            way = belief.mean[robot, 2] + mountings.angle[sensor]
            innovation = wrap(record.bearing - (np.arctan2(away[:, 1], away[:, 0]) - way))
            variance = (self.noise.bearing * (record.bound + turned + off / distance)) ** 2
        else:
            slope, innovation = towards, record.range - distance
            # At the predicted distances: at the measured ones, short readings would weigh more.
            variance = (self.noise.range * (record.bound + off + record.relative_bound * distance)) ** 2
        H[nothing] = slope[nothing] = 0
        H[rows, STATES * robot + 2] -= _turned(slope, arms)
        H[moving, STATES * record.target[moving] + 2] += _turned(slope, tags)[moving]
        for axis in range(2):
            H[rows, STATES * robot + axis] -= slope[:, axis]
            H[moving, STATES * record.target[moving] + axis] += slope[moving, axis]
        return innovation, H, variance

    def _related(self, belief: GaussianBelief, record: RelativeHeading, bound: Array) -> tuple[Array, Array, Array]:
        """Return the same of mates' headings, with bounds (k,), of which half a turn tells nothing."""
        robot, target, angle, H = record.robot, record.target, self.team.mounted.angle, np.zeros((len(bound), belief.mean.size))
        told = np.flatnonzero(bound < np.pi)
        H[told, STATES * robot[told] + 2], H[told, STATES * target[told] + 2] = -1, 1
        looks = belief.mean[:, 2]
        innovation = wrap(record.heading + angle[record.sensor] - angle[record.target_sensor] - looks[target] + looks[robot])
        return innovation, H, (self.noise.relative_heading * bound) ** 2

    def _placed(self, belief: GaussianBelief, record: Position) -> tuple[Array, Array, Array]:
        """Return the same of positions: of each robot that has one, the middle of the box around it, where that ends."""
        found, H, mountings = list[tuple[float, float]](), list[Array](), self.team.mounted
        off = mountings.position_bound[record.sensor] + mountings.astray(record.sensor, record.sensor, record.robot)
        for first in np.unique(record.first):
            own, robot, sensor = record.first == first, record.robot[first], record.sensor[first]
            arm = _arms(belief, record.robot[[first]], mountings.position[[sensor]])
            offsets = record.offset[own] - record.normals[own] @ (belief.mean[robot, :2] + arm[0])
            kept = clip(record.normals[own], offsets, np.full(2, -ENDLESS), np.full(2, ENDLESS))
            for axis, (low, high) in enumerate(zip(*kept[0].bounds, strict=True) if kept else ()):
                if max(-low, high) < ENDLESS:
                    found.append(((low + high) / 2, self.noise.position * ((high - low) / 2 + off[first])))
                    H.append(np.eye(belief.mean.size)[STATES * robot + axis])
                    H[-1][STATES * robot + 2] = _turned(np.eye(2)[[axis]], arm)[0]
        innovation, deviation = np.array(found).reshape(-1, 2).T
        return innovation, np.array(H).reshape(-1, belief.mean.size), deviation**2


def _arms(belief: GaussianBelief, body: Integers, position: Array) -> Array:
    """Return (k, 2) where sensors are, as seen from the centres of bodies (k,), in the world; landmarks have none [m]."""
    way = np.where(body < len(belief.mean), belief.mean[np.minimum(body, len(belief.mean) - 1), 2], 0.0)
    sine, cosine, (ahead, left) = np.sin(way), np.cos(way), position.T
    return np.stack([cosine * ahead - sine * left, sine * ahead + cosine * left], axis=1)


def _turned(slope: Array, arms: Array) -> Array:
    """Return (k,) how fast readings change as arms turn, where these change by (k, 2) slopes as places move."""
    return np.asarray(slope[:, 1] * arms[:, 0] - slope[:, 0] * arms[:, 1])
