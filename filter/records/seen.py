"""A position that is seen in a sensor's frame, of a marker or by the matching of scans, as a bearing and a range."""

from itertools import product

import numpy as np

from filter.arrays import Array, Floats, finite, shown
from filter.errors import InvalidInput
from filter.geometry.angles import ANGLE_ROUNDING, wrap
from filter.geometry.convex import EPSILON
from filter.records.measurements import Bearing, Range
from filter.records.record import AT_THE_CENTRE, place


def seen_position(
    time: float,
    robot: int,
    target: int,
    position: Floats,
    bound: Floats,
    sensor: int = AT_THE_CENTRE,
    target_sensor: int = AT_THE_CENTRE,
) -> tuple[Bearing, Range]:
    """Return what is said of a target by where a sensor sees it: all directions and distances of the box around that.

    Together they say a little less than the box: the piece of a ring that contains it. If the sensor may be in the box, the
    bearing has a bound of pi, which says nothing. A heading that is seen with it is a `RelativeHeading`.

    Args:
        time: When [s].
        robot: Who measured.
        target: Robot or landmark that was seen.
        position: (2,) how far ahead of the sensor it was seen, along its forward axis, and how far to the left [m].
        bound: Largest error along each of these axes, from 0 on, one number or (2,) [m].
        sensor: Which sensor of the robot measured.
        target_sensor: Which sensor, or tag, of a robot was seen.

    Raises:
        InvalidInput: A value is of another type or out of its range, or a robot is its own target.
    """
    middle, half = place("position [m]", position), finite("bound of a position [m]", bound, 0)
    if half.shape not in ((), (2,)):
        raise InvalidInput("bound of a position [m]: one number, or one ahead and one to the left", shown(bound))
    lower, upper = (np.nextafter(middle + sign * half, sign * np.inf) for sign in (-1, 1))
    way, off = _directions(lower, upper)
    reach, doubt = _distances(lower, upper)
    by = sensor, target_sensor
    return Bearing(time, robot, target, way, off, *by), Range(time, robot, target, reach, doubt, 0.0, *by)


def _directions(lower: Array, upper: Array) -> tuple[float, float]:
    """Return middle and half-width of an arc around the directions of a box, by its corners (2,) and (2,) [rad]."""
    nearest = np.clip(0.0, lower, upper)
    if not nearest.any():  # seen from within it
        return 0.0, np.pi
    x, y = np.array([*product(*zip(lower, upper, strict=True))]).T
    ahead = np.arctan2(nearest[1], nearest[0])  # a right angle to either side of it at most is all of the box
    beside = wrap(np.arctan2(y, x) - ahead)
    least, greatest = beside.min(), beside.max()
    return float(wrap(ahead + (least + greatest) / 2)), float((greatest - least) / 2 + ANGLE_ROUNDING)


def _distances(lower: Array, upper: Array) -> tuple[float, float]:
    """Return middle and half-width of an interval around the distances of a box [m]."""
    nearest, farthest = np.clip(0.0, lower, upper), np.maximum(-lower, upper)
    least, most = np.hypot(*nearest) * (1 - 8 * EPSILON), np.hypot(*farthest) * (1 + 8 * EPSILON)
    middle = (least + most) / 2
    return float(middle), float(np.nextafter(max(middle - least, most - middle) * (1 + 8 * EPSILON), np.inf))
