"""Each robot's region, and each pair's: the projection of the team's polytope, cut with what is known of these alone.

The outer polygons' edges become rows themselves: that is how the team's knowledge survives pruning. A prediction moves every
row on its own; what several rows say together of two robots has to be one row before, or it is lost.
"""

from dataclasses import replace
from functools import lru_cache

import numpy as np

from filter.arrays import Array, Integers, read_only
from filter.errors import Inconsistent
from filter.geometry.polygon import SIDES
from filter.linear.certify import imply
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.projection.claims import Outlines, Weights
from filter.projection.stop import IsOver, never
from filter.projection.team import Projector
from filter.projection.window import Window
from filter.sets.belief import Belief
from filter.sets.proof import Proof
from filter.sets.regions import Regions

# A conflict is named by the multipliers above one of these shares of the greatest: the first that leaves a proof.
SHARES = (1e-2, 1e-4, 1e-6, 0.0)
# Where regions are found in the whole team, pairs are found among those near them: regions have taken the rest along already.
NEAR = Window(hops=2, robots=12)
Pairs = tuple[Integers, Integers]  # i and j (g) of each


def refined(belief: Belief, projector: Projector, *, is_over: IsOver = never) -> Belief:
    """Return a belief with every robot's region projected; its edges are the only rows on single robots then.

    Those whose regions were refined longest ago come first: when time is up, the others' regions are what is known of them at
    a glance. The proofs are those of every edge, then of every side of the boxes. Raises `Inconsistent` if the polytope is
    proved to be empty.
    """
    polytope, sources = belief.polytope, belief.sources
    robots = np.arange(len(polytope.lower))
    order = np.argsort(sources.time[polytope.origin], kind="stable") if len(polytope.origin) else robots
    found = projector.robots(polytope, order=order, is_over=is_over)
    if found.contradiction is not None:
        raise _inconsistent(belief, found.contradiction)
    table, numbers = sources.extended("region", belief.time, robots)
    outlines, whose = found.outlines, (np.full(len(robots), WORLD), robots)
    # A search that time cut short had its turn: otherwise it would be the first again, and nobody else would ever come.
    late = np.array([reason == "time" for reason in outlines.reasons], dtype=bool) & (outlines.searches == 0)
    late &= bool(len(polytope.origin))
    own, row = edges_as_rows(polytope, outlines, whose, numbers)
    lower, upper, boxes = proved_boxes(polytope, table, outlines, (own, row), np.flatnonzero(~late))
    pairs = polytope.constraints.select(polytope.constraints.i != WORLD)
    origin = np.where(late, polytope.origin, numbers) if late.any() else numbers
    return replace(
        belief,
        polytope=Polytope(Constraints.concatenate([own, pairs]), lower, upper, origin),
        sources=table,
        found=Regions.of(polytope, outlines),
        events=found.failures,
        proofs=(Proof.of_edges(polytope, sources, outlines, whose), boxes),
    )


def with_pairs(belief: Belief, most: int, projector: Projector, *, is_over: IsOver = never) -> Belief:
    """Return a belief with the projections of at most so many pairs as the rows on them, and why these hold.

    Walks that are lost are events; their pairs keep the rows they have, and so do those that time runs out on.
    """
    polytope, sources = belief.polytope, belief.sources
    i, j = pairs = chosen_pairs(polytope, sources, belief.time, most)
    if not len(j):
        return belief
    near = replace(projector, window=NEAR) if projector.window.leaves_nobody_out else projector
    mutual = near.pairs(polytope, pairs, is_over=is_over)
    table, numbers = sources.extended("region", belief.time, j, i)
    edges, _ = edges_as_rows(polytope, mutual.outlines, pairs, numbers)
    rows, robots = polytope.constraints, len(polytope.lower)
    others = rows.select(~np.isin(_keys(rows.i, rows.j, robots), _keys(i, j, robots)))
    return replace(
        belief,
        polytope=polytope.with_constraints(Constraints.concatenate([others, edges])),
        sources=table,
        events=(*belief.events, *mutual.failures),
        proofs=(*belief.proofs, Proof.of_edges(polytope, sources, mutual.outlines, pairs)),
    )


