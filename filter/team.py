"""What is known of a team for good: how many robots, where the landmarks are, how far anything can be."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from filter.arrays import Array, Floats, Integers, finite, number, read_only
from filter.errors import InvalidInput, OutOfOrder
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.measurements import Compass, Measurement, Odometry


@dataclass(frozen=True, eq=False)
class Team:
    """A team of robots 0, 1, ..., n - 1 among landmarks n, n + 1, ...

    Attributes:
        robots: Number of robots n, from 1 on.
        landmarks: (l, 2) known positions of the landmarks [m].
        speed_limit: Greatest speed of a robot without odometry [m/s]; 0 for one that never moves.
        turn_rate_limit: Greatest turn rate of a robot without odometry [rad/s].
        arena: (2, 2) lower and upper corner of a box that no robot leaves [m]; infinite where there is none.

    Raises:
        InvalidInput: There is no robot, a value is not finite or out of its range, or the arena is empty.
    """

    robots: int
    landmarks: Array = field(default_factory=lambda: np.zeros((0, 2)))
    speed_limit: float = 1.0
    turn_rate_limit: float = np.pi
    arena: Array = field(default_factory=lambda: np.array([[-np.inf] * 2, [np.inf] * 2]))

    if TYPE_CHECKING:  # sequences are taken, arrays are kept

        def __init__(
            self,
            robots: int,
            landmarks: Floats = ...,
            speed_limit: float = ...,
            turn_rate_limit: float = ...,
            arena: Floats = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        if not isinstance(self.robots, int | np.integer) or isinstance(self.robots, bool) or self.robots < 1:
            raise InvalidInput("a team of at least one robot", f"{self.robots!r} robots")
        landmarks = finite("landmark coordinates [m]", self.landmarks)
        landmarks = landmarks if landmarks.size else np.zeros((0, 2))
        if landmarks.ndim != 2 or landmarks.shape[1] != 2:
            raise InvalidInput("landmarks as (l, 2) coordinates", f"shape {landmarks.shape}")
        try:
            arena = np.array(self.arena, dtype=float)
        except (TypeError, ValueError):
            raise InvalidInput("arena: (2, 2) lower and upper corner [m]", repr(self.arena)) from None
        if arena.shape != (2, 2) or not (arena[0] <= arena[1]).all():
            raise InvalidInput("arena: (2, 2) lower corner below upper corner [m]", arena.tolist())
        number("speed limit [m/s]", self.speed_limit, 0)
        number("turn rate limit [rad/s]", self.turn_rate_limit, 0)
        object.__setattr__(self, "landmarks", read_only(landmarks))
        object.__setattr__(self, "arena", read_only(arena))

    def check(self, record: Measurement | Odometry) -> None:
        """Raise `InvalidInput` when the record names a robot or a target that the team does not have."""
        self._known("robot", record.robot, self.robots)
        if not isinstance(record, Compass | Odometry):
            self._known("target", record.target, self.robots + len(self.landmarks))

    def initial_headings(self, positions: Sequence[Polygon], headings: AngularIntervals | None) -> AngularIntervals:
        """Return (n) arcs around the robots' first headings, whole circles where nothing is known.

        Args:
            positions: (n) a polygon around each robot.
            headings: (n) arcs, or None when nothing is known.

        Raises:
            InvalidInput: The numbers of sets and robots differ, or an arc is empty.
        """
        if len(positions) != self.robots:
            raise InvalidInput(f"one initial polygon for each of {self.robots} robots", f"{len(positions)} polygons")
        known = AngularIntervals.circles(self.robots) if headings is None else headings
        if len(known) != self.robots or known.empty.any():
            raise InvalidInput(f"an initial arc for each of {self.robots} headings, none empty", f"{len(known)} arcs")
        return known

    def check_motion(self, belief_time: float, time: float, odometry: Odometry | None) -> None:
        """Check a prediction from one time to another.

        Raises:
            OutOfOrder: `time` is earlier than the belief's, or the odometry starts at another time.
            InvalidInput: The odometry ends at another time, or names an unknown robot.
        """
        if number("time [s]", time) < belief_time:
            raise OutOfOrder("a prediction", time, belief_time)
        if odometry is not None:
            if not isinstance(odometry, Odometry):
                raise InvalidInput("an odometry record, or None", type(odometry).__name__)
            self.check(odometry)
            if odometry.start != belief_time:
                raise OutOfOrder("odometry that starts", odometry.start, belief_time)
            if odometry.time != time:
                raise InvalidInput(f"odometry that ends at the predicted time {time!r} s", f"{odometry.time!r} s")

    def checked(self, belief_time: float, measurements: Iterable[Measurement]) -> tuple[Measurement, ...]:
        """Return measurements that are to be merged at one time, if they can be.

        Raises:
            OutOfOrder: A record is of another time.
            InvalidInput: A record names an unknown robot or landmark.
        """
        if not isinstance(measurements, Iterable):
            raise InvalidInput("a sequence of records", type(measurements).__name__)
        records = tuple(measurements)
        for record in records:
            if not isinstance(record, Measurement):
                raise InvalidInput("records of compass, bearing or range", type(record).__name__)
            self.check(record)
            if record.time != belief_time:
                raise OutOfOrder(type(record).__name__.lower(), record.time, belief_time)
        return records

    def _known(self, role: str, bodies: Integers, count: int) -> None:
        unknown = bodies[bodies >= count]
        if len(unknown):
            last = self.robots + len(self.landmarks) - 1
            marks = f" and landmarks {self.robots} to {last}" if len(self.landmarks) else " and no landmark"
            known = f"robots 0 to {self.robots - 1}" + (marks if role == "target" else "")
            raise InvalidInput(f"a {role} among {known}", f"{role} {unknown[0]}")

    def name(self, body: int) -> str:
        """Return a body's short name: r0, r1, ... for robots, l0, l1, ... for landmarks."""
        return f"r{body}" if body < self.robots else f"l{body - self.robots}"
