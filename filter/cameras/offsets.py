"""Whether a camera is turned or late: a robot then drives, or turns, otherwise than the bearings of the landmarks say.

All sightings of a turned camera agree on another heading; only the direction in which its robot drives does not, and of that a
few metres tell too little for a proof. A camera whose clock is late sees landmarks aside whenever its robot turns. Here is an
estimate beside the sets: an extended Kalman filter of each robot's pose and its camera's offset and delay, with deviations from
the declared bounds. **It is evidence, no proof, and nothing of it enters a region**; it only says what not to believe.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array, Frozen, Mask
from filter.cameras.alignment import Alignment
from filter.cameras.sightings import Sightings
from filter.compiled import compiled
from filter.geometry.angles import AngularIntervals, wrap
from filter.records.odometry import Odometry
from filter.team import Team

UNKNOWN = 0.8  # with a heading that is known no better than this, nothing is estimated [rad]
FAR_OUT = 2.0  # with a position neither [m]
JUMPED = 2  # so many landmarks in turn to the same side: the robot was bumped, or its camera
LATELY = 0.25  # over such a time the turn rate is averaged that a late camera shows [s]
RECENT = 0.05  # the last sighting's part in the share of those that an estimate does not explain, ...
WRONG = 0.7  # ... which shows that it is wrong
SINGULAR = 1e-12  # a covariance of a sighting whose determinant is no more than so large a share of the variances' product


@dataclass(frozen=True, eq=False)
class Offsets(Frozen):
    """What motion says of n cameras.

    Attributes:
        mean: (n, 5) position [m], heading, the camera's offset [rad], and its delay [s]; positive as in `Turned` and `Late`.
        covariance: (n, 5, 5) of it.
        rate: (n,) how fast the robot turned lately [rad/s].
        running: (n,) whether there is an estimate.
        misfit: (n,) the share of the last sightings, some twenty, that are beyond the gate.
        astray: (n, 2) how many landmarks in turn are beyond the gate to one side, negative to the right, and the last.
        allowed: (n,) the bound of the robot's last bearing [rad].
        good_until: (n, 2) until when the camera looked good [s], less the time for which it can hide that it is turned or late.
        bad_since: (n, 2) since when the estimate is that of a turned or late camera [s]; infinite where it is not.
        suspected: (n, 2) cameras that are suspected to be turned, of which no angle is merged; or late, of which nothing is.
        vouched: (n,) cameras whose offset is known, and is none of a turned camera.
        on_trial: (n,) suspected cameras without an estimate, which are heard all the same, with no guarantee, to get one.
    """

    mean: Array
    covariance: Array
    rate: Array
    running: Mask
    misfit: Array
    astray: Array
    allowed: Array
    good_until: Array
    bad_since: Array
    suspected: Mask
    vouched: Mask
    on_trial: Mask

    @classmethod
    def none(cls, robots: int, time: float) -> Offsets:
        """Return that nothing is known, at a time [s]."""
        nobody, never, zeros = np.zeros((robots, 2), dtype=bool), np.full((robots, 2), np.inf), np.zeros((robots, 5, 5))
        estimate = zeros[:, 0], zeros, zeros[:, 0, 0], nobody[:, 0], zeros[:, 0, 0], zeros[:, 0, :2]
        return cls(*estimate, never[:, 0], np.full((robots, 2), time), never, nobody, nobody[:, 0], nobody[:, 0])

    @property
    def turned(self) -> Mask:
        """(n,) cameras that are suspected to be turned."""
        return self.suspected[:, 0]

    @property
    def late(self) -> Mask:
        """(n,) cameras that are suspected to be late."""
        return self.suspected[:, 1]

    @property
    def deviations(self) -> Array:
        """(n, 2) deviations of offset [rad] and delay [s]."""
        return np.sqrt(np.diagonal(self.covariance, axis1=1, axis2=2)[:, 3:])

    def moved(self, odometry: Odometry | None, team: Team, duration: float, rules: Alignment) -> Offsets:
        """Return the estimates after a motion of so long [s]; of robots that no odometry tells of, within their limits."""
        mean, covariance = self.mean.copy(), self.covariance.copy()
        path, path_bound, turned, twist, direction, slip, way = _moves(odometry, team, duration)
        whole, lately = max(duration, 1e-9), duration / (duration + LATELY)
        across = slip + (np.abs(path) + path_bound) * np.minimum(1.0, direction)
        lasting, wander = max(rules.lasting, duration) / whole, np.square([rules.wander, rules.drift]) * duration
        noise = lasting * np.square([path_bound + slip, across, twist])
        chord = path * np.sinc(turned / 2 / np.pi)
        for robot in np.flatnonzero(self.running):
            move = np.array([chord[robot], turned[robot], way[robot]])
            _drive(mean[robot], covariance[robot], move, np.append(noise[:, robot], wander))
        rate = np.where(self.running, self.rate + lately * (turned / whole - self.rate), self.rate)
        return replace(self, mean=mean, covariance=covariance, rate=rate)

    def seen(self, sightings: Sightings, landmarks: Array, rules: Alignment) -> Offsets:
        """Return them after sightings of landmarks (l, 2) [m]."""
        mean, covariance, misfit = self.mean.copy(), self.covariance.copy(), self.misfit.copy()
        astray, allowed = self.astray.copy(), self.allowed.copy()
        allowed[sightings.robot] = sightings.bearing_bound
        seen = np.stack([sightings.bearing, sightings.distance], axis=1)
        bounds = [rules.bearing * sightings.bearing_bound, rules.range * sightings.distance_bound]
        deviations, heard = np.stack(bounds, axis=1), self.running[sightings.robot]
        for k in np.flatnonzero(heard).tolist():
            robot, target = sightings.robot[k], sightings.landmark[k]
            mine = mean[robot], covariance[robot], self.rate[robot]
            far, aside = _see(*mine, landmarks[target], seen[k], deviations[k], rules.gate)
            misfit[robot] += RECENT * (far - misfit[robot])
            (count, last), side = astray[robot], np.sign(aside) if abs(aside) > rules.gate else 0.0
            count = side if side * count <= 0 else count + side * (last != target)
            astray[robot] = (count, target) if abs(count) < JUMPED else 0.0
            if abs(count) >= JUMPED:  # heading and offset are open, their difference is not
                covariance[robot, 2:4, 2:4] += rules.prior**2 * np.eye(2)
        return replace(self, mean=mean, covariance=covariance, misfit=misfit, astray=astray, allowed=allowed)

    def checked(self, lower: Array, upper: Array, headings: AngularIntervals, rules: Alignment) -> Offsets:
        """Return them without those that are wrong or have become too wide, and begun where enough is known.

        That is boxes around the robots, lower and upper (n, 2) [m], and arcs (n) around their headings.
        """
        mean, covariance, misfit = self.mean.copy(), self.covariance.copy(), self.misfit.copy()
        running = self.running & self._are_sound
        middle, half = (lower + upper) / 2, (upper - lower) / 2
        is_known = (headings.bound <= UNKNOWN) & (half.max(axis=1) <= FAR_OUT)
        mean[~running], covariance[~running] = 0.0, 0.0
        for robot in np.flatnonzero(~running & is_known).tolist():
            mean[robot, :3] = *middle[robot], headings.centre[robot]
            covariance[robot] = np.diag(np.square([*half[robot], headings.bound[robot], 0.0, rules.clock]))
            covariance[robot, 2:4, 2:4] += rules.prior**2  # what is known of the heading, the camera may have said
            running[robot], misfit[robot] = True, 0.0
        return replace(self, mean=mean, covariance=covariance, running=running, misfit=misfit)

    @property
    def _are_sound(self) -> Mask:
        """(n,) which estimates are numbers, narrow enough, and fit to most of what was seen."""
        variance = np.diagonal(self.covariance, axis1=1, axis2=2)
        narrow = (variance[:, :2].max(axis=1) <= FAR_OUT**2) & (variance[:, 2] <= UNKNOWN**2) & (variance >= 0).all(axis=1)
        finite = np.isfinite(self.mean).all(axis=1) & np.isfinite(self.covariance).all(axis=(1, 2))
        return np.asarray(narrow & finite & (self.misfit < WRONG))

    def judged(self, time: float, rules: Alignment) -> Offsets:
        """Return them with cameras suspected whose offset or delay is beyond a bound for sure; no longer those that agree."""
        mean, deviation, running = self.mean.copy(), self.deviations, self.running[:, None]
        mean[:, 3] = wrap(mean[:, 3])  # a full turn is none
        off, bound = np.abs(mean[:, 3:]), np.column_stack([self.allowed, np.full(len(mean), rules.tolerated_delay)])
        known = running & (deviation < np.array([rules.prior, rules.clock]) / 2)
        beyond = running & (off - rules.deviations * deviation > bound * [rules.share, 1.0])
        beyond[:, 0] &= ~self.late  # whatever a late camera shows, it may be late by more
        bad_since = np.where(beyond, np.minimum(self.bad_since, time), np.inf)
        agrees, looks_good = known & (off + deviation <= bound), known & (off <= deviation / 2)
        suspected = (time - bad_since >= rules.patience) | (self.suspected & ~agrees)
        good_until = np.where(looks_good, np.maximum(self.good_until, time - rules.hidden), self.good_until)
        vouched = known[:, 0] & ~beyond[:, 0] & ~suspected.any(axis=1)
        found = {"good_until": good_until, "bad_since": bad_since, "suspected": suspected, "vouched": vouched}
        return replace(self, mean=mean, **found)

    def waiting(self, robots: Mask) -> Offsets:
        """Return them with those on trial whose robots (n,) have a suspended guarantee: to hear them takes nothing from it."""
        return replace(self, on_trial=self.suspected.any(axis=1) & ~self.running & robots)

    def without(self, robot: int) -> Offsets:
        """Return them without the estimate of a robot that is put somewhere, or leaves; its camera stays suspected.

        It is on trial no longer: what was heard of it then is forgotten with the place.
        """
        others = np.arange(len(self.running)) != robot
        return replace(self, running=self.running & others, on_trial=self.on_trial & others)


def _moves(odometry: Odometry | None, team: Team, duration: float) -> Array:
    """Return (7, n) path and its bound, turn and its bound, direction bound, slip, and what is aside, of each robot."""
    found = np.zeros((7, team.robots))
    found[3], found[5] = team.turn_rate_limit * duration, team.speed_limit * duration
    if odometry is not None:
        bounds = odometry.direction_bound, odometry.slip_bound, odometry.aside
        found[:, odometry.robot] = odometry.distance, odometry.distance_bound, odometry.turn, odometry.turn_bound, *bounds
    return found


@compiled
def _drive(mean: Array, covariance: Array, move: Array, noise: Array) -> None:
    """Move one estimate in place by chord, turn and what is aside (3,); (5,) variances along, across, of turn, offset, lag."""
    chord, turn, aside = move
    way = mean[2] + turn / 2 + aside
    x, y = np.cos(way), np.sin(way)
    mean[0] += chord * x
    mean[1] += chord * y
    mean[2] += turn
    F, Q = np.eye(5), np.diag(noise)
    F[0, 2], F[1, 2] = -chord * y, chord * x
    Q[0, 0], Q[1, 1] = x * x * noise[0] + y * y * noise[1], y * y * noise[0] + x * x * noise[1]
    Q[0, 1] = Q[1, 0] = x * y * (noise[0] - noise[1])
    covariance[:] = F @ covariance @ F.T + Q


@compiled
def _see(
    mean: Array, covariance: Array, rate: float, place: Array, seen: Array, deviations: Array, gate: float
) -> tuple[bool, float]:
    """Merge a bearing and a range (2,) of a place (2,) into one estimate, in place; the robot turns at a rate [rad/s].

    Returns:
        Whether it is beyond the gate, and how many deviations the bearing alone is aside; what cannot be weighed is beyond it.
    """
    dx, dy = place[0] - mean[0], place[1] - mean[1]
    distance = max(np.hypot(dx, dy), 1e-6)
    H = np.zeros((2, 5))
    H[0] = dy / distance**2, -dx / distance**2, -1.0, 1.0, rate
    H[1, 0], H[1, 1] = -dx / distance, -dy / distance
    off = seen[0] - (np.arctan2(dy, dx) - mean[2] + mean[3] + rate * mean[4])
    apart = np.array([off - 2 * np.pi * np.round(off / (2 * np.pi)), seen[1] - distance])
    R = np.diag(deviations**2)
    S = H @ covariance @ H.T + R
    if not S[0, 0] * S[1, 1] - S[0, 1] * S[1, 0] > SINGULAR * S[0, 0] * S[1, 1]:
        return True, 0.0
    aside = apart[0] / np.sqrt(S[0, 0])
    far = float(apart @ np.linalg.solve(S, apart)) / gate**2
    if far > 1:
        S += (far - 1) * R
        R *= far
    K = np.linalg.solve(S, H @ covariance).T
    mean += K @ apart
    kept = np.eye(5) - K @ H
    joseph = kept @ covariance @ kept.T + K @ R @ K.T
    covariance[:] = (joseph + joseph.T) / 2
    return far > 1, aside
