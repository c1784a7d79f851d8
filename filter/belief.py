"""What is known at one time: the polytope, the headings, and a region for each robot."""

from __future__ import annotations

from dataclasses import dataclass, field, fields, replace

import numpy as np

from filter.angles import AngularIntervals
from filter.arrays import Array, Floats, Integers, read_only
from filter.constraints import Constraints
from filter.polygon import Polygon
from filter.polytope import Polytope
from filter.projection import Reason, performance_ratio

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


@dataclass(frozen=True, eq=False)
class Region:
    """Where one robot is.

    Attributes:
        outer: Contains the robot, as long as every declared bound holds.
        inner: Every point of it is possible; None when nothing is known from inside (after a prediction, say).
        searches: How many directions were searched.
        reason: Why the search ended, or None when there was none.
        causes: For each edge of the outer polygon the numbers of its sources in the belief's table; for a side of
            the box what the box comes from.
    """

    outer: Polygon
    inner: Polygon | None
    searches: int
    reason: Reason | None
    causes: tuple[Integers, ...]

    def __post_init__(self) -> None:
        object.__setattr__(self, "causes", tuple(map(read_only, self.causes)))

    @property
    def performance_ratio(self) -> float:
        """Area inside over area outside (eq. 7), in [0, 1]; 0 without an inner polygon."""
        return performance_ratio(self.inner, self.outer)


@dataclass(frozen=True, eq=False)
class Belief:
    """What the filter knows at one time.

    Attributes:
        time: When [s].
        polytope: Where the whole team can be.
        headings: (n) arcs that contain the robots' headings.
        regions: (n) where each robot is.
        sources: What produced the rows and the edges.
    """

    time: float
    polytope: Polytope
    headings: AngularIntervals
    regions: tuple[Region, ...]
    sources: Sources

    @classmethod
    def compact(
        cls, time: float, polytope: Polytope, headings: AngularIntervals, regions: tuple[Region, ...], sources: Sources
    ) -> Belief:
        """Return a belief whose table holds only the sources that its rows and edges name."""
        rows = polytope.constraints
        used = np.unique(
            np.concatenate([rows.source, polytope.origin, *(cause for region in regions for cause in region.causes)])
        )
        regions = tuple(
            replace(region, causes=tuple(np.searchsorted(used, cause) for cause in region.causes)) for region in regions
        )
        renumbered = replace(rows, source=np.searchsorted(used, rows.source))
        origin = np.searchsorted(used, polytope.origin)
        return cls(time, replace(polytope, constraints=renumbered, origin=origin), headings, regions, sources.select(used))

    @property
    def constraints(self) -> Constraints:
        """The polytope's rows."""
        return self.polytope.constraints

    def causes(self, robot: int, edge: int) -> tuple[Source, ...]:
        """Return what an edge of a robot's outer polygon was proved from, one step back."""
        return tuple(self.sources[int(number)] for number in self.regions[robot].causes[edge])
