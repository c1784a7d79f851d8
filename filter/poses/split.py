"""Where a cell is split: through the target of the range that it is too wide for, or by its heading; compiled."""

import numpy as np

from filter.arrays import Array
from filter.compiled import bounds_of, compiled, sum_of
from filter.geometry.angles import intersection
from filter.poses.cell import Line, Pose, Said, Scale, nearest_of
from filter.poses.cone import directions, wrapped

WORTH_A_SLICE = 2  # bearings by a robot itself, from which on it is worth to split its heading
FINEST_BEARING = 1e-3  # a heading is not split for bearings that are finer than this [rad]
HALF_A_CIRCLE = np.pi / 2 + 1e-6  # the directions of a target on the edge of a cell, rounded
OFF_THE_EDGE = 1e-3  # a line that is so near the edge of a cell, in its width, splits nothing off


@compiled
def where_to_split(pose: Pose, size: int, said: Said, scale: Scale) -> tuple[float, float, float, float]:
    """Return how badly a cell is too wide, and the line to split it along; one without a direction is for a heading.

    For a range that is how far the chord of its directions is inside the circle, in widths of the band, or of the cell if that
    is thinner, as far as it comes from the cell's width and not from the target's; for the heading, how wide it is in the
    least bound of two bearings or more.
    """
    (cell, heading), worst, line, bearings, finest = pose, 0.0, (0.0, 0.0, 0.0), 0, np.inf
    for t in range(len(said.first) - 1):
        points = said.points[said.point_first[t] : said.point_first[t + 1]]
        centre, bound, _ = directions(cell, size, points, nearest_of(said, t), scale.margin)
        x, y, extent = _middle(points)
        for q in range(said.first[t], said.first[t + 1]):
            value, half, least, greatest = said.sector[q]
            if half < np.pi:
                own = said.own[q]
                bearings, finest = bearings + own, min(finest, half) if own else finest
                way = wrapped(heading[0] + value) if own else value
                narrowed = intersection(centre, bound, way, min(np.pi, half + heading[1] * own))
                centre, bound = narrowed if narrowed[1] >= 0 else (centre, bound)
            if greatest < np.inf:
                across = min(greatest - least + extent, _width(cell, size, centre)) + scale.margin
                wide = _width(cell, size, centre + np.pi / 2)
                need = least * (1 - np.cos(bound)) / across * wide / (wide + extent + scale.margin)
                if need > worst:
                    worst, line = need, _line(cell, size, (centre, bound), (x, y))
    need = heading[1] / max(finest, FINEST_BEARING) if bearings >= WORTH_A_SLICE else 0.0
    return (need, 0.0, 0.0, heading[0]) if need > worst else (worst, *line)


@compiled
def _middle(points: Array) -> tuple[float, float, float]:
    """Return the middle of points, and twice how far they are from it at most [m]."""
    x, y, extent = sum_of(points[:, 0]) / len(points), sum_of(points[:, 1]) / len(points), 0.0
    for t in range(len(points)):
        extent = max(extent, 2 * np.hypot(points[t, 0] - x, points[t, 1] - y))
    return x, y, extent


@compiled
def _width(cell: Array, size: int, direction: float) -> float:
    """Return how wide a cell is along a direction [m]."""
    low, high, x, y = np.inf, -np.inf, np.cos(direction), np.sin(direction)
    for m in range(size):
        along = x * cell[m, 0] + y * cell[m, 1]
        low, high = min(low, along), max(high, along)
    return high - low


@compiled
def _line(cell: Array, size: int, arc: tuple[float, float], point: tuple[float, float]) -> Line:
    """Return a line through a point, in the middle of an arc or across the longer side; if that misses the cell, its middle."""
    (centre, bound), (x, y) = arc, point
    (west, east), (south, north) = bounds_of(cell[:size, 0]), bounds_of(cell[:size, 1])
    a, b = -np.sin(centre), np.cos(centre)
    if bound > HALF_A_CIRCLE:  # the point is within the cell, and the arc has no middle
        a, b = (1.0, 0.0) if east - west >= north - south else (0.0, 1.0)
    (low, high), through = bounds_of(a * cell[:size, 0] + b * cell[:size, 1]), a * x + b * y
    hair = OFF_THE_EDGE * (high - low)
    return a, b, through if low + hair < through < high - hair else (low + high) / 2
