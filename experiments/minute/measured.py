"""A minute of two robots as their sensors tell it: each at its own rate and phase, errors uniform within declared bounds."""

from __future__ import annotations

import math
from collections.abc import Iterator

import numpy as np

from experiments.minute.drive import Drive, drive
from experiments.minute.said import Distance, Minute, North, PoseSaid, Promised, Said, Seen, Yaw
from experiments.own_data.units import SECOND
from filter import wrap
from sim.drive import SPEED_LIMIT
from sim.sensors import Sensors
from sim.visibility import visible

MINUTE = 60  # [s]
START = 100  # what the clock shows when the robots set off [s]
ROBOTS = ("alice", "bob")
GATE = "gate"  # the landmark that cameras see
ANCHORS = {"northwest": [-5.9, 3.9], "southwest": [-5.9, -3.9], "east": [5.9, 0.0]}  # those that UWB radios reach [m]
RATES = {"odometry": 50, "compass": 20, "detections": 10, "uwb": 7}  # [Hz]
PHASES = {  # when each robot's first message is [ns]
    "odometry": (1_300_000, 9_700_000),
    "compass": (13_100_000, 31_900_000),
    "detections": (42_300_000, 77_700_000),
    "uwb": (5_100_000, 61_000_000),
}
SLOT = 10_000_000  # from one UWB range of a robot to the next [ns]
LATENCY = (500_000, 4_000_000)  # from a stamp to the receipt [ns]
INSIDE = 1 - 1e-9  # an error at the very bound stays inside when floats are rounded
FLOAT32 = 1e-6  # what rounding to 32 bits changes at most, below 16 m [m]
HEADING_SHARE, START_SHARE = 0.9, 0.9  # of the bound at the start, as what is declared is rounded to millimetres


class Sensing:
    """The sensors of one robot on a drive."""

    def __init__(self, robot: int, driven: Drive, bounds: Promised, generator: np.random.Generator) -> None:
        """Prepare the sensors of one of the robots; all errors are drawn from the generator."""
        self._robot, self._name, self._drive, self._bounds = robot, ROBOTS[robot], driven, bounds
        self._generator = generator

    def said(self) -> Iterator[Said]:
        """Yield all that they say, stream by stream."""
        yield from self._odometry()
        for stamp in self._stamps("compass"):
            heading = float(self._drive.at(stamp)[1][self._robot])
            yield self._message(stamp, "compass", North(Yaw.of(heading + self._error(self._bounds.compass))))
            yield self._message(stamp, "truth", self._truth(stamp))
        for stamp in self._stamps("detections"):
            yield self._message(stamp, "detections", self._seen(stamp))
        for slot, target in enumerate((*ANCHORS, *(mate for mate in ROBOTS if mate != self._name))):
            for stamp in self._stamps("uwb", slot * SLOT):
                yield self._message(stamp, "uwb", self._distance(stamp, target))

    def _stamps(self, stream: str, after: int = 0) -> Iterator[int]:
        """Yield the times of a stream's messages since the start [ns]."""
        rate = RATES[stream]
        for k in range(MINUTE * rate):
            yield PHASES[stream][self._robot] + after + k * SECOND // rate

    def _message(self, time: int, stream: str, value: PoseSaid | North | Seen | Distance) -> Said:
        stamp = START * SECOND + time
        return Said(stamp, stamp + int(self._generator.integers(*LATENCY)), self._name, stream, value)

    def _error(self, bound: float) -> float:
        return bound * INSIDE * float(self._generator.uniform(-1, 1))

    def _odometry(self) -> Iterator[Said]:
        """Yield poses that add up what the wheels say of each interval, errors and all; they drift as odometry does."""
        x, y, turned, before = 0.0, 0.0, Yaw.of(0.0), None
        for stamp in self._stamps("odometry"):
            moved = (0.0, 0.0) if before is None else self._increment(before, stamp)
            seconds = 1.0 if before is None else (stamp - before) / SECOND
            way = turned.heading + moved[1] / 2
            x, y = x + moved[0] * math.cos(way), y + moved[0] * math.sin(way)
            turned, before = Yaw.of(turned.heading + moved[1]), stamp
            yield self._message(stamp, "odometry", PoseSaid(x, y, turned, moved[0] / seconds, moved[1] / seconds))

    def _increment(self, before: int, stamp: int) -> tuple[float, float]:
        """Return the distance [m] and the turn [rad] of an interval, as measured."""
        (first, heading), (last, heading_after) = (self._drive.at(time) for time in (before, stamp))
        (x, y), turn = last[self._robot] - first[self._robot], heading_after[self._robot] - heading[self._robot]
        way = heading[self._robot] + turn / 2
        distance = math.copysign(math.hypot(x, y), x * math.cos(way) + y * math.sin(way))
        return distance + self._error(self._bounds.distance), float(turn) + self._error(self._bounds.turn)

    def _truth(self, stamp: int) -> PoseSaid:
        places, headings = self._drive.at(stamp)
        x, y = places[self._robot].tolist()
        return PoseSaid(x, y, Yaw.of(float(headings[self._robot])))

    def _seen(self, stamp: int) -> Seen:
        places, headings = self._drive.at(stamp)
        marks, radius = self._drive.beacon[None], self._drive.mast_radius
        reach = Sensors().detection_range
        looking, seen = visible(places, marks, self._drive.walls, body_radius=radius, detection_range=reach)
        bodies, found = np.concatenate([places, marks]), {}
        for target in seen[looking == self._robot].tolist():
            x, y = (bodies[target] - places[self._robot]).tolist()
            bearing = math.atan2(y, x) - headings[self._robot] + self._error(self._bounds.bearing)
            distance = math.hypot(x, y) + self._error(self._bounds.detection)
            found[(*ROBOTS, GATE)[target]] = (max(distance, 0.0), float(wrap(bearing)))
        return Seen(found)

    def _distance(self, stamp: int, target: str) -> Distance:
        places, _ = self._drive.at(stamp)
        there = places[ROBOTS.index(target)] if target in ROBOTS else np.array(ANCHORS[target])
        (x, y), (low, high) = there - places[self._robot], self._bounds.uwb
        error = float(self._generator.uniform(low + FLOAT32, high - FLOAT32))
        return Distance(target, float(np.float32(math.hypot(x, y) + error)))


def minute(generator: np.random.Generator) -> Minute:
    """Return a minute of two robots; the same generator gives the same bytes."""
    driving, starting, *sensing = generator.spawn(2 + len(ROBOTS))
    driven, bounds = drive(len(ROBOTS), MINUTE + 1, driving), Promised()
    said = [each for robot in range(len(ROBOTS)) for each in Sensing(robot, driven, bounds, sensing[robot]).said()]
    starts = {}
    for name, place, heading in zip(ROBOTS, *driven.at(0), strict=True):
        middle = place + bounds.start * START_SHARE * starting.uniform(-1, 1, 2)
        about = float(wrap(heading + bounds.start_heading * HEADING_SHARE * starting.uniform(-1, 1)))
        starts[name] = ([round(value, 3) for value in middle.tolist()], round(about, 3))
    return Minute(
        said=sorted(said, key=lambda each: (each.received, each.stamp, each.robot, each.stream)),
        landmarks={GATE: driven.beacon.tolist(), **ANCHORS},
        arena=driven.arena.tolist(),
        speed_limit=SPEED_LIMIT,
        turn_rate_limit=Sensors().turn_rate,
        starts=starts,
        bounds=bounds,
    )
