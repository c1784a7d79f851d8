"""How far a robot can have moved: displacement sets, and what they do to constraints.

Odometry is a range-bearing measurement of one's own past: every displacement lies in the trapezoid of a sector, as for
a target seen at that range and bearing. Slip adds a disc.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Integers, read_only
from filter.compiled import compiled
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON
from filter.linear.constraints import WORLD, Constraints
from filter.measurements import Odometry
from filter.team import Team

# A sector wider than this, almost a half-plane, says nothing that the longest way does not say [rad].
WIDEST = 1.5


@dataclass(frozen=True, eq=False)
class Displacements:
    """For each of n robots a set of displacements: what is in the hull of some vertices and in a disc, and then a slip.

    Attributes:
        vertices: (n, 8, 2) [m].
        reach: (n,) no displacement is longer, slip aside [m].
        slip: (n,) radius of the disc [m].
    """

    vertices: Array
    reach: Array
    slip: Array

    def __post_init__(self) -> None:
        for name in ("vertices", "reach", "slip"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def support(self, robot: Integers, direction: Array) -> Array:
        """Return (r,) upper bounds of direction . u over the robots' displacements u, for directions (r, 2) [m]."""
        return _support(self.vertices, self.reach, self.slip, robot, direction)

    def moved(self, constraints: Constraints) -> Constraints:
        """Return the rows after every robot has moved by any of its displacements.

        With x' = x + u: normal . (x'_j - x'_i) <= offset + h_j(normal) + h_i(-normal), h the support of the set.
        """
        growth = self.support(constraints.j, constraints.normal)
        pair = np.flatnonzero(constraints.i != WORLD)
        growth[pair] += self.support(constraints.i[pair], -constraints.normal[pair])
        return constraints.shifted(growth)


@compiled
def _support(vertices: Array, reach: Array, slip: Array, robot: Integers, direction: Array) -> Array:
    support = np.empty(len(robot))
    for k in range(len(robot)):
        x, y, corners = direction[k, 0], direction[k, 1], vertices[robot[k]]
        farthest, size = -np.inf, 0.0
        for m in range(len(corners)):
            farthest = max(farthest, corners[m, 0] * x + corners[m, 1] * y)
            size = max(size, abs(corners[m, 0]) + abs(corners[m, 1]))
        length, rounding = np.hypot(x, y), 16 * EPSILON * (size + slip[robot[k]])
        support[k] = min(farthest, reach[robot[k]] * length) + (slip[robot[k]] + rounding) * length
    return support


def displacements(odometry: Odometry | None, headings: AngularIntervals, team: Team, duration: float) -> Displacements:
    """Return where each robot can have gone in `duration` [s], from n headings at the start [rad].

    A robot without odometry can have gone anywhere within its speed limit.

    Algorithm:
        Path length s in [least, greatest], direction within d of phi = heading + turn / 2. The robot's heading deviates
        from phi's true value by half the turn and the direction bound at most, so the chord is at least
        least cos(that) long. Range [least cos(that), greatest] over the sector phi +- d is a trapezoid. No displacement
        is longer than the path, which tells where the sector is wide.
    """
    vertices = np.zeros((team.robots, 8, 2))
    reach, slip = np.zeros(team.robots), np.full(team.robots, team.speed_limit * duration)
    if odometry is None:
        return Displacements(vertices, reach, slip)
    direction = headings[odometry.robot].turned(odometry.turn / 2, odometry.turn_bound / 2 + odometry.direction_bound)
    bend = np.minimum(np.pi / 2, (np.abs(odometry.turn) + odometry.turn_bound) / 2 + odometry.direction_bound)
    least, greatest = odometry.distance - odometry.distance_bound, odometry.distance + odometry.distance_bound
    ahead = _trapezoid(np.maximum(least, 0) * np.cos(bend), np.maximum(greatest, 0), direction)
    behind = _trapezoid(np.maximum(-greatest, 0) * np.cos(bend), np.maximum(-least, 0), direction.turned(np.pi))
    ahead = np.where((greatest < 0)[:, None, None], behind, ahead)
    behind = np.where((least > 0)[:, None, None], ahead, behind)
    farthest = np.maximum(np.abs(least), np.abs(greatest))
    full_circle = np.abs(odometry.turn) + odometry.turn_bound >= 2 * np.pi  # the way back can be the shortest
    anywhere = ((direction.bound > WIDEST) | full_circle)[:, None, None]
    square = farthest[:, None, None] * np.tile([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]], (2, 1))
    vertices[odometry.robot] = np.where(anywhere, square, np.concatenate([ahead, behind], axis=1))
    reach[odometry.robot], slip[odometry.robot] = farthest, odometry.slip_bound
    return Displacements(vertices, reach, slip)


def _trapezoid(nearest: Array, farthest: Array, direction: AngularIntervals) -> Array:
    """Return (k, 4, 2) corners of the smallest trapezoid around [nearest, farthest] over (k) sectors."""
    along = np.stack([np.cos(direction.centre), np.sin(direction.centre)], axis=1)
    across = np.stack([-along[:, 1], along[:, 0]], axis=1)
    bound = np.minimum(direction.bound, WIDEST)
    near = (nearest * np.cos(bound))[:, None]
    far, slope = farthest[:, None], np.tan(bound)[:, None]
    corners = [side * (along + turn * slope * across) for side in (near, far) for turn in (-1, 1)]
    return np.stack(corners, axis=1)


def turned_headings(odometry: Odometry | None, headings: AngularIntervals, team: Team, duration: float) -> AngularIntervals:
    """Return the n headings after the motion [rad]; a robot without odometry can have turned within its turn-rate limit."""
    turn, bound = np.zeros(team.robots), np.full(team.robots, team.turn_rate_limit * duration)
    if odometry is not None:
        turn[odometry.robot], bound[odometry.robot] = odometry.turn, odometry.turn_bound
    return headings.turned(turn, bound)
