"""Headings narrowed by what compasses and bearings say of them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals, intersection
from filter.linear.polytope import Polytope
from filter.linear.sources import Source, Sources
from filter.measurements import Bearing, Compass, Measurement
from filter.sensing.rows import heading_arcs_of_bearing, heading_arcs_of_compass, spans_of_targets


def narrowed_headings(
    headings: AngularIntervals, polytope: Polytope, measurements: Sequence[Measurement], landmarks: Array
) -> AngularIntervals:
    """Return the (n) headings after compasses, and bearings to targets whose direction is roughly known [rad].

    Args:
        headings: (n) what is known of them before.
        polytope: Where the robots are, as far as is known before.
        measurements: Of that time; ranges say nothing here.
        landmarks: (l, 2) their positions [m].

    Raises:
        Inconsistent: What is known and measured of a heading is proved to have nothing in common.
    """
    arcs, sources = [AngularIntervals(np.zeros(0), np.zeros(0))], Sources()
    for record in measurements:
        if isinstance(record, Compass):
            arcs.append(heading_arcs_of_compass(record))
            sources, _ = sources.extended("compass", record.time, record.robot)
        elif isinstance(record, Bearing):
            spans = spans_of_targets(polytope, landmarks, record.robot, record.target)
            arcs.append(heading_arcs_of_bearing(record, spans))
            sources, _ = sources.extended("bearing", record.time, record.robot, record.target)
    centre, bound = np.concatenate([each.centre for each in arcs]), np.concatenate([each.bound for each in arcs])
    return _narrowed(headings, AngularIntervals(centre, bound), sources)


def _narrowed(headings: AngularIntervals, arcs: AngularIntervals, sources: Sources) -> AngularIntervals:
    """Intersect headings with arcs, the narrowest first, so that the order they come in makes no difference."""
    order = np.lexsort((arcs.centre, arcs.bound))
    centre, bound = headings.centre.copy(), headings.bound.copy()
    last = _intersect((centre, bound), (arcs.centre, arcs.bound), sources.robot, order)
    if last >= 0:
        same = order[: last + 1][sources.robot[order[: last + 1]] == sources.robot[order[last]]]
        raise _disagreement(headings[sources.robot[order[[last]]]], arcs[same], [sources[int(k)] for k in same])
    return AngularIntervals(centre, bound)


@compiled
def _intersect(known: tuple[Array, Array], arcs: tuple[Array, Array], robot: Integers, order: Integers) -> int:
    """Narrow the arcs of robots in place; return the first place in the order where nothing is left, or -1."""
    centre, bound = known
    for k in range(len(order)):
        arc, whose = order[k], robot[order[k]]
        centre[whose], bound[whose] = intersection(centre[whose], bound[whose], arcs[0][arc], arcs[1][arc])
        if bound[whose] < 0:
            return k
    return -1


def _disagreement(known: AngularIntervals, measured: AngularIntervals, sources: list[Source]) -> Inconsistent:
    """Return the error that names the arc which excludes the last measured one; if only all together do, then all."""
    last = sources[-1]
    every = AngularIntervals(np.append(known.centre, measured.centre[:-1]), np.append(known.bound, measured.bound[:-1]))
    named = [Source("heading", last.time, last.robot), *sources[:-1]]
    apart = np.flatnonzero(every.intersection(measured[np.full(len(every), -1)]).empty)
    return Inconsistent(f"at {last.time} s", [*(named[k] for k in (apart[:1] if len(apart) else range(len(named)))), last])
