"""What a usual line of a log holds, as types that msgspec decodes. See docs/log.md."""

from __future__ import annotations

from typing import Annotated, Generic, TypeVar

import numpy as np
from msgspec import UNSET, Meta, Struct, UnsetType
from msgspec.json import Decoder

from experiments.logs.checks import LARGEST, SHORTEST

Number = Annotated[float, Meta(ge=-LARGEST, le=LARGEST)]
Positive = Annotated[float, Meta(ge=0, le=LARGEST)]
Duration = Annotated[float, Meta(ge=SHORTEST, le=LARGEST)]
HalfTurn = Annotated[float, Meta(ge=0, le=np.pi)]
RightAngle = Annotated[float, Meta(ge=0, lt=np.pi / 2)]
Angle = Annotated[float, Meta(ge=-2 * np.pi, le=2 * np.pi)]
Share = Annotated[float, Meta(ge=0, lt=1)]
Whole = Annotated[int, Meta(ge=0)]
Point = tuple[Number, Number]

Named = Whole | str
Pair = Number | list[Number]  # no tuple: msgspec 0.23 mixes up the limits of a number with a tuple's beside it
Body = TypeVar("Body")  # a number, or from version 2 on a name, too
Bound = TypeVar("Bound")  # an entry of a list: a bound, or from version 2 on any number or a pair of them


class Line(Struct, tag_field="record", forbid_unknown_fields=True, gc=False):
    """Base of lines."""


class OdometryLine(Line, Generic[Body], tag="odometry"):
    """A line of odometry."""

    start: Number
    time: Number
    robot: Body | list[Body]
    distance: Number | list[Number]
    distance_bound: Positive | list[Positive]
    turn: Number | list[Number]
    turn_bound: Positive | list[Positive]
    direction_bound: RightAngle | list[RightAngle]
    slip_bound: Positive | list[Positive]
    aside: Angle | list[Angle] | UnsetType = UNSET  # from version 2 on


class TwistLine(Line, Generic[Body], tag="twist"):
    """A line of twists."""

    time: Number
    robot: Body | list[Body]
    speed: Number | list[Number]
    speed_bound: Positive | list[Positive]
    turn_rate: Number | list[Number]
    turn_rate_bound: Positive | list[Positive]
    direction_bound: RightAngle | list[RightAngle]
    slip_rate: Positive | list[Positive]
    hold: Duration | list[Duration]
    aside: Angle | list[Angle] | UnsetType = UNSET


class CompassLine(Line, Generic[Body, Bound], tag="compass"):
    """A line of compasses."""

    time: Number
    robot: Body | list[Body]
    heading: Number | list[Number]
    bound: HalfTurn | list[Bound]
    sensor: Body | list[Body | None] | UnsetType | None = UNSET  # from version 2 on


class BearingLine(Line, Generic[Body, Bound], tag="bearing"):
    """A line of bearings."""

    time: Number
    robot: Body | list[Body]
    bearing: Number | list[Number]
    bound: HalfTurn | list[Bound]
    target: Body | list[Body | None] | UnsetType | None = UNSET
    landmark: Body | list[Body | None] | UnsetType | None = UNSET
    sensor: Body | list[Body | None] | UnsetType | None = UNSET
    target_sensor: Body | list[Body | None] | UnsetType | None = UNSET


class RangeLine(Line, Generic[Body, Bound], tag="range"):
    """A line of ranges."""

    time: Number
    robot: Body | list[Body]
    range: Positive | list[Positive]
    bound: Positive | list[Bound]
    relative_bound: Share | list[Share]
    target: Body | list[Body | None] | UnsetType | None = UNSET
    landmark: Body | list[Body | None] | UnsetType | None = UNSET
    sensor: Body | list[Body | None] | UnsetType | None = UNSET
    target_sensor: Body | list[Body | None] | UnsetType | None = UNSET


class RelativeHeadingLine(Line, Generic[Body, Bound], tag="relative_heading"):
    """A line of relative headings."""

    time: Number
    robot: Body | list[Body]
    target: Body | list[Body]
    heading: Number | list[Number]
    bound: HalfTurn | list[Bound]
    sensor: Body | list[Body | None] | UnsetType | None = UNSET
    target_sensor: Body | list[Body | None] | UnsetType | None = UNSET


class FixLine(Line, Generic[Body], tag="position"):
    """One robot's position, within a bound in x and y."""

    time: Number
    robot: Body
    position: Point
    bound: Positive | list[Positive]
    sensor: Body | UnsetType | None = UNSET


class TruthLine(Line, tag="truth"):
    """The truth of all robots."""

    time: Number
    positions: list[Point]
    headings: list[Number]


class SomeTruthLine(Line, Generic[Body], tag="truth"):
    """The truth of one robot, or of all; nobody knows what is null."""

    time: Number
    positions: list[Point | None] | UnsetType = UNSET
    headings: list[Number | None] | UnsetType = UNSET
    robot: Body | UnsetType = UNSET
    position: Point | UnsetType | None = UNSET
    heading: Number | UnsetType | None = UNSET


class FrameLine(Line, tag="frame"):
    """The end of a frame."""

    time: Number


first: Decoder[Line] = Decoder(
    OdometryLine[Whole]
    | CompassLine[Whole, HalfTurn]
    | BearingLine[Whole, HalfTurn]
    | RangeLine[Whole, Positive]
    | TruthLine
    | FrameLine
)
second: Decoder[Line] = Decoder(
    OdometryLine[Named]
    | TwistLine[Named]
    | CompassLine[Named, Pair]
    | BearingLine[Named, Pair]
    | RangeLine[Named, Pair]
    | RelativeHeadingLine[Named, Pair]
    | FixLine[Named]
    | SomeTruthLine[Named]
    | FrameLine
)
