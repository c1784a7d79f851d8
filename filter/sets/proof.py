"""Why what an update claims is so: proofs by multipliers, and what an edge comes from."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from filter.arrays import Array, Frozen, Integers
from filter.errors import Inconsistent
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.linear.sources import Source, Sources
from filter.poses.cells import Cases
from filter.poses.votes import Polled
from filter.projection.claims import Outlines, Weights
from filter.sets.merged import Directions

Line = tuple[int, int, Array]  # robots i (or WORLD) and j, and a normal (2,)
Bounded = Literal["regions", "boxes", "pairs", "sides", "nothing"]


@dataclass(frozen=True, eq=False)
class Proof(Frozen):
    """Claims that everything in a polytope satisfies normal . (x_j - x_i) <= offset, with the multipliers that prove them.

    A claim holds because, with the multipliers y of its rows and the normal c, the greatest value of (c - A'y) . x over the
    box, plus y . b, is no greater than its offset: in exact arithmetic.

    Attributes:
        of: What is bounded: each robot's position by its region or its box, the positions of pairs as seen from one another,
            the sides to which targets are, or nothing at all: what has no length is said to be below 0, so nothing is possible.
        polytope: Rows and box; its rows' sources are numbers in the table below.
        sources: What produced the rows.
        i: (k,) robot, or WORLD for a claim on the position of one robot alone.
        j: (k,) robot.
        normal: (k, 2).
        offset: (k,) [m].
        weights: (k) the rows that each claim rests on, and their multipliers.
    """

    of: Bounded
    polytope: Polytope
    sources: Sources
    i: Integers
    j: Integers
    normal: Array
    offset: Array
    weights: Weights

    @classmethod
    def of_edges(cls, polytope: Polytope, sources: Sources, outlines: Outlines, whose: tuple[Integers, Integers]) -> Proof:
        """Return why every edge holds, of outlines of robots, or of pairs i, j."""
        i, j = (each[outlines.outer.owner] for each in whose)
        return cls(
            "regions" if (i == WORLD).all() else "pairs",
            polytope,
            sources,
            i,
            j,
            outlines.outer.normals,
            outlines.outer.offsets,
            outlines.weights,
        )

    @classmethod
    def of_nothing(cls, polytope: Polytope, sources: Sources, robot: int, multipliers: Array) -> Proof:
        """Return why a polytope is empty: its rows with multipliers (r,), or without any the box of a robot."""
        whose = np.array([WORLD]), np.array([robot])
        return cls("nothing", polytope, sources, *whose, np.zeros((1, 2)), np.zeros(1), Weights.of(multipliers[None]))

    def __len__(self) -> int:
        return len(self.offset)

    def rests_on(self, claim: int) -> tuple[Integers, Array]:
        """Return the rows that a claim is proved from, and their multipliers."""
        return self.weights.rests_on(claim)


Evidence = Proof | Cases | Directions | Polled


class After:
    """A context in which what raises `Inconsistent` tells what was proved before it, too."""

    def __init__(self, evidence: Sequence[Evidence]) -> None:
        self._evidence = evidence

    def __enter__(self) -> None: ...

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        if isinstance(error, Inconsistent):
            error.evidence = (*self._evidence, *error.evidence)


def causes_of(proofs: Sequence[Proof], time: float, line: Line, otherwise: set[Source]) -> set[Source]:
    """Return what an edge or a side of a box was proved from by the last of some proofs, before the update of a time [s].

    Without a proof that is what was said otherwise.
    """
    i, j, normal = line
    for last in range(len(proofs) - 1, -1, -1):
        proof = proofs[last]
        found, claims = set[Source](), np.flatnonzero((proof.i == i) & (proof.j == j) & (proof.normal == normal).all(axis=1))
        for source, row in _rests_on(proof, int(claims[0])) if len(claims) else ():
            is_of_now = source.kind == "region" and source.time == time
            found |= causes_of(proofs[:last], time, row, {source}) if is_of_now else {source}
        if found:
            return found
    return otherwise


def _rests_on(proof: Proof, claim: int) -> list[tuple[Source, Line]]:
    """Return the source of each row, and the row, that a claim rests on; without rows it is a side of the box."""
    rows, origin, (used, _) = proof.polytope.constraints, proof.polytope.origin, proof.rests_on(claim)
    if not len(used) and len(origin):
        robot = int(proof.j[claim])
        return [(proof.sources[int(origin[robot])], (WORLD, robot, proof.normal[claim]))]
    lines = ((int(rows.i[row]), int(rows.j[row]), rows.normal[row]) for row in used.tolist())
    return [(proof.sources[int(rows.source[row])], line) for row, line in zip(used.tolist(), lines, strict=True)]
