"""How robots look when they measure, and what bearings say of the directions of ranges."""

from typing import NamedTuple

import numpy as np

from filter.geometry.angles import AngularIntervals
from filter.sensing.arms import Arms
from filter.sensing.headings import headings_at, narrowed_headings
from filter.sensing.readings import BEARINGS, RANGES, Readings
from filter.sensing.since import Moves


class Look(NamedTuple):
    """How robots look, and what lies between the places of sensors and where robots are.

    Attributes:
        headings: (n) now [rad].
        sights: (b) those of bearings, when these were taken [rad].
        moves: Where robots have gone since the readings; None if these are of one instant.
        arms: From the places of sensors to the centres of robots; None if all readings are taken at centres.
    """

    headings: AngularIntervals
    sights: AngularIntervals
    moves: Moves | None
    arms: Arms | None

    @classmethod
    def of(cls, headings: AngularIntervals, readings: Readings, spans: AngularIntervals) -> "Look":
        """Return how n robots of some headings before (n) look, if bearings' targets are in the directions of (b) spans [rad].

        Raises `Inconsistent` if what is known and measured of a heading is proved to have nothing in common.
        """
        bearings, since, robots = readings.bearings, readings.since, len(headings)
        if since is None:
            now = narrowed_headings(headings, readings, spans)
            return cls(now, now[bearings.robot], None, Arms.of(readings, now, robots))
        looks = headings_at(since, readings, spans)
        sights = looks[(readings.at[BEARINGS] + 1) * robots + bearings.robot]
        return cls(looks[-robots:], sights, since.moves(looks), Arms.of(readings, looks, robots))

    @classmethod
    def of_compasses(cls, headings: AngularIntervals, readings: Readings) -> "Look":
        """Return how robots look as far as compasses and odometry tell."""
        return cls.of(headings, readings, AngularIntervals.circles(len(readings.bearings.robot)))


def narrowed_by_bearings(spans: AngularIntervals, ways: AngularIntervals, readings: Readings, bodies: int) -> AngularIntervals:
    """Return the directions (r) of ranges' targets, narrowed by those (b) of bearings between the same places, from either.

    There are so many bodies, robots and landmarks.
    """
    bearings, ranges = readings.bearings, readings.ranges
    if not len(bearings.robot) or not len(ranges.robot):
        return spans
    keys = []
    for each, at in ((bearings, readings.at[BEARINGS]), (ranges, readings.at[RANGES])):
        (spots, count), first, last = (
            readings.spots(each),
            np.minimum(each.robot, each.target),
            np.maximum(each.robot, each.target),
        )
        keys.append(((at * bodies + first) * bodies + last) * count + spots)
    order = np.argsort(keys[0], kind="stable")
    about, of_ranges = (np.where(each.robot > each.target, np.pi, 0.0) for each in (bearings, ranges))
    forth = ways.turned_by(about, np.zeros(len(about)))[order]
    begin, end = (np.searchsorted(keys[0][order], keys[1], side) for side in ("left", "right"))
    exactly = np.zeros(len(of_ranges))
    return spans.turned_by(of_ranges, exactly).narrowed(begin, end, forth).turned_by(of_ranges, exactly)
