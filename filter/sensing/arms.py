"""Sensors off their robots' centres: what is said of the places of sensors becomes what is said of the centres.

A sensor that is mounted at m on a robot with heading h is at x + R(h) m. So the centre is away from the sensor by -R(h) m, as
if the robot had driven so far from there: an arc of displacements, one for each heading, and a slip for how far off the place
can be. Rows and polygons are moved by it as they are by a motion (`filter.sensing.since`); the narrower the heading, the less.

If its clock is off, it measures from where it is some time before or after the stamp. By then the robot has turned, so that the
arc is wider, and driven, so that the slip is larger; and so has the robot that it measures.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Frozen, Integers
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON, hull_of
from filter.linear.constraints import Constraints
from filter.records.record import AT_THE_CENTRE
from filter.records.sensors import Mountings
from filter.sensing.motion import CORNERS, Displacements
from filter.sensing.readings import ROWS, Readings

# Where the corners around an arc are, in its half-width from its beginning: at both ends, and where tangents meet; and in how
# many times its half-width from there these touch it.
TANGENTS = CORNERS - 2
PLACES = np.concatenate([[0.0], np.arange(1, 2 * TANGENTS, 2) / TANGENTS, [2.0]])
TOUCH = np.concatenate([[0.0], np.full(TANGENTS, 1 / TANGENTS), [0.0]])
CORNERS_OF_SLIP = 8  # of what stands for its disc


@dataclass(frozen=True, eq=False)
class Arms(Frozen):
    """For each of k readings the ways from the places of sensors to the centres of their robots.

    They are bearings, then ranges, then half-planes of positions.

    Attributes:
        robot: (k,) who measured.
        own: (k) from the sensor that measured.
        others: (k) from the one that was measured; of landmarks, and where nobody was, there is no way.
    """

    robot: Integers
    own: Displacements
    others: Displacements

    @classmethod
    def of(cls, readings: Readings, looks: AngularIntervals, robots: int) -> Arms | None:
        """Return them for n robots' headings (n), or at s instants and before, (s n + n) [rad]; None if all are at centres."""
        if readings.mountings is None:
            return None
        robot, sensor, target, tag = _ends(readings, robots)
        first = 0 if readings.since is None else (np.concatenate(readings.at[ROWS]) + 1) * robots
        is_robot, mate, mountings = target < robots, np.where(target < robots, target, 0), readings.mountings
        swing, drift = (np.where(is_robot, each[sensor, mate], 0.0) for each in (mountings.swing, mountings.drift))
        # A landmark has no sensor and stays, hence a way of no length, whoever's heading stands for its own.
        own, others = looks[first + robot], looks[np.where(is_robot, first + mate, 0)].turned(0.0, swing)
        from_own = ways_from(mountings, sensor, own.turned(0.0, mountings.swing[sensor, robot]), mountings.drift[sensor, robot])
        return cls(robot, from_own, ways_from(mountings, tag, others, drift))

    def moved(self, rows: Constraints, reading: Integers) -> Constraints:
        """Return rows on the places of sensors, each of one of (r,) readings, as rows on the centres."""
        is_own = (rows.j == self.robot[reading])[:, None]
        towards = np.where(is_own, rows.normal, -rows.normal)
        return rows.shifted(self.own.support(reading, towards) + self.others.support(reading, -towards))

    def between(self, reading: Integers) -> tuple[Array, Array]:
        """Return by what (r, 2) the way between the centres is another than the one that is measured, up to what (r,) [m]."""
        (centre, radius, size), (end, more, further) = self.own.discs, self.others.discs
        by, doubt = end[reading] - centre[reading], 1e-12 * (size + further)[reading]
        return by, radius[reading] + more[reading] + doubt

    def seen(self, reading: int, from_other: bool) -> Array:
        """Return corners (p, 2) around by what the way that is measured is another than that between the centres [m].

        From the other one's point of view it is the opposite.
        """
        here, there = self._corners(self.own, reading), self._corners(self.others, reading)
        apart = (here[:, None] - there).reshape(-1, 2)
        return hull_of(-apart if from_other else apart)

    def _corners(self, ways: Displacements, reading: int) -> Array:
        corners, size = ways.vertices[reading], np.abs(ways.vertices[reading]).sum(axis=1).max()
        if not size and not ways.slip[reading]:
            return corners[:1]
        angle = 2 * np.pi * np.arange(CORNERS_OF_SLIP) / CORNERS_OF_SLIP
        around = np.stack([np.cos(angle), np.sin(angle)], axis=1) / np.cos(np.pi / CORNERS_OF_SLIP)
        radius = ways.slip[reading] + 16 * EPSILON * (size + ways.slip[reading])
        return hull_of(np.add(corners[:, None], radius * around).reshape(-1, 2))


def _ends(readings: Readings, robots: int) -> tuple[Integers, Integers, Integers, Integers]:
    """Return of (k,) readings the robot and the sensor that measured, and the target and its sensor; n where there is none."""
    pairs, alone = (readings.bearings, readings.ranges), readings.positions
    robot, sensor = (np.concatenate([getattr(each, name) for each in (*pairs, alone)]) for name in ("robot", "sensor"))
    target = np.concatenate([*(each.target for each in pairs), np.full(len(alone.robot), robots)])
    tag = np.concatenate([*(each.target_sensor for each in pairs), np.full(len(alone.robot), AT_THE_CENTRE)])
    return robot, sensor, target, tag


def ways_from(mountings: Mountings, sensor: Integers, looks: AngularIntervals, drift: Array | float = 0.0) -> Displacements:
    """Return the ways from the places of sensors (k,) to the centres of robots with (k) headings [rad].

    Robots are elsewhere than when sensors measured, by up to a drift (k,) [m].
    """
    back = -mountings.position[sensor]
    length = np.hypot(back[:, 0], back[:, 1])
    ways = looks.turned(np.arctan2(back[:, 1], back[:, 0]))
    begin, bound = ways.centre[:, None] - ways.bound[:, None], ways.bound[:, None]
    angle, reach = begin + bound * PLACES, length[:, None] / np.cos(bound * TOUCH)
    slip = mountings.position_bound[sensor] + drift + 16 * EPSILON * length  # as the angles of corners are rounded, too
    return Displacements(np.stack([reach * np.cos(angle), reach * np.sin(angle)], axis=2), length, slip)
