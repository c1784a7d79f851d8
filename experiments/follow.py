"""Your own log through one filter: what comes out is regions in forms that other tools read.

Run `python -m experiments.follow --help`. The exit code is the guarantee: 0 only if it was in force all the time and no truth,
where the log tells it, was outside; 1 for one that was outside while it was in force, for measurements proved to disagree, or
for a pose of --watch that is proved wrong; 4 if it was suspended, as that of a Kalman filter always is; 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Annotated, Any, Literal

import tyro

from experiments.following.beside import Beside
from experiments.following.metrics import Metrics, Value
from experiments.following.scenarios import Scenario, of_log
from experiments.following.tolerating import Tolerating
from experiments.keeping.files import Poses, Proofs, check_provable
from experiments.keeping.regions import RegionFiles
from experiments.keeping.running import Keeper, Running, Told, exit_code
from experiments.keeping.watched import ALARMS, BACK, EPISODES, POSES, TOLERANCE, Watched
from experiments.logs import LogReader
from experiments.regions import FILES, Format, check_packages
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import print_table, tell
from experiments.watchdog.claimed import claims_in
from experiments.watchdog.judge import judge_of
from experiments.watchdog.told import print_episodes, sentence
from experiments.watchdog.watching import Watching
from filter import ExtendedKalmanFilter, Filter, InvalidInput, Policy, RobustFilter, SetMembershipFilter, Team, Window

LOG, RECORDING = "log.jsonl", "follow.rrd"
EVERY = 0.1  # so long a time is one step, where nothing needs each stamp [s]
# What a run leaves in its folder; what is there from an earlier one would be taken for this one's.
PROOFS = ("certificates.jsonl.gz", "headings.jsonl.gz", "regions.jsonl.gz", "alternatives.jsonl.gz")
LEFT = (ALARMS, EPISODES, *PROOFS, RECORDING, *FILES.values())


@dataclass(frozen=True)
class Options:
    """Follow your own log with one filter, and write its regions in forms that other tools read.

    Exit code 0 only if the guarantee was in force all the time, and no truth, where the log tells it, was outside; 1 for one
    that was outside while it was in force, for measurements proved to disagree, or for a watched pose that is proved wrong;
    4 if the guarantee was suspended, as that of a Kalman filter always is; 2 for bad input.
    """

    log: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="LOG")]
    """What the robots measured: a log.jsonl, see docs/log.md."""
    filter: Literal["sets", "robust", "ekf"] = "sets"
    """sets: guaranteed as long as every bound holds; robust: the same with --policy reject, and with evidence on cameras that
    are turned or late; ekf: a Kalman filter, which guarantees nothing."""
    against: Literal["ekf"] | None = None
    """Run a Kalman filter beside it, and tell both."""
    watch: Path | None = None
    """Hold other estimators' trajectories against the regions: a folder of r0.tum or r0_slam.tum, see experiments.watch."""
    out: Path = Path("runs/follow")
    """Folder for the summary, the log, the trajectories and the regions."""
    formats: tuple[Format, ...] = ("jsonl",)
    """What the regions are written as, see docs/regions.md."""
    recording: bool = False
    """Record follow.rrd, to look at with Rerun."""
    every: float | None = None
    """Merge what was measured in so long a time at once, at its last stamp [s]; 0 for a step at every stamp. By default 0.1
    for a plain run of sets; 0 with --against, --watch or --certificates, for which each stamp counts, and other filters."""
    hops: int | None = None
    """Find each region in the window of the robots so many sightings away, not in the whole team; 1 does for large teams."""
    light: bool = False
    """Take less along from step to step: faster, with regions larger by little."""
    policy: Policy = "raise"
    """What to do when measurements are proved to disagree: raise (stop), or reject what is wrong: go on with what is known
    whichever one thing that is, until it is found out."""
    tolerating: tyro.conf.OmitArgPrefixes[Tolerating] = field(default_factory=Tolerating)
    """What may be wrong, all the time."""
    certificates: bool = False
    """Write certificates.jsonl.gz, to be proved again by python -m experiments.prove."""
    view: bool = False
    """Show the run in a live viewer while it goes on, and record it."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Follow a log with command-line arguments; return the exit code."""
    stopped = "the regions and the trajectories end here, there is no summary"
    return command("follow", Options, run, arguments, stopped=stopped)


def run(options: Options) -> int:
    """Follow a log; return the exit code.

    Raises:
        CorralError: An option, the log, a trajectory or the output folder cannot be used.
        OSError: Something cannot be written.
    """
    _check(options)
    log = LogReader(options.log)
    scenario, watching = _watching(options, of_log(log))
    if options.certificates:
        check_provable(scenario.team)
    filter_ = filter_of(options, scenario.team)
    folder = _emptied(output_folder(options.out))
    log.copy(folder / LOG)
    return Following(options, scenario, folder, watching).run(filter_)


def filter_of(options: Options, team: Team) -> Filter[Any]:
    """Return the filter that the options ask for.

    Raises:
        InvalidInput: The team is none for it, or there are no such windows.
    """
    if options.filter == "ekf":
        return ExtendedKalmanFilter(team)
    kind, policy = (RobustFilter, "reject") if options.filter == "robust" else (SetMembershipFilter, options.policy)
    scope = Window.everybody() if options.hops is None else Window(options.hops)
    tolerance, proved = options.tolerating.tolerance(), options.certificates
    make = kind.light if options.light else kind
    return make(team, scope=scope, policy=policy, tolerance=tolerance, each_alone=proved)


def every_of(options: Options) -> float:
    """Return how long a time is one step [s]."""
    each = options.filter != "sets" or bool(options.against or options.watch or options.certificates)
    return options.every if options.every is not None else 0.0 if each else EVERY


