"""Everything that is compiled, made or loaded before it is needed, so that no step of a run has to wait for it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from filter.compiled import MADE
from filter.geometry.angles import AngularIntervals
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.projection.window import Window
from filter.robust.robust_filter import RobustFilter
from filter.sets.set_membership import SetMembershipFilter
from filter.team import Team

# A small scene: robots that drive straight on among landmarks and see everything, each measurement right but the last range.
PLACES, HEADINGS = np.array([[0.0, 0.0], [2.0, 0.5], [1.0, 2.0]]), np.array([0.3, 2.0, -1.0])  # [m] [rad]
LANDMARKS = np.array([[3.0, 3.0], [-1.0, 2.0]])  # [m]
STEPS, DURATION, DRIVEN, BOUND, LIE = 3, 0.125, 0.05, 0.05, 1.0  # [1] [s] [m] [m] or [rad] [m]


def warm_up() -> int:
    """Compile everything, or load it; return how many functions had to be compiled.

    To compile takes a minute or so, to load what is kept on disk a second or two. Afterwards no filter has to do either.
    """
    before = _made()
    team = Team(len(PLACES), LANDMARKS, speed_limit=1.0, turn_rate_limit=1.0, arena=np.array([[-9.0, -9.0], [9.0, 9.0]]))
    for filter_ in (
        SetMembershipFilter(team, policy="reject"),
        SetMembershipFilter.light(team, scope=Window(hops=1), policy="reject"),
        SetMembershipFilter(team, exact=False, policy="reject"),
        RobustFilter(team),
    ):
        _follow(filter_)
    return _made() - before


def _made() -> int:
    return sum(sum(each.stats.cache_misses.values()) for each in MADE)


def _follow(filter_: Any) -> None:
    """Let a filter follow the scene, from known headings and from unknown ones, and look at its regions."""
    boxes, arcs = (
        [Polygon.box(place - 1, place + 1) for place in PLACES],
        AngularIntervals(HEADINGS, np.full(len(PLACES), BOUND)),
    )
    arcs.intersection(arcs)
    for headings in (arcs, None):
        belief = filter_.start(0.0, boxes, headings)
        for odometry, records in _scene():
            belief = filter_.update(filter_.predict(belief, odometry.time, odometry), records)
        polygons = [region.outer for region in belief.regions]
        _ = Polygons.of(polygons).areas, [(polygon.area, polygon.centroid) for polygon in polygons]


def _scene() -> Iterator[tuple[Odometry, list[Measurement]]]:
    """Yield what each step brings; in the last one a robot has no odometry, none has a compass, and a range is a lie."""
    robots, bodies = len(PLACES), len(PLACES) + len(LANDMARKS)
    who, whom = np.divmod(np.flatnonzero(~np.eye(robots, bodies, dtype=bool)), bodies)
    ways = np.stack([np.cos(HEADINGS), np.sin(HEADINGS)], axis=1)
    for step in range(1, STEPS + 1):
        time, last = step * DURATION, step == STEPS
        apart = np.concatenate([PLACES + step * DRIVEN * ways, LANDMARKS])[whom] - (PLACES + step * DRIVEN * ways)[who]
        bearings, ranges = np.arctan2(apart[:, 1], apart[:, 0]) - HEADINGS[who], np.hypot(*apart.T)
        ranges[-1] += LIE * last
        driving = np.arange(robots - last)
        bound, sure, straight = np.full(len(driving), BOUND), np.full(len(who), BOUND), np.zeros(len(driving))
        records: list[Measurement] = [] if last else [Compass(time, np.arange(robots), HEADINGS, np.full(robots, BOUND))]
        records += [Bearing(time, who, whom, bearings, sure), Range(time, who, whom, ranges, sure, np.zeros(len(who)))]
        path = np.full(len(driving), DRIVEN)
        yield Odometry(time - DURATION, time, driving, path, bound, straight, bound, bound, bound), records
