"""From measurements to headings: what compasses and bearings say of them."""

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals, intersection
from filter.linear.sources import Source, Sources
from filter.records.measurements import Bearing, Compass
from filter.sensing.readings import Readings


def heading_arcs_of_compass(record: Compass) -> AngularIntervals:
    """Return (k) arcs that contain the measuring robots' headings [rad]."""
    return AngularIntervals(np.zeros(len(record.bound)), record.bound).turned(record.heading)


def heading_arcs_of_bearing(record: Bearing, spans: AngularIntervals) -> AngularIntervals:
    """Return (k) arcs that contain the measuring robots' headings, where (k) spans hold the targets' directions [rad]."""
    return spans.turned(-record.bearing, record.bound)


def narrowed_headings(headings: AngularIntervals, readings: Readings, spans: AngularIntervals) -> AngularIntervals:
    """Return the (n) headings after compasses, and bearings to targets whose directions are in (b) spans [rad].

    Raises `Inconsistent` if what is known and measured of a heading is proved to have nothing in common.
    """
    compasses, bearings = readings.compasses, readings.bearings
    found = heading_arcs_of_compass(compasses), heading_arcs_of_bearing(bearings, spans)
    robot = np.concatenate([compasses.robot, bearings.robot])
    arcs = AngularIntervals(*(np.concatenate([getattr(each, name) for each in found]) for name in ("centre", "bound")))
    order = np.lexsort((arcs.centre, arcs.bound))  # the narrowest first
    centre, bound = headings.centre.copy(), headings.bound.copy()
    last = _intersect((centre, bound), (arcs.centre, arcs.bound), robot, order)
    if last >= 0:
        sources, _ = Sources().extended("compass", compasses.time, compasses.robot)
        sources, _ = sources.extended("bearing", bearings.time, bearings.robot, bearings.target)
        raise _conflict(headings, arcs, sources, order[:last], order[last])
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


def _conflict(known: AngularIntervals, arcs: AngularIntervals, sources: Sources, before: Integers, last: int) -> Inconsistent:
    """Return the error that names the arc, of those before, which excludes the last one; if only all together do, then all."""
    robot, newest = sources.robot[last], sources[last]
    same = before[sources.robot[before] == robot]
    named = [Source("heading", newest.time, newest.robot), *map(sources.__getitem__, same)]
    every = AngularIntervals(np.append(known.centre[robot], arcs.centre[same]), np.append(known.bound[robot], arcs.bound[same]))
    apart = np.flatnonzero(every.intersection(arcs[np.full(len(every), last)]).empty)
    return Inconsistent(f"at {newest.time} s", [*(named[k] for k in (apart[:1] if len(apart) else range(len(named)))), newest])
