"""Does the filter keep a moving team? Follows one in the simulator, or in a log, and checks every robot at every step.

Run `python -m experiments.moving_team --help`. The exit code is the guarantee: 0 only if it was in force all the time, and no
position and no heading was ever outside what the filter claimed; 1 for one that was outside while it was in force, or for
measurements proved to disagree; 4 if it was suspended, as the policy "reject" does; 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, fields
from pathlib import Path

from experiments.following.beside import Beside
from experiments.following.metrics import Metrics, Value
from experiments.following.scenarios import Scenario, from_log
from experiments.following.simulated import from_simulator
from experiments.following.steps import warmed_up
from experiments.keeping.files import Poses, Proofs, check_provable
from experiments.keeping.recorded import recorded
from experiments.keeping.running import Keeper, Running, exit_code
from experiments.logs import LogWriter
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import print_table, tell
from filter import InvalidInput, Policy, SetMembershipFilter, Window
from sim.episode import MeasurementChoice, WorldKind, episode
from sim.errors import ErrorKind

LOG = "log.jsonl"
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
    """What to do when measurements are proved to disagree: raise (stop), or reject what is wrong: go on with what is known
    whichever one thing that is, until it is found out."""
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
    if options.certificates:
        check_provable(scenario.team)
    make = SetMembershipFilter.light if options.light else SetMembershipFilter
    team_filter = make(
        scenario.team,
        exact=options.solver == EXACT,
        solvers=SOLVERS if options.solver == EXACT else (options.solver, *SOLVERS),
        scope=Window.everybody() if options.hops is None else Window(options.hops),
        policy=options.policy,
        each_alone=options.certificates,
    )
    folder = output_folder(options.out)
    following = Following(options, scenario, folder)
    conflict = following.run(team_filter)
    summary = summary_of(options, following, conflict)
    write_summary(folder, summary)
    print_table(f"moving_team, in {folder}", summary)
    if conflict:
        tell(f"the filter stopped: {conflict}")
    if following.beside.failure:
        tell(f"the EKF's trajectories end early: {following.beside.failure}")
    if (suspended := following.running.metrics.suspended) is not None:
        tell(f"the guarantee is {suspended}")
    return exit_code(following.running.metrics, conflict is not None)


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
        self.beside = Beside(scenario)
        self._keepers: list[Keeper] = [
            recorded(
                scenario,
                folder / "moving_team.rrd",
                f"moving_team_{options.replay.stem if options.replay else options.seed}",
                inside=options.hops is None,
                view=options.view,
                camera=options.camera,
            ),
            Poses(folder, scenario.team),
        ]
        log = LogWriter(folder / LOG, scenario.header, scenario.initial)
        self._keepers += [Proofs(folder, scenario.team)] if options.certificates else []
        self.running = Running(scenario, Metrics(), self.beside, log)

    def run(self, team_filter: SetMembershipFilter) -> str | None:
        """Follow to the end; return None, or what was proved to disagree and stopped the filter.

        Raises:
            CorralError: A frame cannot be used.
        """
        return self.running.through(team_filter, self._keepers)


def summary_of(options: Options, following: Following, conflict: str | None) -> dict[str, Value]:
    """Return the run's summary; what a log does not tell is None."""
    told: dict[str, Value] = {"solver": options.solver, "policy": options.policy, "warm_up_s": warmed_up()}
    if options.replay is None:
        told |= {"seed": options.seed, "errors": options.errors, "measurements_mode": options.measurements}
    else:
        told |= {"replay": str(options.replay)}
    return following.running.summary(told, conflict)


if __name__ == "__main__":
    sys.exit(main())
