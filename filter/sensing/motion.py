"""How far a robot can have moved: displacement sets, and what they do to constraints.

Odometry is a range-bearing measurement of one's own past: every displacement lies in the trapezoid of a sector, as for
a target seen at that range and bearing. Slip adds a disc.
"""

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Frozen, Integers
from filter.compiled import bounds_of, compiled
from filter.geometry.angles import AngularIntervals, turned
from filter.geometry.convex import EPSILON, hull_of
from filter.geometry.sector import WIDEST, trapezoid
from filter.linear.constraints import WORLD, Constraints
from filter.records.odometry import Odometry
from filter.team import Team

SQUARE = np.array([[1.0, 1.0], [-1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]])
CORNERS = 8  # of a set of displacements: of a trapezoid ahead, and of one behind


@dataclass(frozen=True, eq=False)
class Displacements(Frozen):
    """For each of n robots a set of displacements: what is in the hull of some vertices and in a disc, and then a slip.

    Attributes:
        vertices: (n, CORNERS, 2) [m].
        reach: (n,) no displacement is longer, slip aside [m].
        slip: (n,) radius of the disc [m].
    """

    vertices: Array
    reach: Array
    slip: Array

    def support(self, robot: Integers, direction: Array) -> Array:
        """Return (r,) upper bounds of direction . u over the robots' displacements u, for directions (r, 2) [m]."""
        return _support(self.vertices, self.reach, self.slip, robot, direction)

    def moved(self, constraints: Constraints) -> Constraints:
        """Return the rows after every robot has moved by any of its displacements.

        With x' = x + u: normal . (x'_j - x'_i) <= offset + h_j(normal) + h_i(-normal), h the support of the set.
        """
        pair, normal = np.flatnonzero(constraints.i != WORLD), constraints.normal
        robot = np.concatenate([constraints.j, constraints.i[pair]])
        growth = self.support(robot, np.concatenate([normal, -normal[pair]]))
        own, mates = growth[: len(normal)], growth[len(normal) :]
        own[pair] += mates
        return constraints.shifted(own)

    @property
    def discs(self) -> tuple[Array, Array, Array]:
        """Centres (n, 2) and radii (n,) of discs around the sets, and the size (n,) of the numbers, for their rounding [m]."""
        found = _discs(self.vertices, self.slip)
        return found[:, :2].copy(), found[:, 2].copy(), found[:, 3].copy()

    @property
    def normals(self) -> Array:
        """(n, CORNERS, 2) outward normals of the edges of the hulls of the vertices; NaN where there are fewer."""
        return _normals(self.vertices)


@compiled
def _normals(vertices: Array) -> Array:
    normals = np.full(vertices.shape, np.nan)
    for robot in range(len(vertices)):
        hull = hull_of(vertices[robot])
        for k in range(len(hull) if len(hull) > 1 else 0):
            following = hull[(k + 1) % len(hull)]
            x, y = following[0] - hull[k, 0], following[1] - hull[k, 1]
            length = np.hypot(x, y)
            normals[robot, k, 0], normals[robot, k, 1] = y / length, -x / length
    return normals


@compiled
def _discs(vertices: Array, slip: Array) -> Array:
    """Return (n, 4) centre, radius and size."""
    found = np.empty((len(slip), 4))
    for k in range(len(slip)):
        (west, east), (south, north) = bounds_of(vertices[k, :, 0]), bounds_of(vertices[k, :, 1])
        x, y, radius = (west + east) / 2, (south + north) / 2, 0.0
        for m in range(vertices.shape[1]):
            radius = max(radius, np.hypot(vertices[k, m, 0] - x, vertices[k, m, 1] - y))
        radius += slip[k]
        found[k, 0], found[k, 1], found[k, 2], found[k, 3] = x, y, radius, abs(x) + abs(y) + radius
    return found


@compiled
def _support(vertices: Array, reach: Array, slip: Array, robot: Integers, direction: Array) -> Array:
    support = np.empty(len(robot))
    for k in range(len(robot)):
        whose = robot[k]
        support[k] = support_of(vertices[whose], reach[whose], slip[whose], direction[k, 0], direction[k, 1])
    return support


