"""Where the team can be after a motion: the Minkowski sum of the polytope and of the sets of displacements. After changes, too.

Every row is moved outward by as much as the robots can have gone in its own direction. Where two of them meet in a corner, the
moved ones meet in a mitre, farther out than any point of the corner has gone. The sum of two polygons has the edge normals of
both; so rows through the corners, in the normals of the displacements' own edges, are moved as well. They follow from the two.
"""

from dataclasses import replace

import numpy as np

from filter.arrays import Array
from filter.errors import Inconsistent
from filter.geometry.polygon import SIDES
from filter.linear.certify import imply
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Source, Sources
from filter.sensing.motion import Displacements
from filter.sensing.since import Moves
from filter.sets.belief import Belief
from filter.sets.proof import Proof


def moved(belief: Belief, time: float, moves: Displacements | Moves, arena: Array, corners: bool) -> tuple[Polytope, Sources]:
    """Return the polytope after moves within the arena (2, 2) [m], and its sources, with rows through corners or without.

    Raises `Inconsistent` if a robot has left the arena.
    """
    robots = np.arange(len(belief.headings))
    by = moves.support(np.repeat(robots, len(SIDES)), np.tile(SIDES, (len(robots), 1))).reshape(-1, len(SIDES))
    lower = np.maximum(_outward(belief.polytope.lower, -by[:, 2:], -np.inf), arena[0])
    upper = np.minimum(_outward(belief.polytope.upper, by[:, :2], np.inf), arena[1])
    outside = np.flatnonzero((lower > upper).any(axis=1))
    if len(outside):
        robot = int(outside[0])
        no_rows = belief.constraints.select(np.zeros(0, dtype=np.int64))
        nothing = Proof.of_nothing(Polytope(no_rows, lower, upper), belief.sources, robot, np.zeros(0))
        raise Inconsistent(f"has left the arena by {time} s", [Source("region", belief.time, robot)], robot, (nothing,))
    rows, sources = belief.constraints, belief.sources
    if corners:
        through, sources = rows_through_corners(belief, moves)
        rows = Constraints.concatenate([rows, through])
    return Polytope(moves.moved(rows), lower, upper, belief.polytope.origin), sources


def rows_through_corners(belief: Belief, moves: Displacements | Moves) -> tuple[Constraints, Sources]:
    """Return rows through corners of polygons, and sources: of all robots and pairs that the last update proved something of.

    The normals are those of the edges of what the robots' displacements, or the differences of those, can be.
    """
    polytope, bodies = belief.polytope, len(belief.headings) + 1
    proofs = (*belief.proofs_of("regions"), *belief.proofs_of("pairs"))
    proved = [(proof.i - WORLD) * bodies + proof.j for proof in proofs]
    key = np.unique(np.concatenate([np.zeros(0, dtype=np.int64), *proved]))
    i, j = key // bodies + WORLD, key % bodies
    normals = moves.normals
    wanted = np.concatenate([normals[j], np.where((i != WORLD)[:, None, None], -normals[i], np.nan)], axis=1)
    whose, which = np.ascontiguousarray(np.nonzero(np.isfinite(wanted[:, :, 0])))
    directions = wanted[whose, which]
    clipped, offsets = polytope.of(i, j), np.empty(len(whose))
    unused = np.empty((len(whose), 2), dtype=np.int64), np.empty((len(whose), 2))
    outlines = clipped.polygons.normals, clipped.polygons.vertices, clipped.behind, clipped.polygons.first
    box = polytope.lower, polytope.upper
    imply((offsets, *unused), (i, j), outlines, (whose, directions), polytope.constraints.rows, box)
    table, numbers = belief.sources.extended("region", belief.time, j, i)
    return Constraints(i[whose], j[whose], directions, offsets, numbers[whose]), table


def _outward(corner: Array, by: Array, outward: float) -> Array:
    """Return corners moved by so much, rounded outward (an infinity); those that do not move stay as they are."""
    return np.asarray(np.where(by == 0, corner, np.nextafter(corner + by, outward)))


def with_robot(belief: Belief, robot: int, alone: Belief) -> Belief:
    """Return what is known if one robot is what another belief says of its only one, whatever was known of it before."""
    table, number = belief.sources.extended("initial set", belief.time, [robot])
    mine, of_others = alone.polytope, (belief.constraints.i != robot) & (belief.constraints.j != robot)
    whole = np.ones(len(mine.constraints), dtype=np.int64)
    own = replace(mine.constraints, j=robot * whole, source=number * whole)
    lower, upper, origin = belief.polytope.lower.copy(), belief.polytope.upper.copy(), belief.polytope.origin.copy()
    lower[robot], upper[robot], origin[robot] = mine.lower[0], mine.upper[0], number[0]
    rows = Constraints.concatenate([belief.constraints.select(of_others), own])
    headings, slices = belief.headings.replaced(np.array([robot]), alone.headings), belief.slices.without(np.array([robot]))
    here, polytope = belief.guarantee.with_again(robot), Polytope(rows, lower, upper, origin)
    return Belief(belief.time, polytope, headings, table, here, slices=slices).compact()


def without_robot(belief: Belief, robot: int) -> Belief:
    """Return what is known if one robot is away: what tied others to it is gone."""
    tied = (belief.constraints.i == robot) | ((belief.constraints.i != WORLD) & (belief.constraints.j == robot))
    polytope = belief.polytope.with_constraints(belief.constraints.select(~tied))
    slices = belief.slices.without(np.array([robot]))
    return Belief(
        belief.time, polytope, belief.headings, belief.sources, belief.guarantee.without(robot), slices=slices
    ).compact()