def _check(options: Options) -> None:
    """Refuse options that would mean nothing together, and files that would be written over."""
    of_sets = ("every", "policy", "certificates")
    alone = {"sets": (), "robust": of_sets, "ekf": (*of_sets, "hops", "light", "watch")}
    for name in alone[options.filter]:
        if getattr(options, name) != getattr(Options, name):
            raise InvalidInput(f"--filter sets, which has --{name}", f"--filter {options.filter}")
    if options.tolerating.tolerance() is not None and options.filter == "ekf":
        raise InvalidInput("--filter sets or robust, which have --tolerate", "--filter ekf")
    for name in ("against", "recording", "view"):
        if options.filter == "ekf" and getattr(options, name):
            raise InvalidInput(f"a filter with regions for --{name}", "--filter ekf")
    if options.every:
        for name in ("against", "watch", "certificates"):
            if getattr(options, name):
                raise InvalidInput(f"a step at every stamp for --{name}, as of --every 0", f"--every {options.every:g}")
    for form in options.formats:
        check_packages(form)
    written = {(options.out / name).resolve() for name in (LOG, *LEFT)}
    if options.log.resolve() in written:
        raise InvalidInput("another --out than the folder of the log", str(options.out))
    if options.watch and options.watch.resolve() == (options.out / "trajectories").resolve():
        raise InvalidInput("another --out than that of the watched trajectories", str(options.out))


def _watching(options: Options, scenario: Scenario) -> tuple[Scenario, Watching | None]:
    """Return what holds trajectories against the regions, if any; it looks through the log first."""
    if options.watch is None:
        return scenario, None
    claims, frames = claims_in(options.watch, POSES, scenario.team.robots, 0.0), list(scenario.frames)
    watching = Watching(scenario.team, judge_of(scenario.team, frames, claims, TOLERANCE), claims, BACK)
    return replace(scenario, frames=iter(frames), count=len(frames)), watching


def _emptied(folder: Path) -> Path:
    for name in LEFT:
        (folder / name).unlink(missing_ok=True)
    return folder


class Following:
    """A filter follows a log; everything that shall be kept of it is written as it goes on."""

    def __init__(self, options: Options, scenario: Scenario, folder: Path, watching: Watching | None) -> None:
        self._options, self._scenario, self._folder = options, scenario, folder
        self._beside = Beside(scenario) if options.against else None
        self._running = Running(scenario, Metrics(), self._beside, warm=False, every=every_of(options))
        self._watched = Watched(watching, folder) if watching else None
        self._told: list[Told] = [*self._judges(), *([self._watched] if self._watched else [])]
        self._keepers: list[Keeper] = [*self._recording(), Poses(folder, scenario.team), *self._told]
        self._keepers += [RegionFiles(folder, scenario.names, options.formats)]
        self._keepers += [Proofs(folder, scenario.team)] if options.certificates else []

    def _judges(self) -> Iterator[Told]:
        if "ekf" in (self._options.filter, self._options.against):
            from experiments.keeping.against import Against  # noqa: PLC0415 - what few need shall cost nobody else time

            yield Against()

    def _recording(self) -> Iterator[Keeper]:
        options, path = self._options, self._folder / RECORDING
        if options.recording or options.view:
            from experiments.keeping.recorded import recorded  # noqa: PLC0415 - Rerun is half a second that few need

            inside = options.filter != "ekf" and options.hops is None
            yield recorded(self._scenario, path, f"follow_{options.log.stem}", inside=inside, view=options.view)

    def run(self, filter_: Filter[Any]) -> int:
        """Follow to the end, write the summary and tell it; return the exit code.

        Raises:
            CorralError: A frame cannot be used.
            OSError: Something cannot be written.
        """
        conflict = self._running.through(filter_, self._keepers)
        summary = self._summary(conflict)
        write_summary(self._folder, summary)
        print_table(f"follow, in {self._folder}", {name: value for name, value in summary.items() if value is not None})
        self._tell(conflict)
        alarms = self._watched.watching.alarms if self._watched else 0
        return 1 if alarms else exit_code(self._running.metrics, conflict is not None)

    def _summary(self, conflict: str | None) -> dict[str, Value]:
        options = self._options
        told: dict[str, Value] = {"replay": str(options.log)}
        if options.filter == "sets":
            told |= {"solver": "exact", "policy": options.policy}
        own: dict[str, Value] = {"filter": options.filter, "formats": " ".join(dict.fromkeys(options.formats))}
        own |= {"tolerated": str(options.tolerating.tolerance() or "")} if options.filter == "sets" else {}
        own |= {"every_s": every_of(options), "recording": RECORDING if options.recording or options.view else None}
        for keeper in self._told:
            own |= keeper.summary()
        return self._running.summary(told, conflict) | own

    def _tell(self, conflict: str | None) -> None:
        metrics, watched = self._running.metrics, self._watched
        if watched:
            print_episodes(watched.watching.episodes)
            tell(sentence({name.removeprefix("watch_"): value for name, value in watched.summary().items()}))
        if conflict:
            tell(f"the filter stopped: {conflict}")
        if self._beside and self._beside.failure:
            tell(f"the EKF ends early: {self._beside.failure}")
        tolerance = self._options.tolerating.tolerance()
        if tolerance is not None and conflict is None and metrics.suspended is None:
            tell(f"the guarantee is in force {tolerance}")
        if metrics.suspended is not None:
            tell(f"the guarantee is {self._scenario.team.words(metrics.suspended)}")
        if not metrics.checks and self._options.filter != "ekf":
            tell("the log tells no truth: nothing was checked against it")


if __name__ == "__main__":
    sys.exit(main())
