"""What is known at one time: the polytope, the headings, a region for each robot, why, and what happened on the way."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from filter.arrays import whole_number
from filter.geometry.angles import AngularIntervals
from filter.guarantee import Guarantee
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Source, Sources, in_order
from filter.poses.slices import Slices
from filter.projection.fallback import Fallback
from filter.records.names import InWords
from filter.records.odometry import Odometry
from filter.sets.proof import Bounded, Evidence, Proof, causes_of
from filter.sets.regions import Regions


@dataclass(frozen=True)
class Rejected(InWords):
    """A measurement that was dropped, as the filter's policy says, for measurements to agree again.

    Attributes:
        source: What was dropped.
        conflict: What was proved to exclude one another, the dropped one with it or resting on it.
    """

    source: Source
    conflict: tuple[Source, ...]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        return f"rejected {words(self.source)}; in conflict: {'; '.join(map(words, self.conflict))}"


Event = Rejected | Fallback


@dataclass(frozen=True, eq=False)
class Moved:
    """What a prediction was made from, so that the next update can say whether the motion is at fault.

    Attributes:
        before: The belief before; what that was made from is left out, or all would be kept for ever.
        odometry: How the robots moved since, or None where nothing was measured of that.
    """

    before: Belief
    odometry: Odometry | None


@dataclass(frozen=True, eq=False)
class Belief:
    """What the filter knows at one time.

    Attributes:
        time: When [s].
        polytope: Where the whole team can be.
        headings: (n) arcs that contain the robots' headings.
        sources: What produced the rows and the edges.
        guarantee: Suspended since the first measurement that was ever rejected: some bound was broken, nobody knows which.
        found: (n) where each robot is, as the last update found; None at the start and after a prediction.
        events: What the last update dropped, and where its walks and solvers failed.
        proofs: Why every edge of every region holds, every side of the polytope's box, and every edge of the pairs that
            were projected, as of the last update; before them what was proved case by case, and what directions were read
            from. Where an update took several rounds, one after the other. None after a prediction.
        moved: What a prediction was made from; None at the start and after an update.
        slices: The poses of robots whose headings are wide, position and heading together.
    """

    time: float
    polytope: Polytope
    headings: AngularIntervals
    sources: Sources
    guarantee: Guarantee
    found: Regions | None = None
    events: tuple[Event, ...] = ()
    proofs: tuple[Evidence, ...] = ()
    moved: Moved | None = None
    slices: Slices = field(default_factory=Slices.none)

    @cached_property
    def regions(self) -> Regions:
        """(n) where each robot is: as the last update found, or else as the rows on each robot alone tell at a glance."""
        return self.found or Regions.at_a_glance(self.polytope)

    def compact(self) -> Belief:
        """Return the same with a table that holds only the sources that rows, edges and boxes name."""
        rows, origin = self.polytope.constraints, self.polytope.origin
        cause = self.found.cause if self.found else origin
        used = np.zeros(len(self.sources), dtype=bool)
        used[np.concatenate([rows.source, origin, cause])] = True
        now = np.cumsum(used) - 1
        polytope = replace(self.polytope, constraints=rows.with_sources(now[rows.source]), origin=now[origin])
        found = replace(self.found, cause=now[cause]) if self.found else None
        return replace(self, polytope=polytope, found=found, sources=self.sources.select(np.flatnonzero(used)))

    def with_robot(self, robot: int, alone: Belief) -> Belief:
        """Return what is known if one robot is what another belief says of its only one, whatever was known of it before."""
        table, number = self.sources.extended("initial set", self.time, [robot])
        mine, of_others = alone.polytope, (self.constraints.i != robot) & (self.constraints.j != robot)
        whole = np.ones(len(mine.constraints), dtype=np.int64)
        own = replace(mine.constraints, j=robot * whole, source=number * whole)
        lower, upper, origin = self.polytope.lower.copy(), self.polytope.upper.copy(), self.polytope.origin.copy()
        lower[robot], upper[robot], origin[robot] = mine.lower[0], mine.upper[0], number[0]
        rows = Constraints.concatenate([self.constraints.select(of_others), own])
        headings, slices = self.headings.replaced(np.array([robot]), alone.headings), self.slices.without(np.array([robot]))
        here, polytope = self.guarantee.with_again(robot), Polytope(rows, lower, upper, origin)
        return Belief(self.time, polytope, headings, table, here, slices=slices).compact()

    def without_robot(self, robot: int) -> Belief:
        """Return what is known if one robot is away: what tied others to it is gone."""
        tied = (self.constraints.i == robot) | ((self.constraints.i != WORLD) & (self.constraints.j == robot))
        polytope = self.polytope.with_constraints(self.constraints.select(~tied))
        slices = self.slices.without(np.array([robot]))
        return Belief(self.time, polytope, self.headings, self.sources, self.guarantee.without(robot), slices=slices).compact()

    @property
    def constraints(self) -> Constraints:
        """The polytope's rows."""
        return self.polytope.constraints

    def proofs_of(self, what: Bounded) -> Iterator[Proof]:
        """Yield the proofs of one kind of claims, one for each round of the last update."""
        return (proof for proof in self.proofs if isinstance(proof, Proof) and proof.of == what)

    def causes(self, robot: int, edge: int) -> tuple[Source, ...]:
        """Return what an edge of a robot's outer polygon was proved from, one step back; `InvalidInput` if there is none."""
        region = self.regions[whole_number("robot", robot, 0, len(self.regions) - 1)]
        place = whole_number("edge", edge, 0, len(region.causes) - 1)
        proofs = tuple(proof for proof in self.proofs if isinstance(proof, Proof))
        last = {self.sources[int(number)] for number in region.causes[place]}
        found = causes_of(proofs, self.time, (WORLD, robot, region.outer.normals[place]), last)
        return tuple(sorted(found, key=in_order))
