"""Plane geometry of walls (axis-aligned rectangles) and discs, vectorised over all pairs.

Walls are (w, 4): lower x, lower y, upper x, upper y [m].
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Mask


def nearest_on_walls(points: Array, walls: Array) -> Array:
    """Return (k, w, 2), the point of every wall that is nearest to each of the (k, 2) points [m]."""
    return np.clip(points[:, None, :], walls[None, :, :2], walls[None, :, 2:])


def distance_to_walls(points: Array, walls: Array) -> Array:
    """Return (k, w) distances of the (k, 2) points to every wall [m]; 0 inside."""
    return np.asarray(np.linalg.norm(points[:, None, :] - nearest_on_walls(points, walls), axis=2))


def meets_walls(starts: Array, ends: Array, walls: Array) -> Mask:
    """Return (k, w), whether each segment from `starts` to `ends`, (k, 2) both, has a point in every wall.

    The walls may differ from segment to segment: (k, w, 4).

    Algorithm: a segment is in the wall while it is between the wall's two sides in x and in y at once; those are two
    intervals of the segment's parameter, cut to [0, 1].
    """
    start, along = starts[:, None, :], (ends - starts)[:, None, :]
    with np.errstate(divide="ignore", invalid="ignore"):
        first, second = (walls[..., :2] - start) / along, (walls[..., 2:] - start) / along
    enter, leave = np.minimum(first, second), np.maximum(first, second)
    # A segment parallel to a side is between it and the opposite one always or never; 0 / 0 has no sense there.
    between = (walls[..., :2] <= start) & (start <= walls[..., 2:])
    enter = np.where(along == 0, np.where(between, -np.inf, np.inf), enter)
    leave = np.where(along == 0, np.where(between, np.inf, -np.inf), leave)
    return np.asarray(np.maximum(enter.max(axis=2), 0) <= np.minimum(leave.min(axis=2), 1))


def distance_to_segments(points: Array, starts: Array, ends: Array) -> Array:
    """Return (k, p) distances of every one of the (p, 2) points to the (k,) segments from `starts` to `ends` [m]."""
    along = ends - starts
    length_squared = np.maximum((along**2).sum(axis=1), np.finfo(float).tiny)[:, None]
    offset = points[None, :, :] - starts[:, None, :]
    share = np.clip((offset @ along[:, :, None])[:, :, 0] / length_squared, 0, 1)
    return np.asarray(np.linalg.norm(offset - share[:, :, None] * along[:, None, :], axis=2))
