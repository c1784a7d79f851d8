"""Does the filter keep a moving team? Follows one in the simulator, or in a log, and checks every robot at every step.

Run `python -m experiments.moving_team --help`. The exit code is the guarantee: 0 only if it was in force all the time, and no
position and no heading was ever outside what the filter claimed; 1 for one that was outside while it was in force, or for
measurements proved to disagree; 4 if it was suspended, as the policy "reject" does; 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from contextlib import nullcontext
from dataclasses import dataclass, fields
from pathlib import Path

import numpy as np

from experiments.following.beside import Beside
from experiments.following.metrics import Escapes, Metrics, Value
from experiments.following.scenarios import Scenario, from_log
from experiments.following.simulated import from_simulator
from experiments.following.steps import Contacts, steps, warmed_up
from experiments.logs import Certificates, LogWriter
from experiments.show.command import SUSPENDED, command
from experiments.show.output import Trajectories, output_folder, write_summary
from experiments.show.recording import Recording
from experiments.show.terminal import StepProgress, print_table, tell
from experiments.show.viewer import open_viewer
from filter import Belief, Inconsistent, InvalidInput, Policy, SetMembershipFilter, Step, Window
from sim.episode import MeasurementChoice, WorldKind, episode
from sim.errors import ErrorKind

LOG = "log.jsonl"
PICTURE_EVERY = 1.0  # [s]
ROUNDING = 1e-9  # of times [s]


EXACT = "exact"  # no solver: walks over the vertices
SOLVERS = SetMembershipFilter.solvers


@dataclass(frozen=True)
class Options:
    """Follow a moving team in the simulator (or in a log) and check every robot at every step.

    Exit code 0 only if the guarantee was in force all the time, and no position and no heading was ever outside what the filter
    claimed; 1 for one that was outside while it was in force, or for measurements proved to disagree; 4 if the guarantee was
    suspended; 2 for bad input.
    """

    robots: int = 6
    """Number of robots."""
    duration: float = 60.0
    """How long the run is [s]."""
    rate: float = 10.0
    """Steps a second [Hz]."""
    seed: int = 0
    """Where all randomness comes from: the same seed, the same run."""
    errors: ErrorKind = "uniform"
    """Kind of the sensors' errors, always within their bounds."""
    world: WorldKind = "mujoco"
    """Where they drive: mujoco, made for up to 100 robots, or kinematic, lighter by far."""
    hops: int | None = None
    """Find each region in the window of the robots so many sightings away, not in the whole team; 1 does for large teams."""
    light: bool = False
    """Take less along from step to step, for large teams: rows of fewer kinds, and fewer of them."""
    solver: str = "exact"
    """How regions are found: exact, or searched by piqp or any other solver that qpsolvers finds here."""
    measurements: MeasurementChoice = "all"
    """all; absolute: none from robot to robot; none: odometry and compass alone."""
    out: Path = Path("runs/moving_team")
    """Folder for summary, log, trajectories and recording."""
    policy: Policy = "raise"
    """What to do when measurements are proved to disagree: raise (stop), or reject the fewest and newest of them; the guarantee
    is suspended from then on."""
    certificates: bool = False
    """Write certificates.jsonl.gz, to be proved again by python -m experiments.prove."""
    view: bool = False
    """Show the run in a live viewer while it goes on."""
    camera: bool = False
    """Record a picture of the simulated world every second (needs OpenGL)."""
    replay: Path | None = None
    """Take everything from this log instead of the simulator."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command(
        "moving_team",
        Options,
        run,
        arguments,
        stopped="the log, the recording and the trajectories end here, there is no summary",
    )


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option, the log, or the output folder cannot be used.
    """
    scenario = scenario_of(options)
    make = SetMembershipFilter.light if options.light else SetMembershipFilter
    team_filter = make(
        scenario.team,
        exact=options.solver == EXACT,
        solvers=SOLVERS if options.solver == EXACT else (options.solver, *SOLVERS),
        scope=Window.everybody() if options.hops is None else Window(options.hops),
        policy=options.policy,
    )
    folder = output_folder(options.out)
    following = Following(options, scenario, folder)
    conflict = following.run(team_filter)
    summary = summary_of(options, scenario, following.metrics) | {"inconsistent": conflict}
    write_summary(folder, summary)
    print_table(f"moving_team, in {folder}", summary)
    if conflict:
        tell(f"the filter stopped: {conflict}")
    if following.beside.failure:
        tell(f"the EKF's trajectories end early: {following.beside.failure}")
    if following.metrics.suspended is not None:
        tell(f"the guarantee is {following.metrics.suspended}")
    return exit_code(following.metrics, conflict is not None)


def exit_code(metrics: Metrics, conflict: bool) -> int:
    """Return what a run was worth: 1 for a broken promise, else `SUSPENDED` if nothing was promised for a while, else 0."""
    if metrics.broken or conflict:
        return 1
    return 0 if metrics.suspended is None else SUSPENDED


