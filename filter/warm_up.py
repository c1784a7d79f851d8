"""Everything that is compiled, made or loaded before it is needed, so that no step of a run has to wait for it."""

from collections.abc import Iterator
from itertools import islice
from typing import Any

import numpy as np

from filter.compiled import MADE
from filter.diagnosis.robust_filter import RobustFilter
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.diagnosis.tolerance import Tolerance
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.geometry.around import lines_around
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.motions import Motions
from filter.projection.window import Window
from filter.records.frame import Frame
from filter.records.measurements import Bearing, Compass, Measurement, Range
from filter.records.odometry import Odometry
from filter.records.relative import RelativeHeading
from filter.team import Team

# A small scene: robots that drive straight on among landmarks and see everything; at last a range comes alone, and is wrong.
PLACES, HEADINGS = np.array([[0.0, 0.0], [2.0, 0.5], [1.0, 2.0]]), np.array([0.3, 2.0, -1.0])  # [m] [rad]
LANDMARKS = np.array([[3.0, 3.0], [-1.0, 2.0]])  # [m]
STEPS, DURATION, DRIVEN, BOUND, LIE = 4, 0.125, 0.05, 0.05, 1.0  # [1] [s] [m] [m] or [rad] [m]


def warm_up() -> int:
    """Compile everything, or load it; return how many functions had to be compiled.

    To compile takes a minute or so, to load what is kept on disk a second or two. Afterwards no filter has to do either.
    """
    before, team = _made(), Team(len(PLACES), LANDMARKS, 1.0, 1.0, [[-9.0, -9.0], [9.0, 9.0]])
    _follow(SetMembershipFilter(team))
    _together(SetMembershipFilter(team))
    _follow(SetMembershipFilter.light(team, scope=Window(hops=1)))
    _follow(SetMembershipFilter(team, exact=False))
    _follow(RobustFilter(team))
    _tolerated(SetMembershipFilter.light(team, tolerance=Tolerance(1, DURATION, "cameras")))
    _tolerated(SetMembershipFilter.light(team, tolerance=Tolerance(1, DURATION, "identities")))
    return _made() - before


def _made() -> int:
    return sum(sum(each.stats.cache_misses.values()) for each in MADE)


def _follow(filter_: Any) -> None:
    """Let a filter follow the scene, from known headings and from unknown ones, and look at its regions."""
    boxes = [Polygon.box(place - 1, place + 1) for place in PLACES]
    arcs = AngularIntervals(HEADINGS, np.full(len(PLACES), BOUND))
    arcs.intersection(arcs)
    for headings in (arcs, None):
        belief = filter_.start(0.0, boxes, headings)
        for odometry, records in _scene():
            belief = _told(filter_, filter_.predict(belief, odometry.time, odometry), records)
        polygons = [region.outer for region in belief.regions]
        _ = lines_around([Polygons.of(polygons)] * 2)
        _ = Polygons.of(polygons).areas, [(polygon.area, polygon.centroid) for polygon in polygons]


def _told(filter_: Any, belief: Any, records: list[Measurement]) -> Any:
    """Return a belief after records; as it was if these are proved to be in conflict, which is looked for, too."""
    try:
        return filter_.update(belief, records)
    except Inconsistent:
        return belief


def _together(filter_: SetMembershipFilter) -> None:
    """Let a filter merge two instants at once, and join what was driven up to them."""
    boxes, arcs = (
        [Polygon.box(place - 1, place + 1) for place in PLACES],
        AngularIntervals(HEADINGS, np.full(len(PLACES), BOUND)),
    )
    told = [(odometry, [*records, _mate(odometry.time)]) for odometry, records in islice(_scene(), 2)]
    frames = [Frame(odometry.time, odometry, records) for odometry, records in told]
    filter_.advance(filter_.start(0.0, boxes, arcs), frames)
    motions = Motions(filter_.team)
    for frame in frames:
        motions = motions.merged(frame.odometry) if frame.odometry else motions
    motions.since(DURATION).between(DURATION / 2, 2 * DURATION)


def _tolerated(filter_: SetMembershipFilter) -> None:
    """Let a filter that tolerates a lie follow ranges alone, of robots whose headings are unknown, until a window ends."""
    belief = filter_.start(0.0, [Polygon.box(place - 1, place + 1) for place in PLACES])
    for odometry, records in islice(_scene(), 3):
        ranges = [record for record in records if isinstance(record, Range)]
        belief = filter_.update(filter_.predict(belief, odometry.time, odometry), ranges)


def _mate(time: float) -> RelativeHeading:
    """Return how the last robot looks, as the first one sees it."""
    return RelativeHeading(time, 0, len(PLACES) - 1, HEADINGS[-1] - HEADINGS[0], BOUND)


def _scene() -> Iterator[tuple[Odometry, list[Measurement]]]:
    """Yield what each step brings; before the last one, a robot has no odometry and none has a compass.

    The wrong range is alone, as the search for what is wrong takes the longer, the more is measured.
    """
    robots, bodies = len(PLACES), len(PLACES) + len(LANDMARKS)
    who, whom = np.divmod(np.flatnonzero(~np.eye(robots, bodies, dtype=bool)), bodies)
    ways = np.stack([np.cos(HEADINGS), np.sin(HEADINGS)], axis=1)
    for step in range(1, STEPS + 1):
        time, blind = step * DURATION, step == STEPS - 1
        places = PLACES + step * DRIVEN * ways
        apart = np.concatenate([places, LANDMARKS])[whom] - places[who]
        bearings, ranges = np.arctan2(apart[:, 1], apart[:, 0]) - HEADINGS[who], np.hypot(*apart.T)
        records: list[Measurement] = [] if blind else [Compass(time, np.arange(robots), HEADINGS, BOUND)]
        records += [Bearing(time, who, whom, bearings, BOUND), Range(time, who, whom, ranges, BOUND, 0)]
        if step == STEPS:
            records = [Range(time, who[-1], whom[-1], ranges[-1] + LIE, BOUND, 0)]
        yield Odometry(time - DURATION, time, np.arange(robots - blind), DRIVEN, BOUND, 0, BOUND, BOUND, BOUND), records