@compiled
def support_of(corners: Array, reach: float, slip: float, x: float, y: float) -> float:
    """Return an upper bound of (x, y) . u over the displacements u of one robot [m]."""
    farthest, size = -np.inf, 0.0
    for m in range(len(corners)):
        farthest = max(farthest, corners[m, 0] * x + corners[m, 1] * y)
        size = max(size, abs(corners[m, 0]) + abs(corners[m, 1]))
    length, rounding = np.hypot(x, y), 16 * EPSILON * (size + slip)
    return min(farthest, reach * length) + (slip + rounding) * length


def displacements(odometry: Odometry | None, headings: AngularIntervals, team: Team, duration: float) -> Displacements:
    """Return where each robot can have gone in `duration` [s], from n headings at the start [rad].

    A robot without odometry can have gone anywhere within its speed limit.
    """
    return displacements_of(odometry, headings, team.speed_limit * duration)


def displacements_of(odometry: Odometry | None, headings: AngularIntervals, reach: Array) -> Displacements:
    """Return where each robot can have gone, from n headings at the start [rad]; without odometry, no farther than (n,) [m].

    Algorithm:
        Path length s in [least, greatest], direction within d of phi = heading + turn / 2 + aside. On its way the robot's
        deviates from that by half the turn and the direction bound at most, so the chord is at least least cos(that) long.
        Range [least cos(that), greatest] over the sector phi +- d is a trapezoid. No displacement is longer than the path,
        which tells where the sector is wide.
    """
    vertices, path, slip = np.zeros((len(headings), CORNERS, 2)), np.zeros(len(headings)), reach.copy()
    if odometry is None:
        return Displacements(vertices, path, slip)
    told = odometry.robot, odometry.turn, odometry.turn_bound, odometry.direction_bound, odometry.aside
    least, greatest = odometry.distance - odometry.distance_bound, odometry.distance + odometry.distance_bound
    _gone(vertices, path, (headings.centre, headings.bound), told, (least, greatest))
    slip[odometry.robot] = odometry.slip_bound
    return Displacements(vertices, path, slip)


@compiled
def _gone(
    vertices: Array,
    path: Array,
    headings: tuple[Array, Array],
    told: tuple[Integers, Array, Array, Array, Array],
    lengths: tuple[Array, Array],
) -> None:
    """Write the vertices (n, CORNERS, 2) and the longest path (n,) of robots of which odometry tells."""
    (centre, bound), (robot, turn, turn_bound, direction_bound, aside) = headings, told
    for k in range(len(robot)):
        whose, least, greatest, off = robot[k], lengths[0][k], lengths[1][k], direction_bound[k]
        way, wide = turned(centre[whose], bound[whose], turn[k] / 2 + aside[k], turn_bound[k] / 2 + off)
        back, most_turned = turned(way, wide, np.pi, 0.0), abs(turn[k]) + turn_bound[k]
        chord = np.cos(min(np.pi / 2, most_turned / 2 + off))
        path[whose] = max(abs(least), abs(greatest))
        for half in range(2):
            if wide > WIDEST or most_turned >= 2 * np.pi:  # after a full circle the way back can be the shortest
                corners = path[whose] * SQUARE
            elif least > 0 or (greatest >= 0 and half == 0):
                corners = trapezoid(way, wide, max(0.0, least) * chord, max(0.0, greatest))
            else:
                corners = trapezoid(back[0], back[1], max(0.0, -greatest) * chord, max(0.0, -least))
            for m in range(4):  # not all at once: numba takes seconds to compile that
                vertices[whose, 4 * half + m, 0], vertices[whose, 4 * half + m, 1] = corners[m, 0], corners[m, 1]


def turned_headings(odometry: Odometry | None, headings: AngularIntervals, team: Team, duration: float) -> AngularIntervals:
    """Return the n headings after the motion [rad]; a robot without odometry can have turned within its turn-rate limit."""
    turn, bound = np.zeros(team.robots), team.turn_rate_limit * duration
    if odometry is not None:
        turn[odometry.robot], bound[odometry.robot] = odometry.turn, odometry.turn_bound
    return headings.turned(turn, bound)
