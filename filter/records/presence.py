"""Robots that join a team, come back, are put down somewhere, or leave it."""

from dataclasses import dataclass, field

from filter.arrays import Frozen, checked, instance, whole_number
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.records.record import TIME

ONE_ROBOT = checked(whole_number, "robot")


@dataclass(frozen=True, eq=False)
class Placed(Frozen):
    """A robot is in a set now, whatever was known of it before: it joins, comes back, or is put down somewhere.

    Raises `InvalidInput` if a value is of another type, or the arc is not one.

    Attributes:
        time: When [s].
        robot: Which one.
        polygon: Contains it; None stands for the team's arena.
        heading: One arc that contains its heading, or None when nothing is known.
    """

    time: float = field(metadata=TIME)
    robot: int = field(metadata=ONE_ROBOT)
    polygon: Polygon | None = field(default=None, metadata=checked(instance, "a polygon", Polygon, type(None)))
    heading: AngularIntervals | None = field(default=None, metadata=checked(instance, "an arc", AngularIntervals, type(None)))


@dataclass(frozen=True, eq=False)
class Left(Frozen):
    """A robot is away from now on: nothing is said of it until it is `Placed`. Raises `InvalidInput` as `Placed` does.

    Attributes:
        time: When [s].
        robot: Which one.
    """

    time: float = field(metadata=TIME)
    robot: int = field(metadata=ONE_ROBOT)


Change = Placed | Left
