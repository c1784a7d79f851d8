"""Who sees whom: line of sight among walls and bodies.

Bodies are the robots 0, 1, ..., n - 1 and the landmarks n, n + 1, ...; robots look, robots and landmarks are looked at.
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers, Mask
from sim.geometry import distance_to_segments, meets_walls


def visible(
    positions: Array, landmarks: Array, walls: Array, *, body_radius: float, detection_range: float
) -> tuple[Integers, Integers]:
    """Return who sees whom, ordered by robot and then by target.

    A pair sees each other within the detection range when no wall and no third body crosses the line between their middles.
    A robot does not see itself, and neither it nor its target hides anything from itself.

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
    near = np.linalg.norm(bodies[:robots, None] - bodies[None], axis=2) <= detection_range
    first, second = np.nonzero(np.triu(near, k=1))  # sight is mutual: look at each pair once
    clear = _clear(bodies, first, second, walls, body_radius)
    first, second = first[clear], second[clear]
    mutual = second < robots
    looking, seen = np.concatenate([first, second[mutual]]), np.concatenate([second, first[mutual]])
    order = np.lexsort([seen, looking])
    return looking[order], seen[order]


def _clear(bodies: Array, first: Integers, second: Integers, walls: Array, body_radius: float) -> Mask:
    """Return (p,), whether neither a wall nor a third body is between the bodies of each pair."""
    starts, ends = bodies[first], bodies[second]
    hides = distance_to_segments(bodies, starts, ends) <= body_radius
    pairs = np.arange(len(first))
    hides[pairs, first] = hides[pairs, second] = False
    return np.asarray(~hides.any(axis=1) & ~meets_walls(starts, ends, walls).any(axis=1))
