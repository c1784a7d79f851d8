"""Measurements of one instant as sightings: what was seen, by whom, in which sector of its own frame."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Integers, Table
from filter.measurements import Bearing, Compass, Measurement, Range
from filter.sensing.rows import WIDENING

FARTHEST = 1e6  # what a bearing without a range says of the distance [m]


@dataclass(frozen=True, eq=False)
class Sightings(Table):
    """A bearing and a range of the same pair, or one of them; or a compass reading.

    Attributes:
        robot: (k,) who saw.
        target: (k,) what; the robot itself for a compass.
        sector: (k, 4) bearing and its bound [rad], least and greatest range [m]. Without a bearing the bound is pi, without
            a range they are 0 and `FARTHEST`. For a compass: heading and bound, 0 and 0.
    """

    robot: Integers
    target: Integers
    sector: Array

    @classmethod
    def of(cls, measurements: Sequence[Measurement], robots: int) -> Sightings:
        """Return the sightings in records of one time: compasses first, then landmarks, then team mates.

        The n-th bearing of a pair goes with its n-th range. In which order the records come makes no difference, but to that.
        """
        rows = [(robot, robot, (*reading, 0.0, 0.0)) for robot, reading in _compasses(measurements)]
        bearings, ranges = _readings(measurements, Bearing), _readings(measurements, Range)
        for pair in bearings.keys() | ranges.keys():
            seen, measured = bearings.get(pair, []), ranges.get(pair, [])
            for k in range(max(len(seen), len(measured))):
                bearing = seen[k] if k < len(seen) else (0.0, np.pi)
                rows.append((*pair, (*bearing, *(measured[k] if k < len(measured) else (0.0, FARTHEST)))))
        rows.sort(key=lambda row: (row[0] != row[1], row[1] < robots, *row))
        robot, target = (np.array([row[column] for row in rows], dtype=np.int64) for column in (0, 1))
        return cls(robot, target, np.array([row[2] for row in rows], dtype=float).reshape(-1, 4))


def _compasses(measurements: Sequence[Measurement]) -> list[tuple[int, tuple[float, float]]]:
    records = [record for record in measurements if isinstance(record, Compass)]
    return [
        (robot, (heading, bound))
        for record in records
        for robot, heading, bound in zip(record.robot.tolist(), record.heading.tolist(), record.bound.tolist(), strict=True)
    ]


def _readings(
    measurements: Sequence[Measurement], kind: type[Bearing] | type[Range]
) -> dict[tuple[int, int], list[tuple[float, float]]]:
    """Return the readings of every pair: bearings with their bounds, or intervals of ranges, both widened a little."""
    found: dict[tuple[int, int], list[tuple[float, float]]] = defaultdict(list)
    for record in measurements:
        if not isinstance(record, kind):
            continue
        if isinstance(record, Bearing):
            first, second = record.bearing, record.bound + WIDENING
        else:
            least, greatest = record.interval()
            first, second = least * (1 - WIDENING), greatest * (1 + WIDENING)
        for robot, target, *reading in zip(*(c.tolist() for c in (record.robot, record.target, first, second)), strict=True):
            found[robot, target].append((reading[0], reading[1]))
    return found
