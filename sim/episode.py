"""A team drives and measures: frame by frame, with the truth to judge by."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, get_args

import numpy as np

from filter import Frame, InvalidInput, Measurement, Odometry, Team, Truth
from filter.arrays import finite, read_only
from sim.drive import SPEED_LIMIT, Driver
from sim.encoders import Encoders, odometry
from sim.errors import ErrorKind, Errors, known_kind
from sim.kinematic import KinematicWorld
from sim.layout import Layout, layout, start_poses
from sim.sensors import Readings, Sensors
from sim.visibility import visible
from sim.world import TIMESTEP, World

MeasurementChoice = Literal["all", "absolute", "none"]
MEASUREMENT_CHOICES: tuple[MeasurementChoice, ...] = get_args(MeasurementChoice)
WorldKind = Literal["mujoco", "kinematic"]

START_BOUND = 0.5  # [m]
# A start at the very corner of its box stays inside when floats are rounded.
INSIDE = 1 - 1e-9
SLOWEST_RATE = 0.5  # [Hz]; in longer steps a robot can have driven anywhere


class Episode(Iterator[Frame]):
    """One run of the simulator: an iterator of frames, and what a filter needs to know before the first. Its length is theirs.

    Attributes:
        team: Number of robots, landmarks, arena and limits of motion.
        start_centres: (n, 2) middles of the boxes that the robots start in [m].
        start_bound: Half-width of those boxes [m].
        sensors: The bounds that all records keep.
        world: The world at the instant of the last frame.
    """

    def __init__(
        self,
        robots: int,
        *,
        frames: int,
        rate: float,
        seed: int,
        errors: ErrorKind,
        measurements: MeasurementChoice,
        sensors: Sensors,
        world: WorldKind,
    ) -> None:
        """Build the world; see `episode`, which checks what comes in."""
        # One stream for each purpose: what one draws never changes what another does.
        streams = [np.random.default_rng(sequence) for sequence in np.random.SeedSequence(seed).spawn(8)]
        plan = layout(robots)
        self.world = _world(world, plan, streams[0], sensors=sensors, errors=errors, slipping=streams[7])
        self.team = Team(robots, plan.beacons, SPEED_LIMIT, sensors.turn_rate, plan.arena)
        self.start_bound, self.sensors = START_BOUND, sensors
        anywhere = Errors("extreme" if errors == "extreme" else "uniform", (robots, 2), streams[2])
        self.start_centres = read_only(self.world.positions() - START_BOUND * INSIDE * anywhere.draw())
        self._driver = Driver(self.world, streams[1])
        wheel_radius, angles = self.world.wheel_radius, self.world.wheel_angles()
        self._encoders = Encoders(sensors, errors, angles, streams[3], wheel_radius=wheel_radius)
        targets = robots + len(plan.beacons)
        self._readings = Readings(sensors, errors, streams[4:7], robots=robots, targets=targets)
        self._keep_from = {"all": 0, "absolute": robots, "none": targets}[measurements]
        self._rate, self._frames, self._next = rate, frames, 0

    def __len__(self) -> int:
        return self._frames

    def __next__(self) -> Frame:
        if self._next == self._frames:
            raise StopIteration
        motion = self._move() if self._next else None
        time = self._next / self._rate
        truth = Truth(read_only(self.world.positions()), read_only(self.world.headings()))
        self._next += 1
        return Frame(time, motion, self._measure(time, truth), truth)

    def _move(self) -> Odometry:
        world = self.world
        self._driver.advance(round(1 / (self._rate * TIMESTEP)))
        arcs = self._encoders.read(world.wheel_angles())
        start, time = (self._next - 1) / self._rate, self._next / self._rate
        return odometry(self.sensors, arcs, wheel_radius=world.wheel_radius, track=world.track, start=start, time=time)

    def _measure(self, time: float, truth: Truth) -> tuple[Measurement, ...]:
        world = self.world
        reach = self.sensors.detection_range
        looking, seen = visible(
            truth.positions, world.landmarks, world.walls, body_radius=world.mast_radius, detection_range=reach
        )
        bodies = np.concatenate([truth.positions, world.landmarks])
        return self._readings.take(time, bodies, truth.headings, looking=looking, seen=seen, keep_from=self._keep_from)


def episode(
    robots: int = 6,
    *,
    duration: float = 60.0,
    rate: float = 10.0,
    seed: int = 0,
    errors: ErrorKind = "uniform",
    measurements: MeasurementChoice = "all",
    sensors: Sensors | None = None,
    world: WorldKind = "mujoco",
) -> Episode:
    """Return a run of the simulator; the same arguments give the same bytes.

    Frame k is at time k / rate, k = 0, 1, ..., round(duration * rate) - 1. The first has no odometry; every later one has
    odometry of all robots since the one before. The truth depends on world, robots and seed alone, in the kinematic world on
    the kind of errors and the bounds on slip, too; what is measured does not depend on `measurements`: records are made first
    and left out afterwards.

    Args:
        robots: Number of robots, from 1 on; made for up to 100 in MuJoCo, for thousands in the kinematic world.
        duration: How long [s].
        rate: Frames in a second [Hz], from 0.5 on; a whole number of 5 ms timesteps must make a frame.
        seed: From 0 on.
        errors: The kind of errors, one of `sim.errors.ERROR_KINDS`.
        measurements: "all"; "absolute", compasses and landmarks, no robot of another; "none", compasses (and odometry) only.
        sensors: The bounds of the sensors; the default ones if None.
        world: "mujoco", or "kinematic" for the light one, whose robots slip up to the bounds.

    Raises:
        InvalidInput: An argument is none of these.
    """
    _check_rate(rate)
    if measurements not in MEASUREMENT_CHOICES:
        raise InvalidInput(f"measurements among {', '.join(MEASUREMENT_CHOICES)}", repr(measurements))
    if world not in get_args(WorldKind):
        raise InvalidInput(f"a world among {', '.join(get_args(WorldKind))}", repr(world))
    if isinstance(seed, bool) or not isinstance(seed, int | np.integer) or seed < 0:
        raise InvalidInput("a seed: a whole number from 0 on", repr(seed))
    frames = round(float(finite("duration [s]", duration, 0)) * rate)
    if frames < 1:
        raise InvalidInput(f"a duration of at least one frame, 1 / rate = {1 / rate:g} s", f"{duration!r} s")
    return Episode(
        robots,
        frames=frames,
        rate=float(rate),
        seed=seed,
        errors=known_kind(errors),
        measurements=measurements,
        sensors=sensors or Sensors(),
        world=world,
    )


def _world(
    kind: WorldKind,
    plan: Layout,
    placing: np.random.Generator,
    *,
    sensors: Sensors,
    errors: ErrorKind,
    slipping: np.random.Generator,
) -> World | KinematicWorld:
    positions, headings = start_poses(plan, placing)
    if kind == "mujoco":
        return World(plan, positions, headings)
    return KinematicWorld(plan, positions, headings, sensors=sensors, errors=errors, generator=slipping)


def _check_rate(rate: float) -> None:
    finite("rate [Hz]", rate, SLOWEST_RATE)
    steps = 1 / (rate * TIMESTEP)
    if round(steps) < 1 or abs(steps - round(steps)) > 1e-9 * steps:
        expected = f"a rate that divides {1 / TIMESTEP:g} Hz (a frame is a whole number of {TIMESTEP:g} s timesteps)"
        raise InvalidInput(expected, f"{rate!r} Hz")
