"""From measurements to headings and constraints (section 3 of the paper, with its signs mended).

Errata: the paper's first bearing row has a wrong sign (as printed it cuts off the truth in half of random draws), and
its lower range row lacks a minus (as printed it says nothing).
"""

from __future__ import annotations

import numpy as np

from filter.arrays import Array, Integers
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON
from filter.linear.constraints import WORLD, Constraints, rounding_of_rows
from filter.linear.polytope import Polytope
from filter.measurements import Bearing, Compass, Range

# The far side of a range is a circle, replaced by tangents at most this far apart; 30 degrees cost 2.3 % of area at most.
TANGENT_SPACING = np.pi / 6
# Every bearing is widened by this [rad] and every range by this share: far above rounding, far below any sensor. So errors
# that just reach their bounds leave the polytope an interior, without which no solver can be accurate.
WIDENING = 1e-8


def heading_arcs_of_compass(record: Compass) -> AngularIntervals:
    """Return (k) arcs that contain the measuring robots' headings [rad]."""
    return AngularIntervals(np.zeros(len(record.bound)), record.bound).turned(record.heading)


def heading_arcs_of_bearing(record: Bearing, spans: AngularIntervals) -> AngularIntervals:
    """Return (k) arcs that contain the measuring robots' headings, where (k) spans hold the targets' directions [rad].

    A target known to lie in the span [a, b] and seen at the bearing beta +- d bounds the heading by [a, b] - beta +- d.
    """
    return spans.turned(-record.bearing, record.bound)


def world_arcs(record: Bearing, headings: AngularIntervals) -> AngularIntervals:
    """Return (k) arcs that contain the targets' directions in the world, given the (k) measuring robots' headings [rad]."""
    return headings.turned(record.bearing, record.bound)


def bearing_rows(robot: Integers, target: Integers, arcs: AngularIntervals, source: Integers) -> Constraints:
    """Return two rows for each (k) arc narrower than half a circle; wider ones are no convex set and give none.

    With d = x_target - x_robot: dx sin(least) - dy cos(least) <= 0 and -dx sin(greatest) + dy cos(greatest) <= 0.
    """
    narrow = np.flatnonzero(arcs.bound < np.pi / 2 - 2 * WIDENING)
    least = arcs.centre[narrow] - arcs.bound[narrow] - WIDENING
    greatest = arcs.centre[narrow] + arcs.bound[narrow] + WIDENING
    normal = np.concatenate(
        [
            np.stack([np.sin(least), -np.cos(least)], axis=1),
            np.stack([-np.sin(greatest), np.cos(greatest)], axis=1),
        ]
    )
    twice = np.concatenate([narrow, narrow])
    return Constraints.between(robot[twice], target[twice], normal, np.zeros(len(twice)), source[twice])


def range_rows(record: Range, arcs: AngularIntervals, source: Integers, spacing: float = TANGENT_SPACING) -> Constraints:
    """Return the rows of ranges to targets whose directions lie in (k) arcs.

    Far side: u . d <= greatest for directions u evenly over the arc, `spacing` apart at most [rad]; a narrow arc has
    one, an unknown direction twelve. Near side, for arcs narrower than half a circle: -u . d <= -least cos(bound).
    """
    least, greatest = record.interval()
    count = np.maximum(1, np.ceil(2 * arcs.bound / spacing)).astype(int)
    which = np.repeat(np.arange(len(count)), count)
    place = np.arange(len(which)) - np.repeat(np.cumsum(count) - count, count)
    angle = arcs.centre[which] + arcs.bound[which] * ((2 * place + 1) / count[which] - 1)
    near = np.flatnonzero((arcs.bound < np.pi / 2) & (least > 0))
    nearest = -least[near] * (1 - WIDENING) * np.cos(np.minimum(np.pi / 2, arcs.bound[near] + WIDENING))
    direction = np.concatenate([angle, arcs.centre[near] + np.pi])
    offset = np.concatenate([greatest[which] * (1 + WIDENING), nearest])
    measured = np.concatenate([which, near])
    normal = np.stack([np.cos(direction), np.sin(direction)], axis=1)
    return Constraints.between(record.robot[measured], record.target[measured], normal, offset, source[measured])


def on_robots(rows: Constraints, polytope: Polytope, landmarks: Array) -> Constraints:
    """Return rows on bodies as rows on robots: landmarks, numbered from n on, are put in, and all rounding is covered.

    Args:
        rows: Rows just built, all of them on pairs.
        polytope: Where the n robots can be.
        landmarks: (l, 2) known positions [m].
    """
    robots = len(polytope.lower)
    lower, upper = np.concatenate([polytope.lower, landmarks]), np.concatenate([polytope.upper, landmarks])
    outward = rows.shifted(rounding_of_rows(rows, lower, upper))
    fixed = outward.j >= robots
    where = np.concatenate([np.zeros((robots, 2)), landmarks])[outward.j]
    shift = -(outward.normal * where).sum(axis=1)
    rounding = 4 * EPSILON * np.abs(outward.normal * where).sum(axis=1)
    moved = outward.shifted(shift + rounding)
    return Constraints(
        np.where(fixed, WORLD, moved.i),
        np.where(fixed, moved.i, moved.j),
        np.where(fixed[:, None], -moved.normal, moved.normal),
        moved.offset,
        moved.source,
    )


def spans_of_targets(polytope: Polytope, landmarks: Array, robot: Integers, target: Integers) -> AngularIntervals:
    """Return (k) arcs that contain the directions from robots to targets, as far as the polytope tells at a glance [rad].

    Rows that exclude one another say nothing here: to find that out, and the causes, is for the search that follows.
    """
    robots, first, second = len(polytope.lower), np.minimum(robot, target), np.maximum(robot, target)
    pairs, which = np.unique(first * (robots + len(landmarks)) + second, return_inverse=True)
    i, j = pairs // (robots + len(landmarks)), pairs % (robots + len(landmarks))
    fixed, mutual = np.flatnonzero(j >= robots), np.flatnonzero(j < robots)
    spans = AngularIntervals.circles(len(pairs))
    seen = polytope.of_robots(i[fixed]).polygons.mirrored(landmarks[j[fixed] - robots]).spans()
    spans = spans.replaced(fixed, seen).replaced(mutual, polytope.of(i[mutual], j[mutual]).polygons.spans())
    return spans[which].turned(np.where(robot > target, np.pi, 0.0))
