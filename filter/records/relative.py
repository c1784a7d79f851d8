"""The heading of a mate as a robot sees it: what a marker that is seen, or the matching of two scans, tells of it."""

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from filter.arrays import Array, Floats, Integers, checked, finite
from filter.records.radians import bearing_in_radians
from filter.records.record import ROBOT, SENSOR, TARGET, TIME, Sighting, centre


@dataclass(frozen=True, eq=False)
class RelativeHeading(Sighting):
    """By how much mates head elsewhere than the robot that measures: their heading less its own, to whole turns.

    Where sensors are named, it is the forward axis of the target's, as seen from that of the robot's. It tells nothing of
    places; where the mate is, is said by a `Bearing` and a `Range` (see `seen_position`). Raises `InvalidInput` as all
    records do (see `filter.records.measurements`). Refused as degrees are those of more than four turns, in either sense.

    Attributes:
        time: When [s].
        robot: (k,) who measured.
        target: (k,) robot that was seen, not itself; a landmark has no heading.
        heading: (k,) measured heading of the target, counter-clockwise from that of the robot [rad].
        bound: (k,) largest error, in [0, pi] [rad]; one of pi says nothing.
        sensor: (k,) which sensor of the robot measured.
        target_sensor: (k,) which sensor, or tag, of the target was seen.
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    target: Integers = field(metadata=TARGET)
    heading: Array = field(metadata=checked(finite, "relative heading [rad]"))
    bound: Array = field(metadata=checked(finite, "relative heading bound [rad]", 0, np.pi))
    sensor: Integers = field(default_factory=centre, metadata=SENSOR)
    target_sensor: Integers = field(default_factory=centre, metadata=SENSOR)

    if TYPE_CHECKING:  # numbers and sequences are taken, arrays are kept

        def __init__(
            self,
            time: float,
            robot: Floats,
            target: Floats,
            heading: Floats,
            bound: Floats,
            sensor: Floats = ...,
            target_sensor: Floats = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        bearing_in_radians(self.heading, "relative heading")
