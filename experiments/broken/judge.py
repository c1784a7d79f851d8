"""An independent judge: is it proved that past and instant exclude each other? Branch and bound over boxes of poses.

Of every robot the past is where it was known to be before the fault, moved by what was told; the instant is what was seen and
measured in one frame, of landmarks at their places on the map, of mates wherever their own past lets them be. If no pose is
left for some robot, a bound must have been broken, and nobody needs the truth to see it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from experiments.broken.boxes import Boxes
from experiments.broken.past import Past
from filter import AngularIntervals, Array, Bearing, Compass, Frame, Mask, Polygon, Range, Team

FINEST = 0.004  # half-sides of boxes that are not split any more [m]
MOST = 20_000  # boxes at a time; with more nothing is proved
LEVER = 4.0  # how far away what is seen is, about [m]

Corners = tuple[Array, Array]


@dataclass(frozen=True, eq=False)
class Instant:
    """What one frame says of one robot's pose.

    Attributes:
        ranges: Corners (s, 2) of bodies that are so far away, and (s, 2) least and greatest distances [m].
        bearings: The same of bodies that it sees, with (s, 2) bearings and their bounds [rad].
        directions: The same of mates that see it, with (s, 2) directions and their bounds [rad].
        headings: (c, 2) what its compass says, and the bounds [rad].
    """

    ranges: tuple[Corners, Array]
    bearings: tuple[Corners, Array]
    directions: tuple[Corners, Array]
    headings: Array

    def allows(self, boxes: Boxes) -> Mask:
        """Return (k,) which boxes have a pose left for each of the things that it says."""
        seen = boxes.within_range(*self.ranges) & boxes.within_bearing(*self.bearings)
        return seen & boxes.within_direction(*self.directions) & boxes.within_heading(self.headings)


@dataclass(frozen=True, eq=False)
class Judge:
    """Follows what was known before a fault by what is told alone, and holds each frame against it.

    Attributes:
        team: The robots and the landmarks on the map.
        pasts: (n) of the robots.
    """

    team: Team
    pasts: tuple[Past, ...]

    @classmethod
    def of(cls, team: Team, regions: Sequence[Polygon], headings: AngularIntervals | None) -> Judge:
        """Return one who knows regions and headings (n) of a time at which all bounds had held; None for unknown headings."""
        arcs = AngularIntervals.circles(team.robots) if headings is None else headings
        return cls(team, tuple(Past.of(region, arcs, robot) for robot, region in enumerate(regions)))

    def after(self, frame: Frame) -> Judge:
        """Return one who knows what was told of the motion to a frame, too."""
        told = frame.odometry
        if told is None:
            return self
        return Judge(self.team, tuple(past.moved(told, robot) for robot, past in enumerate(self.pasts)))

    def proves(self, frame: Frame) -> bool:
        """Return whether for some robot no pose is left, at a frame to which this judge has come."""
        places = self.places()
        return any(is_empty(past, self.instant(frame, robot, places)) for robot, past in enumerate(self.pasts))

    def places(self) -> Corners:
        """Return corners (n + l, 2) of where every body can be [m]."""
        boxes = [past.box for past in self.pasts]
        low, high = (np.array([box.middle[0, :2] + sign * box.half[0, :2] for box in boxes]) for sign in (-1, 1))
        marks = self.team.landmarks
        return np.concatenate([low, marks]), np.concatenate([high, marks])

    def instant(self, frame: Frame, robot: int, places: Corners) -> Instant:
        """Return what a frame says of one robot, by its own sensors and by mates that see it."""
        arcs = np.array([past.heading_now for past in self.pasts])
        lengths = _columns(frame, Range, "robot", "target", "range", "bound", "relative_bound")
        angles = _columns(frame, Bearing, "robot", "target", "bearing", "bound")
        compass = _columns(frame, Compass, "robot", "heading", "bound")
        own, by = angles[angles[:, 0] == robot], angles[angles[:, 1] == robot]
        either = lengths[(lengths[:, :2] == robot).any(axis=1)]
        apart, off = either[:, 2], either[:, 3]
        distances = np.stack([(apart - off) / (1 + either[:, 4]), (apart + off) / (1 - either[:, 4])], axis=1)
        mates = by[:, 0].astype(int)
        return Instant(
            (_at(places, either[:, :2].sum(axis=1) - robot), distances),
            (_at(places, own[:, 1]), own[:, 2:]),
            (_at(places, mates), by[:, 2:] + arcs[mates]),
            compass[compass[:, 0] == robot, 1:],
        )


def _columns(frame: Frame, kind: type, *names: str) -> Array:
    """Return (k, len(names)) columns of all records of a kind in a frame."""
    records = [record for record in frame.measurements if isinstance(record, kind)]
    return np.concatenate(
        [np.zeros((0, len(names))), *(np.stack([getattr(each, name) for name in names], axis=1) for each in records)]
    )


def _at(places: Corners, bodies: Array) -> Corners:
    low, high = places
    return low[bodies.astype(int)], high[bodies.astype(int)]


def is_empty(past: Past, instant: Instant) -> bool:
    """Return whether it is proved that no pose is in both; as soon as one is found that nothing excludes, it is not."""
    boxes = past.box
    while len(boxes := boxes.select(past.allows(boxes) & instant.allows(boxes))):
        middles = boxes.middles
        if len(boxes) > MOST or (past.allows(middles) & instant.allows(middles)).any():
            return False
        if (boxes.half * [1.0, 1.0, LEVER]).max() < FINEST:
            return False
        boxes = boxes.split(LEVER)
    return True
