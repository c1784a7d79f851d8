"""Sizes of teams to measure, and what they come to."""

from __future__ import annotations

from dataclasses import dataclass

from experiments.following.scenarios import Scenario
from experiments.following.simulated import from_simulator
from sim.episode import WorldKind, episode
from sim.errors import ErrorKind

RATE = 10.0  # [Hz]
LEFT_OUT = 10  # first steps, in which the initial boxes shrink: they are no part of any figure but the escapes


@dataclass(frozen=True)
class Case:
    """A size of team to measure.

    Attributes:
        robots: Number of robots.
        world: Where they drive.
        errors: Kind of the sensors' errors.
        seed: Where all randomness comes from.
        steps: How many steps are measured, after those that are left out.
        baselines: Whether the whole team's program and the Kalman filter are to be compared with.
    """

    robots: int
    world: WorldKind
    errors: ErrorKind
    seed: int
    steps: int
    baselines: bool = True

    @property
    def frames(self) -> int:
        """How many frames are simulated."""
        return LEFT_OUT + self.steps

    def scenario(self) -> Scenario:
        """Return the run, simulated as its frames are taken.

        Raises:
            InvalidInput: The simulator cannot do this.
        """
        duration = self.frames / RATE
        run = episode(self.robots, duration=duration, rate=RATE, seed=self.seed, errors=self.errors, world=self.world)
        return from_simulator(run, RATE)


@dataclass(frozen=True)
class Size:
    """What a size of team came to; times are medians over the measured steps, but for one.

    Attributes:
        robots: Number of robots.
        world: Where they drove.
        steps: Measured steps.
        compile_seconds: Time of the first steps of a small team: compiled code is made, or fetched [s].
        simulate_ms: Time in which a frame is simulated.
        step_median_ms: Time of a step, prediction and update.
        step_p95_ms: Time that 95 % of the steps keep.
        phases_median_ms: Time of each of the filter's phases.
        rows: Number of the belief's rows after a step, the mean.
        window_robots_mean: Robots in a window.
        window_robots_max: Robots in the largest window.
        memory_mib: Greatest memory of the process until the last step, interpreter and simulator included.
        area_m2: Area of a robot's outer polygon, the mean.
        escapes: Positions and headings outside what the filter claimed, in all steps.
        projections: Regions that were projected, in all steps.
        fallbacks: How often another solver had to stand in for the walk, in all steps.
        area_ratio_to_team: Area over that from the whole team's program, from the same beliefs and measurements.
        ekf_step_median_ms: Time of a step of the joint extended Kalman filter.
        conflict: What was proved to disagree and ended the run, if anything.
    """

    robots: int
    world: WorldKind
    steps: int
    compile_seconds: float
    simulate_ms: float | None
    step_median_ms: float | None
    step_p95_ms: float | None
    phases_median_ms: dict[str, float | None]
    rows: float | None
    window_robots_mean: float | None
    window_robots_max: int | None
    memory_mib: float | None
    area_m2: float | None
    escapes: int
    projections: int
    fallbacks: int
    area_ratio_to_team: float | None = None
    ekf_step_median_ms: float | None = None
    conflict: str | None = None
