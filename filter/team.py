"""What is known of a team for good: how many robots, where the landmarks are, how far anything can be."""

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from filter.arrays import (
    LARGEST,
    MOST_ROBOTS,
    Array,
    Floats,
    Frozen,
    checked,
    finite,
    floats,
    instance,
    number,
    several,
    shown,
    whole_number,
)
from filter.errors import InvalidInput, OutOfOrder
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.records.measurements import Bearing, Compass, Measurement, Range, measurements_of
from filter.records.odometry import Odometry

ARENA = "(2, 2) lower corner below upper corner [m], infinite where it is open"


def _places(name: str, values: Floats) -> Array:
    landmarks = finite(name, values)
    landmarks = landmarks if landmarks.size else np.zeros((0, 2))
    if landmarks.ndim != 2 or landmarks.shape[1] != 2:
        raise InvalidInput("landmarks as (l, 2) coordinates", f"shape {landmarks.shape}")
    return landmarks


def _box(name: str, values: Floats) -> Array:
    arena = floats(name, values, ARENA)
    if arena.shape != (2, 2) or not ((arena[0] <= np.minimum(arena[1], LARGEST)) & (arena[1] >= -LARGEST)).all():
        raise InvalidInput(f"{name}: {ARENA}", shown(arena.tolist()))
    return arena


@dataclass(frozen=True, eq=False)
class Team(Frozen):
    """A team of robots 0, 1, ..., n - 1 among landmarks n, n + 1, ... Raises `InvalidInput` if a value is out of its range.

    Attributes:
        robots: Number of robots n, from 1 to 1 000 000.
        landmarks: (l, 2) known positions of the landmarks [m].
        speed_limit: Greatest speed of a robot without odometry [m/s]; 0 for one that never moves.
        turn_rate_limit: Greatest turn rate of a robot without odometry [rad/s].
        arena: (2, 2) lower and upper corner of a box that no robot leaves, not empty [m]; infinite where there is none.
    """

    robots: int = field(metadata=checked(whole_number, "number of robots", 1, MOST_ROBOTS))
    landmarks: Array = field(default_factory=lambda: np.zeros((0, 2)), metadata=checked(_places, "landmark coordinates [m]"))
    speed_limit: float = field(default=1.0, metadata=checked(number, "speed limit [m/s]", 0))
    turn_rate_limit: float = field(default=np.pi, metadata=checked(number, "turn rate limit [rad/s]", 0))
    arena: Array = field(default_factory=lambda: np.outer([-np.inf, np.inf], [1, 1]), metadata=checked(_box, "arena"))

    if TYPE_CHECKING:  # sequences are taken, arrays are kept

        def __init__(
            self,
            robots: int,
            landmarks: Floats = ...,
            speed_limit: float = ...,
            turn_rate_limit: float = ...,
            arena: Floats = ...,
        ) -> None: ...

    def check(self, record: Measurement | Odometry) -> None:
        """Raise `InvalidInput` when it is no record, or names a robot or a target that the team does not have."""
        instance("a record", record, Compass, Bearing, Range, Odometry)
        robots, bodies = f"robots 0 to {self.robots - 1}", self.robots + len(self.landmarks)
        marks = f"landmarks {self.robots} to {bodies - 1}" if len(self.landmarks) else "no landmark"
        for role, count, known in (("robot", self.robots, robots), ("target", bodies, f"{robots} and {marks}")):
            named = getattr(record, role, record.robot)
            if (named >= count).any():
                raise InvalidInput(f"a {role} among {known}", f"{role} {named[named >= count][0]}")

    def initial(
        self, positions: Iterable[Polygon | None], headings: AngularIntervals | None
    ) -> tuple[tuple[Polygon, ...], AngularIntervals]:
        """Return (n) polygons and arcs, for None the arena and circles; `InvalidInput` unless there is one for each robot."""
        expected = f"one initial polygon for each of {self.robots} robots"
        polygons = several(f"a sequence with {expected}", positions, Polygon, type(None))
        if len(polygons) != self.robots:
            raise InvalidInput(expected, f"{len(polygons)} polygons")
        instance("initial headings, arcs with centres and bounds [rad]", headings, AngularIntervals, type(None))
        known = AngularIntervals.circles(self.robots) if headings is None else headings
        if len(known) != self.robots or known.empty.any():
            raise InvalidInput(f"an initial arc for each of {self.robots} headings, none empty", f"{len(known)} arcs")
        if None in polygons and np.isinf(self.arena).any():
            raise InvalidInput("a closed arena, for which None stands as an initial polygon", shown(self.arena.tolist()))
        return tuple(Polygon.box(*self.arena) if polygon is None else polygon for polygon in polygons), known

    def check_motion(self, belief_time: float, time: float, odometry: Odometry | None) -> float:
        """Return the time to predict as a float [s]; raises what `Filter.predict` does, and `InvalidInput` if it is too far."""
        before, now = number("time of the belief [s]", belief_time), number("time [s]", time)
        if now < before:
            raise OutOfOrder("a prediction", now, before)
        if max(self.speed_limit, self.turn_rate_limit) * (now - before) > LARGEST:
            raise InvalidInput(f"a time until which robots get no farther than {LARGEST:g} m", f"{now!r} s")
        if odometry is not None:
            instance("odometry", odometry, Odometry, type(None))
            self.check(odometry)
            if odometry.start != before:
                raise OutOfOrder("odometry that starts", odometry.start, before)
            if odometry.time != now:
                raise InvalidInput(f"odometry that ends at the predicted time {now!r} s", f"{odometry.time!r} s")
        return now

    def checked(self, belief_time: float, measurements: Iterable[Measurement]) -> tuple[Measurement, ...]:
        """Return measurements that are to be merged at one time; raises what `Filter.update` does."""
        now, records = number("time of the belief [s]", belief_time), measurements_of(measurements)
        for record in records:
            self.check(record)
            if record.time != now:
                raise OutOfOrder(type(record).__name__.lower(), record.time, now)
        return records

    def check_belief(self, belief: object, kind: type, each: str) -> None:
        """Raise `InvalidInput` when it is no belief of this kind, or its field `each` has not one entry for each robot."""
        instance("belief", belief, kind)
        robots = len(getattr(belief, each))
        if robots != self.robots:
            raise InvalidInput(f"a belief about {self.robots} robots, as the filter's team has", f"one about {robots}")

    def name(self, body: int) -> str:
        """Return a body's short name: r0, r1, ... for robots, l0, l1, ... for landmarks; `InvalidInput` if there is none."""
        known = whole_number("a body", body, 0, self.robots + len(self.landmarks) - 1)
        return f"r{known}" if known < self.robots else f"l{known - self.robots}"
