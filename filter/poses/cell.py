"""Cells: sets of poses of one robot, each a polygon of places with an arc of headings, cut by what was measured; compiled.

A range's band is hollow and a wide bearing is no convex set, so in one piece they say little. In a small cell the direction of
a target is narrow, and both say what they can. So a set of poses is split, pieces are cut, and those proved empty are dropped:
branch and prune, from interval analysis (Jaulin et al., Applied Interval Analysis, 2001).

Targets are sets, too: convex hulls of points, laid end to end. A sector (4,) is a bearing and its bound [rad], least and
greatest range [m]; without a bearing the bound is pi, without a range they are 0 and infinite. Polygons err outward: what is
meant is within the cell's `margin` of the hull of its vertices.
"""

from typing import NamedTuple

import numpy as np

from filter.arrays import Array, Integers, Mask
from filter.compiled import compiled
from filter.geometry.angles import intersection
from filter.geometry.convex import EPSILON, area_of
from filter.geometry.sector import far_and_near, sides
from filter.poses.cone import directions, wrapped
from filter.sensing.rows import WIDENING

CELL_CORNERS = 64  # of a cell at most: a half-plane that would make more is left out
ROUNDS = 10  # in which a cell is cut by everything, as long as
SHRUNK = 0.9  # that leaves less than this share of its area


class Said(NamedTuple):
    """What was measured by or of one robot, target after target, bearings before ranges.

    Attributes:
        sector: (q, 4) of each reading.
        own: (q,) whether its bearing is from the robot's own heading; otherwise it is a direction in the world.
        first: (t + 1,) where the readings of each target begin.
        points: (p, 2) where the targets can be [m].
        point_first: (t + 1,) where the points of each begin.
        spacing: Greatest angle between two tangents of a range's far side [rad].
    """

    sector: Array
    own: Mask
    first: Integers
    points: Array
    point_first: Integers
    spacing: float


class Scale(NamedTuple):
    """How large numbers are, and room to work in.

    Attributes:
        largest: No coordinate is larger [m].
        margin: How far cells and targets can reach beyond the hulls of their points [m].
        room: (CELL_CORNERS + 2, 2) scratch.
    """

    largest: float
    margin: float
    room: Array


Line = tuple[float, float, float]  # x, y and offset of x p_x + y p_y = offset
# Room for the vertices of a cell (CELL_CORNERS, 2) [m], and its heading (2,), centre and bound [rad].
Pose = tuple[Array, Array]


@compiled
def cut(cell: Array, size: int, line: Line, scale: Scale) -> int:
    """Cut a cell in place by x p_x + y p_y <= offset; return how many vertices are left, 0 if that is proved to be none.

    What is cut errs outward as in `clip_box`.
    """
    (x, y, offset), room = line, scale.room
    level, some = offset + 8 * EPSILON * (abs(offset) + (abs(x) + abs(y)) * scale.largest), False
    for m in range(size):
        some = some or x * cell[m, 0] + y * cell[m, 1] > level
    if not some or size + 2 > CELL_CORNERS:
        return size
    kept = 0
    for m in range(size):
        before = m - 1 if m else size - 1
        last, now = x * cell[before, 0] + y * cell[before, 1] - level, x * cell[m, 0] + y * cell[m, 1] - level
        if (last > 0) != (now > 0):
            share = last / (last - now)
            room[kept, 0] = cell[before, 0] + share * (cell[m, 0] - cell[before, 0])
            room[kept, 1] = cell[before, 1] + share * (cell[m, 1] - cell[before, 1])
            kept += 1
        if now <= 0:
            room[kept, 0], room[kept, 1] = cell[m, 0], cell[m, 1]
            kept += 1
    for m in range(kept):
        cell[m, 0], cell[m, 1] = room[m, 0], room[m, 1]
    return kept


@compiled
def pruned(pose: Pose, size: int, said: Said, scale: Scale) -> tuple[int, int]:
    """Cut a cell and its heading in place by everything that was said, in some rounds.

    Return how many vertices are left, 0 if that is proved to be none, and how many rounds it took.
    """
    for count in range(1, ROUNDS + 1):
        before = area_of(pose[0][:size])
        for t in range(len(said.first) - 1):
            size = _seen(pose, size, t, said, scale)
            if size == 0:
                return 0, count
        if area_of(pose[0][:size]) >= SHRUNK * before:
            return size, count
    return size, ROUNDS


@compiled
def cuts_at_most(said: Said) -> float:
    """Return how often a cell is cut at most, before it is split and by that."""
    tangents_and_sides = 2 * np.pi / said.spacing + 4
    return ROUNDS * len(said.sector) * tangents_and_sides + 1


@compiled
def _seen(pose: Pose, size: int, t: int, said: Said, scale: Scale) -> int:
    """Cut a cell by the readings of one target."""
    cell, heading = pose
    points = said.points[said.point_first[t] : said.point_first[t + 1]]
    nearest = nearest_of(said, t)
    centre, bound, farthest = directions(cell, size, points, nearest, scale.margin)
    apart = bound < np.pi or nearest > 0  # of what is in one place with the robot, bearings say nothing
    for q in range(said.first[t], said.first[t + 1]):
        value, half, least, greatest = said.sector[q]
        if half < np.pi:
            if said.own[q]:
                heading[0], heading[1] = intersection(heading[0], heading[1], wrapped(centre - value), bound + half + WIDENING)
                if heading[1] < 0:
                    return 0
                value, half = wrapped(heading[0] + value), half + heading[1]
            half += WIDENING
            if half < np.pi / 2:
                for normal in sides(value, half):
                    size = _behind(cell, size, (normal[0], normal[1], 0.0), points, scale)
            meet = intersection(centre, bound, value, min(half, np.pi))
            if meet[1] >= 0:
                centre, bound = meet
            elif apart:
                return 0
        if size == 0 or farthest < least * (1 - WIDENING):
            return 0
        if greatest < np.inf:
            wide = min(bound + WIDENING, np.pi)
            normals, offsets = far_and_near(centre, wide, least * (1 - WIDENING), greatest * (1 + WIDENING), said.spacing)
            for k in range(len(offsets)):
                size = _behind(cell, size, (normals[k, 0], normals[k, 1], offsets[k]), points, scale)
            if size == 0:
                return 0
    return size


@compiled
def _behind(cell: Array, size: int, line: Line, points: Array, scale: Scale) -> int:
    """Cut a cell by (x, y) . (q - p) <= offset for some point q of a target."""
    (x, y, offset), most = line, -np.inf
    for t in range(len(points)):
        most = max(most, -x * points[t, 0] - y * points[t, 1])
    return cut(cell, size, (-x, -y, offset + most + scale.margin), scale)


@compiled
def nearest_of(said: Said, t: int) -> float:
    """Return the least distance to a target that ranges leave [m]."""
    nearest = 0.0
    for q in range(said.first[t], said.first[t + 1]):
        nearest = max(nearest, said.sector[q, 2])
    return nearest
