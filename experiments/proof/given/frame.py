"""What came with one frame, in exact numbers. Standard library only."""

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from fractions import Fraction

from experiments.proof.edges import SIDES, plane, through_corner
from experiments.proof.exact import Arc, Vector, length
from experiments.proof.given.sensors import CENTRE, Mount
from experiments.proof.motion import Piece

Who = tuple[str, int, int | None]  # kind, robot, target
Pose = tuple[Vector | None, Fraction | None]  # a true place and a true heading, None for what nobody knows
MATES = "relative_heading"  # the kind that says how mates look, as seen by a robot
BOX = [plane(direction) for _, _, direction in SIDES]


@dataclass(frozen=True)
class Reading:
    """One compass reading, bearing, range or relative heading.

    Attributes:
        value: [rad] or [m]; an angle is from the robot's forward axis, wherever the sensor looks.
        bound: Likewise.
        share: A further error of a range, as a share of it.
        own: How the sensor that measures is mounted.
        other: How the one that is measured is.
    """

    value: Fraction
    bound: Fraction
    share: Fraction = Fraction(0)
    own: Mount = CENTRE
    other: Mount = CENTRE


@dataclass(frozen=True)
class Within:
    """A robot is so near to the convex hull of some corners [m]."""

    corners: Sequence[Vector]
    radius: Fraction = Fraction(0)

    def most(self, normal: Vector) -> Fraction:
        """Return a number no smaller than normal . p."""
        farthest = max(normal[0] * x + normal[1] * y for x, y in self.corners)
        return farthest + self.radius * length(normal) if self.radius else farthest


@dataclass(frozen=True)
class Behind:
    """A robot is behind a line, normal . p <= offset."""

    normal: Vector
    offset: Fraction


Place = Within | Behind


@dataclass(frozen=True)
class Start:
    """What is known of a robot from some time on, whatever was known before.

    Attributes:
        place: Where it is.
        heading: Which way it looks.
    """

    place: Within
    heading: Arc


def most_of(place: Place, normal: Vector, edges: dict[Vector, Fraction]) -> Fraction | None:
    """Return a number no smaller than normal . p of a robot in a place; None if nothing says one.

    Of a robot behind a line it follows from the line, or from it and a side of the robot's box, which is among its edges: as a
    rule the normals are the same, or one is the other made of length 1 in floats, which may be turned by a hair.
    """
    if isinstance(place, Within):
        return place.most(normal)
    if normal == place.normal:
        return place.offset
    box = {side: edges[side] for side in BOX if side in edges}
    return through_corner({**box, place.normal: place.offset}, normal)


@dataclass
class Frame:
    """What came with one frame.

    Attributes:
        time: [s].
        readings: Of each kind, robot and target (None for a compass): every reading.
        places: Of each robot, where a sensor of it is, by each position that was measured, and how that is mounted.
        truth: Of robots, where they were and which way they looked.
        measurements: How many were taken; a position of one robot, or one sensor, is one, however many sides it has.
        changes: Robots that were put somewhere, or None for one that has left, in this order, after the motion.
        away: Robots that are not there, then.
        pieces: Of each robot, how it moved since the frame before, one after the other; nothing if no time has passed.
    """

    time: float
    readings: dict[Who, list[Reading]] = field(default_factory=dict)
    places: dict[int, list[tuple[Place, Mount]]] = field(default_factory=dict)
    truth: dict[int, Pose] = field(default_factory=dict)
    measurements: int = 0
    changes: list[tuple[int, Start | None]] = field(default_factory=list)
    away: frozenset[int] = frozenset()
    pieces: list[list[Piece]] = field(default_factory=list)

    @property
    def placed(self) -> dict[int, Start]:
        """Where robots were put, at last."""
        return {robot: start for robot, start in self.changes if start}

    def only(self, *kinds: str) -> "Frame":
        """Return the same with readings of some kinds alone."""
        return replace(self, readings={who: some for who, some in self.readings.items() if who[0] in kinds})

    def of(self, kind: str, robot: int, target: int | None = None) -> list[Reading]:
        """Return all that one robot measured of a target."""
        return self.readings.get((kind, robot, target), [])
