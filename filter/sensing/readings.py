"""The measurements of one time in one order: whatever records they come in, shuffled, split or twice, no bit is another."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from filter.arrays import Array, Integers, read_only
from filter.linear.sources import NOBODY, Kind, Source, Sources
from filter.records.measurements import Bearing, Compass, Measurement, Position, Range
from filter.records.record import field_names
from filter.sensing.since import Moves, Since

KIND_OF: dict[type[Measurement], Kind] = {Compass: "compass", Bearing: "bearing", Range: "range", Position: "position"}
WHO = ("robot", "target")
AT = "at"  # the column of instants
NO_VALUES = (np.zeros(0), np.zeros(0, dtype=np.int64))  # columns of values, and of robots


class Readings(NamedTuple):
    """One record of each kind, with every single measurement once, sorted by its columns.

    They are of one instant, or else of several, and merged at the last of them.

    Attributes:
        compasses: (c)
        bearings: (b)
        ranges: (r)
        positions: (p) half-planes
        at: Of which instant each is, for each of the four kinds; zeros if there is but one.
        since: How robots have moved from one instant to the next; None if there is but one.
        moves: Where they have gone, as compasses and odometry alone tell; None if there is but one.
    """

    compasses: Compass
    bearings: Bearing
    ranges: Range
    positions: Position
    at: tuple[Integers, Integers, Integers, Integers]
    since: Since | None = None
    moves: Moves | None = None

    @classmethod
    def of(cls, time: float, measurements: Sequence[Measurement], since: Since | None = None) -> "Readings":
        """Return measurements that were taken at one time [s], or at instants up to it."""
        stamps = np.array([time]) if since is None else since.stamps
        found = [_sorted(kind, time, measurements, stamps) for kind in KIND_OF]
        compasses, bearings, ranges, positions = (record for record, _ in found)
        first, second, third, fourth = (at for _, at in found)
        return cls(compasses, bearings, ranges, positions, (first, second, third, fourth), since)

    @property
    def records(self) -> tuple[Measurement, ...]:
        """The four records."""
        return self.compasses, self.bearings, self.ranges, self.positions

    @property
    def times(self) -> tuple[Array, ...]:
        """When each of them was taken, for each of the four kinds [s]."""
        stamps = np.array([self.compasses.time]) if self.since is None else self.since.stamps
        return tuple(stamps[at] for at in self.at)

    def numbered(self, sources: Sources, robots: int) -> tuple[Sources, Integers]:
        """Enter what makes rows in a table; return it and numbers (b + r + p + n,) of these, and of the cells of n robots."""
        first = len(sources)
        for record, time in zip(self.records[1:], self.times[1:], strict=True):
            sources, _ = sources.extended(KIND_OF[type(record)], time, record.robot, targets_of(record))
        sources, _ = sources.extended("cells", self.ranges.time, np.arange(robots))
        return sources, np.arange(first, len(sources))

    def tie_robots(self, robots: int) -> bool:
        """Return whether one of n robots measured another."""
        return bool((self.bearings.target < robots).any() or (self.ranges.target < robots).any())

    def concerning(self, robot: int) -> list[Source]:
        """Return all readings by a robot, or of it."""
        found = list[Source]()
        for record, time in zip(self.records, self.times, strict=True):
            target = targets_of(record)
            table, _ = Sources().extended(KIND_OF[type(record)], time, record.robot, target)
            found += [table[k] for k in np.flatnonzero((record.robot == robot) | (target == robot)).tolist()]
        return list(dict.fromkeys(found))


def targets_of(record: Measurement) -> Integers:
    """Return (k,) the targets that are measured, NOBODY for what is of the robot alone."""
    return record.target if isinstance(record, Bearing | Range) else np.full(len(record.robot), NOBODY)


def _sorted(kind: type[Measurement], time: float, measurements: Sequence[Measurement], stamps: Array) -> tuple[Any, Integers]:
    """Return all measurements of a kind as one record, and of which of some stamps each is."""
    columns = _columns(kind, [each for each in measurements if isinstance(each, kind)], stamps)
    at = columns.pop(AT)
    return kind.of_checked(time, columns), read_only(at)


def _columns(kind: type[Measurement], records: Sequence[Any], stamps: Array) -> dict[str, Any]:
    names = [*field_names(kind), AT]
    instants = np.searchsorted(stamps, [each.time for each in records])
    parts = [
        np.concatenate([NO_VALUES[name in WHO], *(getattr(each, name) for each in records)]) + 0 for name in names[:-1]
    ]  # no -0.0
    parts.append(np.repeat(instants, [len(each.robot) for each in records]).astype(np.int64))
    order = np.lexsort(parts[::-1])
    columns = [column[order] for column in parts]
    new = np.ones(len(order), dtype=bool)
    new[1:] = np.any([column[1:] != column[:-1] for column in columns], axis=0)
    return dict(zip(names, (column[new] for column in columns), strict=True))
