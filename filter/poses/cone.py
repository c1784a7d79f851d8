"""In which directions the places of one convex set are, as seen from another; compiled."""

import numpy as np

from filter.arrays import Array
from filter.compiled import compiled
from filter.geometry.angles import ANGLE_ROUNDING

Vector = tuple[float, float]


@compiled
def directions(cell: Array, size: int, points: Array, nearest: float, margin: float) -> tuple[float, float, float]:
    """Return an arc of the directions in which points of the hull of `points` are from places of a cell, and the farthest [m].

    That is, from places at least `nearest` away from them [m]; sets reach as far as `margin` beyond their hulls [m]. The bound
    is pi where no direction is excluded for sure.

    Algorithm:
        Differences of hulls lie in a cone with its tip at the origin; what is beyond it by a few margins is turned by an angle
        that is small where differences are long. Where they are to all sides, the cone is the half-plane beyond which they are
        the least.
    """
    ahead, first, last, farthest = _outermost(cell, size, points, margin)
    least = _gap(cell, size, points, ahead)
    if least <= margin:
        least = _least(cell, size, points, ahead, margin)
    bound = max(_angle(ahead, last), -_angle(ahead, first))
    if least < 0:
        (ahead, least), bound = _shallowest(cell, size, points, margin), np.pi / 2
    # Out of the cone: what is as near as nothing, and the margins of both sets.
    beyond = 3 * margin + max(0.0, -least)
    away, farthest = max(nearest, least) - 2 * beyond, farthest + 2 * margin
    if away <= 4 * beyond:
        return 0.0, np.pi, farthest
    return np.arctan2(ahead[1], ahead[0]), bound + 2 * beyond / away + 4 * ANGLE_ROUNDING, farthest


@compiled
def _outermost(cell: Array, size: int, points: Array, margin: float) -> tuple[Vector, Vector, Vector, float]:
    """Return the middle of all differences, the outermost to its right and left, and the length of the longest [m]."""
    first = last = (0.0, 0.0)
    farthest = 0.0
    for m in range(size):
        for t in range(len(points)):
            apart = points[t, 0] - cell[m, 0], points[t, 1] - cell[m, 1]
            farthest = max(farthest, apart[0] * apart[0] + apart[1] * apart[1])
            if abs(apart[0]) + abs(apart[1]) <= margin:
                continue  # in whatever direction
            if first == (0.0, 0.0):
                first = last = apart
            elif _across(last, apart) > 0:
                last = apart
            elif _across(first, apart) < 0:
                first = apart
    middle = np.arctan2(first[1], first[0]) + _angle(first, last) / 2
    return (np.cos(middle), np.sin(middle)), first, last, np.sqrt(farthest)


@compiled
def _gap(cell: Array, size: int, points: Array, ahead: Vector) -> float:
    """Return how far points are beyond all of a cell in a direction, to rounding; negative where they are not [m]."""
    cell_ends, points_begin = -np.inf, np.inf
    for m in range(size):
        cell_ends = max(cell_ends, ahead[0] * cell[m, 0] + ahead[1] * cell[m, 1])
    for t in range(len(points)):
        points_begin = min(points_begin, ahead[0] * points[t, 0] + ahead[1] * points[t, 1])
    return points_begin - cell_ends


@compiled
def _least(cell: Array, size: int, points: Array, ahead: Vector, margin: float) -> float:
    """Return the least difference in a direction; one that is as near as nothing is zero [m]."""
    least = np.inf
    for m in range(size):
        for t in range(len(points)):
            apart = points[t, 0] - cell[m, 0], points[t, 1] - cell[m, 1]
            least = min(least, 0.0 if abs(apart[0]) + abs(apart[1]) <= margin else _along(ahead, apart))
    return least


@compiled
def _shallowest(cell: Array, size: int, points: Array, margin: float) -> tuple[Vector, float]:
    """Return the direction, across an edge of either set, in which the least difference is the greatest, and that [m]."""
    best, greatest = (1.0, 0.0), -np.inf
    for k in range(size + len(points)):
        of, many, m = (cell, size, k) if k < size else (points, len(points), k - size)
        x, y = of[(m + 1) % many, 0] - of[m, 0], of[(m + 1) % many, 1] - of[m, 1]
        length = np.hypot(x, y)
        if length > margin:
            outward = (y / length, -x / length) if k < size else (-y / length, x / length)
            least = _gap(cell, size, points, outward)
            if least > greatest:
                best, greatest = outward, least
    return best, greatest


@compiled
def _across(a: Vector, b: Vector) -> float:
    return a[0] * b[1] - a[1] * b[0]


@compiled
def _along(a: Vector, b: Vector) -> float:
    return a[0] * b[0] + a[1] * b[1]


@compiled
def _angle(a: Vector, b: Vector) -> float:
    """Return the angle from one direction to another, in (-pi, pi] [rad]."""
    return np.arctan2(_across(a, b), _along(a, b))


@compiled
def wrapped(angle: float) -> float:
    """Return an angle in (-pi, pi] [rad]."""
    return angle - 2 * np.pi * np.ceil((angle - np.pi) / (2 * np.pi))
