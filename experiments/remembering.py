"""A filter that takes more along from step to step, to tell what the filter's forgetting costs, and where; slower by far.

A prediction moves rows outward one by one. Two things are lost there that more rows would keep: what the whole team knows of a
pair, as only single robots are projected; and round corners, as where two rows meet the moved ones leave a mitre. Both kinds
of rows are implied by the belief, so to add them is sound; moved, they are implied no more.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array
from filter.belief import Belief
from filter.constraints import WORLD, Constraints
from filter.measurements import Odometry
from filter.polygon import Polygon
from filter.projection import NOTHING, relative_position
from filter.projector import project_all
from filter.set_membership import SetMembershipFilter

# Neighbouring rows turn by no more than this once corners are kept [rad].
CORNERS = np.pi / 18


@dataclass(frozen=True, eq=False)
class RememberingFilter(SetMembershipFilter):
    """The filter, but that a belief is given rows it implies before it is predicted.

    Attributes:
        pairs: Whether to project the team onto every pair that has rows, too.
        corners: Whether to add lines through the corners of regions and pairs.
    """

    pairs: bool = False
    corners: bool = False

    def predict(self, belief: Belief, time: float, odometry: Odometry | None = None) -> Belief:
        """Return the belief at a later time, as `SetMembershipFilter.predict` does."""
        return super().predict(self._with_implied(belief), time, odometry)

    def _with_implied(self, belief: Belief) -> Belief:
        around = {(WORLD, robot): region.outer for robot, region in enumerate(belief.regions)} if self.corners else {}
        around |= self._around_pairs(belief) if self.pairs or self.corners else {}
        if not around:
            return belief
        i, j = np.array(list(around)).T
        sources, numbers = belief.sources.extended("region", belief.time, j, i)
        rows = [belief.constraints]
        for (first, second), polygon, number in zip(around, around.values(), numbers, strict=True):
            normals, offsets = self._lines(polygon)
            whose = np.full(len(offsets), first), np.full(len(offsets), second)
            rows.append(Constraints(*whose, normals, offsets, np.full(len(offsets), number)))
        polytope = belief.polytope.with_constraints(Constraints.concatenate(rows))
        return replace(belief, polytope=polytope, sources=sources)

    def _around_pairs(self, belief: Belief) -> dict[tuple[int, int], Polygon]:
        """Return a polygon around x_j - x_i for each pair that has rows: projected, or of the pair's rows alone."""
        polytope, rows, robots = belief.polytope, belief.constraints, self.team.robots
        pairs = sorted(set(zip(rows.i[rows.i >= 0].tolist(), rows.j[rows.i >= 0].tolist(), strict=True)))
        if not self.pairs:
            i, j = np.array(pairs, dtype=np.int64).reshape(-1, 2).T
            return dict(zip(pairs, polytope.of_pairs(i, j).polygons, strict=True))
        planes = [relative_position(j, i, robots) for i, j in pairs]
        found = project_all(polytope.program(), planes, [NOTHING] * len(pairs), self.solvers, self.stop).complete
        return {pair: each.outer for pair, each in zip(pairs, found, strict=bool(found))}

    def _lines(self, polygon: Polygon) -> tuple[Array, Array]:
        """Return the half-planes of a polygon, with others through its corners if these are to be kept."""
        if not self.corners:
            return polygon.normals, polygon.offsets
        more = between(polygon.normals)
        return np.concatenate([polygon.normals, more]), np.concatenate([polygon.offsets, polygon.support(more)])


def between(normals: Array) -> Array:
    """Return (k, 2) directions between neighbouring (e, 2) ones, counter-clockwise: no turn is greater than `CORNERS` then."""
    angle = np.arctan2(normals[:, 1], normals[:, 0])
    turn = np.mod(np.roll(angle, -1) - angle, 2 * np.pi)
    pieces = np.ceil(turn / CORNERS).astype(int)
    more = [angle[k] + turn[k] * np.arange(1, pieces[k]) / pieces[k] for k in range(len(angle))]
    towards = np.concatenate([np.zeros(0), *more])
    return np.stack([np.cos(towards), np.sin(towards)], axis=1)
