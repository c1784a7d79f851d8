"""Plane geometry of points, segments, discs and walls (axis-aligned rectangles), and what is near what among many.

Points are (..., 2) [m]; walls are (..., 4): lower x, lower y, upper x, upper y [m]. All but `near` broadcast over their leading
dimensions, as numpy's own functions do: what is computed for one pair does not depend on the pairs beside it.
"""

from __future__ import annotations

from itertools import chain

import numpy as np
from scipy.spatial import cKDTree

from filter import Array, Integers, Mask

# What is near may lie this much farther away, relatively and absolutely [m]: rounding must not lose anything.
ALLOWANCE = 1e-9


def near(points: Array, centres: Array, reach: Array) -> tuple[Integers, Integers]:
    """Return which of the (k, 2) centres, in order, have which of the (p, 2) points within their (k,) reach [m].

    Points that are farther away by a rounding error may be among them.
    """
    if not len(points) or not len(centres):
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    found = cKDTree(points).query_ball_point(centres, reach * (1 + ALLOWANCE) + ALLOWANCE)
    counts = np.fromiter(map(len, found), dtype=np.int64, count=len(found))
    which = np.fromiter(chain.from_iterable(found), dtype=np.int64, count=int(counts.sum()))
    return np.repeat(np.arange(len(centres)), counts), which


def near_walls(points: Array, walls: Array, reach: Array) -> tuple[Integers, Integers]:
    """Return pairs of (k, 2) points and (w, 4) walls: all that are within the points' (k,) reach [m], and some that are not."""
    middles, half = (walls[:, :2] + walls[:, 2:]) / 2, np.linalg.norm(walls[:, 2:] - walls[:, :2], axis=1) / 2
    wall, point = near(points, middles, half + reach.max(initial=0.0))
    apart = np.linalg.norm(points[point] - nearest_on_wall(points[point], walls[wall]), axis=1)
    kept = apart <= reach[point] * (1 + ALLOWANCE) + ALLOWANCE
    return point[kept], wall[kept]


def nearest_on_wall(points: Array, walls: Array) -> Array:
    """Return (..., 2), the wall's point that is nearest to a point [m]."""
    return np.clip(points, walls[..., :2], walls[..., 2:])


def distance_to_wall(points: Array, walls: Array) -> Array:
    """Return (...) distances of points to walls [m]; 0 inside."""
    return np.asarray(np.linalg.norm(points - nearest_on_wall(points, walls), axis=-1))


def meets_wall(starts: Array, ends: Array, walls: Array) -> Mask:
    """Return (...), whether a segment has a point in a wall.

    Algorithm: a segment is in the wall while it is between the wall's two sides in x and in y at once; those are two
    intervals of the segment's parameter, cut to [0, 1].
    """
    along = ends - starts
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (walls[..., :2] - starts) / along, (walls[..., 2:] - starts) / along
    enter, leave = np.minimum(first, second), np.maximum(first, second)
    # A segment parallel to a side is between it and the opposite one always or never; 0 / 0 has no sense there.
    between = (walls[..., :2] <= starts) & (starts <= walls[..., 2:])
    enter = np.where(along == 0, np.where(between, -np.inf, np.inf), enter)
    leave = np.where(along == 0, np.where(between, np.inf, -np.inf), leave)
    return np.asarray(np.maximum(enter.max(axis=-1), 0) <= np.minimum(leave.min(axis=-1), 1))


def distance_to_segment(points: Array, starts: Array, ends: Array) -> Array:
    """Return (...) distances of points to segments [m]."""
    along, offset = ends - starts, points - starts
    length_squared = np.maximum((along**2).sum(axis=-1), np.finfo(float).tiny)
    share = np.clip((offset * along).sum(axis=-1) / length_squared, 0, 1)
    return np.asarray(np.linalg.norm(offset - share[..., None] * along, axis=-1))
