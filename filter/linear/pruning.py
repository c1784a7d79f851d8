"""Dropping constraints, which is always sound; which ones, by the area that is lost."""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers, Mask
from filter.compiled import compiled
from filter.geometry.convex import centroid_of
from filter.geometry.simplify import edges_worth_keeping
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope


def prune(polytope: Polytope, rows_per_robot: int, rows_per_pair: int) -> Constraints:
    """Return the polytope's rows with at most so many left on each robot and on each pair.

    Where there are more, those that the others imply within the group go first, then again and again the edge whose removal
    adds the least area.
    """
    rows = polytope.constraints
    i, j, first = rows.grouped()
    size, budget = np.diff(first), np.where(i == WORLD, rows_per_robot, rows_per_pair)
    crowded = np.flatnonzero(size > budget)
    if not len(crowded):
        return rows
    clipped = polytope.of(i[crowded], j[crowded])
    stays = size <= budget
    stays[crowded[clipped.empty]] = True  # rows that exclude one another all stay, for the next update to name their causes
    keep = np.repeat(stays, size)
    outlines, is_row = clipped.polygons, clipped.behind < len(rows)  # sides of the box stay, and count nothing
    lines = outlines.normals, outlines.offsets
    worthy = _worthy(lines, outlines.vertices, outlines.first, is_row, budget[crowded])
    keep[clipped.behind[worthy & is_row]] = True
    return rows.select(keep)


@compiled
def _worthy(lines: tuple[Array, Array], vertices: Array, first: Integers, removable: Mask, budget: Integers) -> Mask:
    normals, offsets = lines
    keep = np.ones(len(offsets), dtype=np.bool_)
    for k in range(len(budget)):
        begin, end = first[k], first[k + 1]
        x, y = centroid_of(vertices[begin:end])
        level = offsets[begin:end] - (normals[begin:end, 0] * x + normals[begin:end, 1] * y)
        keep[begin:end], _ = edges_worth_keeping(normals[begin:end], level, removable[begin:end], budget[k], -1.0)
    return keep
