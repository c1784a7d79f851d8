"""What is known of a team for good: how many robots, where the landmarks are, how far anything can be."""

from collections.abc import Iterable, Mapping, Sequence, Set
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any

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
    read_only,
    settle,
    several,
    shown,
    whole_number,
)
from filter.errors import InvalidInput, OutOfOrder
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.records.measurements import MEASUREMENTS, Bearing, Measurement, Range, measurements_of
from filter.records.names import names_in, numbered, place_of
from filter.records.odometry import Odometry, Twist
from filter.records.presence import Change, Left, Placed
from filter.records.record import AT_THE_CENTRE, called
from filter.records.relative import RelativeHeading
from filter.records.sensors import Mountings, Sensor, sensors_in

LIMITS = ("speed_limit", "turn_rate_limit", "acceleration_limit", "turn_acceleration_limit")
ARENA = "(2, 2) lower corner below upper corner [m], infinite where it is open"


def _places(name: str, values: Floats) -> Array:
    landmarks = finite(name, values)
    landmarks = landmarks if landmarks.size else np.zeros((0, 2))
    if landmarks.ndim != 2 or landmarks.shape[1] != 2:
        raise InvalidInput("landmarks as (l, 2) coordinates", f"shape {landmarks.shape}")
    return landmarks


def _limits(name: str, values: Floats) -> Array:
    limits = floats(name, values)
    if not (limits >= 0).all():
        raise InvalidInput(f"{name}: numbers from 0 on, infinity where nobody knows", shown(limits.tolist()))
    return limits


def _endless() -> Array:
    return np.full(1, np.inf)


def _box(name: str, values: Floats) -> Array:
    arena = floats(name, values, ARENA)
    if arena.shape != (2, 2) or not ((arena[0] <= np.minimum(arena[1], LARGEST)) & (arena[1] >= -LARGEST)).all():
        raise InvalidInput(f"{name}: {ARENA}", shown(arena.tolist()))
    return arena


