"""Sectors: what lies in some directions and between two distances, as half-planes and as the corners around it; compiled.

A bearing with a range is one, a range alone is one of a full circle, and so is odometry, of one's own past. Its far side is
round, its near side is hollow: the half-planes and the corners are those of convex sets around it.
"""

import numpy as np

from filter.arrays import Array
from filter.compiled import compiled

WIDEST = 1.5  # a sector with a larger half-width, almost a half-plane, says nothing that its far side does not say [rad]
HAIR = 1e-5  # a sector that is so much wider than a whole number of tangents can touch, in these, needs none more


@compiled
def sides(centre: float, bound: float) -> Array:
    """Return normals (2, 2) of the lines from the origin along both sides of a sector of half-width `bound` below pi/2 [rad].

    With d in the sector: dx sin(least) - dy cos(least) <= 0 and -dx sin(greatest) + dy cos(greatest) <= 0.
    """
    least, greatest = centre - bound, centre + bound
    return np.array([[np.sin(least), -np.cos(least)], [-np.sin(greatest), np.cos(greatest)]])


@compiled
def far_and_near(centre: float, bound: float, nearest: float, farthest: float, spacing: float) -> tuple[Array, Array]:
    """Return normals (k, 2) and offsets (k,) of half-planes u . d <= offset around the far and the near side of a sector [m].

    Far side: tangents for directions u evenly over the arc, `spacing` apart at most [rad]; a narrow arc has one, a full
    circle 2 pi / spacing. Near side, for arcs narrower than half a circle: -u . d <= -nearest cos(bound).
    """
    tangents = max(1, int(np.ceil(2 * bound / spacing - HAIR)))
    near = bound < np.pi / 2 and nearest > 0
    normals, offsets = np.empty((tangents + near, 2)), np.empty(tangents + near)
    for k in range(tangents):
        angle = centre + bound * ((2 * k + 1) / tangents - 1)
        normals[k, 0], normals[k, 1], offsets[k] = np.cos(angle), np.sin(angle), farthest
    if near:
        normals[tangents, 0], normals[tangents, 1] = -np.cos(centre), -np.sin(centre)
        offsets[tangents] = -nearest * np.cos(bound)
    return normals, offsets


@compiled
def trapezoid(centre: float, bound: float, nearest: float, farthest: float) -> Array:
    """Return corners (4, 2) of the smallest trapezoid around a sector; of one of `WIDEST` where it is wider [m]."""
    narrow = min(bound, WIDEST)
    x, y, slope, near = np.cos(centre), np.sin(centre), np.tan(narrow), nearest * np.cos(narrow)
    corners = np.empty((4, 2))
    for k in range(4):
        along, turn = near if k < 2 else farthest, slope if k % 2 else -slope
        corners[k, 0], corners[k, 1] = along * (x - turn * y), along * (y + turn * x)
    return corners
