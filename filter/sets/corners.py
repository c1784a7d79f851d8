"""Rows through the corners of polygons, for motion to keep them round: compiled.

A prediction moves rows outward one by one. Where two of them meet at a corner, the moved ones meet in a mitre, farther out than
any point of the corner has gone. Rows through the corner, moved as well, cut the mitre off. They follow from the two.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.linear.constraints import Columns, Constraints
from filter.linear.polytope import Polytope
from filter.projection.walk import certified
from filter.projection.window import Boxes, middle_and_reach
from filter.sets.belief import Proof, Sources

# Edges that turn by less are one, and those that turn by almost half a circle are a segment's: no corner is between them.
STRAIGHT = 1e-9


def with_corners(
    time: float, polytope: Polytope, sources: Sources, proofs: Sequence[Proof], spacing: float
) -> tuple[Polytope, Sources]:
    """Return a polytope with rows through the corners of all robots and pairs that something was proved of, and its table."""
    whose = np.unique(np.concatenate([np.stack([proof.i, proof.j], axis=1) for proof in proofs]), axis=0)
    i, j = np.ascontiguousarray(whose.T)  # of one pair it would be, of several not: two forms to compile
    table, numbers = sources.extended("region", time, j, i)
    more = corner_rows(polytope, i, j, spacing, numbers)
    return polytope.with_constraints(Constraints.concatenate([polytope.constraints, more])), table


def corner_rows(polytope: Polytope, i: Integers, j: Integers, spacing: float, numbers: Integers) -> Constraints:
    """Return rows on robots or pairs through the corners of their polygons, for no two edges to turn by more than the spacing.

    Args:
        polytope: The team's; the polygons are of the rows on each robot or pair alone.
        i: (g,) a robot, or WORLD.
        j: (g,) a robot.
        spacing: [rad].
        numbers: (g,) their sources.
    """
    cuts, rows = polytope.of(i, j), polytope.constraints
    outlines, box = (cuts.polygons.normals, cuts.edges, cuts.polygons.first), (polytope.lower, polytope.upper)
    corners = _corners((i, j), outlines, spacing, rows.columns, box)
    whose = corners[:, 0].astype(np.int64)
    return Constraints(i[whose], j[whose], corners[:, 1:3], corners[:, 3], numbers[whose])


@compiled
def _corners(
    pairs: tuple[Integers, Integers], outlines: tuple[Array, Integers, Integers], spacing: float, team: Columns, box: Boxes
) -> Array:
    """Return for each row (c, 4) whose it is, its normal and a certified offset."""
    (i, j), (normals, edges, first) = pairs, outlines
    turns, pieces = _turns(normals, first, spacing)
    corners = np.empty(((pieces - 1).sum(), 4))
    place, count = np.full(len(box[0]), -1), 0
    for g in range(len(j)):
        where = _place(i[g], j[g], place, box)
        for edge in range(first[g], first[g + 1]):
            following = edge + 1 if edge + 1 < first[g + 1] else first[g]
            a, b = normals[edge], normals[following]
            begin = np.arctan2(a[1], a[0])
            for piece in range(1, pieces[edge]):
                angle = begin + turns[edge] * piece / pieces[edge]
                normal = np.array([np.cos(angle), np.sin(angle)])
                prices = np.array([_across(normal, b), _across(a, normal)]) / _across(a, b)
                behind = np.array([edges[edge], edges[following]])
                corners[count, 0], corners[count, 1:3] = g, normal
                corners[count, 3] = certified(i[g], j[g], normal, prices, behind, where, team)
                count += 1
        place[j[g]] = -1
        if i[g] >= 0:
            place[i[g]] = -1
    return corners


@compiled
def _turns(normals: Array, first: Integers, spacing: float) -> tuple[Array, Integers]:
    """Return by how much each edge turns to the next of its polygon (e,) [rad], and into how many pieces that is cut (e,).

    A polygon as small as its rounding may turn back and forth: in all by more than once around.
    """
    turns, pieces = np.empty(len(normals)), np.ones(len(normals), dtype=np.int64)
    for g in range(len(first) - 1):
        for edge in range(first[g], first[g + 1]):
            a, b = normals[edge], normals[edge + 1 if edge + 1 < first[g + 1] else first[g]]
            turns[edge] = np.arctan2(_across(a, b), a[0] * b[0] + a[1] * b[1])
            if STRAIGHT < turns[edge] < np.pi - STRAIGHT:
                pieces[edge] = int(np.ceil(turns[edge] / spacing))
    return turns, pieces


@compiled
def _place(i: int, j: int, place: Integers, box: Boxes) -> tuple[Integers, Array, Array]:
    """Return robots j and i, where it is not WORLD, as members for `certified`."""
    count = 2 if i >= 0 else 1
    centre, radius = np.empty(2 * count), np.empty(2 * count)
    for k in range(count):
        robot = j if k == 0 else i
        place[robot] = k
        for m in range(2):
            centre[2 * k + m], radius[2 * k + m] = middle_and_reach(box[0][robot, m], box[1][robot, m])
    return place, centre, radius


@compiled
def _across(a: Array, b: Array) -> float:
    return a[0] * b[1] - a[1] * b[0]
