"""Why headings and the near sides of ranges hold: where a target is, as seen from a robot, as claims with their proofs.

A side of a target is a line through the robot that the target is wholly to one side of: one claim on the pair, or on the robot
alone if the target is a landmark, proved like any edge. Two of them are an arc of directions.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from fractions import Fraction
from typing import NamedTuple

import numpy as np

from filter import AngularIntervals, Array, Bearing, Directions, Integers, Proof, Range, wrap
from filter.geometry.angles import ANGLE_ROUNDING
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.projection.claims import Weights
from filter.records.record import field_names
from filter.sensing.arms import Arms
from filter.sensing.headings import heading_arcs_of_bearing
from filter.sensing.rows import WIDENING, spans_of_targets

Sights = Collection[tuple[int, int | None]]  # robots and targets
NEAR = 1e-9  # an arc this near to the end of a heading is what has narrowed it there [rad]
# A reading less sure than this can meet a heading at both ends; what it leaves at one, any other may have taken away [rad].
WIDE = 1.0


class Sighted(NamedTuple):
    """Sides of targets.

    Attributes:
        proof: The claims.
        about: (k,) what each is about.
        sensors: (k, 2) which sensors are meant, on the robots of a claim or on its robot and a landmark; None for the centres.
    """

    proof: Proof
    about: Integers
    sensors: Integers | None


class Seen(NamedTuple):
    """Bearings or ranges, and what lies between the places of their sensors and the centres.

    Attributes:
        record: All of them.
        spots: (k,) numbers for the places between which they were measured.
        apart: By what (k, 2) the way between the centres is another than the one that is measured, up to what (k,) [m]; None
            if they are the same.
    """

    record: Bearing | Range
    spots: Integers
    apart: tuple[Array, Array] | None

    @classmethod
    def of(cls, read: Directions, record: Bearing | Range, arms: Arms | None) -> Seen:
        """Return those of a pass."""
        count, first = len(record.robot), len(read.readings.bearings.robot) if isinstance(record, Range) else 0
        spots = np.broadcast_to(read.readings.spots(record)[0], count)
        return cls(record, spots, None if arms is None else arms.between(first + np.arange(count)))

    def some(self, which: Integers) -> Seen:
        """Return one for each two places among some (k,) of them, in order."""
        key = np.stack([self.record.robot[which], self.record.target[which], self.spots[which]])
        first = which[np.unique(key, axis=1, return_index=True)[1]]
        columns = {name: getattr(self.record, name)[first] for name in field_names(self.record)}
        apart = None if self.apart is None else (self.apart[0][first], self.apart[1][first])
        return Seen(type(self.record).of_checked(self.record.time, columns), self.spots[first], apart)

    def spans(self, known: Polytope, landmarks: Array) -> AngularIntervals:
        """Return (k) arcs of the directions of targets, as far as a polytope tells [rad]."""
        return spans_of_targets(known, landmarks, self.record.robot, self.record.target, self.apart)

    def beyond(self, way: Integers, outward: Array) -> Array:
        """Return (c,) how far the way between centres is beyond the measured one at least, in directions (c, 2) [m]."""
        if self.apart is None:
            return np.zeros(len(way))
        by, radius = self.apart
        return np.asarray((by[way] * outward).sum(axis=1) - radius[way])


def sides_of_bearings(read: Directions, landmarks: Array) -> Sighted:
    """Return the sides of targets whose bearings have made headings narrower; landmarks are (l, 2) [m].

    Both sides of each: half a circle alone could meet another one at both ends. If nothing is left of a heading, those of all.
    """
    seen, bearings = Seen.of(read, read.readings.bearings, read.before), read.readings.bearings
    arcs, claimed = heading_arcs_of_bearing(bearings, seen.spans(read.known, landmarks)), read.headings[bearings.robot]
    off = [wrap(arcs.centre + end * arcs.bound - claimed.centre - end * claimed.bound) for end in (-1, 1)]
    wide = (np.concatenate([bearings.bound, read.readings.relatives.bound]) > WIDE).any()
    nearest = np.flatnonzero((np.abs(off) < NEAR).any(axis=0) | wide | read.is_torn)
    return _sides(read.known, read.sources, landmarks, seen.some(nearest), ANGLE_ROUNDING / 2)


def sides_of_ranges(read: Directions, landmarks: Array, sights: Sights) -> Sighted:
    """Return the sides of some targets of ranges, as they were known with the bearings merged."""
    seen, ranges = Seen.of(read, read.readings.ranges, read.arms), read.readings.ranges
    which = [k for k, sight in enumerate(zip(ranges.robot.tolist(), ranges.target.tolist(), strict=True)) if sight in sights]
    return _sides(read.seen, read.sources, landmarks, seen.some(np.array(which, dtype=np.int64)), WIDENING / 2)


def boxes_at_a_glance(read: Directions, before: Directions) -> Proof:
    """Return the sides of boxes that a pass has begun with, narrower than those of the pass before."""
    known = replace(read.known, lower=before.known.lower, upper=before.known.upper)
    sides = np.stack([before.known.lower - read.known.lower, read.known.upper - before.known.upper], axis=2)
    robot, k, end = np.nonzero(sides < 0)
    normal = (2 * end - 1)[:, None] * np.eye(2)[k]
    offset = np.where(end == 1, read.known.upper[robot, k], -read.known.lower[robot, k])
    i = np.full(len(robot), WORLD)
    return Proof("boxes", known, read.sources, i, robot, normal, offset, _corners(known, (i, robot), normal))


def _sides(known: Polytope, sources: Sources, landmarks: Array, seen: Seen, by: float) -> Sighted:
    """Return both sides of targets whose directions are known, and what each is about, robots being counted before landmarks.

    Args:
        known: From whose rows, at a glance.
        sources: What produced them.
        landmarks: (l, 2) [m].
        seen: Whose.
        by: How far outward of what the filter takes for these directions a side is, so that its proof has room [rad].
    """
    robots, every = len(known.lower), seen.spans(known, landmarks)
    way = np.repeat(np.flatnonzero(~every.full), 2)
    robot, target, spans, end = seen.record.robot[way], seen.record.target[way], every[way], np.tile([-1, 1], len(way) // 2)
    angle, first, last = spans.centre + end * (spans.bound + by), np.minimum(robot, target), np.maximum(robot, target)
    outward, fixed = end[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=1), last >= robots
    i, j = np.where(fixed, WORLD, first), np.where(fixed, first, last)
    normal = np.where((fixed | (robot > target))[:, None], -outward, outward)
    places = np.concatenate([np.zeros((robots, 2)), landmarks])[last]  # of pairs it is their own difference that is bounded
    more = seen.beyond(way, outward)
    offset = np.array([_below(*each) for each in zip(normal.tolist(), places.tolist(), more.tolist(), strict=True)])
    proof = Proof("sides", known, sources, i, j, normal, offset, _corners(known, (i, j), normal))
    return Sighted(proof, np.where(fixed, last, first), None if seen.apart is None else _sensors(seen.record, way))


def _sensors(record: Bearing | Range, which: Integers) -> Integers:
    """Return the sensors (k, 2) of some readings, that on the body with the lower number first."""
    sensors = np.stack([record.sensor, record.target_sensor], axis=1)[which]
    return np.where((record.robot > record.target)[which, None], sensors[:, ::-1], sensors)


def _below(normal: Sequence[float], place: Sequence[float], more: float) -> float:
    """Return the greatest float that is not above normal . place + more."""
    exact = sum((Fraction(a) * Fraction(x) for a, x in zip(normal, place, strict=True)), Fraction(more))
    return float(exact) if Fraction(float(exact)) <= exact else float(np.nextafter(float(exact), -np.inf))


def _corners(polytope: Polytope, whose: tuple[Integers, Integers], normals: Array) -> Weights:
    """Return the rows, and multipliers, of the corner that is farthest in a direction (k, 2), of (k) robots or pairs i, j.

    However small a multiplier is, without it the box would pay for what it leaves of the normal.
    """
    outlines, multipliers = polytope.of(*whose), np.zeros((len(normals), len(polytope.constraints)))
    for claim, (outline, normal) in enumerate(zip(outlines.polygons, normals, strict=True)):
        behind = outlines.behind[outlines.polygons.first[claim] :]
        after, before = outline.normals, np.roll(outline.normals, 1, axis=0)
        turned = _across(before, after)
        shares = np.stack([_across(normal, after), _across(before, normal)]) / np.where(turned > 0, turned, np.nan)
        corner = int(np.nanargmax(shares.min(axis=0)))  # the one of which both are positive
        for edge, share in zip((corner - 1 if corner else len(after) - 1, corner), shares[:, corner], strict=True):
            if behind[edge] < len(polytope.constraints):
                multipliers[claim, behind[edge]] += max(0.0, share)
    return Weights.of(multipliers)


def _across(a: Array, b: Array) -> Array:
    """Return the cross products of vectors (..., 2)."""
    return a[..., 0] * b[..., 1] - a[..., 1] * b[..., 0]
