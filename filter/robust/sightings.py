"""Measurements of one instant as sightings: who saw what, in which sector of its own frame."""

from collections import defaultdict
from collections.abc import Sequence
from itertools import zip_longest

import numpy as np

from filter.arrays import Array
from filter.measurements import Bearing, Compass, Measurement
from filter.sensing.rows import WIDENING

# Who saw, what, and the sector (4,): a bearing and its bound [rad], least and greatest range [m]. Without a bearing the bound
# is pi, without a range they are 0 and FARTHEST. A compass is a bearing of the robot itself.
Sighting = tuple[int, int, Array]
FARTHEST = 1e6  # what a bearing without a range says of the distance [m]


def sightings_in(measurements: Sequence[Measurement], robots: int) -> list[Sighting]:
    """Return the sightings in records of one time: compasses first, then landmarks, then team mates.

    The n-th bearing of a pair goes with its n-th range. In which order the records come makes no difference, but to that.
    """
    bearings: dict[tuple[int, int], list[list[float]]] = defaultdict(list)
    ranges: dict[tuple[int, int], list[list[float]]] = defaultdict(list)
    for record in measurements:
        if isinstance(record, Compass):
            into, target, reading = bearings, record.robot, (record.heading, record.bound)
        elif isinstance(record, Bearing):
            into, target, reading = bearings, record.target, (record.bearing, record.bound + WIDENING)
        else:
            least, greatest = record.interval()
            into, target, reading = ranges, record.target, (least * (1 - WIDENING), greatest * (1 + WIDENING))
        for robot, body, *values in zip(*(column.tolist() for column in (record.robot, target, *reading)), strict=True):
            into[robot, body].append(values)
    pairs = sorted(bearings.keys() | ranges.keys(), key=lambda pair: (pair[0] != pair[1], pair[1] < robots, pair))
    return [
        (*pair, np.array(sector))
        for pair in pairs
        for sector in sorted(
            [*(bearing or (0.0, np.pi)), *(reach or (0.0, FARTHEST))]
            for bearing, reach in zip_longest(bearings[pair], ranges[pair])
        )
    ]
