"""Hulls held against points: what is in a set is in its hull, and the hull's corners are in the set."""

import numpy as np

from experiments.beacons.arcs import corners_of


def grid(low, high, count):
    """Return (count^2, 2) points of a grid over a box, its corners among them."""
    axes = [np.linspace(low[k], high[k], count) for k in (0, 1)]
    return np.stack(np.meshgrid(*axes), axis=-1).reshape(-1, 2)


def is_within(corners, points, slack=0.0):
    """Return whether each of (p, 2) points is inside a counter-clockwise polygon, or outside by no more than a length [m]."""
    edges = np.roll(corners, -1, axis=0) - corners
    length = np.hypot(*edges.T)
    kept = length > 0
    apart = points[:, None] - corners[kept]
    right = apart[..., 0] * edges[kept, 1] - apart[..., 1] * edges[kept, 0]
    return (right / length[kept] <= slack).all(axis=1)


def hold(hull, box, contains):
    """Make sure that all points of two grids that are in a set are in its hull: over the box, and over where the hull is."""
    low, high = np.maximum(hull.around.min(axis=0), box[0]), np.minimum(hull.around.max(axis=0), box[1])
    for points in (grid(*box, 300), grid(low, high, 400)):
        held = points[contains(points)]
        assert is_within(hull.around, corners_of(held[:: max(1, len(held) // 20_000)]), 1e-9).all()
