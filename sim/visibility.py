"""Who sees whom: line of sight among walls and bodies.

Bodies are the robots 0, 1, ..., n - 1 and the landmarks n, n + 1, ...; robots look, robots and landmarks are looked at.
"""

from __future__ import annotations

import numpy as np
from scipy.spatial import cKDTree

from filter import Array, Integers, Mask
from sim.geometry import ALLOWANCE, distance_to_segment, meets_wall, near, near_walls


def visible(
    positions: Array, landmarks: Array, walls: Array, *, body_radius: float, detection_range: float
) -> tuple[Integers, Integers]:
    """Return who sees whom, ordered by robot and then by target.

    A pair sees each other within the detection range when no wall and no third body crosses the line between their middles.
    A robot does not see itself, and neither it nor its target hides anything from itself.

    Only what is near is looked at, so that the time grows with the team and not with its square; this changes no result.

    Args:
        positions: (n, 2) the robots [m].
        landmarks: (l, 2) the landmarks [m].
        walls: (w, 4) lower x, lower y, upper x, upper y [m].
        body_radius: Radius of the disc of each body that hides what is behind it [m].
        detection_range: Greatest distance between middles [m].

    Returns:
        (k,) robots that see and (k,) targets that they see.
    """
    robots, bodies = len(positions), np.concatenate([positions, landmarks])
    first, second = _pairs(bodies, robots, detection_range)  # sight is mutual: look at each pair once
    clear = ~_hidden_by_bodies(bodies, first, second, body_radius)
    first, second = first[clear], second[clear]
    clear = ~_hidden_by_walls(bodies[first], bodies[second], walls)
    first, second = first[clear], second[clear]
    mutual = second < robots
    looking, seen = np.concatenate([first, second[mutual]]), np.concatenate([second, first[mutual]])
    order = np.lexsort([seen, looking])
    return looking[order], seen[order]


def _pairs(bodies: Array, robots: int, detection_range: float) -> tuple[Integers, Integers]:
    """Return the pairs of a robot and a later body that are within the detection range."""
    pairs = cKDTree(bodies).query_pairs(detection_range * (1 + ALLOWANCE) + ALLOWANCE, output_type="ndarray")
    first, second = pairs[pairs[:, 0] < robots].T
    kept = np.linalg.norm(bodies[first] - bodies[second], axis=1) <= detection_range
    return first[kept], second[kept]


def _hidden_by_bodies(bodies: Array, first: Integers, second: Integers, body_radius: float) -> Mask:
    """Return (p,), whether a third body is between the bodies of each pair."""
    starts, ends = bodies[first], bodies[second]
    pair, third = near(bodies, (starts + ends) / 2, np.linalg.norm(ends - starts, axis=1) / 2 + body_radius)
    other = (third != first[pair]) & (third != second[pair])
    pair, third = pair[other], third[other]
    hides = distance_to_segment(bodies[third], starts[pair], ends[pair]) <= body_radius
    return np.bincount(pair[hides], minlength=len(first)) > 0


def _hidden_by_walls(starts: Array, ends: Array, walls: Array) -> Mask:
    """Return (p,), whether a wall is between the ends of each line."""
    line, wall = near_walls((starts + ends) / 2, walls, np.linalg.norm(ends - starts, axis=1) / 2)
    hides = meets_wall(starts[line], ends[line], walls[wall])
    return np.bincount(line[hides], minlength=len(starts)) > 0
