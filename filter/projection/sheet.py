"""What is asked of windows, and room for what is found in them, end to end: arrays that the caller of compiled code makes."""

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers
from filter.linear.certify import Boxes
from filter.linear.constraints import Columns
from filter.projection.inside import MOST_CORNERS
from filter.projection.shadow import LONGEST
from filter.projection.window import Links


class Task(NamedTuple):
    """What all windows of a team have in common.

    Attributes:
        hops: How far a window reaches.
        most: How many robots it may have.
        inside: Whether inner polygons are wanted, too: only in windows that leave nobody out are they right.
        goal: As in `Stop`: performance ratio, area gap and greatest number of edges.
        who: Who has rows with whom.
        team: i, j, normal and offset of all constraints.
        box: Lower and upper corners (n, 2) of all robots.
    """

    hops: int
    most: int
    inside: bool
    goal: tuple[float, float, int]
    who: Links
    team: Columns
    box: Boxes


class Sheet(NamedTuple):
    """Room for what is found in k windows, end to end: the columns of `Outlines`, with room to spare in each.

    The edges of each window begin at `first`, (k + 1,), and are none where its walk was lost; the rows of each at `row_first`,
    (e + 1,); the corners of each inner polygon at `corner_first`, (k + 1,), and are none where nothing is known from inside.
    `searches`, (k,), is how many edges of a shadow were kept, and `why`, (k,), what decided that, a place in `REASONS`.
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
    lines, claims = (np.empty((edges, 2)), np.empty(edges), np.empty((edges, 2))), (_zeros(rows), np.empty(rows))
    first, hulls = (np.empty(count), _zeros(count + 1)), (np.empty((corners, 2)), _zeros(count + 1))
    return Sheet(*lines, *first, *claims, _zeros(edges + 1), *hulls, _zeros(count), _zeros(count))


def _zeros(count: int) -> Integers:
    return np.zeros(count, dtype=np.int64)