def scenario_of(options: Options) -> Scenario:
    """Return the scenario that the options ask for.

    Raises:
        CorralError: An option cannot be used, or not together with another.
    """
    if options.replay is None:
        simulated = episode(
            robots=options.robots,
            duration=options.duration,
            rate=options.rate,
            seed=options.seed,
            errors=options.errors,
            measurements=options.measurements,
            world=options.world,
        )
        return from_simulator(simulated, options.rate)
    for field in fields(Options):
        simulates = field.name in ("robots", "duration", "rate", "seed", "errors", "measurements", "camera", "world")
        if simulates and getattr(options, field.name) != field.default:
            raise InvalidInput(
                "a log to decide everything but --hops, --solver, --policy, --certificates, --out and --view",
                f"--{field.name} with --replay",
            )
    if options.replay.resolve() == (options.out / LOG).resolve():
        raise InvalidInput("another --out than the folder of the replayed log", str(options.out))
    return from_log(options.replay)


class Following:
    """A filter follows a scenario; everything that shall be kept of it is written as it goes on."""

    def __init__(self, options: Options, scenario: Scenario, folder: Path) -> None:
        self.metrics = Metrics()
        viewer = open_viewer() if options.view else None
        self._scenario, team = scenario, scenario.team
        self._contacts = Contacts(team)
        self._picture = scenario.picture if options.camera else None
        self._recording = Recording(
            folder / "moving_team.rrd",
            team,
            walls=scenario.walls,
            wall_height=scenario.wall_height,
            recording_id=f"moving_team_{options.replay.stem if options.replay else options.seed}",
            camera=options.camera,
            inside=options.hops is None,
            viewer=viewer,
        )
        self._trajectories, self.beside = Trajectories(folder, team), Beside(scenario)
        self._log = LogWriter(folder / LOG, scenario.header, scenario.initial)
        self._certificates = Certificates(folder, team.landmarks) if options.certificates else None
        self._pictured = -PICTURE_EVERY
        self._guarantee = "in force"

    def run(self, team_filter: SetMembershipFilter) -> str | None:
        """Follow to the end; return None, or what was proved to disagree and stopped the filter.

        Raises:
            CorralError: A frame cannot be used.
        """
        certificates, progress = self._certificates or nullcontext(), StepProgress(self._scenario.count)
        with self._log, self._recording, self._trajectories, certificates, progress:
            try:
                for step in steps(team_filter, self._scenario, self._log):
                    self._keep(step)
                    progress.advance(step.frame.time, step.seconds)
            except Inconsistent as error:
                self._recording.event(str(error), "ERROR")
                return str(error)
        return None

    def _keep(self, step: Step[Belief]) -> None:
        escapes = self.metrics.add(step.frame, step.belief, step.seconds)
        self._recording.add(step.frame, step.belief)
        self._trajectories.write(step.frame, step.belief)
        if (guess := self.beside.estimate(step.frame)) is not None:
            self._trajectories.estimate("ekf", step.frame.time, guess.mean[:, :2], guess.mean[:, 2])
        if self._certificates:
            self._certificates.write(step)
        for event in step.belief.events:
            self._recording.event(str(event), "WARN")
        self._warrant(step.belief)
        for words in self._contacts.changes(step.frame):
            self._recording.event(words)
        self._report(escapes)
        if self._picture and step.frame.time - self._pictured >= PICTURE_EVERY - ROUNDING:
            self._recording.image(self._picture())
            self._pictured = step.frame.time

    def _warrant(self, belief: Belief) -> None:
        """Record where the guarantee is suspended, and that it is, once."""
        suspended = np.flatnonzero(~belief.guarantee.in_force).tolist()
        if suspended or self._guarantee != "in force":
            self._recording.suspended({robot: belief.regions[robot].outer for robot in suspended})
        if str(belief.guarantee) != self._guarantee:
            self._guarantee = str(belief.guarantee)
            self._recording.event(f"guarantee {self._guarantee}", "WARN" if suspended else "INFO")

    def _report(self, escapes: Escapes) -> None:
        for what, robots in (("position", escapes.positions), ("heading", escapes.headings)):
            for robot in robots:
                self._recording.event(f"{self._scenario.team.name(robot)}: the {what} escaped", "ERROR")


def summary_of(options: Options, scenario: Scenario, metrics: Metrics) -> dict[str, Value]:
    """Return the run's summary; what a log does not tell is None."""
    simulated = options.replay is None
    rate = scenario.header.rate
    return {
        "robots": scenario.team.robots,
        "duration_s": metrics.steps / rate if rate else None,
        "rate_hz": rate,
        "seed": options.seed if simulated else None,
        "errors": options.errors if simulated else None,
        "solver": options.solver,
        "policy": options.policy,
        "measurements_mode": options.measurements if simulated else None,
        "replay": None if simulated else str(options.replay),
        "warm_up_s": warmed_up(),
        **metrics.summary(),
    }


if __name__ == "__main__":
    sys.exit(main())
