"""The outer polygons of a whole team, of robots or of pairs, and what every edge of them rests on."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import chain

import numpy as np

from filter.arrays import Array, Integers
from filter.geometry.polygon import Polygon
from filter.geometry.polygons import Cuts, Polygons, joined, places
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.projection.polygons_of import Projection, Reason
from filter.projection.projector import Failure
from filter.projection.walk import PROVED


@dataclass(frozen=True, eq=False)
class Outlines:
    """Polygons that contain robots, or pairs (x_j - x_i), each edge with its proof from the rows of a polytope.

    Attributes:
        outer: (n) polygons.
        behind: (e,) what is behind each edge: a row on the robot or the pair alone, -4 to -1 for a side of its box, PROVED for
            others.
        row: (m,) the rows that prove the edges, edge after edge.
        multiplier: (m,) of each, above 0.
        row_first: (e + 1,) where those of each edge begin.
        inner: (n) polygons of which every point is possible, or None.
        searches: (n,) how many directions were searched, or edges kept.
        reasons: (n) what decided that, or None.
    """

    outer: Polygons
    behind: Integers
    row: Integers
    multiplier: Array
    row_first: Integers
    inner: tuple[Polygon | None, ...]
    searches: Integers
    reasons: tuple[Reason | None, ...]

    @classmethod
    def at_a_glance(cls, cuts: Cuts, reason: Reason | None = None) -> Outlines:
        """Return what own rows and boxes say, without a projection: larger, sound, nothing known from inside."""
        alone, count = cuts.edges >= 0, len(cuts.polygons)
        first = np.concatenate([np.zeros(1, dtype=np.int64), np.cumsum(alone)])
        zeros, row = np.zeros(count, dtype=np.int64), cuts.edges[alone]
        return cls(cuts.polygons, cuts.edges, row, np.ones(len(row)), first, (None,) * count, zeros, (reason,) * count)

    @classmethod
    def of(cls, polytope: Polytope, robots: Integers, projections: Sequence[Projection]) -> Outlines:
        """Return projections of the polytope onto some robots' positions, which their own rows have cut."""
        behind, claims = [], []
        for robot, found in zip(robots.tolist(), projections, strict=True):
            own = polytope.constraints.rows_of(WORLD, robot)
            behind.append(np.concatenate([np.full(found.searches, PROVED), own, np.arange(-4, 0)])[found.edges])
            claims.append(_claims(found, own))
        counts = [np.bincount(claim, minlength=len(edges)) for (claim, _, _), edges in zip(claims, behind, strict=True)]
        return cls(
            Polygons.of([found.outer for found in projections]),
            np.concatenate([np.zeros(0, dtype=np.int64), *behind]),
            np.concatenate([np.zeros(0, dtype=np.int64), *(row for _, row, _ in claims)]),
            np.concatenate([np.zeros(0), *(weight for _, _, weight in claims)]),
            np.cumsum(np.concatenate([np.zeros(1, dtype=np.int64), *counts])),
            tuple(found.inner for found in projections),
            np.array([found.searches for found in projections], dtype=np.int64),
            tuple(found.reason for found in projections),
        )

    @classmethod
    def concatenate(cls, parts: Sequence[Outlines]) -> Outlines:
        """Return the outlines of all parts, in their order."""
        return cls(
            Polygons.concatenate([part.outer for part in parts]),
            np.concatenate([part.behind for part in parts]),
            np.concatenate([part.row for part in parts]),
            np.concatenate([part.multiplier for part in parts]),
            joined([part.row_first for part in parts]),
            tuple(chain.from_iterable(part.inner for part in parts)),
            np.concatenate([part.searches for part in parts]),
            tuple(chain.from_iterable(part.reasons for part in parts)),
        )

    def select(self, index: Integers) -> Outlines:
        """Return some of the outlines, by (k,) index."""
        edges, _ = places(self.outer.first, index)
        rows, first = places(self.row_first, edges)
        return Outlines(
            self.outer.select(index),
            self.behind[edges],
            self.row[rows],
            self.multiplier[rows],
            first,
            tuple(self.inner[k] for k in index),
            self.searches[index],
            tuple(self.reasons[k] for k in index),
        )


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


def in_order(pieces: Sequence[tuple[Integers, Outlines]]) -> Outlines:
    """Return the outlines of all n robots or pairs from pieces (numbers, their outlines); those without edges are left out."""
    numbers, every = np.concatenate([numbers for numbers, _ in pieces]), Outlines.concatenate([each for _, each in pieces])
    found = np.flatnonzero(np.diff(every.outer.first))
    wanted = found[np.argsort(numbers[found])]
    return every if np.array_equal(wanted, np.arange(len(numbers))) else every.select(wanted)


@dataclass(frozen=True, eq=False)
class Outlined:
    """What a projection of every robot, or of some pairs, gave.

    Attributes:
        outlines: (n) of all of them.
        failures: Where solvers failed.
    """

    outlines: Outlines
    failures: tuple[Failure, ...] = ()


@dataclass(frozen=True, eq=False)
class Contradiction:
    """A proof that a polytope is empty.

    Attributes:
        multipliers: (r,) of its rows.
    """

    multipliers: Array
