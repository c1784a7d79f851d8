"""What cameras see of landmarks: each bearing with the range that was measured along with it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from filter.arrays import Array, Integers, Table
from filter.records.measurements import Bearing, Measurement, Range
from filter.records.record import AT_THE_CENTRE

FARTHEST = 1e6  # what a bearing without a range says of the distance [m]


@dataclass(frozen=True, eq=False)
class Sightings(Table):
    """Bearings of landmarks with their ranges, sorted by robots and landmarks.

    Attributes:
        robot: (k,) whose camera.
        landmark: (k,) which one, from 0 on.
        bearing: (k,) in the robot's frame [rad].
        bearing_bound: (k,) largest error [rad].
        distance: (k,) the middle of what the range allows, or of everything without one [m].
        distance_bound: (k,) half the width of that [m].
    """

    robot: Integers
    landmark: Integers
    bearing: Array
    bearing_bound: Array
    distance: Array
    distance_bound: Array

    @classmethod
    def of(cls, records: Sequence[Measurement], robots: int) -> Sightings:
        """Return what was seen at one time by sensors at the centres of so many robots; of others nothing is estimated.

        The n-th bearing of a pair goes with its n-th range, in the order of the records. Bearings that say nothing go.
        """
        robot, target, bearing, bound = _columns(robots, [(r, r.bearing, r.bound) for r in records if isinstance(r, Bearing)])
        other, body, least, greatest = _columns(robots, [(r, *r.interval()) for r in records if isinstance(r, Range)])
        pairs = 1 + max(target.max(initial=0), body.max(initial=0))
        _, seen, ranged = np.intersect1d(
            _numbered(robot * pairs + target), _numbered(other * pairs + body), assume_unique=True, return_indices=True
        )
        low, high = np.zeros(len(robot)), np.full(len(robot), FARTHEST)
        low[seen], high[seen] = least[ranged], greatest[ranged]
        found = cls(robot, target - robots, bearing, bound, (low + high) / 2, (high - low) / 2)
        in_order = np.lexsort((target, robot))
        return found.select(in_order[bound[in_order] < np.pi])


def _columns(robots: int, told: Sequence[tuple[Bearing | Range, Array, Array]]) -> tuple[Integers, Integers, Array, Array]:
    """Return who measured which landmark, and two columns of what, (k,) each, by sensors at the centres of robots."""
    found = [(np.zeros(0, dtype=np.int64), np.zeros(0, dtype=np.int64), np.zeros(0), np.zeros(0))]
    for record, *values in told:
        kept = (record.target >= robots) & (record.sensor == AT_THE_CENTRE)
        found.append(tuple(column[kept] for column in (record.robot, record.target, *values)))
    robot, target, first, second = map(np.concatenate, zip(*found, strict=True))
    return robot, target, first, second


def _numbered(pair: Integers) -> Integers:
    """Return a number (k,) for each reading of a pair (k,), the same for its n-th one in every list of fewer than 2**20."""
    order = np.argsort(pair, kind="stable")
    ordered = pair[order]
    number = np.empty_like(pair)
    number[order] = (ordered << 20) + np.arange(len(pair)) - np.searchsorted(ordered, ordered)
    return number
