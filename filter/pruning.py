"""Dropping constraints, which is always sound; which ones, by the area that is lost."""

from __future__ import annotations

import numpy as np

from filter.arrays import Integers
from filter.constraints import WORLD, Constraints
from filter.plane import worthy
from filter.polygon import Polygon
from filter.polytope import Polytope


def prune(polytope: Polytope, rows_per_robot: int, rows_per_pair: int) -> Constraints:
    """Return the polytope's rows with at most so many left on each robot and on each pair.

    Where there are more, those that the others imply within the group go first, then one after the other the edge
    whose removal adds the least area. The box stays, and counts nothing.
    """
    rows = polytope.constraints
    groups, member, sizes = np.unique(np.stack([rows.i, rows.j]), axis=1, return_inverse=True, return_counts=True)
    member = member.ravel()
    budgets = np.where(groups[0] == WORLD, rows_per_robot, rows_per_pair)
    keep = (sizes <= budgets)[member]
    for group in np.flatnonzero(sizes > budgets):
        i, j = groups[:, group].tolist()
        known = polytope.of_robot(j) if i == WORLD else polytope.of_pair(i, j)
        # Rows that exclude one another all stay, for the next update to name their causes.
        keep[worthy_edges(*known, int(budgets[group])) if known else polytope.constraints.rows_of(i, j)] = True
    return rows.select(keep)


def worthy_edges(polygon: Polygon, edges: Integers, budget: int) -> Integers:
    """Return which `budget` of a polygon's edges to keep so that little area is added.

    Greedy: again and again the edge goes whose removal adds least.

    Args:
        polygon: With edges counter-clockwise.
        edges: (e,) the row behind each edge; a negative one belongs to the box, stays and counts nothing.
        budget: How many rows may stay.
    """
    offsets = polygon.offsets - polygon.normals @ polygon.centroid
    keep, _ = worthy(polygon.normals, offsets, edges >= 0, budget, -1.0)
    return edges[keep & (edges >= 0)]
