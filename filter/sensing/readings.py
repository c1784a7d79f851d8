"""The measurements of one time in one order: whatever records they come in, shuffled, split or twice, no bit is another."""

from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from filter.arrays import Array, Integers, read_only
from filter.geometry.many import clip_boxes
from filter.linear.sources import NOBODY, Kind, Source, Sources
from filter.records.measurements import Bearing, Compass, Measurement, Position, Range
from filter.records.record import AT_THE_CENTRE, CENTRE, Sighting, field_names
from filter.records.relative import RelativeHeading
from filter.records.sensors import Mountings
from filter.sensing.since import Moves, Since

KIND_OF: dict[type[Measurement], Kind] = {
    Compass: "compass",
    Bearing: "bearing",
    Range: "range",
    Position: "position",
    RelativeHeading: "relative heading",
}
COMPASSES, BEARINGS, RANGES, POSITIONS, RELATIVES = range(len(KIND_OF))  # places of the kinds among `Readings`
ROWS = slice(BEARINGS, RELATIVES)  # of those that make rows
WHO = ("robot", "target", "sensor", "target_sensor")
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
        relatives: (h) headings of mates
        at: Of which instant each is, for each of the five kinds; zeros if there is but one.
        since: How robots have moved from one instant to the next; None if there is but one.
        moves: Where they have gone, as compasses and odometry alone tell; None if there is but one.
        mountings: Of the sensors that measure; None if all of them, but for compasses, are at the centres of robots.
    """

    compasses: Compass
    bearings: Bearing
    ranges: Range
    positions: Position
    relatives: RelativeHeading
    at: tuple[Integers, ...]
    since: Since | None = None
    moves: Moves | None = None
    mountings: Mountings | None = None

    @classmethod
    def of(
        cls,
        time: float,
        measurements: Sequence[Measurement],
        since: Since | None = None,
        mountings: Mountings | None = None,
    ) -> "Readings":
        """Return measurements that were taken at one time [s], or at instants up to it.

        Angles by or of sensors that do not look forward are turned, and made wider, to be as of robots' forward axes.
        """
        stamps = np.array([time]) if since is None else since.stamps
        found = [_sorted(kind, time, measurements, stamps) for kind in KIND_OF]
        compasses, bearings, ranges, positions, relatives = (record for record, _ in found)
        at = tuple(at for _, at in found)
        if mountings is None:
            return cls(compasses, bearings, ranges, positions, relatives, at, since)
        compasses, bearings, relatives = (_looking_forward(record, mountings) for record in (compasses, bearings, relatives))
        of_pairs = (column for each in (bearings, ranges) for column in (each.sensor, each.target_sensor))
        off = any(mountings.spot[column].any() for column in (*of_pairs, positions.sensor))
        return cls(compasses, bearings, ranges, positions, relatives, at, since, None, mountings if off else None)

    @property
    def records(self) -> tuple[Measurement, ...]:
        """The five records."""
        return self.compasses, self.bearings, self.ranges, self.positions, self.relatives

    @property
    def times(self) -> tuple[Array, ...]:
        """When each of them was taken, for each of the five kinds [s]."""
        stamps = np.array([self.compasses.time]) if self.since is None else self.since.stamps
        return tuple(stamps[at] for at in self.at)

    def numbered(self, sources: Sources, robots: int) -> tuple[Sources, Integers]:
        """Enter what makes rows in a table; return it and numbers (b + r + p + n,) of these, and of the cells of n robots."""
        table = sources
        for record, time in zip(self.records[ROWS], self.times[ROWS], strict=True):
            table, _ = table.extended(KIND_OF[type(record)], time, record.robot, targets_of(record), record.sensor)
        table, _ = table.extended("cells", self.ranges.time, np.arange(robots))
        return table, np.arange(len(sources), len(table))

    def spots(self, record: Bearing | Range) -> tuple[Integers | int, int]:
        """Return numbers (k,) for the places of sensors between which bearings or ranges are measured, and how many there are.

        Those of the body with the lower number count first. Where nobody knows for sure when it was measured, each is its own.
        """
        if self.mountings is None:
            return 0, 1
        spots, forth = self.mountings.spot, record.robot < record.target
        first = spots[np.where(forth, record.sensor, record.target_sensor)]
        last, count = spots[np.where(forth, record.target_sensor, record.sensor)], len(spots)
        sizes = [len(each.robot) for each in (self.bearings, self.ranges)]
        alone = count**2 + np.arange(len(record.robot)) + (0 if isinstance(record, Bearing) else sizes[0])
        doubtful = self.mountings.time_bound[record.sensor] > 0
        return np.where(doubtful, alone, first * count + last), count**2 + sum(sizes)

    def placed_nowhere(self, offset: Array, farthest: float) -> list[Source]:
        """Return positions that nobody can be at who is no farther than so from the origin on each axis [m]: that is proved.

        They are of one robot at one instant, by one sensor, whose clock is right, and have nothing in common though they reach
        as far as (p,) offsets say, which allow for rounding [m].
        """
        mounted = self.mountings
        arm = 0.0 if mounted is None else float((np.hypot(*mounted.position.T) + mounted.position_bound).max())
        record, at, times = self.positions, self.at[POSITIONS], self.times[POSITIONS]
        late = np.zeros(len(at)) if mounted is None else mounted.time_bound[record.sensor]
        some = np.flatnonzero(late == 0)
        sensors = int(record.sensor.max(initial=AT_THE_CENTRE)) + 2
        key = (at * (record.robot.max(initial=0) + 1) + record.robot) * sensors + record.sensor + 1
        _, first, which, count = np.unique(key[some], return_index=True, return_inverse=True, return_counts=True)
        order, end = some[np.argsort(which, kind="stable")], np.cumsum(count)
        box = np.full((len(count), 2), 2 * (farthest + arm) + 1)
        normals, offsets = map(read_only, (record.normals[order], offset[order]))  # no other form is compiled
        empty = clip_boxes(normals, offsets, (end - count, end), -box, box).empty
        whose = some[first[empty]]
        table, _ = Sources().extended("position", times[whose], record.robot[whose], NOBODY, record.sensor[whose])
        return [table[k] for k in range(len(table))]

    def tie_robots(self, robots: int) -> bool:
        """Return whether one of n robots measured another."""
        return any(bool((each.target < robots).any()) for each in (self.bearings, self.ranges, self.relatives))

    def concerning(self, robot: int) -> list[Source]:
        """Return all readings by a robot, or of it."""
        found = list[Source]()
        for record, time in zip(self.records, self.times, strict=True):
            target = targets_of(record)
            table, _ = Sources().extended(KIND_OF[type(record)], time, record.robot, target, record.sensor)
            found += [table[k] for k in np.flatnonzero((record.robot == robot) | (target == robot)).tolist()]
        return list(dict.fromkeys(found))


def targets_of(record: Measurement) -> Integers:
    """Return (k,) the targets that are measured, NOBODY for what is of the robot alone."""
    return record.target if isinstance(record, Sighting) else np.full(len(record.robot), NOBODY)


def _sorted(kind: type[Measurement], time: float, measurements: Sequence[Measurement], stamps: Array) -> tuple[Any, Integers]:
    """Return all measurements of a kind as one record, and of which of some stamps each is."""
    columns = _columns(kind, [each for each in measurements if isinstance(each, kind)], stamps)
    at = columns.pop(AT)
    return kind.of_checked(time, columns), read_only(at)


def _looking_forward(record: Any, mountings: Mountings) -> Any:
    """Return compasses, bearings or relative headings of sensors as those of robots' forward axes, at the stamps."""
    tag = record.target_sensor if isinstance(record, RelativeHeading) else CENTRE
    if (record.sensor == AT_THE_CENTRE).all() and (tag == AT_THE_CENTRE).all():
        return record
    angle, off = mountings.angle[record.sensor], mountings.angle_bound[record.sensor] + mountings.angle_bound[tag]
    bound = record.bound + off + mountings.swing[record.sensor, record.robot]
    if isinstance(record, RelativeHeading):
        bound += mountings.swing[record.sensor, record.target]
    name, sign = ("bearing", 1.0) if isinstance(record, Bearing) else ("heading", -1.0 if isinstance(record, Compass) else 1.0)
    columns = {each: getattr(record, each) for each in field_names(record)}
    turned = columns[name] + sign * angle - mountings.angle[tag]
    return type(record).of_checked(record.time, columns | {name: turned, "bound": bound})


def _columns(kind: type[Measurement], records: Sequence[Any], stamps: Array) -> dict[str, Any]:
    names = [*field_names(kind), AT]
    if not records:
        return {name: NO_VALUES[name in WHO or name == AT] for name in names}
    sizes, instants = [len(each.robot) for each in records], np.searchsorted(stamps, [each.time for each in records])
    table = np.empty((len(names), sum(sizes)))  # whole numbers are exact as floats
    for row, name in zip(table, names[:-1], strict=False):
        np.concatenate([getattr(each, name) for each in records], out=row)
    table[-1] = np.repeat(instants, sizes)
    table += 0.0  # no -0.0
    table = table[:, np.lexsort(table[::-1])]
    new = np.ones(table.shape[1], dtype=bool)
    new[1:] = (table[:, 1:] != table[:, :-1]).any(axis=0)
    columns = table[:, new]
    whole = (name in WHO or name == AT for name in names)
    return {
        name: column.astype(np.int64) if is_whole else column
        for name, column, is_whole in zip(names, columns, whole, strict=True)
    }
