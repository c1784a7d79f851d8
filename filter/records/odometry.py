"""How robots moved: what their wheels or their commands say of it."""

from collections.abc import Collection
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from filter.arrays import Array, Floats, Integers, checked, finite, number
from filter.errors import InvalidInput
from filter.records.record import BELOW_90_DEGREES, ROBOT, TIME, Record, field_names

SHORTEST = 1e-6  # that a twist holds [s]


@dataclass(frozen=True, eq=False)
class Odometry(Record):
    """How robots moved between two instants, from wheel encoders or commands.

    The robot drove a path of signed length within `distance +- distance_bound` while it turned by `turn +- turn_bound`;
    its displacement is that path turned from the straight line along (first heading + turn / 2 + aside) by at most
    `direction_bound`, plus a slip of at most `slip_bound` in any direction.

    Attributes:
        start: Beginning of the motion [s].
        time: End of the motion, not before its start [s].
        robot: (k,) who moved; at most once each.
        distance: (k,) path length, negative when driving backwards [m].
        distance_bound: (k,) its largest error [m].
        turn: (k,) change of heading, counter-clockwise [rad].
        turn_bound: (k,) its largest error, from 0 on [rad].
        direction_bound: (k,) largest deviation of the motion's direction, in [0, pi/2) [rad].
        slip_bound: (k,) largest further displacement [m].
        aside: (k,) which way the robot drives, from its forward axis, in [-2 pi, 2 pi] [rad]: 0 on wheels that cannot do
            otherwise, pi/2 for one that strafes to its left.
    """

    start: float = field(metadata=checked(number, "start [s]"))
    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    distance: Array = field(metadata=checked(finite, "distance [m]"))
    distance_bound: Array = field(metadata=checked(finite, "distance bound [m]", 0))
    turn: Array = field(metadata=checked(finite, "turn [rad]"))
    turn_bound: Array = field(metadata=checked(finite, "turn bound [rad]", 0))
    direction_bound: Array = field(metadata=checked(finite, "direction bound [rad]", 0, BELOW_90_DEGREES))
    slip_bound: Array = field(metadata=checked(finite, "slip bound [m]", 0))
    aside: Array = field(default_factory=lambda: np.zeros(1), metadata=checked(finite, "aside [rad]", -2 * np.pi, 2 * np.pi))

    if TYPE_CHECKING:

        def __init__(
            self,
            start: float,
            time: float,
            robot: Floats,
            distance: Floats,
            distance_bound: Floats,
            turn: Floats,
            turn_bound: Floats,
            direction_bound: Floats,
            slip_bound: Floats,
            aside: Floats = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.time < self.start:
            raise InvalidInput(f"odometry that ends at its start or later, from {self.start!r} s on", f"{self.time!r} s")
        if len(np.unique(self.robot)) < len(self.robot):
            raise InvalidInput("odometry: each robot at most once", f"robots {self.robot.tolist()}")

    def without(self, robots: Collection[int]) -> "Odometry":
        """Return the motion of all others."""
        others = np.flatnonzero(~np.isin(self.robot, list(robots)))
        columns = {name: getattr(self, name)[others] for name in field_names(self)}
        return Odometry.of_checked(self.time, columns, start=self.start)


@dataclass(frozen=True, eq=False)
class Twist(Record):
    """How fast robots drive and turn from a time on: until their next record of motion, or for as long as it holds.

    At every moment until then the speed is within `speed +- speed_bound`, the turn rate within `turn_rate +- turn_rate_bound`.
    What else is said of the motion is as in `Odometry`, slip in proportion to the time.

    Attributes:
        time: From when on [s].
        robot: (k,) who moves; at most once each.
        speed: (k,) negative when driving backwards [m/s].
        speed_bound: (k,) its largest error [m/s].
        turn_rate: (k,) counter-clockwise [rad/s].
        turn_rate_bound: (k,) its largest error [rad/s].
        direction_bound: (k,) largest deviation of the motion's direction, in [0, pi/2) [rad].
        slip_rate: (k,) largest further displacement in a second [m/s].
        hold: (k,) for how long it holds, above 0 [s].
        aside: (k,) which way the robot drives, from its forward axis, in [-2 pi, 2 pi] [rad].
    """

    time: float = field(metadata=TIME)
    robot: Integers = field(metadata=ROBOT)
    speed: Array = field(metadata=checked(finite, "speed [m/s]"))
    speed_bound: Array = field(metadata=checked(finite, "speed bound [m/s]", 0))
    turn_rate: Array = field(metadata=checked(finite, "turn rate [rad/s]"))
    turn_rate_bound: Array = field(metadata=checked(finite, "turn rate bound [rad/s]", 0))
    direction_bound: Array = field(metadata=checked(finite, "direction bound [rad]", 0, BELOW_90_DEGREES))
    slip_rate: Array = field(metadata=checked(finite, "slip rate [m/s]", 0))
    hold: Array = field(metadata=checked(finite, "hold [s]", SHORTEST))
    aside: Array = field(default_factory=lambda: np.zeros(1), metadata=checked(finite, "aside [rad]", -2 * np.pi, 2 * np.pi))

    if TYPE_CHECKING:

        def __init__(
            self,
            time: float,
            robot: Floats,
            speed: Floats,
            speed_bound: Floats,
            turn_rate: Floats,
            turn_rate_bound: Floats,
            direction_bound: Floats,
            slip_rate: Floats,
            hold: Floats,
            aside: Floats = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        super().__post_init__()
        if len(np.unique(self.robot)) < len(self.robot):
            raise InvalidInput("a twist of each robot at most once", f"robots {self.robot.tolist()}")
