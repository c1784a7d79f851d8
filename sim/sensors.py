"""What the robots' sensors promise, and what they say: compass, bearings and ranges.

Encoders are in `sim.encoders`. Readings are made for every robot and every target, seen or not, so that what is drawn does
not depend on what is seen, kept or thrown away.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from filter import Array, Bearing, Compass, Integers, InvalidInput, Measurement, Range, wrap
from filter.arrays import finite
from sim.errors import ErrorKind, Errors

DEGREE = np.pi / 180


@dataclass(frozen=True)
class Sensors:
    """The bounds that the sensors promise, on readings and on slip. The defaults hold for the robots of `models`.

    Slip is promised for `slip_step`. Over another time step h, `slip_bound` and `turn_slip` are in proportion to h, as slips
    add up; `direction_slip` stays for shorter steps and, for longer ones, grows by what `turn_rate` allows headings to
    differ from their mean in the time added, turn_rate (h - slip_step) / 2.

    Attributes:
        compass_bound: Largest error of a heading [rad].
        bearing_bound: Largest error of a bearing [rad].
        range_bound: Largest error of a range, relative to the true one, in [0, 1).
        encoder_bound: Largest error of the arc that a wheel rolled, relative to the true one, in [0, 1).
        ticks: Encoder ticks in a turn of the wheel, from 1 on.
        detection_range: Greatest distance to what a robot sees [m].
        distance_slip: Largest difference of driven path and rolled arc, relative to the arc, in [0, 1).
        direction_slip: Largest deviation of the motion from the straight line at the mean heading, per `slip_step` [rad].
        slip_bound: Largest further displacement, per `slip_step` [m].
        turn_slip: Largest difference of true turn and what the wheels' arcs say, per `slip_step` [rad].
        turn_rate: Greatest turn rate of a robot [rad/s].
        slip_step: Time step that the bounds on slip are for [s].

    Raises:
        InvalidInput: A value is not finite or out of its range.
    """

    compass_bound: float = 3 * DEGREE
    bearing_bound: float = 3 * DEGREE
    range_bound: float = 0.05
    encoder_bound: float = 0.01
    ticks: int = 4096
    detection_range: float = 4.0
    distance_slip: float = 0.003
    direction_slip: float = 2.5 * DEGREE
    slip_bound: float = 0.0005
    turn_slip: float = 0.0005
    turn_rate: float = 1.6
    slip_step: float = 0.1

    def __post_init__(self) -> None:
        below_one, below_right_angle = np.nextafter(1, 0), np.nextafter(np.pi / 2, 0)
        finite("compass bound [rad]", self.compass_bound, 0, np.pi)
        finite("bearing bound [rad]", self.bearing_bound, 0, below_right_angle)
        finite("direction slip [rad]", self.direction_slip, 0, below_right_angle)
        for name in ("range_bound", "encoder_bound", "distance_slip"):
            finite(name.replace("_", " "), getattr(self, name), 0, below_one)
        for name in ("detection_range", "slip_bound", "turn_slip", "turn_rate"):
            finite(name.replace("_", " "), getattr(self, name), 0)
        finite("slip step [s]", self.slip_step, np.finfo(float).tiny)
        if not isinstance(self.ticks, int | np.integer) or self.ticks < 1:
            raise InvalidInput("a whole number of ticks from 1 on", repr(self.ticks))


class Readings:
    """Compass, bearings and ranges of a team, with errors of one kind."""

    def __init__(
        self, sensors: Sensors, kind: ErrorKind, generators: list[np.random.Generator], *, robots: int, targets: int
    ) -> None:
        """Draw what stays constant in each robot's sensors.

        Args:
            sensors: The bounds they keep.
            kind: The kind of errors.
            generators: Three, for compass, bearings and ranges.
            robots: Number of robots n.
            targets: Number of robots and landmarks n + l.

        Raises:
            InvalidInput: There is no such kind of errors.
        """
        self._sensors, self._targets = sensors, targets
        self._compass, self._bearing, self._range = (Errors(kind, (robots,), generator) for generator in generators)

    def take(
        self, time: float, bodies: Array, headings: Array, *, looking: Integers, seen: Integers, keep_from: int = 0
    ) -> tuple[Measurement, ...]:
        """Return the records of one instant; a kind that measured nothing is left out.

        Args:
            time: When [s].
            bodies: (n + l, 2) true positions of robots and landmarks [m].
            headings: (n,) true headings [rad].
            looking: (k,) robots that see something.
            seen: (k,) targets that they see.
            keep_from: First target that is kept: 0 for all, n for landmarks only, n + l for none.
        """
        sensors = self._sensors
        compass, bearing, distance = self._compass.draw(), self._bearing.draw(self._targets), self._range.draw(self._targets)
        robots = np.arange(len(headings))
        heading = wrap(headings + sensors.compass_bound * compass)
        records: list[Measurement] = [Compass(time, robots, heading, np.full(len(robots), sensors.compass_bound))]
        kept = seen >= keep_from
        if kept.any():
            i, j = looking[kept], seen[kept]
            offset = bodies[j] - bodies[i]
            angle = wrap(np.arctan2(offset[:, 1], offset[:, 0]) - headings[i] + sensors.bearing_bound * bearing[i, j])
            length = np.linalg.norm(offset, axis=1) * (1 + sensors.range_bound * distance[i, j])
            bounds = np.ones(len(i))
            records.append(Bearing(time, i, j, angle, sensors.bearing_bound * bounds))
            records.append(Range(time, i, j, length, 0 * bounds, sensors.range_bound * bounds))
        return tuple(records)
