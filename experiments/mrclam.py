"""Real robots: a run of the UTIAS multi-robot data set (MRCLAM) through the filter and through an extended Kalman filter.

Run `python -m experiments.mrclam --help`. The exit code is the guarantee: 1 if a truth was outside what the filter claimed
while it said that its guarantee was in force; else 4 if the guarantee was suspended now and then, and 0 if never; 2 for bad
input. Bounds that are declared for real robots break now and then, so that a truth can be outside while the guarantee is
suspended: this is counted, too, in `escapes`, but it breaks no promise. What is assumed and what came out is in
docs/real-robots.md.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, field
from pathlib import Path
from shutil import rmtree
from typing import Literal

import numpy as np

from experiments.following.ellipses import WIDE_SIZE
from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, guarantee_summary
from experiments.following.scenarios import Scenario
from experiments.following.steps import steps, warmed_up
from experiments.keeping.provable import CERTIFIED
from experiments.real_robots.bounds import Bounds
from experiments.real_robots.data import RobotLog, Run, read_tables, run_of
from experiments.real_robots.faults import faulty
from experiments.real_robots.figures import draw_all
from experiments.real_robots.followed import Followed, Which, team_filter
from experiments.real_robots.frames import frames
from experiments.real_robots.kalman import kalman_filter
from experiments.real_robots.metrics import Escaped, Tally, summary_of
from experiments.real_robots.motion import Motions
from experiments.show.command import SUSPENDED, command
from experiments.show.output import Trajectories, output_folder, write_summary
from experiments.show.recording import Recording
from experiments.show.terminal import StepProgress, print_table, tell, too_short
from filter import Array, GaussianBelief, InvalidInput, Mask, Team

ENOUGH = 300.0  # seconds: until then the known start decides, not what the robots see
RECORD_EVERY = 0.25  # what happens is recorded at once, the rest so often [s]


@dataclass(frozen=True)
class Options:
    """Follow the real robots of a run of the MRCLAM data set, and compare with an extended Kalman filter.

    Exit code 1 if a position or a heading was outside what the filter claimed while it said that its guarantee was in force;
    else 4 if the guarantee was suspended now and then, and 0 if never; 2 for bad input. Escapes while the guarantee was
    suspended are counted as escapes all the same.
    """

    data: Path
    """Folder of a run, as MRCLAM_Dataset6."""
    robots: str = "1,2,3,4,5"
    """Which robots take part, by their numbers in the files."""
    start: float = 0.0
    """When to start, since the first command or measurement [s]."""
    duration: float | None = None
    """How long at most [s]; to the end if not given."""
    fault: str = "none"
    """Put a fault into a copy of the data: silent, biased, biased_right, swapped, exchanged, duplicated, shifted,
    or shifted_camera."""
    fault_robot: int = 1
    """Whose fault it is, by its number in the files."""
    filter: Which = "sets"
    """sets: the one filter for all teams. robust: the same, with evidence on turned and late cameras."""
    tolerate: Literal[0, 1] = 1
    """1: right although, for each robot, what it measures of one body, or one mate of it, is wrong for a while. 0: all is
    believed that is not proved wrong: smaller regions. What is proved to be more is in doubt until it is found out."""
    certificates: bool = False
    """Keep in certified/ what python -m experiments.prove proves again."""
    seed: int = 0
    """Where in its initial set each robot starts."""
    out: Path = Path("runs/mrclam")
    """Folder for summary, events, figures, trajectories and recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    stopped = "the recording and the trajectories end here, there is no summary"
    return command("mrclam", Options, run, arguments, stopped=stopped)


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option, a file of the data, or the output folder cannot be used.
    """
    keep_within(options, seed=(0, np.inf))
    robots, data = numbers_of(options.robots), data_of(options)
    declared = Bounds()
    bounds = declared.chained()  # the filter goes from frame to frame
    scenario, single = (scenario_of(options, data, robots, each) for each in (bounds, declared))
    proofs = options.out / CERTIFIED
    kept = proofs if options.certificates else None
    sets = team_filter(scenario, Motions(data, robots, bounds), options.tolerate, kept, options.filter)
    folder = output_folder(options.out)
    rmtree(proofs, ignore_errors=True)  # of an earlier run
    name = f"mrclam_{data.name}_{options.fault}"
    following = Following(scenario, folder, name, repeated(data, robots, scenario.team))
    following.run(sets, single)
    table = following.tally.table()
    found = summary_of(table, options.start, following.tally.resets)
    aside = following.tally.put_aside
    told: dict[str, Value] = {"sensors_put_aside": len(aside), "put_aside": "; ".join(aside), "warm_up_s": warmed_up()}
    told |= guarantee_summary(following.tally.suspended, scenario.team.words)
    told["too_short"] = too_short("who is nearer and smaller", seconds=(float(str(found["duration_s"])), ENOUGH))
    summary = header_of(options, data, robots) | found | told
    write_summary(folder, summary)
    draw_all(folder, table, scenario.team)
    print_table(f"mrclam, in {folder}", summary)
    broken = int(str(found["frame_escapes_in_force"])) + int(str(found["frame_heading_escapes_in_force"]))
    if broken:
        tell("a truth was outside while the guarantee was said to be in force")
        return 1
    return 0 if following.tally.suspended is None else SUSPENDED


def scenario_of(options: Options, data: Run, robots: Sequence[int], bounds: Bounds) -> Scenario:
    """Return the run with some bounds, the same for the same seed but for them."""
    generator = np.random.default_rng(options.seed)
    return frames(data, robots, options.start, options.duration, bounds=bounds, generator=generator)


def numbers_of(robots: str) -> tuple[int, ...]:
    """Return the robots' numbers of a list with commas.

    Raises:
        InvalidInput: It is none.
    """
    try:
        return tuple(int(word) for word in robots.split(","))
    except ValueError:
        raise InvalidInput("robots as numbers with commas, 1,2,3", repr(robots)) from None


def data_of(options: Options) -> Run:
    """Return the run, with its fault if there shall be one.

    Raises:
        InvalidInput: A file is missing or damaged, or there is no such fault or robot.
    """
    tables = read_tables(options.data)
    return run_of(tables if options.fault == "none" else faulty(tables, options.fault, options.fault_robot))


def repeated(data: Run, robots: Sequence[int], team: Team) -> list[str]:
    """Return in words how much of whose logs is there twice."""
    logs = [(team.name(k), data.logs[robot]) for k, robot in enumerate(robots)]
    return [f"{name}: {_repeats(log)}" for name, log in logs if log.dropped.duplicates]


def _repeats(log: RobotLog) -> str:
    twice = log.dropped.duplicates
    return f"{twice} of {len(log.commands) + len(log.measurements) + twice} lines of its log repeat others, and are left out"


def header_of(options: Options, data: Run, robots: Sequence[int]) -> dict[str, Value]:
    """Return what the summary says of the data."""
    return {
        "data": data.name,
        "robots": len(robots),
        "robot_numbers": options.robots,
        "start_s": options.start,
        "seed": options.seed,
        "filter": options.filter,
        "tolerate": options.tolerate,
        "fault": options.fault if options.fault == "none" else f"{options.fault}, robot {options.fault_robot}",
        **{f"dropped_{name}": count for name, count in asdict(data.dropped).items()},
    }


class Following:
    """Both filters follow a scenario; everything that shall be kept is written as it goes on."""

    def __init__(self, scenario: Scenario, folder: Path, recording_id: str, logs: Sequence[str] = ()) -> None:
        self.tally = Tally(scenario.header.start)
        self._scenario = scenario
        self._trajectories = Trajectories(folder, scenario.team)
        path, walls = folder / "mrclam.rrd", scenario.walls
        self._recording = Recording(path, scenario.team, recording_id=recording_id, walls=walls, wall_height=0.0, inside=False)
        self._changes = Changes(scenario.team, logs)
        self._events = folder / "events.txt"
        self._events.write_text("", encoding="utf-8")
        self._recorded = -np.inf

    def run(self, followed: Iterator[Followed], single: Scenario) -> None:
        """Follow to the end.

        Args:
            followed: The filter's steps.
            single: The scenario with the bounds of single records, from which the Kalman filter has its deviations.

        Raises:
            CorralError: A frame cannot be used.
        """
        estimates = steps(kalman_filter(single.team), single)
        with self._recording, self._trajectories, StepProgress(self._scenario.count) as progress:
            for step, estimate in zip(followed, estimates, strict=True):
                self._keep(step, estimate.belief)
                progress.advance(step.frame.time, step.seconds)

    def _keep(self, step: Followed, estimate: GaussianBelief) -> None:
        escaped = self.tally.add(step, estimate)
        self._trajectories.write(step.frame, step.belief)
        self._trajectories.estimate("ekf", step.frame.time, estimate.mean[:, :2], estimate.mean[:, 2])
        words = self._changes.words(step, escaped)
        if words or step.frame.time - self._recorded >= RECORD_EVERY:
            self._record(step, estimate)
        for text, level in words:
            self._recording.event(text, level)
        with self._events.open("a", encoding="utf-8") as file:
            file.writelines(f"{step.frame.time:10.3f} {level:5} {text}\n" for text, level in words)

    def _record(self, step: Followed, estimate: GaussianBelief) -> None:
        self._recorded = step.frame.time
        outers = [region.outer for region in step.belief.regions]
        self._recording.add(step.frame, step.belief)
        self._recording.ellipses(estimate.mean[:, :2], estimate.position_covariances, WIDE_SIZE)
        self._recording.suspended({int(robot): outers[robot] for robot in np.flatnonzero(step.suspended)})
        self._recording.rejected(rejected_lines(step, self._scenario.team))


def rejected_lines(step: Followed, team: Team) -> list[Array]:
    """Return (2, 2) lines from each robot to what it measured, of the measurements rejected at this frame [m]."""
    places = np.concatenate([[region.outer.centroid for region in step.belief.regions], team.landmarks])
    pairs = {(source.robot, source.target) for source in step.rejected if source.target is not None}
    return [places[list(pair)] for pair in sorted(pairs)]


@dataclass
class Changes:
    """Tells what happens, and when a lasting thing begins and ends.

    Attributes:
        team: Whose run it is.
        logs: What is to be said of the logs, once.
    """

    team: Team
    logs: Sequence[str] = ()
    _before: dict[str, set[int]] = field(default_factory=dict)

    def words(self, step: Followed, escaped: Escaped) -> list[tuple[str, str]]:
        """Return in words what is new at this frame, each with its level."""
        words = [(event, "WARN") for event in (*self.logs, *step.events)]
        self.logs = ()
        words += self._turns("no commands, nothing is known of its motion", "commands again", step.silent, "WARN")
        words += self._turns("guarantee suspended", "guarantee in force again", step.suspended, "WARN", step.guarantee.because)
        words += self._turns("truth outside the polygon", "truth inside again", escaped.positions, "ERROR")
        return words + self._turns("heading outside its interval", "heading inside again", escaped.headings, "ERROR")

    def _turns(
        self, begins: str, ends: str, holds: Mask, level: str, because: Sequence[str] | None = None
    ) -> list[tuple[str, str]]:
        now, before = set(np.flatnonzero(holds).tolist()), self._before.get(begins, set())
        self._before[begins] = now
        why = {robot: f", as {because[robot]}" if because else "" for robot in now}
        new = [(f"{self.team.name(robot)}: {begins}{why[robot]}", level) for robot in sorted(now - before)]
        return new + [(f"{self.team.name(robot)}: {ends}", "INFO") for robot in sorted(before - now)]


if __name__ == "__main__":
    sys.exit(main())
