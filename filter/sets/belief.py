"""What is known at one time: the polytope, the headings, a region for each robot, why, and what happened on the way."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from filter.arrays import Array, Floats, Integers, read_only, whole_number
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.sets.regions import Regions

KINDS = ("initial set", "compass", "bearing", "range", "region")


@dataclass(frozen=True)
class Source:
    """What produced a constraint.

    Attributes:
        kind: "initial set", "compass", "bearing", "range", "region" (an earlier outer polygon) or "heading".
        time: When [s].
        robot: Who measured, or whose region or heading it is.
        target: What was measured, or None.
    """

    kind: str
    time: float
    robot: int
    target: int | None = None

    def __str__(self) -> str:
        who = f"robot {self.robot}" + (f" to {self.target}" if self.target is not None else "")
        return f"{self.kind} of {who} at {self.time:.3f} s"


@dataclass(frozen=True, eq=False)
class Sources:
    """The table that the rows' source numbers point into.

    Attributes:
        kind: (k,) index into KINDS.
        time: (k,) [s].
        robot: (k,) who.
        target: (k,) what, -1 for nothing.
    """

    kind: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    time: Array = field(default_factory=lambda: np.zeros(0))
    robot: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))
    target: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        for column in fields(self):
            object.__setattr__(self, column.name, read_only(getattr(self, column.name)))

    def __len__(self) -> int:
        return len(self.kind)

    def __getitem__(self, number: int) -> Source:
        target = int(self.target[number])
        return Source(
            KINDS[self.kind[number]], float(self.time[number]), int(self.robot[number]), target if target >= 0 else None
        )

    def extended(self, kind: str, time: float, robot: Floats, target: Floats = -1) -> tuple[Sources, Integers]:
        """Return the table with (k) more entries, and their numbers."""
        robots, targets = np.broadcast_arrays(np.asarray(robot, dtype=np.int64), np.asarray(target, dtype=np.int64))
        more = (np.full(len(robots), KINDS.index(kind)), np.full(len(robots), time), robots, targets)
        joined = [np.concatenate([getattr(self, column.name), new]) for column, new in zip(fields(self), more, strict=True)]
        return Sources(*joined), np.arange(len(self), len(self) + len(robots))

    def select(self, numbers: Integers) -> Sources:
        """Return the table of some entries."""
        return Sources(*(getattr(self, column.name)[numbers] for column in fields(self)))


@dataclass(frozen=True)
class Rejected:
    """A measurement that was dropped, as the filter's policy says, for measurements to agree again.

    Attributes:
        source: What was dropped.
        conflict: What was proved to exclude one another, the dropped one with it or resting on it.
    """

    source: Source
    conflict: tuple[Source, ...]

    def __str__(self) -> str:
        return f"rejected {self.source}; in conflict: {'; '.join(map(str, self.conflict))}"


@dataclass(frozen=True)
class Fallback:
    """A solver's answers were no good, and others were asked for.

    Attributes:
        robot: Whose region was searched, or None for the deepest point of the whole team.
        failed: The solvers whose answers were no good, in the order they were asked.
        used: The solver whose answers were good, or None: what is proved anyway, and what was propagated, has to do.
        seen_from: The other robot of a pair, if it was the region of one seen from the other.
    """

    robot: int | None
    failed: tuple[str, ...]
    used: str | None
    seen_from: int | None = None

    def __str__(self) -> str:
        what = "the deepest point" if self.robot is None else f"the region of robot {self.robot}"
        what += "" if self.seen_from is None else f" seen from robot {self.seen_from}"
        return f"{what}: no good answer of {', '.join(self.failed)}, {self.used or 'nobody'} took over"


Event = Rejected | Fallback


@dataclass(frozen=True, eq=False)
class Proof:
    """Claims that everything in a polytope satisfies normal . (x_j - x_i) <= offset, with the multipliers that prove them.

    A claim holds because, with the multipliers y of its rows, the normal c and the box,
    the greatest value of (c - A'y) . x over the box, plus y . b, is no greater than its offset: in exact arithmetic.

    Attributes:
        polytope: Rows and box; its rows' sources are numbers in the table below.
        sources: What produced the rows.
        i: (k,) robot, or WORLD for a claim on the position of one robot alone.
        j: (k,) robot.
        normal: (k, 2).
        offset: (k,) [m].
        claim: (m,) claim that each multiplier belongs to.
        row: (m,) row of the polytope that each multiplier belongs to.
        multiplier: (m,) above 0.
    """

    polytope: Polytope
    sources: Sources
    i: Integers
    j: Integers
    normal: Array
    offset: Array
    claim: Integers
    row: Integers
    multiplier: Array

    def __post_init__(self) -> None:
        for name in ("i", "j", "normal", "offset", "claim", "row", "multiplier"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.offset)

    def rests_on(self, claim: int) -> tuple[Integers, Array]:
        """Return the rows that a claim is proved from, and their multipliers."""
        where = np.flatnonzero(self.claim == claim)
        return self.row[where], self.multiplier[where]


@dataclass(frozen=True, eq=False)
class Belief:
    """What the filter knows at one time.

    Attributes:
        time: When [s].
        polytope: Where the whole team can be.
        headings: (n) arcs that contain the robots' headings.
        regions: (n) where each robot is.
        sources: What produced the rows and the edges.
        events: What the last update dropped, and where its solvers failed.
        proofs: Why every edge of every region holds, every side of the polytope's box, and every edge of the pairs that
            were projected, as of the last update; none after a prediction.
    """

    time: float
    polytope: Polytope
    headings: AngularIntervals
    regions: Regions
    sources: Sources
    events: tuple[Event, ...] = ()
    proofs: tuple[Proof, ...] = ()

    def compact(self) -> Belief:
        """Return the same with a table that holds only the sources that rows, edges and boxes name."""
        rows, origin, cause = self.polytope.constraints, self.polytope.origin, self.regions.cause
        used = np.zeros(len(self.sources), dtype=bool)
        for numbers in (rows.source, origin, cause):
            used[numbers] = True
        now = np.cumsum(used) - 1
        polytope = replace(self.polytope, constraints=replace(rows, source=now[rows.source]), origin=now[origin])
        regions = replace(self.regions, cause=now[cause])
        return replace(self, polytope=polytope, regions=regions, sources=self.sources.select(np.flatnonzero(used)))

    @property
    def constraints(self) -> Constraints:
        """The polytope's rows."""
        return self.polytope.constraints

    def causes(self, robot: int, edge: int) -> tuple[Source, ...]:
        """Return what an edge of a robot's outer polygon was proved from, one step back.

        Raises:
            InvalidInput: There is no such robot, or no such edge.
        """
        causes = self.regions[whole_number("robot", robot, 0, len(self.regions) - 1)].causes
        return tuple(self.sources[int(number)] for number in causes[whole_number("edge", edge, 0, len(causes) - 1)])
