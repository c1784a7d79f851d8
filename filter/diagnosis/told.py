"""What suspects say: readings without those of one, or with markers exchanged, and who has said something in them."""

from collections.abc import Collection, Iterable, Sequence
from typing import Any

import numpy as np

from filter.arrays import Integers, Mask
from filter.linear.sources import NOBODY
from filter.records.measurements import Compass, Measurement
from filter.records.record import field_names
from filter.sensing.readings import Readings, targets_of
from filter.sets.suspect import Suspect

Records = tuple[Measurement, ...]
Who = tuple[str, int, int]  # see `Suspect.who`


def in_one_order(time: float, measurements: Sequence[Measurement]) -> Records:
    """Return measurements of one time [s], each once, in an order that does not depend on how they came."""
    return tuple(record for record in Readings.of(time, measurements).records if len(record.robot))


def without(suspect: Suspect, records: Records) -> Records:
    """Return what is left of records if a suspect is wrong: as if it had said nothing, or as if markers were exchanged."""
    left = (_left(suspect, record) for record in records)
    return tuple(record for record in left if record is not None)


def without_all(suspects: Iterable[Suspect], records: Records) -> Records:
    """Return what is left if each of several is wrong."""
    for suspect in suspects:
        records = without(suspect, records)
    return records


def without_robots(robots: Collection[int], records: Records) -> Records:
    """Return what is left without all that some robots measured, and that was measured of them."""
    out = list(robots)
    left = (some(each, ~np.isin(each.robot, out) & ~np.isin(targets_of(each), out)) for each in records)
    return tuple(record for record in left if record is not None)


def without_ties(robots: Collection[int], bodies: int, records: Records) -> Records:
    """Return what is left without what ties some robots to any others that are among so many bodies."""
    out, left = list(robots), list[Measurement | None]()
    for record in records:
        target = targets_of(record)
        mates = (target != NOBODY) & (target < bodies)
        left.append(some(record, ~mates | ~(np.isin(record.robot, out) | np.isin(target, out))))
    return tuple(record for record in left if record is not None)


def said(records: Records) -> set[Who]:
    """Return who has said something: sensors, compasses, bodies and sightings; of a position the sighting is of nobody."""
    found = set[Who]()
    for record in records:
        pairs = set(zip(record.robot.tolist(), targets_of(record).tolist(), strict=True))
        if isinstance(record, Compass):
            found |= {("compass", robot, NOBODY) for robot, _ in pairs}
            continue
        found |= {("sensor", robot, NOBODY) for robot, _ in pairs}
        found |= {("sighting", robot, target) for robot, target in pairs}
        found |= {("body", NOBODY, target) for _, target in pairs if target != NOBODY}
    return found


def signature(records: Records) -> tuple[tuple[str, bytes, bytes], ...]:
    """Return what tells the leavings of two suspects apart, of the same records."""
    return tuple((type(each).__name__, each.robot.tobytes(), targets_of(each).tobytes()) for each in records)


def said_by(suspect: Suspect, record: Measurement) -> Mask:
    """Return which (k,) readings of a record a suspect has said, or are of it; an exchange and a past say none."""
    robot, target, is_compass = record.robot, targets_of(record), isinstance(record, Compass)
    said_it: dict[str, Mask | bool] = {
        "compass": (robot == suspect.robot) & is_compass,
        "sensor": (robot == suspect.robot) & (not is_compass),
        "body": target == suspect.target,
        "sighting": (robot == suspect.robot) & (target == suspect.target),
    }
    return np.broadcast_to(said_it.get(suspect.kind, False), robot.shape)


def _left(suspect: Suspect, record: Measurement) -> Measurement | None:
    if suspect.kind != "exchange":
        return some(record, ~said_by(suspect, record))
    return record if isinstance(record, Compass) else _exchanged(suspect, record, targets_of(record))


def _exchanged(suspect: Suspect, record: Any, target: Integers) -> Measurement | None:
    """Return what was read of either of two robots as read of the other; nobody sees itself."""
    _, first, second = suspect.who
    one, other = target == first, target == second
    if not (one | other).any():
        return record
    columns = {name: getattr(record, name) for name in field_names(record)}
    columns["target"] = np.where(one, second, np.where(other, first, target))
    return some(type(record).of_checked(record.time, columns), columns["target"] != record.robot)


def some(record: Any, keep: Mask) -> Any:
    """Return those (k,) readings of a record that are to be kept; None for nothing."""
    if keep.all():
        return record
    columns = {name: getattr(record, name)[keep] for name in field_names(record)}
    return type(record).of_checked(record.time, columns) if keep.any() else None
