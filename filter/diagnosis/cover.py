"""What holds whichever of several beliefs is right: hulls of regions, and arcs around headings."""

from collections.abc import Sequence

import numpy as np

from filter.arrays import Array
from filter.geometry.angles import ANGLE_ROUNDING, AngularIntervals, wrap
from filter.geometry.many import Polygons
from filter.geometry.polygon import SIDES, Polygon
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.sets.belief import Belief


def cover_of(beliefs: Sequence[Belief]) -> Belief:
    """Return what holds in each of some beliefs of one time, without rows on pairs, events and proofs.

    The guarantee is that of the first one.
    """
    first, robots = beliefs[0], np.arange(len(beliefs[0].headings))
    hulls = [hull_of([belief.regions.outer[robot] for belief in beliefs]) for robot in robots.tolist()]
    table, numbers = Sources().extended("region", first.time, robots)
    j = np.repeat(robots, [len(hull.offsets) for hull in hulls])
    normals, offsets = (np.concatenate([getattr(hull, name) for hull in hulls]) for name in ("normals", "offsets"))
    lower = np.min([belief.polytope.lower for belief in beliefs], axis=0)
    upper = np.max([belief.polytope.upper for belief in beliefs], axis=0)
    rows = Constraints(np.full(len(j), WORLD), j, normals, offsets, numbers[j])
    headings = arcs_around([belief.headings for belief in beliefs])
    return Belief(first.time, Polytope(rows, lower, upper, numbers), headings, table, first.guarantee)


def hulls_of(several: Sequence[Polygons]) -> Polygons:
    """Return (n) polygons, each around its own ones in several lists of n."""
    return Polygons.of([hull_of([each[k] for each in several]) for k in range(len(several[0]))])


def hull_of(polygons: Sequence[Polygon]) -> Polygon:
    """Return a polygon around others: it errs outward, or is the one if they are the same."""
    first = polygons[0]
    if all(np.array_equal(first.offsets, each.offsets) and np.array_equal(first.normals, each.normals) for each in polygons):
        return first
    normals = Polygon.hull(np.concatenate([polygon.vertices for polygon in polygons])).normals
    offsets, sides = (np.max([polygon.support(each) for polygon in polygons], axis=0) for each in (normals, SIDES))
    return Polygon.from_half_planes(normals, offsets, -sides[2:], sides[:2])


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
