"""Boxes around polygons, proved from two edges for each side: compiled."""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.geometry.polygon import SIDES
from filter.geometry.polygons import Polygons
from filter.linear.constraints import WORLD, Columns, Constraints
from filter.linear.polytope import Polytope
from filter.projection.shadow import WORTHLESS
from filter.projection.walk import certified
from filter.projection.window import Boxes, middle_and_reach
from filter.sets.belief import Proof, Sources


def proved_boxes(
    polytope: Polytope, sources: Sources, outer: Polygons, edges: tuple[Constraints, Integers], robots: Integers
) -> tuple[Array, Array, Proof]:
    """Return lower and upper corners (n, 2) of the polytope's box, made smaller around some robots' polygons, and why.

    Args:
        polytope: Its box is where each proof starts.
        sources: The table of the edges.
        outer: (n) polygons around the robots.
        edges: The polygons' edges as rows, and (e,) which of these each edge of a polygon is; -1 for a side of the box.
        robots: (k,) whose boxes are made smaller.
    """
    rows, box = edges[0], (polytope.lower, polytope.upper)
    bounds, used, prices = np.empty((len(robots), 4)), np.full((len(robots), 4, 2), -1), np.zeros((len(robots), 4, 2))
    polygons = outer.normals, outer.vertices, outer.first, edges[1]
    _bound((bounds, used, prices), polygons, robots, rows.columns, box)
    lower, upper = polytope.lower.copy(), polytope.upper.copy()
    high, low = np.minimum(upper[robots], bounds[:, :2]), np.maximum(lower[robots], -bounds[:, 2:])
    good = (low <= high).all(axis=1)  # otherwise it is empty, which is for the next update to prove and to explain
    lower[robots[good]], upper[robots[good]] = low[good], high[good]
    claim, place = np.nonzero(prices.reshape(-1, 2))
    row, multipliers = used.reshape(-1, 2)[claim, place], prices.reshape(-1, 2)[claim, place]
    whole, normals = Polytope(rows, polytope.lower, polytope.upper), np.tile(SIDES, (len(robots), 1))
    whose, nobody = np.repeat(robots, 4), np.full(4 * len(robots), WORLD)
    return lower, upper, Proof(whole, sources, nobody, whose, normals, bounds.ravel(), claim, row, multipliers)


@compiled
def _bound(
    into: tuple[Array, Integers, Array],
    outer: tuple[Array, Array, Integers, Integers],
    robots: Integers,
    team: Columns,
    box: Boxes,
) -> None:
    """Write certified extents (k, 4) to the right, top, left and bottom, and two rows and prices (k, 4, 2) for each."""
    (bounds, rows, prices), (normals, vertices, first, row) = into, outer
    place, centre, radius, side = np.full(len(box[0]), -1), np.empty(2), np.empty(2), np.empty(2)
    for k in range(len(robots)):
        robot, begin, end = robots[k], first[robots[k]], first[robots[k] + 1]
        place[robot] = 0
        for m in range(2):
            centre[m], radius[m] = middle_and_reach(box[0][robot, m], box[1][robot, m])
        for s in range(4):
            side[0], side[1] = (1.0, 0.0, -1.0, 0.0)[s], (0.0, 1.0, 0.0, -1.0)[s]
            following = begin
            for edge in range(begin, end):
                if _along(side, vertices[edge]) > _along(side, vertices[following]):
                    following = edge
            before = following - 1 if following > begin else end - 1
            turned = _across(normals[before], normals[following])
            for which in range(2):
                edge = before if which == 0 else following
                part = _across(side, normals[following]) if which == 0 else _across(normals[before], side)
                if row[edge] >= 0 and turned != 0 and WORTHLESS < part / turned < np.inf:
                    rows[k, s, which], prices[k, s, which] = row[edge], part / turned
            bounds[k, s] = certified(WORLD, robot, side, prices[k, s], rows[k, s], (place, centre, radius), team)
        place[robot] = -1


@compiled
def _along(a: Array, b: Array) -> float:
    return a[0] * b[0] + a[1] * b[1]


@compiled
def _across(a: Array, b: Array) -> float:
    return a[0] * b[1] - a[1] * b[0]
