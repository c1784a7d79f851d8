"""A small team that drives, told of by its wheels, and measures; what a fault does is done here."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from experiments.broken.fault import Fault
from experiments.broken.scene import (
    BEARING,
    COMPASS,
    DIRECTION,
    DISTANCE,
    HEADING,
    NEAREST,
    RANGE,
    ROBOTS,
    SLIP,
    STEP,
    TURN,
    Scene,
)
from filter import (
    AngularIntervals,
    Array,
    Bearing,
    Compass,
    Frame,
    Integers,
    Mask,
    Measurement,
    Odometry,
    Polygon,
    Range,
    Truth,
    wrap,
)

SPEED = (0.3, 0.5)  # [m] a frame
TURNING, BACK = np.radians(25), np.radians(45)  # how much robots turn in a frame as they like, and back into the arena [rad]
TURN_BACK = 4.3  # robots farther than this from either axis turn back [m]


@dataclass
class World:
    """Robots in a scene, at one frame.

    Attributes:
        scene: Where they are.
        rng: Where all that happens is drawn from.
        positions: (n, 2) [m].
        headings: (n,) in (-pi, pi] [rad].
        frame: Its number.
    """

    scene: Scene
    rng: np.random.Generator
    positions: Array
    headings: Array
    frame: int = 0

    @classmethod
    def drawn(cls, scene: Scene, rng: np.random.Generator) -> World:
        """Put the robots down somewhere."""
        return cls(scene, rng, rng.uniform(-TURN_BACK, TURN_BACK, (ROBOTS, 2)), rng.uniform(-np.pi, np.pi, ROBOTS))

    @property
    def time(self) -> float:
        """Of the frame [s]."""
        return STEP * self.frame

    @property
    def _truth(self) -> Truth:
        """Where the robots are."""
        return Truth(self.positions, self.headings)

    def begun(self, fault: Fault) -> tuple[tuple[Polygon, ...], AngularIntervals | None]:
        """Return what is known at the start: boxes around the robots, and arcs around headings or None."""
        errors, half = self.scene.errors(self.rng, ROBOTS, 3), self.scene.start
        wrong = np.zeros((ROBOTS, 3))
        if fault.begins("start", self.frame):
            wrong[fault.robot] = *fault.offset, fault.turn
            errors[fault.robot] = np.where(wrong[fault.robot], np.sign(wrong[fault.robot]), errors[fault.robot])
        centres = self.positions + half * errors[:, :2] + wrong[:, :2]
        arcs = AngularIntervals(wrap(self.headings + HEADING * errors[:, 2] + wrong[:, 2]), np.full(ROBOTS, HEADING))
        return tuple(Polygon.box(centre - half, centre + half) for centre in centres), arcs if self.scene.headings else None

    def told(self, fault: Fault) -> Frame:
        """Return the frame of the start, before any motion."""
        return Frame(self.time, None, self._measured(fault), self._truth)

    def driven(self, fault: Fault) -> Frame:
        """Go on to the next frame, and return it."""
        odometry = self._drive(fault)
        return Frame(self.time, odometry, self._measured(fault), self._truth)

    def _drive(self, fault: Fault) -> Odometry:
        """Go on; return what wheels tell of it."""
        self.frame += 1
        errors, way = self.scene.errors(self.rng, 4, ROBOTS), self.rng.uniform(-np.pi, np.pi, ROBOTS)
        distance, turn = self.rng.uniform(*SPEED, ROBOTS), self._turns()
        told = np.zeros((2, ROBOTS))
        if fault.begins("slip", self.frame):
            told[:, fault.robot] = fault.offset[0], fault.turn
            distance[fault.robot] += max(0.0, -fault.offset[0])  # wheels that tell too little slide
        self._go(distance, turn, errors[2] * DIRECTION, SLIP * errors[3] * np.array([np.cos(way), np.sin(way)]))
        if fault.begins("kidnap", self.frame):
            self.positions[fault.robot] += fault.offset
            self.headings[fault.robot] = wrap(self.headings[fault.robot] + fault.turn)
        lengths, turns = distance + told[0] + DISTANCE * errors[0], turn + told[1] + TURN * errors[1]
        bounds = {"distance_bound": DISTANCE, "turn_bound": TURN, "direction_bound": DIRECTION, "slip_bound": SLIP}
        return Odometry(self.time - STEP, self.time, range(ROBOTS), distance=lengths, turn=turns, **bounds)

    def _turns(self) -> Array:
        """Draw how robots turn; those that are far out turn to the middle."""
        home = wrap(np.arctan2(-self.positions[:, 1], -self.positions[:, 0]) - self.headings)
        out = np.abs(self.positions).max(axis=1) > TURN_BACK
        return np.where(out, np.clip(home, -BACK, BACK), self.rng.uniform(-TURNING, TURNING, ROBOTS))

    def _go(self, distance: Array, turn: Array, aside: Array, slip: Array) -> None:
        way, chord = self.headings + turn / 2 + aside, distance * np.sinc(turn / (2 * np.pi))
        self.positions = self.positions + (chord * np.array([np.cos(way), np.sin(way)]) + slip).T
        self.headings = wrap(self.headings + turn)

    def bodies(self, fault: Fault | None = None) -> Array:
        """Return (n + l, 2) where robots and landmarks are [m]; a moved landmark is not where the map says."""
        places = np.concatenate([self.positions, self.scene.landmarks])
        if fault and fault.now("moved", self.frame):
            places[fault.body] += fault.offset
        return places

    def seen(self, places: Array) -> Mask:
        """Return (n, n + l) which robot sees which of the bodies at places (n + l, 2)."""
        away = np.hypot(*(places - self.positions[:, None]).transpose(2, 0, 1))
        return (away >= NEAREST) & (away <= self.scene.view)

    def _measured(self, fault: Fault) -> tuple[Measurement, ...]:
        """Return what compasses and cameras tell in this frame."""
        records: list[Measurement] = []
        compass = self.headings + COMPASS * self.scene.errors(self.rng, ROBOTS)
        if fault.now("compass", self.frame):
            compass[fault.robot] += fault.turn
        if self.scene.compass:
            records.append(Compass(self.time, range(ROBOTS), wrap(compass), COMPASS))
        return (*records, *self._sightings(fault))

    def _sightings(self, fault: Fault) -> tuple[Measurement, ...]:
        places = self.bodies(fault)
        robot, target = np.nonzero(self.seen(places))
        apart = (places[target] - self.positions[robot]).T
        away, (turned, longer) = np.hypot(*apart), self.scene.errors(self.rng, 2, len(robot))
        bearing = np.arctan2(apart[1], apart[0]) - self.headings[robot] + BEARING * turned
        reach = away * (1 + self.scene.relative * longer) + RANGE * longer
        if fault.now("biased", self.frame):
            of = robot == fault.robot
            bearing, reach = bearing + fault.turn * of, np.maximum(0.0, reach + fault.offset[0] * of)
        named = self._named(fault, robot, target)
        own = np.flatnonzero(robot != named)  # who wears one's own marker is taken for nobody
        if not len(own):
            return ()
        told = self.time, robot[own], named[own]
        relative = self.scene.relative
        return Bearing(*told, wrap(bearing[own]), BEARING), Range(*told, np.maximum(0.0, reach[own]), RANGE, relative)

    def _named(self, fault: Fault, robot: Integers, target: Integers) -> Integers:
        """Return as what the (k,) targets of robots are read."""
        if fault.now("swap", self.frame):
            pair = fault.robot, fault.body
            return np.select([target == pair[0], target == pair[1]], pair[::-1], target)
        if fault.now("misread", self.frame):
            return np.where((robot == fault.robot) & (target == fault.body), fault.read, target)
        return target
