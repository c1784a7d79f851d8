"""How much the linear approximation of a range and bearing measurement overestimates (section 3 and Fig. 3 of the paper).

A range in [least, greatest] over a sector of half-width d is an annular sector U. Its rows make a polygon around U: the two
bearing rows, one chord on the near side, and tangents on the far side - one in the paper, any number here.
"""

from __future__ import annotations

import numpy as np

from filter import Range
from filter.arrays import Array
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.sensing.rows import bearing_rows, range_rows

DISTANCE = 1.0  # areas are compared, so that any distance will do [m]


def sector_area(least: Array | float, greatest: Array | float, half_width: Array | float) -> Array:
    """Return the area of the annular sector U [m2]; lengths in [m], half-width in [rad]."""
    return np.asarray((np.square(greatest) - np.square(least)) * half_width)


def polygon_area(least: Array | float, greatest: Array | float, half_width: Array | float, tangents: int = 1) -> Array:
    """Return the area of the polygon around U with so many tangents on the far side [m2].

    Each tangent touches the middle of its share of the arc. With one tangent this over `sector_area` is the paper's formula.
    """
    far = np.square(greatest) * tangents * np.tan(np.asarray(half_width) / tangents)
    return np.asarray(far - np.square(least) * np.sin(half_width) * np.cos(half_width))


def overestimate(range_error: Array | float, half_width: Array | float, tangents: int = 1) -> Array:
    """Return the polygon's area over the sector's, for a range known to +- `range_error` of itself and +- half_width [rad]."""
    least, greatest = 1 - np.asarray(range_error), 1 + np.asarray(range_error)
    return np.asarray(polygon_area(least, greatest, half_width, tangents) / sector_area(least, greatest, half_width))


def least_overestimate(range_error: Array | float, half_width: Array | float) -> Array:
    """Return the same for any number of tangents: the convex hull of U, beyond which no rows can go."""
    least, greatest = 1 - np.asarray(range_error), 1 + np.asarray(range_error)
    hull = np.square(greatest) * half_width - np.square(least) * np.sin(half_width) * np.cos(half_width)
    return np.asarray(hull / sector_area(least, greatest, half_width))


def polygon_of_rows(range_error: float, half_width: float, tangents: int = 1) -> Polygon:
    """Return the polygon that the filter's own rows make of a measurement along +x at 1 m.

    Args:
        range_error: The range is within 1 +- this [m].
        half_width: Of the bearing [rad].
        tangents: How many on the far side.
    """
    robot, target, source = np.array([0]), np.array([1]), np.array([0])
    arcs = AngularIntervals(np.zeros(1), np.array([half_width]))
    measured = Range(0.0, robot, target, np.array([DISTANCE]), np.array([range_error]), np.zeros(1))
    # A hair wider than its share, as the number of tangents is rounded up.
    spacing = 2 * half_width / tangents * (1 + 1e-9)
    parts = [bearing_rows(robot, target, arcs, source), range_rows(measured, arcs, source, spacing)]
    normals, offsets = np.concatenate([part.normal for part in parts]), np.concatenate([part.offset for part in parts])
    return Polygon.from_half_planes(normals, offsets, [-4 * DISTANCE] * 2, [4 * DISTANCE] * 2)
