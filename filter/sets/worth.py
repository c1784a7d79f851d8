"""Whether it is worth it to go on: for how many robots, and while regions become smaller by how much."""

import numpy as np

from filter.arrays import Array, Integers

# Cells, another pass and another round are worth it for this share of all robots, by number or area: they cost as much for all.
MANY = 0.1
SMALLER = 0.03  # another round is worth it while regions become smaller by this share


def matter(robots: Integers, areas: Array) -> bool:
    """Return whether some robots are not few among (n,) regions of some areas [m2]."""
    return len(robots) >= MANY * len(areas) or bool(areas[robots].sum() >= MANY * areas.sum())


def are_smaller(now: Array, before: Array) -> bool:
    """Return whether (n,) areas have become smaller than before [m2], all together or most of them; those of nothing cannot."""
    if not before.any():
        return False
    shares = np.divide(now, before, out=np.ones(len(now)), where=before > 0)
    return bool(min(now.sum() / before.sum(), shares.mean()) < 1 - SMALLER)
