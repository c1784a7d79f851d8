"""What holds whichever of several beliefs is right: hulls of regions, and arcs around headings."""

from collections.abc import Sequence

import numpy as np

from filter.arrays import Array
from filter.geometry.angles import ANGLE_ROUNDING, AngularIntervals, wrap
from filter.geometry.around import lines_around
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.sets.belief import Belief


def cover_of(beliefs: Sequence[Belief]) -> Belief:
    """Return what holds in each of some beliefs of one time, without rows on pairs, events and proofs.

    The guarantee is that of the first one.
    """
    first, robots = beliefs[0], np.arange(len(beliefs[0].headings))
    normals, offsets, begin = lines_around([belief.regions.outer for belief in beliefs])
    table, numbers = Sources().extended("region", first.time, robots)
    j = np.repeat(robots, np.diff(begin))
    lower = np.min([belief.polytope.lower for belief in beliefs], axis=0)
    upper = np.max([belief.polytope.upper for belief in beliefs], axis=0)
    rows = Constraints(np.full(len(j), WORLD), j, normals, offsets, numbers[j])
    headings = arcs_around([belief.headings for belief in beliefs])
    return Belief(first.time, Polytope(rows, lower, upper, numbers), headings, table, first.guarantee)


def arcs_around(several: Sequence[AngularIntervals]) -> AngularIntervals:
    """Return (n) arcs, each around its own ones in several lists of n; they err outward."""
    centres, bounds = np.array([arcs.centre for arcs in several]), np.array([arcs.bound for arcs in several])
    found: list[Array] = [np.zeros(len(several[0])), np.full(len(several[0]), np.pi)]
    for reference in centres:
        away = wrap(centres - reference)
        low, high = (away - bounds).min(axis=0), (away + bounds).max(axis=0)
        middle, half = reference + (low + high) / 2, (high - low) / 2 + 8 * ANGLE_ROUNDING
        narrower = half < found[1]
        found = [np.where(narrower, each, before) for each, before in zip((middle, half), found, strict=True)]
    return AngularIntervals.of_found(*found)
