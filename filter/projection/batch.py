"""Many windows, one after the other, written into arrays that the caller made: compiled.

Python never gets more than one array back from compiled code: while a second one is put into its hands, an interrupt would
be lost, or the process.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.projection.inside import MOST_CORNERS
from filter.projection.shadow import LONGEST
from filter.projection.simplex import EMPTY
from filter.projection.walk import Task, project_window


class Sheet(NamedTuple):
    """Room for what is found in k windows, end to end; the columns of `Outlines`.

    Attributes:
        normals: (e, 2)
        offsets: (e,) [m].
        vertices: (e, 2) [m].
        margin: (k,) [m].
        first: (k + 1,) where the edges of each begin; one without edges was lost.
        row: (m,)
        weight: (m,)
        row_first: (e + 1,)
        corners: (p, 2) of inner polygons [m].
        corner_first: (k + 1,)
        searches: (k,)
        why: (k,) a place in `REASONS`.
    """

    normals: Array
    offsets: Array
    vertices: Array
    margin: Array
    first: Integers
    row: Integers
    weight: Array
    row_first: Integers
    corners: Array
    corner_first: Integers
    searches: Integers
    why: Integers


def blank(own: Integers, task: Task) -> Sheet:
    """Return a sheet with room for k windows, whose robots or pairs have so many rows of their own (k,)."""
    count, robots = len(own), min(task.most, len(task.box[0]))
    edges = int(own.sum()) + count * (min(task.goal[2], LONGEST) + 4)
    rows, corners = edges * 2 * robots + 1, count * MOST_CORNERS if task.inside else 0
    return Sheet(
        np.empty((edges, 2)),
        np.empty(edges),
        np.empty((edges, 2)),
        np.empty(count),
        np.zeros(count + 1, dtype=np.int64),
        np.empty(rows, dtype=np.int64),
        np.empty(rows),
        np.zeros(edges + 1, dtype=np.int64),
        np.empty((corners, 2)),
        np.zeros(count + 1, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
        np.zeros(count, dtype=np.int64),
    )


@compiled
def project_some(i: Integers, j: Integers, task: Task, sheet: Sheet) -> int:
    """Project the windows of some pairs i, j, or of robots j where i is WORLD, onto a sheet.

    Returns:
        0; or, where a window is proved to be empty, how many rows prove that: these are the first ones of the sheet.
    """
    place = np.full(len(task.box[0]), -1)
    edges, claims, corners = 0, 0, 0
    for k in range(len(j)):
        one = project_window(i[k], j[k], task, place)
        if one.how == EMPTY:
            for at in range(len(one.row)):
                sheet.row[at], sheet.weight[at] = one.row[at], one.weight[at]
            return len(one.row)
        for at in range(len(one.offsets)):
            _put(one.normals, at, sheet.normals, edges)
            _put(one.vertices, at, sheet.vertices, edges)
            sheet.offsets[edges], sheet.row_first[edges + 1] = one.offsets[at], claims + one.first[at + 1]
            edges += 1
        for at in range(len(one.row)):
            sheet.row[claims], sheet.weight[claims] = one.row[at], one.weight[at]
            claims += 1
        for at in range(len(one.inside)):
            _put(one.inside, at, sheet.corners, corners)
            corners += 1
        sheet.first[k + 1], sheet.corner_first[k + 1] = edges, corners
        sheet.margin[k], sheet.searches[k], sheet.why[k] = one.margin, one.searches, one.why
    return 0


@compiled
def _put(points: Array, at: int, into: Array, place: int) -> None:
    into[place, 0], into[place, 1] = points[at, 0], points[at, 1]
