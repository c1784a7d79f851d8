"""An integrity monitor: can another estimator's trajectory be true?

Runs the set-membership filter on a log and checks TUM trajectories of the same robots against it, made by whatever
estimator. Run `python -m experiments.watch --help`. Exit code 0 if no pose is proved wrong, 1 if any is, 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from rich.table import Table

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, rounded
from experiments.following.scenarios import from_log
from experiments.logs import find_trajectories
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Terminal, print_table, show_table
from experiments.watchdog.claimed import Claimed, read_claims
from experiments.watchdog.episodes import Episode
from experiments.watchdog.judge import Judge
from experiments.watchdog.reach import Reach
from experiments.watchdog.watching import Watching, write_episodes
from filter import InvalidInput


@dataclass(frozen=True)
class Options:
    """Check other estimators' trajectories against regions that are guaranteed to contain the robots.

    A pose between two frames is held against the regions of both, widened by how far a robot can get in the time between.
    Exit code 0 if no pose is proved wrong, 1 if any is, 2 for bad input. A proof holds as long as the log's bounds do, its
    speed limit among them.
    """

    log: Path
    """What the robots measured: a log.jsonl, see docs/log.md."""
    tum: Path
    """A trajectory, or a folder of them: r0.tum is robot 0's, r0_slam.tum the estimator slam's of robot 0."""
    pattern: str = "r*.tum"
    """Which files of the folder."""
    offset: float = 0.0
    """What to add to the stamps of poses for times of the log [s]."""
    tolerance: float = 1e-6
    """How far a stamp may then still be from the time that the pose is of [s]."""
    back: float = 1.0
    """How far regions are traced back to what the sensors said [s]."""
    out: Path = Path("runs/watch")
    """Folder for alarms.csv, episodes.csv and summary.json."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the monitor with command-line arguments; return the exit code."""
    return command("watch", Options, run, arguments, stopped="what was not looked at may be wrong")


def run(options: Options) -> int:
    """Run the monitor; return the exit code.

    Raises:
        CorralError: The log, a trajectory or the folder cannot be used, or the log disagrees with itself.
    """
    keep_within(options, offset=(-np.inf, np.inf), tolerance=(0, np.inf), back=(0, np.inf))
    scenario = from_log(options.log)
    files = find_trajectories(options.tum, options.pattern, scenario.team.robots)
    claims = read_claims(files, scenario.team.robots, options.offset)
    frames = list(scenario.frames)
    if not frames:
        raise InvalidInput(f"{options.log}: at least one frame", "none")
    judge = Judge(Reach.of(scenario.team, frames), options.tolerance)
    _check_times(judge, claims)
    folder = output_folder(options.out)
    watching = Watching(judge, claims, options.back)
    watching.run(replace(scenario, frames=iter(frames), count=len(frames)), folder / "alarms.csv")
    summary = _summary(watching, files)
    write_episodes(folder / "episodes.csv", watching.episodes)
    write_summary(folder, summary)
    _print_episodes(watching.episodes)
    print_table(f"watch, in {folder}", summary)
    Terminal().print(_sentence(summary), highlight=False, soft_wrap=True)
    return int(watching.alarms > 0)


def _check_times(judge: Judge, claims: Sequence[Claimed]) -> None:
    if not any(claimed.poses(judge.first, judge.last) for claimed in claims):
        begin, end = min(claimed.times[0] for claimed in claims), max(claimed.times[-1] for claimed in claims)
        span = f"poses between {judge.first:.3f} s and {judge.last:.3f} s, the log's first and last frame (see --offset)"
        raise InvalidInput(span, f"poses from {begin:.3f} s to {end:.3f} s")


def _summary(watching: Watching, files: Mapping[str, Mapping[int, Path]]) -> dict[str, Value]:
    judge, claims, episodes = watching.judge, watching.claims, watching.episodes
    return {
        "robots": len({robot for of in files.values() for robot in of}),
        "trajectories": sum(map(len, files.values())),
        "poses": sum(claimed.poses() for claimed in claims),
        "checks": watching.checks,
        "before_first_frame": sum(claimed.poses(until=judge.first) for claimed in claims),
        "after_last_frame": sum(claimed.poses(after=judge.last) for claimed in claims),
        "alarms": watching.alarms,
        "alarm_share": rounded(watching.alarms / watching.checks),
        "episodes": len(episodes),
        "distance_max_m": rounded(max((episode.worst.distance for episode, _ in episodes), default=0.0)),
    }


def _sentence(summary: Mapping[str, Value]) -> str:
    judged = (
        "{checks} of {poses} poses were judged: {before_first_frame} are before the log's first frame, {after_last_frame} after"
    )
    wrong = "{alarms} are proved wrong, in {episodes} episode" + "s" * (summary["episodes"] != 1)
    return f"{judged} its last. {wrong}, if every bound of the log holds.".format(**summary)


def _print_episodes(episodes: Sequence[tuple[Episode, str]]) -> None:
    table = Table("trajectory", "from [s]", "to [s]", "poses", "beyond [m]", "proved at its worst by", title="Proved wrong")
    for episode, behind in episodes:
        numbers = (f"{episode.start:.3f}", f"{episode.end:.3f}", str(episode.poses), f"{episode.worst.distance:.3f}")
        table.add_row(episode.trajectory, *numbers, behind)
    if episodes:
        show_table(table)


if __name__ == "__main__":
    sys.exit(main())