def chosen_pairs(polytope: Polytope, sources: Sources, time: float, most: int) -> Pairs:
    """Return at most so many pairs i < j, in order: those just measured, then those longest ago, then those without rows."""
    rows, robots = polytope.constraints, len(polytope.lower)
    if robots * (robots - 1) // 2 <= most:
        return _all_pairs(robots)
    if not most:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    i, j, first = rows.grouped()
    last = np.maximum.reduceat(sources.time[rows.source], first[:-1]) if len(rows) else np.zeros(0)
    known = np.flatnonzero(i != WORLD)
    known = known[np.lexsort((last[known], last[known] < time))]
    i, j = i[known], j[known]
    if len(known) < most:
        first, second = _all_pairs(robots)
        others = ~np.isin(_keys(first, second, robots), _keys(i, j, robots))
        i, j = np.append(i, first[others]), np.append(j, second[others])
    order = np.lexsort((j[:most], i[:most]))
    return i[:most][order], j[:most][order]


@lru_cache(8)
def _all_pairs(robots: int) -> Pairs:
    i, j = np.triu_indices(robots, 1)
    return read_only(i), read_only(j)


def edges_as_rows(polytope: Polytope, outlines: Outlines, whose: Pairs, numbers: Integers) -> tuple[Constraints, Integers]:
    """Return the edges of (n) outlines as rows, and which row (e,) each is, or their number for a side of a box.

    Edges that were proved anew get the outlines' sources, numbers (n,); rows that were known keep theirs.
    """
    rows, weights, outer = polytope.constraints, outlines.weights, outlines.outer
    is_row = weights.counts > 0
    i, j = (each[outer.owner[is_row]] for each in whose)
    source, one = numbers[outer.owner[is_row]], weights.row[weights.first[:-1][is_row]]
    known = (weights.counts[is_row] == 1) & (rows.i[one] == i) & (rows.j[one] == j)
    source[known] = rows.source[one[known]]
    edges = Constraints(i, j, outer.normals[is_row], outer.offsets[is_row], source)
    return edges, read_only(np.where(is_row, np.cumsum(is_row) - 1, len(edges)))


def proved_boxes(
    polytope: Polytope, sources: Sources, outlines: Outlines, edges: tuple[Constraints, Integers], robots: Integers
) -> tuple[Array, Array, Proof]:
    """Return lower and upper corners (n, 2) of a polytope's box, made smaller around the polygons of robots (k,), and why.

    The outlines are those of all n robots, with their edges as rows (see `edges_as_rows`), whose sources are in the table.
    """
    (rows, row), outer, asked = edges, outlines.outer, len(robots) * len(SIDES)
    box, nobody = (polytope.lower, polytope.upper), np.full(len(outer), WORLD)
    bounds, used, prices = np.empty(asked), np.empty((asked, 2), dtype=np.int64), np.empty((asked, 2))
    polygons, normals = (outer.normals, outer.vertices, row, outer.first), np.tile(SIDES, (len(robots), 1))
    whose = np.repeat(robots, len(SIDES))
    imply((bounds, used, prices), (nobody, np.arange(len(outer))), polygons, (whose, normals), rows.rows, box)
    sides, lower, upper = bounds.reshape(-1, 4), polytope.lower.copy(), polytope.upper.copy()
    high, low = np.minimum(upper[robots], sides[:, :2]), np.maximum(lower[robots], -sides[:, 2:])
    good = (low <= high).all(axis=1)  # otherwise it is empty, which is for the next update to prove and to explain
    lower[robots[good]], upper[robots[good]] = low[good], high[good]
    claim, place = np.nonzero(prices)
    weights = Weights(used[claim, place], prices[claim, place], np.searchsorted(claim, np.arange(asked + 1)))
    whole = Polytope(rows, polytope.lower, polytope.upper)
    return lower, upper, Proof("boxes", whole, sources, np.full(asked, WORLD), whose, normals, bounds, weights)


def _inconsistent(belief: Belief, multipliers: Array) -> Inconsistent:
    """Return the error that names the sources of a Farkas certificate (r,), of as few rows as still prove it.

    Its evidence is this certificate, after the belief's proofs.
    """
    program, sources = belief.polytope.program(), belief.sources
    kept = (np.where(multipliers > share * multipliers.max(), multipliers, 0) for share in SHARES)
    proof = next((weights for weights in kept if program.proves_empty(weights)), multipliers)
    conflict = np.unique(belief.constraints.source[proof > 0])
    conflict = conflict[np.argsort(sources.time[conflict], kind="stable")]
    nothing = Proof.of_nothing(belief.polytope, sources, 0, proof)
    named = [sources[number] for number in conflict.tolist()]
    return Inconsistent(f"at {belief.time} s", named, evidence=(*belief.proofs, nothing))


def _keys(i: Integers, j: Integers, robots: int) -> Integers:
    """Return a number for each pair; negative where i is WORLD."""
    return np.where(i == WORLD, -1, i * robots + j)
