"""How far motions are from what odometry says of them."""

import numpy as np


def outside(lengths, direction_bound, along, across):
    """Return how far points are from {s (cos d, sin d): s within the lengths, |d| <= bound}; s may be negative."""
    distances = []
    for sign in (1, -1):  # ahead and behind
        low, high = (np.sort(sign * np.stack(lengths), axis=0)[end] for end in (0, 1))
        x, y = sign * along, sign * across
        angle = np.clip(np.arctan2(y, x), -direction_bound, direction_bound)
        length = np.clip(x * np.cos(angle) + y * np.sin(angle), np.maximum(low, 0), np.maximum(high, 0))
        distance = np.hypot(x - length * np.cos(angle), y - length * np.sin(angle))
        distances.append(np.where(high >= 0, distance, np.inf))
    return np.minimum(*distances)
