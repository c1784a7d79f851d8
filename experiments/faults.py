"""One bound breaks, then all hold again or one lies on: does the filter notice, say so, and get right?

Eight kinds of faults in a small team; see docs/faults.md. Run `python -m experiments.faults --help`. The exit code is the
guarantee: 0 only if no truth was outside while the filter said that its guarantee was in force, from the first frame on in
which an independent judge proves that a bound is broken; 1 otherwise; 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from experiments.broken.fault import KINDS, Kind, checked_kind
from experiments.broken.figures import draw_faults
from experiments.broken.outcome import Case, Outcome, outcome_of
from experiments.broken.recording import record_episode
from experiments.broken.scene import LANDMARKS
from experiments.broken.told import print_kinds, sentence, summary_of
from experiments.following.frozen import keep_within
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary, write_whole
from experiments.show.terminal import Terminal, gathered, print_table
from experiments.sweep.executors import executor
from filter import InvalidInput


@dataclass(frozen=True)
class Options:
    """Break one bound in each of many episodes, and see what the filter makes of it.

    Exit code 0 only if no truth was outside while the filter said that its guarantee was in force, from the first frame on at
    which an independent judge proves that a bound is broken; 1 otherwise; 2 for bad input.
    """

    episodes: int = 500
    """How many, of each kind in turn."""
    landmarks: int = 4
    """How many: 4 and more are all in view of all robots, fewer are seen now and then."""
    kinds: str = ",".join(KINDS)
    """Which kinds of faults, with commas; each has the same episodes, whatever other kinds there are."""
    recording_of: int | None = None
    """The number of an episode to make a recording of, counted from 0."""
    workers: Annotated[int | None, tyro.conf.arg(aliases=["--jobs"])] = None
    """How many processes; one on each core if not given. The result does not depend on it."""
    seed: int = 0
    """Where all randomness comes from: the same seed, the same episodes."""
    out: Path = Path("runs/faults")
    """Folder for the summary, the figure, the list of episodes and the recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("faults", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        InvalidInput: An option or the output folder cannot be used.
    """
    cases = cases_of(options)
    folder = output_folder(options.out)
    with executor(options.workers) as pool:
        outcomes = gathered([pool.submit(outcome_of, case) for case in cases], "episodes")
    summary = summary_of(options.landmarks, options.seed, outcomes)
    write_summary(folder, summary)
    write_episodes(folder / "episodes.csv", outcomes)
    draw_faults(folder, outcomes)
    print_kinds(outcomes)
    print_table(f"faults, in {folder}", {key: value for key, value in summary.items() if not isinstance(value, list | dict)})
    Terminal().print(sentence(outcomes), highlight=False, soft_wrap=True)
    if options.recording_of is not None:
        record_episode(cases[options.recording_of], folder / f"episode_{options.recording_of}.rrd")
    return int(summary["outside_in_force"] != 0)


def cases_of(options: Options) -> list[Case]:
    """Return the episodes to follow.

    Raises:
        InvalidInput: An option is out of its range, or there is no such kind.
    """
    keep_within(options, episodes=(1, np.inf), landmarks=LANDMARKS, seed=(0, np.inf), recording_of=(0, options.episodes - 1))
    kinds = chosen(options.kinds)
    numbers = range(options.episodes)
    return [Case(options.seed, kinds[number % len(kinds)], number // len(kinds), options.landmarks) for number in numbers]


def chosen(words: str) -> list[Kind]:
    """Return the kinds of faults in words with commas, each once; raises `InvalidInput` if there is no such kind."""
    kinds = [checked_kind(word.strip()) for word in words.split(",")]
    if len(set(kinds)) < len(kinds):
        raise InvalidInput("each kind of fault once", repr(words))
    return kinds


def write_episodes(path: Path, outcomes: Sequence[Outcome]) -> None:
    """Write a line for every episode, in the order of their numbers."""
    names = [name for name in Outcome.__dataclass_fields__ if name != "fault"]
    lines = [",".join(["episode", "kind", "when", "until", "below", *names])]
    for number, outcome in enumerate(outcomes):
        fault = outcome.fault
        values = [number, fault.kind, fault.when, fault.until, fault.below, *(getattr(outcome, name) for name in names)]
        lines.append(",".join("" if value is None else str(value) for value in values))
    write_whole(path, "\n".join(lines) + "\n")


if __name__ == "__main__":
    sys.exit(main())
