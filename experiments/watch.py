"""An integrity monitor: can another estimator's trajectory be true?

Runs the set-membership filter on a log and checks TUM trajectories of the same robots against it, made by whatever
estimator. Run `python -m experiments.watch --help`. Exit code 0 if no pose is proved wrong, 1 if any is, 2 for bad input.
"""

from __future__ import annotations

import csv
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.table import Table

from experiments.follow.frozen import keep_within
from experiments.follow.metrics import Value, rounded
from experiments.follow.scenarios import from_log
from experiments.follow.steps import steps
from experiments.logs import Trajectory, find_trajectories, read_trajectory
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import StepProgress, print_table, show_table
from filter import Alarm, Array, Belief, InvalidInput, SetMembershipFilter, Step, watch


@dataclass(frozen=True)
class Options:
    """Check another estimator's trajectories against regions that are guaranteed to contain the robots.

    Exit code 0 if no pose is proved wrong, 1 if any is, 2 for bad input. A proof holds as long as the log's bounds do.
    """

    log: Path
    """What the robots measured: a log.jsonl, see docs/log.md."""
    tum: Path
    """A trajectory, or a folder with one of each robot: r0.tum or r0_anything.tum is robot 0's."""
    pattern: str = "r*.tum"
    """Which files of the folder."""
    tolerance: float = 1e-6
    """How far apart in time a pose and a frame may be and still be of one instant [s]."""
    out: Path = Path("runs/watch")
    """Folder for alarms.csv and summary.json."""


@dataclass(frozen=True)
class Stretch:
    """Alarms of one robot at one frame after the other.

    Attributes:
        worst: The alarm that is farthest beyond its line.
        start: Time of the first one [s].
        end: Time of the last one [s].
        frames: How many they are.
        last_frame: Number of the last one's frame.
    """

    worst: Alarm
    start: float
    end: float
    frames: int
    last_frame: int

    def longer(self, alarm: Alarm, frame: int) -> Stretch:
        """Return the stretch with one more alarm."""
        worst = max(self.worst, alarm, key=lambda each: each.distance)
        return replace(self, worst=worst, end=alarm.time, frames=self.frames + 1, last_frame=frame)


class Stretches:
    """Joins alarms of one robot that follow one another without a break."""

    def __init__(self) -> None:
        self._latest: dict[int, int] = {}
        self.found: list[Stretch] = []

    def add(self, frame: int, alarm: Alarm) -> None:
        """Take in an alarm of the frame with this number."""
        place = self._latest.get(alarm.robot)
        if place is not None and self.found[place].last_frame == frame - 1:
            self.found[place] = self.found[place].longer(alarm, frame)
            return
        self._latest[alarm.robot] = len(self.found)
        self.found.append(Stretch(alarm, alarm.time, alarm.time, 1, frame))


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the monitor with command-line arguments; return the exit code."""
    return command("watch", Options, run, arguments, stopped="what was not looked at may be wrong")


def run(options: Options) -> int:
    """Run the monitor; return the exit code.

    Raises:
        CorralError: The log, a trajectory or the folder cannot be used, or the log disagrees with itself.
    """
    keep_within(options, tolerance=(0, np.inf))
    files = find_trajectories(options.tum, options.pattern, from_log(options.log).team.robots)
    trajectories = {robot: read_trajectory(file) for robot, file in files.items()}
    folder = output_folder(options.out)
    stretches = Stretches()
    checks = _watched(options, trajectories, folder / "alarms.csv", stretches)
    poses = sum(len(trajectory.times) for trajectory in trajectories.values())
    if not checks:
        raise InvalidInput(f"poses within {options.tolerance:g} s of the log's frames", f"none among {poses}")
    alarms = sum(each.frames for each in stretches.found)
    summary: dict[str, Value] = {
        "robots": len(trajectories),
        "poses": poses,
        "checks": checks,
        "alarms": alarms,
        "alarm_share": rounded(alarms / checks),
        "distance_max_m": rounded(max((each.worst.distance for each in stretches.found), default=0.0)),
    }
    write_summary(folder, summary)
    _print_stretches(stretches.found)
    print_table(f"watch, in {folder}", summary)
    return int(alarms > 0)


def _watched(options: Options, trajectories: Mapping[int, Trajectory], path: Path, stretches: Stretches) -> int:
    """Check every pose, write every alarm, join alarms to stretches; return how many poses were checked."""
    checks = 0
    with path.open("w", encoding="utf-8", newline="") as file, StepProgress(None) as progress:
        writer = csv.writer(file, lineterminator="\n")
        writer.writerow(["time_s", "robot", "distance_m", "normal_x", "normal_y", "offset_m", "sources"])
        for frame, (step, positions) in enumerate(_matched(options, trajectories)):
            checks += int(np.isfinite(positions).all(axis=1).sum())
            for alarm in watch(step.belief, positions):
                writer.writerow(_row(alarm))
                stretches.add(frame, alarm)
            progress.advance(step.frame.time, step.seconds)
    return checks


def _matched(options: Options, trajectories: Mapping[int, Trajectory]) -> Iterator[tuple[Step[Belief], Array]]:
    """Yield each step on the log with the (n, 2) positions that the trajectories claim; NaN for no claim."""
    scenario = from_log(options.log)
    for step in steps(SetMembershipFilter(scenario.team), scenario):
        claimed = np.full((scenario.team.robots, 2), np.nan)
        for robot, trajectory in trajectories.items():
            claimed[robot] = trajectory.at(step.frame.time, options.tolerance)
        yield step, claimed


def _row(alarm: Alarm) -> list[object]:
    sources = "; ".join(map(str, alarm.sources))
    return [alarm.time, f"r{alarm.robot}", alarm.distance, *alarm.normal.tolist(), alarm.offset, sources]


def _print_stretches(stretches: Sequence[Stretch]) -> None:
    table = Table("robot", "from [s]", "to [s]", "poses", "beyond [m]", "proved at its worst by", title="Proved wrong")
    for each in sorted(stretches, key=lambda each: (each.start, each.worst.robot)):
        proof = "; ".join(map(str, each.worst.sources))
        numbers = (f"{each.start:.3f}", f"{each.end:.3f}", str(each.frames), f"{each.worst.distance:.3f}")
        table.add_row(f"r{each.worst.robot}", *numbers, proof)
    if stretches:
        show_table(table)


if __name__ == "__main__":
    sys.exit(main())
