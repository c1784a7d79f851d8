"""Dropping constraints, which is always sound; which ones, by the area that is lost."""

from __future__ import annotations

import numpy as np

from filter.arrays import Integers
from filter.constraints import WORLD, Constraints
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
    lines = np.column_stack([polygon.normals, polygon.offsets - polygon.normals @ polygon.centroid]).tolist()
    around = list(range(len(edges)))
    added = {k: _added_area(lines, around, k) for k in around if edges[k] >= 0}
    while len(added) > budget:
        least = min(added, key=added.__getitem__)
        place = around.index(least)
        around.pop(place)
        del added[least]
        for k in (around[place - 1], around[place % len(around)]):
            if k in added:
                added[k] = _added_area(lines, around, k)
    return edges[sorted(added)]


def _added_area(lines: list[list[float]], around: list[int], k: int) -> float:
    """Return the area of the triangle that removing edge k adds; infinite where its neighbours do not meet beyond it [m2]."""
    place = around.index(k)
    before, edge, after = lines[around[place - 1]], lines[k], lines[around[(place + 1) % len(around)]]
    start, end, apex = _meet(before, edge), _meet(edge, after), _meet(before, after)
    if start is None or end is None or apex is None:
        return np.inf
    (x0, y0), (x1, y1), (x2, y2) = start, end, apex
    return abs((x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)) / 2


def _meet(first: list[float], second: list[float]) -> tuple[float, float] | None:
    """Return where two lines a x + b y = c meet, or None unless the second turns left of the first by less than half a turn."""
    (a, b, c), (d, e, f) = first, second
    turn = a * e - b * d
    return ((c * e - b * f) / turn, (a * f - c * d) / turn) if turn > 0 else None
