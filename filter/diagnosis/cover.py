"""What holds whichever of several beliefs is right: hulls of regions, and arcs around headings; of pairs and poses, too."""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace

import numpy as np

from filter.arrays import Array, Integers
from filter.geometry.angles import ANGLE_ROUNDING, AngularIntervals, wrap
from filter.geometry.around import hulls_of, lines_around
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.poses.slices import NARROW_HEADING, Slices, regrouped
from filter.projection.claims import Outlines
from filter.sets.belief import Belief
from filter.sets.proof import Evidence, Proof

Seen = Callable[[Belief, tuple[Integers, Integers]], Outlines]  # where robots of pairs are, one seen from the other, and why


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


def united(beliefs: Sequence[Belief], seen: Seen, slices: int) -> tuple[Belief, tuple[Evidence, ...]]:
    """Return what holds in each of some beliefs of one time, and in each what proves what it says of pairs.

    That is with rows on pairs, and so many slices of a robot at most; of one alone it is that, and there is nothing to prove.
    """
    if len(beliefs) == 1:
        return replace(beliefs[0], events=(), proofs=()), ()
    around, proofs = _with_pairs(cover_of(beliefs), beliefs, seen)
    return replace(around, slices=_slices_of(around, beliefs, slices)).compact(), proofs


def _with_pairs(around: Belief, beliefs: Sequence[Belief], seen: Seen) -> tuple[Belief, tuple[Evidence, ...]]:
    """Return a cover with the hulls of what each belief says of pairs that all of them have rows on; and of each why."""
    rows, robots = around.constraints, len(around.headings)
    keys = set.intersection(*(set(_pairs(belief, robots).tolist()) for belief in beliefs))
    if not keys:
        return around, ()
    i, j = np.divmod(np.array(sorted(keys)), robots)
    outlines = [seen(belief, (i, j)) for belief in beliefs]
    hulls = hulls_of([each.outer for each in outlines])
    table, numbers = around.sources.extended("pair", around.time, i, j)
    mutual = Constraints(i[hulls.owner], j[hulls.owner], hulls.normals, hulls.offsets, numbers[hulls.owner])
    polytope = around.polytope.with_constraints(Constraints.concatenate([rows, mutual]))
    why = (Proof.of_edges(one.polytope, one.sources, each, (i, j)) for one, each in zip(beliefs, outlines, strict=True))
    return replace(around, polytope=polytope, sources=table), tuple(why)


def _pairs(belief: Belief, robots: int) -> Integers:
    """Return a number for each pair that a belief has rows on."""
    rows = belief.constraints
    mutual = rows.i != WORLD
    return np.unique(rows.i[mutual] * robots + rows.j[mutual])


def _slices_of(around: Belief, beliefs: Sequence[Belief], most: int) -> Slices:
    """Return slices around those of all beliefs, of robots whose heading is wide; a belief without them is one."""
    wide = np.unique(np.concatenate([belief.slices.robot for belief in beliefs]))
    wide = wide[around.headings.bound[wide] > NARROW_HEADING] if most else wide[:0]
    return Slices.concatenate([Slices.none(), *(_of_robot(around, beliefs, robot, most) for robot in wide.tolist())])


def _of_robot(around: Belief, beliefs: Sequence[Belief], robot: int, most: int) -> Slices:
    parts = Slices.concatenate([part for belief in beliefs for part in _poses(belief, robot)])
    arcs, heading = np.stack([parts.centre, parts.bound], axis=1), around.headings
    whole = np.array([heading.centre[robot], heading.bound[robot]])
    table = regrouped(whole, (np.arange(len(parts)), arcs, np.ascontiguousarray(parts.reach)), len(parts), most)
    return Slices.of_table(np.full(len(table), robot), table)


def _poses(belief: Belief, robot: int) -> Iterator[Slices]:
    """Yield the slices of a robot, or one around all that is known of its pose."""
    mine = belief.slices.of(robot)
    if len(mine):
        yield mine
        return
    yield Slices.around(robot, belief.regions.outer[robot], belief.headings)
