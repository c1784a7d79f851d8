"""What the whole team knows of pairs: projected like regions, so that it survives the motion of both robots.

A prediction moves every row on its own. What several rows say together of two robots has to be one row before, or it is lost.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from filter.arrays import Integers
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.budget import IsOver, never
from filter.projection.polygons_of import Stop
from filter.projection.team import project_pairs
from filter.projection.window import Window
from filter.sets.belief import Fallback, Sources
from filter.sets.refine import Scope, Searched, edges_as_rows, proof_of

# Where regions are found in the whole team, pairs are found among those near them: regions have taken the rest along already.
NEAR = Window(hops=2, robots=12)

Pairs = tuple[Integers, Integers]


def with_pairs(
    time: float,
    found: Searched,
    most: int,
    *,
    stop: Stop,
    scope: Scope = "team",
    is_over: IsOver = never,
    threads: int | None = None,
) -> Searched:
    """Return what was found with the projections of at most so many pairs as the rows on them, and why these hold.

    Walks that are lost are events; their pairs keep the rows they have, and so do those that time runs out on.
    """
    polytope, sources = found.polytope, found.sources
    i, j = pairs = chosen_pairs(polytope, sources, time, most)
    if not len(j):
        return found
    window = scope if isinstance(scope, Window) else NEAR
    mutual = project_pairs(polytope, pairs, window, stop, is_over=is_over, threads=threads)
    table, numbers = sources.extended("region", time, j, i)
    edges, _ = edges_as_rows(polytope, mutual.outlines, pairs, numbers)
    rows, robots = polytope.constraints, len(polytope.lower)
    others = rows.select(~np.isin(_keys(rows.i, rows.j, robots), _keys(i, j, robots)))
    lost = (Fallback(int(j[each.plane]), each.failed, each.used, int(i[each.plane])) for each in mutual.failures)
    return replace(
        found,
        polytope=polytope.with_constraints(Constraints.concatenate([others, edges])),
        sources=table,
        events=(*found.events, *lost),
        proofs=(*found.proofs, proof_of(polytope, sources, mutual.outlines, pairs)),
    )


def chosen_pairs(polytope: Polytope, sources: Sources, time: float, most: int) -> Pairs:
    """Return at most so many pairs i < j, (g) each: those just measured, then those longest ago, then those without rows."""
    rows, robots = polytope.constraints, len(polytope.lower)
    order, i, j, size = rows.grouped()
    if not most or robots < 2:
        return np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64)
    last = np.maximum.reduceat(sources.time[rows.source[order]], np.cumsum(size) - size)
    known = np.flatnonzero(i != WORLD)
    known = known[np.lexsort((last[known], last[known] < time))]
    i, j = i[known], j[known]
    if len(known) < most:
        first, second = np.triu_indices(robots, 1)
        others = ~np.isin(_keys(first, second, robots), _keys(i, j, robots))
        i, j = np.append(i, first[others]), np.append(j, second[others])
    return i[:most], j[:most]


def _keys(i: Integers, j: Integers, robots: int) -> Integers:
    """Return a number for each pair; negative where i is WORLD."""
    return np.where(i == WORLD, -1, i * robots + j)
