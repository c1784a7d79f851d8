"""Each robot's region: the projection of the team's polytope, cut with what is known of that robot alone.

The outer polygon's edges become rows themselves: that is how the team's knowledge survives pruning.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from filter.arrays import Array, Integers
from filter.belief import Event, Fallback, Proof, Region, Sources
from filter.constraints import WORLD, Constraints
from filter.errors import Inconsistent
from filter.polygon import SIDES, Polygon
from filter.polytope import Polytope
from filter.projection import Projection, Stop, position
from filter.projector import Projections, project_all
from filter.solvers import Solver
from filter.window import Window
from filter.windows import project_windows

Scope = Literal["team"] | Window

# Boxes of so many robots are proved at a time.
TOGETHER = 32
# A conflict is named by the multipliers above one of these shares of the greatest: the first that leaves a proof.
SHARES = (1e-2, 1e-4, 1e-6, 0.0)


def regions_at_a_glance(polytope: Polytope) -> tuple[Region, ...]:
    """Return each robot's region from its own rows alone, without a search: larger, sound, nothing known from inside."""
    source = polytope.constraints.source
    regions = []
    for robot in range(len(polytope.lower)):
        outer, edges = polytope.of_robot(robot) or (Polygon.box(*polytope.box_of_robot(robot)), np.arange(-4, 0))
        causes = tuple(source[edge : edge + 1] if edge >= 0 else polytope.source_of_box(robot) for edge in edges)
        regions.append(Region(outer, None, 0, None, causes))
    return tuple(regions)


@dataclass(frozen=True, eq=False)
class Searched:
    """What a search of every robot's region gave.

    Attributes:
        polytope: With the regions' edges as the only rows on single robots and with the regions' boxes.
        regions: (n) where each robot is.
        sources: The table, with the regions entered.
        events: Where solvers failed.
        proofs: Of every edge, then of every side of the boxes.
    """

    polytope: Polytope
    regions: tuple[Region, ...]
    sources: Sources
    events: tuple[Event, ...]
    proofs: tuple[Proof, ...]


def searched(
    time: float, polytope: Polytope, sources: Sources, solvers: Sequence[Solver], *, stop: Stop, scope: Scope = "team"
) -> Searched:
    """Search every robot's region in the whole team's polytope, or in the robot's window of it.

    The solvers are asked in turn, the next one where an answer is no good. If none is good, the best of what they prove
    is taken; with what was propagated it is always a region, only a larger one.

    Raises:
        Inconsistent: The polytope is proved to be empty.
    """
    robots = len(polytope.lower)
    if isinstance(scope, Window):
        projections = project_windows(polytope, scope, solvers, stop)
    else:
        projections = _in_the_team(polytope, solvers, stop)
    if projections.contradiction is not None:
        conflict = sorted(_conflict(polytope, projections.contradiction), key=lambda k: (sources.time[k], k))
        raise Inconsistent(f"at {time} s", [sources[number] for number in conflict])
    table, numbers = sources.extended("region", time, np.arange(robots))
    regions, own, edged = [], [], []
    proofs: list[Proof] = []
    for robot, found in enumerate(projections.found):
        region, edges, proof = _region(polytope, sources, robot, found, int(numbers[robot]))
        regions.append(region)
        own.append(edges)
        edged.append(np.flatnonzero(found.edges >= 0))
        proofs.append(proof)
    pairs = polytope.constraints.select(polytope.constraints.i != WORLD)
    lower, upper, boxes = _boxes(polytope, table, regions, own, edged)
    smaller = Polytope(Constraints.concatenate([pairs, *own]), lower, upper, numbers)
    events = tuple(Fallback(each.plane, each.failed, each.used) for each in projections.failures)
    return Searched(smaller, tuple(regions), table, events, (*proofs, *boxes))


def _in_the_team(polytope: Polytope, solvers: Sequence[Solver], stop: Stop) -> Projections:
    robots, rows = len(polytope.lower), polytope.constraints
    own = [rows.rows_of(WORLD, robot) for robot in range(robots)]
    known = [(rows.normal[each], rows.offset[each]) for each in own]
    return project_all(polytope.program(), [position(robot, robots) for robot in range(robots)], known, solvers, stop)


def _conflict(polytope: Polytope, multipliers: Array) -> Integers:
    """Return the numbers of the sources of a Farkas certificate (r,), of as few rows as still prove it."""
    program = polytope.program()
    kept = (np.where(multipliers > share * multipliers.max(), multipliers, 0) for share in SHARES)
    proof = next((weights for weights in kept if program.proves_empty(weights)), multipliers)
    return np.unique(polytope.constraints.source[proof > 0])


