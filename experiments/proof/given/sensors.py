"""How sensors are mounted on their robots, as a log's header says it. Standard library only."""

from collections.abc import Sequence
from dataclasses import dataclass
from fractions import Fraction
from math import pi
from typing import Any

from experiments.proof.exact import Vector
from experiments.proof.reading import Broken, Record, body, number, shown

NO = Fraction(0)
OPTIONAL = {"position", "position_bound", "angle", "angle_bound"}


@dataclass(frozen=True)
class Mount:
    """Where a sensor is on whatever robot carries it, and which way it looks.

    Attributes:
        place: How far forward of the robot's centre, and how far to the left [m].
        off: How far from there it is at most [m].
        angle: Which way it looks, from the robot's forward axis [rad].
        angle_off: How far from there it looks at most [rad].
        spot: A number for each place on a robot, 0 for the centre: where it is the same, so is the place, for sure.
    """

    place: Vector = (NO, NO)
    off: Fraction = NO
    angle: Fraction = NO
    angle_off: Fraction = NO
    spot: int = 0

    @property
    def is_at_the_centre(self) -> bool:
        """Whether it is where its robot is, for sure."""
        return not (any(self.place) or self.off)


CENTRE = Mount()


class Mounts:
    """The sensors of a log."""

    def __init__(self, sensors: Record) -> None:
        self._names, self._mounts = list(sensors), list[Mount]()
        places: list[tuple[Any, ...]] = [CENTRE.place]
        for count, (name, record) in enumerate(sensors.items()):
            place, off, angle, angle_off = _mounted(name, record)
            places.append((*place, count) if off else place)  # no other is where one is that can be off
            self._mounts.append(Mount(place, off, angle, angle_off, places.index(places[-1])))

    def of(self, value: Any) -> Mount:
        """Return how a sensor is mounted, by its name or number; null is at the centre and looks forward."""
        number = self.number(value)
        return CENTRE if number < 0 else self._mounts[number]

    def number(self, value: Any) -> int:
        """Return the number of a sensor, by its name or number; -1 for null, which is at the centre."""
        if value is None:
            return -1
        if isinstance(value, str) and value in self._names:
            return self._names.index(value)
        return body(value, len(self._mounts))

    def pair(self, values: Any) -> tuple[Mount, Mount]:
        """Return how two sensors are mounted, by their numbers; -1 is at the centre."""
        if not isinstance(values, Sequence) or len(values) != 2:
            raise Broken(f"two sensors were expected, not {shown(values)}")
        first, last = (self.of(None if value == -1 else value) for value in values)
        return first, last


def _mounted(name: str, record: Any) -> tuple[Vector, Fraction, Fraction, Fraction]:
    if not isinstance(record, dict) or not set(record) <= OPTIONAL:
        raise Broken(f"sensor {shown(name)} with {sorted(OPTIONAL)} was expected, not {shown(record)}")
    x, y = (Fraction(number(value)) for value in record.get("position", (0.0, 0.0)))
    off, angle_off = (Fraction(number(record.get(key, 0.0), 0)) for key in ("position_bound", "angle_bound"))
    angle = Fraction(number(record.get("angle", 0.0)))
    if abs(angle) > 2 * pi or angle_off > pi:
        raise Broken(f"sensor {shown(name)}: an angle of a turn at most, known to half a turn, was expected")
    return (x, y), off, angle, angle_off
