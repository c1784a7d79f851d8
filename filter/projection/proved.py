"""Projections of a polytope, from inside and from outside, each edge and each point proved (sections 5 and 6 of the paper).

A direction that was maximised gives a point of the projection and a line that supports it. The hull of the points is
inside, the intersection of the half-planes outside.
"""

from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Frozen, Integers
from filter.geometry.convex import EPSILON, SMALLEST
from filter.geometry.polygon import Polygon, clip
from filter.linear.program import LinearProgram
from filter.projection.claims import Weights
from filter.projection.stop import Reason

HalfPlanes = tuple[Array, Array]  # normals (k, 2) and offsets (k,)
NOTHING: HalfPlanes = (np.zeros((0, 2)), np.zeros(0))

# A polygon of less area than this share of its squared size is a segment, to rounding.
NO_AREA = 1e-12


@dataclass(frozen=True, eq=False)
class Projection(Frozen):
    """What is known of a projection after some searches.

    Attributes:
        outer: Contains the projection: proved.
        edges: (e,) the search behind each edge of the outer polygon; from s on which of k half-planes that were known
            anyway, from s + k on which side of the program's box.
        inner: Lies in the projection: its vertices are proved feasible. None when no point could be.
        directions: (s, 2) searched directions, of length 1.
        weights: The proof of each direction's edge.
        inner_areas: (s,) area inside after each search, as the solver has it [m2].
        outer_areas: (s,) area outside, likewise, infinite before the fourth [m2].
        reason: Why the search ended, by these areas.
        looseness: The most that what is proved in a direction differs from the point found for it, as a share of the
            box's extent; infinite when the solver gave up. A guess of the answers' quality, no proof of anything.
    """

    outer: Polygon
    edges: Integers
    inner: Polygon | None
    directions: Array
    weights: Weights
    inner_areas: Array
    outer_areas: Array
    reason: Reason
    looseness: float

    @property
    def searches(self) -> int:
        """Number of searches."""
        return len(self.directions)

    @property
    def performance_ratio(self) -> float:
        """Area inside over area outside (eq. 7), in [0, 1]; 0 without an inner polygon."""
        return performance_ratio(self.inner, self.outer)


def performance_ratio(inner: Polygon | None, outer: Polygon) -> float:
    """Return area inside over area outside (eq. 7), in [0, 1]; 1 for two polygons without area, 0 without an inner one."""
    if inner is None:
        return 0.0
    lower, upper = outer.bounds
    without = outer.area <= NO_AREA * float(((upper - lower) ** 2).sum())
    return 1.0 if without else min(1.0, inner.area / outer.area)


def position(robot: int, robots: int) -> Array:
    """Return D (2, 2 robots) of the projection onto a robot's position (eq. 2)."""
    return np.eye(2, 2 * robots, 2 * robot)


def certified_offsets(program: LinearProgram, D: Array, directions: Array, multipliers: Array) -> Array:
    """Return (s,) offsets of proved edges: direction (s, 2) . D x is nowhere greater in the program's polytope [m].

    The multipliers (s, r) are candidates for the proofs, from wherever: bad ones give large offsets, none a wrong one.
    """
    # What the rounding of direction . D can be worth; nothing for positions and their differences.
    exact = np.isin(D, (-1, 0, 1)).all(axis=0) & (np.count_nonzero(D, axis=0) <= 1)
    size = np.abs(directions) @ np.where(exact, 0.0, np.abs(D)) @ (np.abs(program.centre) + program.radius)
    return program.certified_bounds(directions @ D, multipliers) + 4 * EPSILON * size


def looseness(program: LinearProgram, D: Array, directions: Array, points: Array, certified: Array) -> float:
    """Return the greatest gap between (s,) edges and their (s, v) points, as a share of the extent of the box there."""
    if not np.isfinite(certified).all():
        return np.inf
    extent = np.abs(directions @ D) @ program.radius
    gap = np.abs(certified - ((points @ D.T) * directions).sum(axis=1))
    rounding = 16 * EPSILON * np.abs(certified)
    return float(np.max(np.where(gap > rounding, gap, 0) / np.maximum(extent + rounding, SMALLEST), initial=0))


def outer_polygon(program: LinearProgram, D: Array, edges: HalfPlanes, known: HalfPlanes) -> tuple[Polygon, Integers]:
    """Return a polygon around the projection {D x}, and what is behind each of its edges, as in `Projection`."""
    rounding = (4 + np.count_nonzero(D, axis=1)) * EPSILON * (np.abs(D) @ (np.abs(program.centre) + program.radius))
    middle, reach = D @ program.centre, np.abs(D) @ program.radius + rounding
    normals, offsets = np.concatenate([edges[0], known[0]]), np.concatenate([edges[1], known[1]])
    # Where these leave nothing, which nobody has proved with names, what was known and the box contain the projection, too.
    for begin in (0, len(edges[0])):
        kept = clip(normals[begin:], offsets[begin:], middle - reach, middle + reach)
        if kept is not None:
            return kept[0], begin + kept[1]
    return Polygon.box(middle - reach, middle + reach), len(offsets) + np.arange(4)


def inner_polygon(program: LinearProgram, D: Array, points: Array, interior: Array) -> Polygon | None:
    """Return the hull of (k, v) points, in the projection {D x}, or None where none of them is proved feasible.

    They are first pulled to an interior point (v,), as far as they need it.
    """
    pulled = program.pulled(points, interior)
    feasible = pulled[program.holds(pulled)]
    return Polygon.hull(feasible @ D.T) if len(feasible) else None
