"""Which measurements are behind an edge: regions are traced to what the sensors said, as far back as is asked."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from experiments.following.metrics import Words
from filter import Array, Belief, Compass, Integers, Proof, RelativeHeading, Source, Step
from filter.linear.sources import in_order
from filter.sensing.readings import Readings

WORLD = -1  # what an edge of a robot's own region is seen from
SAME_DIRECTION = 1e-6  # an edge whose normal is within this of a row's carries it alone [rad]


@dataclass(frozen=True, eq=False)
class Edge:
    """A line that bounds a robot, or where it is as seen from another.

    Attributes:
        time: When [s].
        i: The robot it is seen from, or WORLD.
        j: Robot.
        normal: (2,) outward.
    """

    time: float
    i: int
    j: int
    normal: Array


def traced(steps: Sequence[Step[Belief]], edges: Sequence[Edge]) -> tuple[Source, ...]:
    """Return what some edges come from, in order of time: what sensors said, and where the steps end what was known before.

    Args:
        steps: Those to trace back through, the last of which the edges are of.
        edges: Lines that hold there, or follow from two edges of a region.
    """
    at, left, seen = {step.frame.time: step for step in steps}, list(edges), set()
    found: set[Source] = set()
    while left:
        edge = left.pop()
        for source, behind in _rests_on(at[edge.time].belief, edge):
            found |= set(_driven(steps, source.time, edge))
            if source.kind != "region" or source.time not in at:
                found.add(source)
            elif (key := (behind.time, behind.i, behind.j, *behind.normal.tolist())) not in seen:
                seen.add(key)
                left.append(behind)
    found = {said for source in found for said in _said(at, source)}
    found |= {heading for source in found if source.time in at for heading in _headings(at[source.time], source)}
    return tuple(sorted(found, key=in_order))


def _rests_on(belief: Belief, edge: Edge) -> Iterator[tuple[Source, Edge]]:
    """Yield what an edge rests on: each row's source, and the row as an edge of that time."""
    for proof in belief.proofs_of("regions" if edge.i == WORLD else "pairs"):
        claims = np.flatnonzero((proof.i == edge.i) & (proof.j == edge.j))
        for claim in claims[_next_to(proof.normal[claims], edge.normal)].tolist() if len(claims) else ():
            yield from _rows_behind(proof, claim)


def _rows_behind(proof: Proof, claim: int) -> Iterator[tuple[Source, Edge]]:
    rows, origin, (used, _) = proof.polytope.constraints, proof.polytope.origin, proof.rests_on(claim)
    for row in used.tolist():
        source = proof.sources[int(rows.source[row])]
        yield source, Edge(source.time, int(rows.i[row]), int(rows.j[row]), rows.normal[row])
    if not len(used) and len(origin):  # it is a side of the box
        source = proof.sources[int(origin[proof.j[claim]])]
        yield source, Edge(source.time, WORLD, int(proof.j[claim]), proof.normal[claim])


def _next_to(normals: Array, normal: Array) -> Integers:
    """Return which of (e, 2) normals is that one, or which two are next to it on either side."""
    turns = np.arctan2(normals @ [-normal[1], normal[0]], normals @ normal)
    if np.abs(turns).min() <= SAME_DIRECTION:
        return np.array([np.abs(turns).argmin()])
    return np.array([np.where(turns > 0, turns, np.inf).argmin(), np.where(turns < 0, -turns, np.inf).argmin()])


def _driven(steps: Sequence[Step[Belief]], since: float, edge: Edge) -> Iterator[Source]:
    """Yield the odometry by which a row about an edge's robots was moved from an earlier time on [s]."""
    for step in steps:
        driven = step.frame.odometry
        if driven is not None and since < step.frame.time <= edge.time:
            for robot in {edge.i, edge.j} & set(driven.robot.tolist()):
                yield Source("odometry", step.frame.time, robot)


def _said(at: Mapping[float, Step[Belief]], source: Source) -> list[Source]:
    """Return what a source is: for cells, all that was said of the robot then."""
    if source.kind != "cells" or source.time not in at:
        return [source]
    return Readings.of(source.time, at[source.time].frame.measurements).concerning(source.robot)


def _headings(step: Step[Belief], source: Source) -> Iterator[Source]:
    """Yield what a bearing was turned by: compasses of the instant, also of mates whose heading was seen, or of theirs."""
    if source.kind == "bearing":
        told = [record for record in step.frame.measurements if isinstance(record, Compass | RelativeHeading)]
        readings, left, seen = Readings.of(source.time, told), [source.robot], set[int]()
        while left:
            robot = left.pop()
            seen.add(robot)
            said = readings.concerning(robot)
            yield from said
            left += {body for one in said for body in (one.robot, one.target) if body is not None} - seen


def in_words(sources: Sequence[Source], words: Words = str) -> str:
    """Return sources as text in the words of a team, those of one kind between the same two together."""
    alike: dict[Source, list[Source]] = defaultdict(list)
    for source in sources:
        alike[replace(source, time=0.0)].append(source)
    told = []
    for each in alike.values():
        who, when = words(each[0]).rpartition(" at ")[0], [source.time for source in each]
        several = f"{who} at {len(when)} times from {min(when):.3f} s to {max(when):.3f} s"
        told.append(several if len(when) > 1 else words(each[0]))
    return "; ".join(told)
