"""Do the ranges of a real team that stands keep the bounds of their first seconds, and what happens if one of them lies?

Run `python -m experiments.standing_team LOG --anchors NAMES --help`. The exit code is the guarantee: 0 only if it was in force
all the time and no truth was outside; 1 for one that was outside while it was in force; 4 if it was suspended; 2 for bad input.
docs/real-robots.md has a real team's figures.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Annotated

import numpy as np
import tyro

from experiments.beacons.heard import Bounds, Heard, Lie, bounds_of, heard, lied, scene_of
from experiments.beacons.outcomes import Outcome, followed
from experiments.beacons.recording import record
from experiments.beacons.standing_figure import draw_standing
from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, guarantee_summary, rounded
from experiments.following.scenarios import from_log
from experiments.following.steps import warmed_up
from experiments.following.tolerating import Tolerating
from experiments.keeping.running import exit_code
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import print_table, tell
from filter import Array, Doubted, Inconsistent, Judged, SetMembershipFilter, Team


@dataclass(frozen=True)
class Options:
    """Localize robots that stand by the ranges of a log, with bounds that its first seconds tell; let one lie if you like.

    Exit code 0 only if the guarantee was in force all the time and no truth was outside; 1 for one that was outside while it
    was in force; 4 if the guarantee was suspended; 2 for bad input.
    """

    log: Annotated[tyro.conf.Positional[Path], tyro.conf.arg(metavar="LOG")]
    """What the robots measured and where they truly are: a log.jsonl, see docs/log.md."""
    anchors: tuple[str, ...]
    """Names of the robots whose places are taken as known; the others can be anywhere."""
    learned: float = 10.0
    """How many of the first seconds tell the bounds, by the truth; the filter sees what comes after them [s]."""
    margin: float = 0.1
    """How much wider the bounds are on either side, as a share of their width."""
    bounds: Bounds = "common"
    """common: the same for all; pair: each robot that measures another one has its own."""
    lie: Lie = "none"
    """none; longer: the first robot's range to the first anchor is 1.5 m longer for five seconds; moved: the first anchor is
    moved by 1 m."""
    lie_after: float = 10.0
    """How long after the first seconds the lie begins [s]."""
    every: float = 0.5
    """Time between two steps [s]."""
    tolerating: tyro.conf.OmitArgPrefixes[Tolerating] = field(default_factory=Tolerating)
    """What may be wrong, all the time."""
    out: Path = Path("runs/standing_team")
    """Folder for summary, figure and recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("standing_team", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option, the log or the output folder cannot be used.
    """
    keep_within(options, learned=(0.1, np.inf), margin=(0, 10), lie_after=(0, np.inf), every=(0.01, np.inf))
    said = heard(from_log(options.log))
    anchors = [said.number(name) for name in options.anchors]
    limits = bounds_of(said, options.learned, options.margin, options.bounds)
    liar, begins = liar_of(said, anchors), options.learned + options.lie_after
    scene = scene_of(lied(said, options.lie, liar, begins), anchors, limits, options.learned, options.every)
    folder = output_folder(options.out)
    warmed_up()
    try:
        outcome = followed(filter_of(options, scene.team), scene)
    except Inconsistent as error:
        tell(f"the filter stopped: {scene.team.words(error)}")
        return 1
    who = said.names[liar[0]], said.names[liar[1]]
    summary = {**summary_of(options, outcome, broken(said, limits, options.learned)), **verdicts(options.lie, who, outcome)}
    write_summary(folder, summary)
    draw_standing(folder, outcome, None if options.lie == "none" else begins)
    record(folder / "standing_team.rrd", filter_of(options, scene.team), scene)
    print_table(f"standing_team, in {folder}", summary)
    return exit_code(outcome.checks, conflict=False)


def liar_of(said: Heard, anchors: Sequence[int]) -> tuple[int, int]:
    """Return who lies, or of whom: the first robot that is no anchor, and the first anchor."""
    others = [robot for robot in range(len(said.names)) if robot not in anchors]
    return (others or anchors)[0], (anchors or others)[0]


def filter_of(options: Options, team: Team) -> SetMembershipFilter:
    """Return the filter that the options ask for."""
    return SetMembershipFilter(team, policy="reject", tolerance=options.tolerating.tolerance())


def broken(said: Heard, limits: Array, learned: float) -> tuple[int, int]:
    """Return how many of the ranges after the first seconds are outside their bounds, and how many there are."""
    later = said.time > learned
    outside = (said.error < limits[:, 0]) | (said.error > limits[:, 1])
    return int((outside & later).sum()), int(later.sum())


def summary_of(options: Options, outcome: Outcome, outside: tuple[int, int]) -> dict[str, Value]:
    """Return the run's summary."""
    return {
        "bounds": options.bounds,
        "lie": options.lie,
        "ranges": outside[1],
        "ranges_outside_bounds": outside[0],
        **outcome.checks.counts(),
        **guarantee_summary(outcome.checks.suspended, outcome.scene.team.words),
        "first_area_median_m2": rounded(float(np.median(outcome.areas[0]))),
        "last_area_median_m2": rounded(float(np.median(outcome.areas[-1]))),
        "last_area_max_m2": rounded(float(outcome.areas[-1].max())),
        "step_median_ms": rounded(1e3 * float(np.median(outcome.seconds))),
    }


def verdicts(lie: Lie, who: tuple[str, str], outcome: Outcome) -> dict[str, Value]:
    """Return when something was in doubt first, who was found guilty, and how many of these have to do with who lied.

    Args:
        lie: What lied.
        who: The names of who measured and of whom, or of whom alone if that one was moved.
        outcome: What the filter made of it.
    """
    team, events = outcome.scene.team, [event for _, event in outcome.events]
    doubts = [event.time for event in events if isinstance(event, Doubted)]
    guilty = [event.suspect for event in events if isinstance(event, Judged) and event.verdict == "guilty"]
    liars = set(map(team.number_of, who[1:] if lie == "moved" else who))
    right = [each for each in guilty if liars & {each.robot, each.target}]
    return {
        "doubts": len(doubts),
        "first_doubt_s": rounded(doubts[0]) if doubts else None,
        "guilty": "; ".join(map(team.words, guilty)) or None,
        "guilty_of_the_lie": len(right) if lie != "none" else None,
    }


if __name__ == "__main__":
    sys.exit(main())
