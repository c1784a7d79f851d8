"""From measurements to headings: what compasses, bearings and mates say of them."""

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled, put
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals, intersection, turned
from filter.linear.sources import Source, Sources
from filter.records.measurements import Bearing, Compass
from filter.sensing.readings import BEARINGS, COMPASSES, Readings
from filter.sensing.since import Moves, Since
from filter.sensing.ties import Ties, tie

Arcs = tuple[Array, Array]  # centres and bounds
OF_HEADINGS = ("compass", "bearing", "relative heading")  # what is measured of these


def heading_arcs_of_compass(record: Compass) -> AngularIntervals:
    """Return (k) arcs that contain the measuring robots' headings [rad]."""
    nothing = np.zeros(len(record.bound))
    return AngularIntervals.of_found(nothing, record.bound).turned_by(record.heading, nothing)


def heading_arcs_of_bearing(record: Bearing, spans: AngularIntervals) -> AngularIntervals:
    """Return (k) arcs that contain the measuring robots' headings, where (k) spans hold the targets' directions [rad]."""
    return spans.turned_by(-record.bearing, record.bound)


def narrowed_headings(headings: AngularIntervals, readings: Readings, spans: AngularIntervals) -> AngularIntervals:
    """Return the (n) headings after compasses, bearings to targets in directions of (b) spans, and mates' headings [rad].

    Raises `Inconsistent` if what is known and measured of a heading is proved to have nothing in common.
    """
    compasses, bearings = readings.compasses, readings.bearings
    found = heading_arcs_of_compass(compasses), heading_arcs_of_bearing(bearings, spans)
    robot = np.concatenate([compasses.robot, bearings.robot])
    arcs = AngularIntervals.of_found(*(np.concatenate([getattr(each, name) for each in found]) for name in ("centre", "bound")))
    order = np.lexsort((arcs.centre, arcs.bound))  # the narrowest first
    looks = np.stack([headings.centre, headings.bound])
    last = _intersect((looks[0], looks[1]), (arcs.centre, arcs.bound), robot, order)
    if last >= 0:
        sources, _ = Sources().extended("compass", compasses.time, compasses.robot, sensor=compasses.sensor)
        sources, _ = sources.extended("bearing", bearings.time, bearings.robot, bearings.target, bearings.sensor)
        raise _conflict(headings, arcs, sources, order[:last], order[last])
    if len(readings.relatives.robot) and (torn := tie(looks, Ties.of(readings, len(headings)))) >= 0:
        raise _torn(readings, torn)
    return AngularIntervals.of_found(*looks)


def looks_at_a_glance(since: Since, readings: Readings) -> tuple[AngularIntervals, Moves]:
    """Return what `headings_at` does without bearings, and where robots have gone, that looked so."""
    looks = headings_at(since, readings, AngularIntervals.circles(len(readings.bearings.robot)))
    return looks, since.moves(looks)


def headings_at(since: Since, readings: Readings, spans: AngularIntervals) -> AngularIntervals:
    """Return (s n + n) headings in the beginning and at each of s instants, as all readings tell; (b) spans hold directions.

    Raises `Inconsistent` if what is known and measured of a heading is proved to have nothing in common.
    """
    compasses, bearings, robots = readings.compasses, readings.bearings, len(since.headings)
    found = heading_arcs_of_compass(compasses), heading_arcs_of_bearing(bearings, spans)
    centre, bound = (np.concatenate([getattr(each, name) for each in found]) for name in ("centre", "bound"))
    place = np.concatenate([readings.at[COMPASSES] * robots + compasses.robot, readings.at[BEARINGS] * robots + bearings.robot])
    place += robots
    looks = _followed((since.headings.centre, since.headings.bound), since.turns, (centre, bound), (place, np.argsort(place)))
    if len(readings.relatives.robot):
        tie(looks, Ties.of(readings, robots))
    nothing = np.flatnonzero(looks[1] < 0)
    if len(nothing):
        robot = int(nothing[0]) % robots
        raise Inconsistent(f"up to {readings.compasses.time} s", [Source("heading", readings.compasses.time, robot)])
    return AngularIntervals.of_found(*looks)


@compiled
def _followed(before: Arcs, turns: Array, arcs: Arcs, places: tuple[Integers, Integers]) -> Array:
    """Return (2, s n + n) centres and bounds of headings, through (s, n, 2) turns and back, cut by arcs at their places."""
    steps, robots = turns.shape[:2]
    looks, (place, order), following = np.empty((2, (steps + 1) * robots)), places, 0
    put(before[0], looks[0])
    put(before[1], looks[1])
    for k in range(robots, looks.shape[1]):
        turn = turns[k // robots - 1, k % robots]
        centre, bound = turned(looks[0, k - robots], looks[1, k - robots], turn[0], turn[1])
        while following < len(order) and place[order[following]] == k:
            centre, bound = intersection(centre, bound, arcs[0][order[following]], arcs[1][order[following]])
            following += 1
        looks[0, k], looks[1, k] = centre, bound
    for k in range(looks.shape[1] - robots - 1, -1, -1):
        turn = turns[k // robots, k % robots]
        centre, bound = turned(looks[0, k + robots], looks[1, k + robots], -turn[0], turn[1])
        looks[0, k], looks[1, k] = intersection(looks[0, k], looks[1, k], centre, bound)
    return looks


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


def _torn(readings: Readings, which: int) -> Inconsistent:
    """Return the error that names what a relative heading excludes: all that is known and measured of the two headings."""
    relatives = readings.relatives
    two, time = (int(relatives.robot[which]), int(relatives.target[which])), relatives.time
    said = [source for robot in two for source in readings.concerning(robot) if source.kind in OF_HEADINGS]
    return Inconsistent(f"at {time} s", [*(Source("heading", time, robot) for robot in two), *dict.fromkeys(said)])
