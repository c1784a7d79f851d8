"""Why headings and the near sides of ranges hold: where a target is, as seen from a robot, as claims with their proofs.

A side of a target is a line through the robot that the target is wholly to one side of: one claim on the pair, or on the robot
alone if the target is a landmark, proved like any edge. Two of them are an arc of directions.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import replace
from fractions import Fraction

import numpy as np

from filter import Array, Bearing, Belief, Integers, Proof, Rejected, Step, wrap
from filter.geometry.angles import ANGLE_ROUNDING
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.claims import Weights
from filter.sensing.headings import heading_arcs_of_bearing
from filter.sensing.readings import Readings
from filter.sensing.rows import WIDENING, bearing_rows, on_robots, spans_of_targets, world_arcs

Sighted = tuple[Proof, Integers]  # claims, and what each is about
NEAR = 1e-9  # an arc this near to the end of a heading is what has narrowed it there [rad]


def sides(belief: Belief, landmarks: Array, sights: Iterable[tuple[int, int | None]], by: float) -> Sighted:
    """Return both sides of targets whose directions are known, and what each is about, robots being counted before landmarks.

    Args:
        belief: From whose rows, at a glance.
        landmarks: (l, 2) [m].
        sights: Robots and targets.
        by: How far outward of what the filter takes for these directions a side is, so that its proof has room [rad].
    """
    polytope, robots = belief.polytope, len(belief.headings)
    robot, target = np.repeat(np.array(sorted(sights), dtype=np.int64).reshape(-1, 2), 2, axis=0).T
    spans, end = spans_of_targets(polytope, landmarks, robot, target), np.tile([-1, 1], len(robot) // 2)
    known = np.flatnonzero(~spans.full)
    robot, target, spans, end = robot[known], target[known], spans[known], end[known]
    angle, first, last = spans.centre + end * (spans.bound + by), np.minimum(robot, target), np.maximum(robot, target)
    outward, fixed = end[:, None] * np.stack([-np.sin(angle), np.cos(angle)], axis=1), last >= robots
    i, j = np.where(fixed, WORLD, first), np.where(fixed, first, last)
    normal = np.where((fixed | (robot > target))[:, None], -outward, outward)
    places = np.concatenate([np.zeros((robots, 2)), landmarks])[last]
    offset = np.array([_below(*each) for each in zip(normal.tolist(), places.tolist(), strict=True)])
    weights = _corners(polytope, (i, j), normal)
    about = np.where(fixed, last, first)
    return Proof("sides", polytope, belief.sources, i, j, normal, np.where(fixed, offset, 0.0), weights), about


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


def sides_behind_headings(step: Step[Belief], landmarks: Array) -> Sighted:
    """Return the sides of targets whose bearings have made headings narrower; landmarks are (l, 2) [m].

    Both sides of each: half a circle alone could meet another one at both ends.
    """
    known, headings, found = step.predicted, step.belief.headings, set[tuple[int, int]]()
    for record in _bearings(step):
        spans = spans_of_targets(known.polytope, landmarks, record.robot, record.target)
        arcs, claimed = heading_arcs_of_bearing(record, spans), headings[record.robot]
        for end in (-1, 1):
            off = np.abs(wrap(arcs.centre + end * arcs.bound - claimed.centre - end * claimed.bound))
            nearest = off < NEAR
            found |= set(zip(record.robot[nearest].tolist(), record.target[nearest].tolist(), strict=True))
    return sides(known, landmarks, found, ANGLE_ROUNDING / 2)


def sides_behind_ranges(step: Step[Belief], landmarks: Array) -> Sighted:
    """Return the sides of targets of ranges that proofs may rest on, as they were known with the bearings merged."""
    before, after = step.predicted, step.belief
    readings = Readings.of(before.time, _bearings(step))
    sources, numbers = readings.numbered(before.sources, len(before.headings))
    bearings = readings.bearings
    robot, arcs = bearings.robot, world_arcs(bearings, after.headings[bearings.robot])
    fresh = on_robots(bearing_rows(robot, bearings.target, arcs, numbers[: len(robot)]), before.polytope, landmarks)
    rows = Constraints.concatenate([before.constraints, fresh])
    known = replace(before, polytope=before.polytope.with_constraints(rows), sources=sources)
    proofs = (*after.proofs_of("regions"), *after.proofs_of("boxes"), *after.proofs_of("pairs"))
    used = [(proof.sources, proof.polytope.constraints.source[proof.weights.row]) for proof in proofs]
    used.append((after.sources, after.constraints.source))  # later steps may rest on these
    named = (table[number] for table, numbers in used for number in np.unique(numbers).tolist())
    found = {(one.robot, one.target) for one in named if one.kind == "range" and one.time == after.time}
    return sides(known, landmarks, found, WIDENING / 2)


def _bearings(step: Step[Belief]) -> list[Bearing]:
    """Return a step's bearings but those that the filter has rejected."""
    events = (event for event in step.belief.events if isinstance(event, Rejected))
    rejected = {(event.source.robot, event.source.target) for event in events if event.source.kind == "bearing"}
    found = []
    for record in step.frame.measurements:
        if isinstance(record, Bearing):
            seen = zip(record.robot.tolist(), record.target.tolist(), strict=True)
            kept = np.flatnonzero([pair not in rejected for pair in seen])
            columns = (getattr(record, name)[kept] for name in ("robot", "target", "bearing", "bound"))
            found.append(Bearing(record.time, *columns))
    return found
