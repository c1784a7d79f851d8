"""Why headings and the near sides of ranges hold: where a target is, as seen from a robot, as claims with their proofs.

A side of a target is a line through the robot that the target is wholly to one side of: one claim on the pair, or on the robot
alone if the target is a landmark, proved like any edge. Two of them are an arc of directions.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from filter import Array, Directions, Integers, Proof, wrap
from filter.geometry.angles import ANGLE_ROUNDING
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.linear.sources import Sources
from filter.projection.claims import Weights
from filter.sensing.headings import heading_arcs_of_bearing
from filter.sensing.rows import WIDENING, spans_of_targets

Sighted = tuple[Proof, Integers]  # claims, and what each is about
Sights = Collection[tuple[int, int | None]]  # robots and targets
NEAR = 1e-9  # an arc this near to the end of a heading is what has narrowed it there [rad]


def sides_of_bearings(read: Directions, landmarks: Array) -> Sighted:
    """Return the sides of targets whose bearings have made headings narrower; landmarks are (l, 2) [m].

    Both sides of each: half a circle alone could meet another one at both ends.
    """
    bearings = read.readings.bearings
    spans = spans_of_targets(read.known, landmarks, bearings.robot, bearings.target)
    arcs, claimed = heading_arcs_of_bearing(bearings, spans), read.headings[bearings.robot]
    off = [wrap(arcs.centre + end * arcs.bound - claimed.centre - end * claimed.bound) for end in (-1, 1)]
    nearest = (np.abs(off) < NEAR).any(axis=0)
    sights = set(zip(bearings.robot[nearest].tolist(), bearings.target[nearest].tolist(), strict=True))
    return _sides(read.known, read.sources, landmarks, sights, ANGLE_ROUNDING / 2)


def sides_of_ranges(read: Directions, landmarks: Array, sights: Sights) -> Sighted:
    """Return the sides of some targets of ranges, as they were known with the bearings merged."""
    return _sides(read.seen, read.sources, landmarks, sights, WIDENING / 2)


def boxes_at_a_glance(read: Directions, before: Directions) -> Proof:
    """Return the sides of boxes that a pass has begun with, narrower than those of the pass before."""
    known = replace(read.known, lower=before.known.lower, upper=before.known.upper)
    sides = np.stack([before.known.lower - read.known.lower, read.known.upper - before.known.upper], axis=2)
    robot, k, end = np.nonzero(sides < 0)
    normal = (2 * end - 1)[:, None] * np.eye(2)[k]
    offset = np.where(end == 1, read.known.upper[robot, k], -read.known.lower[robot, k])
    i = np.full(len(robot), WORLD)
    return Proof("boxes", known, read.sources, i, robot, normal, offset, _corners(known, (i, robot), normal))


def _sides(known: Polytope, sources: Sources, landmarks: Array, sights: Sights, by: float) -> Sighted:
    """Return both sides of targets whose directions are known, and what each is about, robots being counted before landmarks.

    Args:
        known: From whose rows, at a glance.
        sources: What produced them.
        landmarks: (l, 2) [m].
        sights: Robots and targets.
        by: How far outward of what the filter takes for these directions a side is, so that its proof has room [rad].
    """
    robots = len(known.lower)
    robot, target = np.repeat(np.array(sorted(sights), dtype=np.int64).reshape(-1, 2), 2, axis=0).T
    spans, end = spans_of_targets(known, landmarks, robot, target), np.tile([-1, 1], len(robot) // 2)
    narrow = np.flatnonzero(~spans.full)
    robot, target, spans, end = robot[narrow], target[narrow], spans[narrow], end[narrow]
    angle, first, last = spans.centre + end * (spans.bound + by), np.minimum(robot, target), np.maximum(robot, target)
    outward, fixed = end[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=1), last >= robots
    i, j = np.where(fixed, WORLD, first), np.where(fixed, first, last)
    normal = np.where((fixed | (robot > target))[:, None], -outward, outward)
    places = np.concatenate([np.zeros((robots, 2)), landmarks])[last]
    offset = np.array([_below(*each) for each in zip(normal.tolist(), places.tolist(), strict=True)])
    weights = _corners(known, (i, j), normal)
    about = np.where(fixed, last, first)
    return Proof("sides", known, sources, i, j, normal, np.where(fixed, offset, 0.0), weights), about


def _below(normal: Sequence[float], place: Sequence[float]) -> float:
    """Return the greatest float that is not above normal . place."""
    exact = sum((Fraction(a) * Fraction(x) for a, x in zip(normal, place, strict=True)), Fraction(0))
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
