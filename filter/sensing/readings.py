"""The measurements of one time in one order: whatever records they come in, shuffled, split or twice, no bit is another."""

from collections.abc import Sequence
from typing import Any, NamedTuple, TypeVar

import numpy as np

from filter.arrays import Integers
from filter.linear.sources import NOBODY, Kind, Source, Sources
from filter.records.measurements import Bearing, Compass, Measurement, Position, Range
from filter.records.record import field_names

KIND_OF: dict[type[Measurement], Kind] = {Compass: "compass", Bearing: "bearing", Range: "range", Position: "position"}
WHO = ("robot", "target")
NO_VALUES = (np.zeros(0), np.zeros(0, dtype=np.int64))  # columns of values, and of robots
AnyRecord = TypeVar("AnyRecord", Compass, Bearing, Range, Position)


class Readings(NamedTuple):
    """One record of each kind, with every single measurement once, sorted by its columns.

    Attributes:
        compasses: (c)
        bearings: (b)
        ranges: (r)
        positions: (p) half-planes
    """

    compasses: Compass
    bearings: Bearing
    ranges: Range
    positions: Position

    @classmethod
    def of(cls, time: float, measurements: Sequence[Measurement]) -> "Readings":
        """Return measurements that were taken at one time [s]."""
        return cls(
            _sorted(Compass, time, measurements),
            _sorted(Bearing, time, measurements),
            _sorted(Range, time, measurements),
            _sorted(Position, time, measurements),
        )

    def numbered(self, sources: Sources, robots: int) -> tuple[Sources, Integers]:
        """Enter what makes rows in a table; return it and numbers (b + r + p + n,) of these, and of the cells of n robots."""
        first = len(sources)
        for record in (self.bearings, self.ranges, self.positions):
            sources, _ = sources.extended(KIND_OF[type(record)], record.time, record.robot, targets_of(record))
        sources, _ = sources.extended("cells", self.ranges.time, np.arange(robots))
        return sources, np.arange(first, len(sources))

    def tie_robots(self, robots: int) -> bool:
        """Return whether one of n robots measured another."""
        return bool((self.bearings.target < robots).any() or (self.ranges.target < robots).any())

    def concerning(self, robot: int) -> list[Source]:
        """Return all readings by a robot, or of it."""
        found = list[Source]()
        for record in self:
            target = targets_of(record)
            table, _ = Sources().extended(KIND_OF[type(record)], record.time, record.robot, target)
            found += [table[k] for k in np.flatnonzero((record.robot == robot) | (target == robot)).tolist()]
        return list(dict.fromkeys(found))


def targets_of(record: Measurement) -> Integers:
    """Return (k,) the targets that are measured, NOBODY for what is of the robot alone."""
    return record.target if isinstance(record, Bearing | Range) else np.full(len(record.robot), NOBODY)


def _sorted(kind: type[AnyRecord], time: float, measurements: Sequence[Measurement]) -> AnyRecord:
    return kind.of_checked(time, _columns(kind, [each for each in measurements if isinstance(each, kind)]))


def _columns(kind: type[Measurement], records: Sequence[Any]) -> dict[str, Any]:
    names = field_names(kind)
    parts = [
        np.concatenate([NO_VALUES[name in WHO], *(getattr(each, name) for each in records)]) + 0 for name in names
    ]  # no -0.0
    order = np.lexsort(parts[::-1])
    columns = [column[order] for column in parts]
    new = np.ones(len(order), dtype=bool)
    new[1:] = np.any([column[1:] != column[:-1] for column in columns], axis=0)
    return dict(zip(names, (column[new] for column in columns), strict=True))
