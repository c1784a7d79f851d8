"""Differences of ranges (TDOA): how much farther a robot is from one place than from another."""

import numpy as np

from filter.arrays import Floats, finite, instance, number, shown, whole_number
from filter.errors import InvalidInput
from filter.geometry.hyperbola import of_difference
from filter.geometry.polygon import Polygon
from filter.records.measurements import Position
from filter.records.record import AT_THE_CENTRE, place


def position_from_range_difference(
    time: float,
    robot: int,
    places: Floats,
    difference: float,
    bound: Floats,
    within: Polygon,
    tangents: int = 12,
    sensor: int = AT_THE_CENTRE,
) -> Position:
    """Return where in a polygon a robot can be that is so much farther from one place than from another.

    The half-planes hold every place in the polygon with such a difference. So the polygon has to hold the robot: the arena
    does, or the outer region of a belief at that time. Nothing that it says itself is in the record. If no place in it has
    such a difference they exclude all of it, and a filter says `Inconsistent`.

    The two are known places. For anchors that are robots, or known within a bound only, use ranges.

    Args:
        time: When [s].
        robot: Whose distances differ.
        places: (2, 2) of two anchors a and b, not the same [m].
        difference: Measured distance from a less that from b [m].
        bound: Its largest error from 0 on, or a pair [least, greatest] of measured - true [m].
        within: Holds the robot, or the antenna if a sensor is given.
        tangents: How many touch the hyperbola, from 2 to 1000.
        sensor: Which sensor of the robot, an antenna say, measured; -1 for the centre.

    Raises:
        InvalidInput: The places are the same, or something is of another type, not finite, or out of its range.
    """
    anchors, value = finite("places [m]", places), number("difference [m]", difference)
    if anchors.shape != (2, 2) or not np.hypot(*(place("place [m]", anchors[1]) - anchors[0])):
        raise InvalidInput("two different places (2, 2) [m]", shown(places))
    least, greatest = _errors(bound)
    polygon, count = instance("a polygon", within, Polygon), whole_number("tangents", tangents, 2, 1000)
    low, high = np.nextafter(value - greatest, -np.inf), np.nextafter(value - least, np.inf)
    normals, offsets = of_difference(polygon, anchors, low, high, count)
    return Position(time, np.full(len(offsets), robot), normals[:, 0], normals[:, 1], offsets, sensor)


def _errors(bound: Floats) -> tuple[float, float]:
    """Return the least and the greatest of measured - true."""
    pair = finite("bound of a difference [m]", bound)
    if pair.shape == () and pair >= 0:
        return -float(pair), float(pair)
    if pair.shape == (2,) and pair[0] <= pair[1]:
        return float(pair[0]), float(pair[1])
    raise InvalidInput("bound of a difference [m]: one number from 0 on, or a pair [least, greatest]", shown(bound))
