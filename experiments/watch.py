"""An integrity monitor: can another estimator's trajectory be true?

Runs the set-membership filter on a log and checks TUM trajectories of the same robots against it, made by whatever
estimator. Run `python -m experiments.watch --help`. Exit code 0 if no pose is proved wrong, 1 if any is, 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from experiments.following.frozen import keep_within
from experiments.following.scenarios import from_log
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Terminal, print_table
from experiments.watchdog.claimed import claims_in
from experiments.watchdog.judge import judge_of
from experiments.watchdog.told import print_episodes, sentence, summary_of
from experiments.watchdog.watching import Watching, write_episodes


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
    claims = claims_in(options.tum, options.pattern, scenario.team.robots, options.offset)
    frames = list(scenario.frames)
    judge = judge_of(scenario.team, frames, claims, options.tolerance)
    watching = Watching(scenario.team, judge, claims, options.back)
    folder = output_folder(options.out)
    watching.run(replace(scenario, frames=iter(frames), count=len(frames)), folder / "alarms.csv")
    summary = summary_of(watching)
    write_episodes(folder / "episodes.csv", watching.episodes)
    write_summary(folder, summary)
    print_episodes(watching.episodes)
    print_table(f"watch, in {folder}", summary)
    Terminal().print(sentence(summary), highlight=False, soft_wrap=True)
    return int(watching.alarms > 0)


if __name__ == "__main__":
    sys.exit(main())