@dataclass(frozen=True, eq=False)
class Team(Frozen):
    """A team of robots 0, 1, ..., n - 1 among landmarks n, n + 1, ... Raises `InvalidInput` if a value is out of its range.

    Robots and landmarks can have names: `Team(["alice", "bob"], {"gate": [4, 0]}, speed_limit={"alice": 3, "bob": 0})`. Inside
    they are numbers (see `number_of`); everywhere a person reads they are names.

    Attributes:
        robots: Number of robots n, from 1 to 1 000 000, or their names.
        landmarks: (l, 2) known positions of the landmarks, or such by their names [m].
        speed_limit: (n,) greatest speed of robots without odometry, one for all or each its own [m/s]; 0 for what never moves.
            Of all robots, if a sensor has a `time_bound`.
        turn_rate_limit: (n,) greatest turn rate of robots without odometry, likewise [rad/s].
        arena: (2, 2) lower and upper corner of a box that no robot leaves, not empty [m]; infinite where there is none.
        names: (n + l,) of robots and landmarks, no two alike: r0, r1, ... and l0, l1, ... unless they were given.
        acceleration_limit: (n,) how fast the speed of robots changes at most, likewise; infinite where nobody knows [m/s2].
        turn_acceleration_limit: (n,) how fast their turn rate changes at most, likewise [rad/s2].
        sensors: What robots carry that is not at their centre, or does not look forward, numbered from 0 on. Any robot may have
            any of them; all that have it carry it alike.
    """

    robots: int = field(metadata=checked(whole_number, "number of robots", 1, MOST_ROBOTS))
    landmarks: Array = field(default_factory=lambda: np.zeros((0, 2)), metadata=checked(_places, "landmark coordinates [m]"))
    speed_limit: Array = field(default_factory=lambda: np.ones(1), metadata=checked(finite, "speed limit [m/s]", 0))
    turn_rate_limit: Array = field(
        default_factory=lambda: np.full(1, np.pi), metadata=checked(finite, "turn rate limit [rad/s]", 0)
    )
    arena: Array = field(default_factory=lambda: np.outer([-np.inf, np.inf], [1, 1]), metadata=checked(_box, "arena"))
    names: tuple[str, ...] = ()
    acceleration_limit: Array = field(default_factory=_endless, metadata=checked(_limits, "acceleration limit [m/s2]"))
    turn_acceleration_limit: Array = field(
        default_factory=_endless, metadata=checked(_limits, "turn acceleration limit [rad/s2]")
    )
    sensors: Sequence[Sensor] = field(default=(), metadata={"check": sensors_in})

    if TYPE_CHECKING:  # sequences and mappings are taken, arrays are kept

        def __init__(
            self,
            robots: int | Sequence[str],
            landmarks: Floats | Mapping[str, Floats] = ...,
            speed_limit: Floats | Mapping[str, float] = ...,
            turn_rate_limit: Floats | Mapping[str, float] = ...,
            arena: Floats = ...,
            names: Sequence[str] = ...,
            acceleration_limit: Floats | Mapping[str, float] = ...,
            turn_acceleration_limit: Floats | Mapping[str, float] = ...,
            sensors: Iterable[Sensor] = ...,
        ) -> None: ...

    def __post_init__(self) -> None:
        of_robots, of_marks = self._taken_apart()
        super().__post_init__()
        robots = of_robots or numbered("r", self.robots)
        marks = of_marks if of_marks is not None else numbered("l", len(self.landmarks))
        count = self.robots + len(self.landmarks)
        names = names_in(f"one name for each of {count} robots and landmarks", self.names or (*robots, *marks), count)
        settle(self, names=names, **{limit: self._each(limit) for limit in LIMITS})
        late = max((sensor.time_bound for sensor in self.sensors), default=0.0)
        if max(self.speed_limit.max(), self.turn_rate_limit.max()) * late > LARGEST:
            raise InvalidInput(f"time bounds of sensors in which robots get no farther than {LARGEST:g} m", f"{late!r} s")

    def _taken_apart(self) -> tuple[tuple[str, ...] | None, tuple[str, ...] | None]:
        """Put numbers and arrays in the place of names and mappings; return the names of robots and of landmarks."""
        robots: Any = self.robots
        marks, of_robots, of_marks = self.landmarks, None, None
        if isinstance(robots, list | tuple):
            of_robots = names_in("robots", robots)
            settle(self, robots=len(of_robots))
        if isinstance(marks, Mapping):
            of_marks = names_in("landmarks", marks)
            settle(self, landmarks=list(marks.values()))
        for limit in LIMITS:
            if isinstance(values := getattr(self, limit), Mapping):
                named = of_robots or self.names[: self.robots]
                if set(values) != set(named):
                    raise InvalidInput(f"{limit}: one for each of {', '.join(named)}", ", ".join(map(str, values)))
                settle(self, **{limit: [values[name] for name in named]})
        return of_robots, of_marks

    def _each(self, limit: str) -> Array:
        values = getattr(self, limit)
        if values.shape not in ((), (1,), (self.robots,)):
            raise InvalidInput(f"{limit}: one, or one for each of {self.robots} robots", f"shape {values.shape}")
        return read_only(np.broadcast_to(values, self.robots))

    @cached_property
    def limits(self) -> Array:
        """(n, 4) limits of speed, turn rate, acceleration and turn acceleration, in the units of each."""
        return read_only(np.stack([getattr(self, limit) for limit in LIMITS], axis=1))

    @cached_property
    def _fastest(self) -> float:
        return float(self.limits[:, :2].max())

    @cached_property
    def mounted(self) -> Mountings:
        """How the sensors are mounted, by their numbers, of which -1 is at the centre."""
        return Mountings.of(self.sensors, self.speed_limit, self.turn_rate_limit)

    @property
    def mountings(self) -> Mountings | None:
        """The same; None if there are no sensors."""
        return self.mounted if self.sensors else None

    def check(self, record: Measurement | Odometry | Twist) -> None:
        """Raise `InvalidInput` when it is no record, or names a robot, a target or a sensor that the team does not have."""
        instance("a record", record, *MEASUREMENTS, Odometry, Twist)
        marks = 0 if isinstance(record, RelativeHeading) else len(self.landmarks)
        for role, greatest, count in zip(
            ("robot", "target"), record.greatest, (self.robots, self.robots + marks), strict=False
        ):
            if greatest >= count:
                named = getattr(record, role)
                raise InvalidInput(f"a {role} among {self._known(role, marks)}", f"{role} {named[named >= count][0]}")
        if not isinstance(record, Odometry | Twist):
            self._check_sensors(record)

    def _known(self, role: str, marks: int) -> str:
        robots = self.robots
        landmarks = f" and landmarks {robots} to {robots + marks - 1}" if marks else " and no landmark"
        return f"robots 0 to {robots - 1}" + landmarks * (role == "target")

    def _check_sensors(self, record: Measurement) -> None:
        count, (sensor, tagged) = len(self.sensors), record.greatest[2:]
        if max(sensor, tagged) >= count:
            known = f"0 to {count - 1}, or -1" if count else "none, hence -1"
            raise InvalidInput(f"a sensor among the team's, {known} for the centre", max(sensor, tagged))
        if not isinstance(record, Bearing | Range) or tagged == AT_THE_CENTRE:
            return
        if (record.target_sensor[record.target >= self.robots] != AT_THE_CENTRE).any():
            raise InvalidInput("a target_sensor on a robot: landmarks are where they are", "one on a landmark")

    def checked_change(self, change: Change, belief_time: float | None = None) -> Change:
        """Return that a robot is placed or has left; `InvalidInput` when it is neither, or the team has no such robot.

        Raises `OutOfOrder` if it is not of the belief's time, where there is one.
        """
        instance("a robot that is placed, or has left", change, Placed, Left)
        if change.robot >= self.robots:
            raise InvalidInput(f"a robot among {self._known('robot', 0)}", f"robot {change.robot}")
        if belief_time is not None and change.time != belief_time:
            raise OutOfOrder(called(type(change)), change.time, belief_time)
        return change

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
        if self._fastest * (now - before) > LARGEST:
            raise InvalidInput(f"a time until which robots get no farther than {LARGEST:g} m", f"{now!r} s")
        if odometry is not None:
            instance("odometry", odometry, Odometry, type(None))
            self.check(odometry)
            if odometry.start != before:
                raise OutOfOrder("odometry that starts", odometry.start, before)
            if odometry.time != now:
                raise InvalidInput(f"odometry that ends at the predicted time {now!r} s", f"{odometry.time!r} s")
        return now

    def checked(
        self, belief_time: float, measurements: Iterable[Measurement], away: Set[int] = frozenset()
    ) -> tuple[Measurement, ...]:
        """Return measurements that are to be merged at one time; raises what `Filter.update` does, for robots away, too."""
        now, records = number("time of the belief [s]", belief_time), measurements_of(measurements)
        for record in records:
            self.check(record)
            if record.time != now:
                raise OutOfOrder(called(type(record)), record.time, now)
            gone = away and away & {*record.robot.tolist(), *getattr(record, "target", record.robot).tolist()}
            if gone:
                raise InvalidInput("measurements among robots that are there", f"{self.name(min(gone))}, which has left")
        return records

    def check_belief(self, belief: object, kind: type, each: str) -> None:
        """Raise `InvalidInput` when it is no belief of this kind, or its field `each` has not one entry for each robot."""
        instance("belief", belief, kind)
        robots = len(getattr(belief, each))
        if robots != self.robots:
            raise InvalidInput(f"a belief about {self.robots} robots, as the filter's team has", f"one about {robots}")

    def name(self, body: int) -> str:
        """Return the name of a robot or a landmark; `InvalidInput` if there is none of that number."""
        return self.names[whole_number("a body", body, 0, len(self.names) - 1)]

    @cached_property
    def is_named(self) -> bool:
        """Whether robots or landmarks have names of their own."""
        return self.names != (*numbered("r", self.robots), *numbered("l", len(self.landmarks)))

    def words(self, what: object) -> str:
        """Return a robot by its number, what happened, what is known, or an error, in words with the names of the team."""
        if isinstance(what, int | np.integer):
            return self.name(int(what))
        named = getattr(what, "named", None)
        return named(self) if named else str(what)

    def number_of(self, name: str) -> int:
        """Return the number of the robot or the landmark of a name; `InvalidInput` if there is none, with the nearest."""
        return place_of("a robot or a landmark", name, self.names)

    def sensor_number(self, name: str) -> int:
        """Return the number of the sensor of a name; `InvalidInput` if there is none, with the nearest."""
        return place_of("a sensor", name, [sensor.name for sensor in self.sensors])