def _region(
    polytope: Polytope, sources: Sources, robot: int, found: Projection, number: int
) -> tuple[Region, Constraints, Proof]:
    """Return a projection as a region with its causes, its edges as rows, and its edges' proofs."""
    rows = polytope.constraints.rows_of(WORLD, robot)
    known = polytope.constraints.source[rows]
    claim, row, weight = _claims(found, rows)
    cuts = np.searchsorted(claim, np.arange(1, len(found.edges)))
    box = polytope.source_of_box(robot)
    causes = tuple(np.unique(part) if len(part) else box for part in np.split(polytope.constraints.source[row], cuts))
    outer, whose, fixed = found.outer, np.full(len(found.edges), robot), np.flatnonzero(found.edges >= 0)
    proof = Proof(polytope, sources, whose, outer.normals, outer.offsets, claim, row, weight)
    source = np.append(np.full(found.searches, number), known)[found.edges[fixed]]
    edges = Constraints.on_robot(robot, outer.normals[fixed], outer.offsets[fixed], source)
    return Region(outer, found.inner, found.searches, found.reason, causes), edges, proof


def _claims(found: Projection, own: Integers) -> tuple[Integers, Integers, Array]:
    """Return which edge (m,) is proved by which row (m,) with which weight (m,); what was known proves itself."""
    edge_of = np.full(found.searches + len(own), -1)
    fixed = np.flatnonzero(found.edges >= 0)
    edge_of[found.edges[fixed]] = fixed
    weights, itself = found.weights, edge_of[found.searches :]
    claim = np.concatenate([edge_of[weights.direction], itself])
    row, weight = np.concatenate([weights.row, own]), np.concatenate([weights.weight, np.ones(len(own))])
    order = np.argsort(claim, kind="stable")
    order = order[np.searchsorted(claim[order], 0) :]  # without the directions and rows that are no edge
    return claim[order], row[order], weight[order]


def _boxes(
    polytope: Polytope, sources: Sources, regions: Sequence[Region], own: Sequence[Constraints], edged: Sequence[Integers]
) -> tuple[Array, Array, list[Proof]]:
    """Return lower and upper corners (n, 2) of proved boxes around the regions, within the polytope's, and the proofs.

    Args:
        polytope: Its box is where each proof starts.
        sources: The table of the rows.
        regions: (n) the regions.
        own: (n) the regions' edges as rows.
        edged: (n) the edge of the outer polygon that each of these rows is.
    """
    lower, upper, proofs = polytope.lower.copy(), polytope.upper.copy(), []
    for first in range(0, len(regions), TOGETHER):
        robots = np.arange(first, min(first + TOGETHER, len(regions)))
        rows = Constraints.concatenate(own[first : first + TOGETHER])
        multipliers = np.zeros((len(robots), 4, len(rows)))
        for k, robot in enumerate(robots.tolist()):
            multipliers[k][:, rows.j == robot] = _of_extreme_vertices(regions[robot].outer)[:, edged[robot]]
        weights = multipliers.reshape(4 * len(robots), len(rows))
        among = Constraints(rows.i, rows.j - first, rows.normal, rows.offset, rows.source)
        program = Polytope(among, polytope.lower[robots], polytope.upper[robots]).program()
        bounds = program.certified_bounds(np.kron(np.eye(len(robots)), SIDES), weights)
        high = np.minimum(upper[robots], bounds.reshape(-1, 4)[:, :2])
        low = np.maximum(lower[robots], -bounds.reshape(-1, 4)[:, 2:])
        good = robots[(low <= high).all(axis=1)]  # otherwise it is empty, which is for the next update to prove and to explain
        lower[good], upper[good] = low[good - first], high[good - first]
        claim, row = np.nonzero(weights)
        whole, normals = Polytope(rows, polytope.lower, polytope.upper), np.tile(SIDES, (len(robots), 1))
        proofs.append(Proof(whole, sources, np.repeat(robots, 4), normals, bounds, claim, row, weights[claim, row]))
    return lower, upper, proofs


def _of_extreme_vertices(outer: Polygon) -> Array:
    """Return (4, e) candidates for the multipliers of a polygon's extents: of the two edges that meet in an extreme vertex."""
    corner = np.argmax(SIDES @ outer.vertices.T, axis=1)
    first, second = outer.normals[corner - 1], outer.normals[corner]
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        turn = _cross(first, second)
        shares = np.stack([_cross(SIDES, second) / turn, _cross(first, SIDES) / turn])
    shares = np.where(np.isfinite(shares), np.maximum(shares, 0), 0)
    multipliers = np.zeros((4, len(outer.offsets)))
    sides = np.arange(4)
    multipliers[sides, corner - 1] = shares[0]
    multipliers[sides, corner] = shares[1]
    return multipliers


def _cross(a: Array, b: Array) -> Array:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]
