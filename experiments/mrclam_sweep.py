"""Every fault of every robot in a run of the MRCLAM data set: who escapes, and whether the guilty sensor is named.

Run `python -m experiments.mrclam_sweep --help`. The exit code is the guarantee of the robots that have no part in a fault: 0
only if none of them was outside what the filter claimed while it said that its guarantee was in force. What is asked of the
filter besides, and what came out, is in docs/real-robots.md.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.table import Table

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value
from experiments.real_robots.bounds import Bounds
from experiments.real_robots.data import Run, read_tables, run_of
from experiments.real_robots.faults import BEGINS, faulty, next_to
from experiments.real_robots.followed import Followed, team_filter
from experiments.real_robots.frames import frames
from experiments.real_robots.motion import Motions
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import gathered, show_table
from experiments.sweep.executors import executor
from filter import Integers, InvalidInput, Mask

EXCHANGED = ("markers of {0} and {1}, exchanged", "place or marker of {0}", "place or marker of {1}")
# What is to be named of the robots that have a part in a fault: any of these.
NAMES = {
    "biased": ("camera of {0}", "sensor of {0}"),
    "biased_right": ("camera of {0}", "sensor of {0}"),
    "shifted_camera": ("camera clock of {0}", "sensor of {0}"),
    "swapped": EXCHANGED,
    "exchanged": EXCHANGED,
}


@dataclass(frozen=True)
class Options:
    """Follow a run of the MRCLAM data set once for every fault of every robot.

    Exit code 0 only if no robot that has no part in a fault was outside of what the filter claimed while it said that its
    guarantee was in force; 1 otherwise; 2 for bad input.
    """

    data: Path
    """Folder of a run, as MRCLAM_Dataset6."""
    faults: str = "none,silent,biased,biased_right,swapped,exchanged,duplicated,shifted,shifted_camera"
    """Which faults, with commas; none is the run as it is."""
    fault_robots: str = "1,2,3,4,5"
    """Whose, by their numbers in the files."""
    start: float = 0.0
    """When to start, since the first command or measurement [s]."""
    duration: float | None = None
    """How long at most [s]; to the end if not given."""
    workers: int | None = None
    """How many processes; one on each core if not given."""
    seed: int = 0
    """Where in its initial set each robot starts."""
    out: Path = Path("runs/mrclam_sweep")
    """Folder for the summary."""


@dataclass(frozen=True)
class Outcome:
    """What came of one fault. Robots are counted in every frame.

    Attributes:
        fault: Its name.
        robot: Whose, by its number in the files.
        others: How often one that has no part in it was outside, position or heading.
        others_in_force: How often while the guarantee for it was said to be in force.
        positions: How often the position of one that has a part in it was.
        headings: How often its heading was.
        named: What is guilty and was named, and how long after the fault had begun [s].
        missed: 1 if nothing was named that should have been, else 0.
        wrong: What is good and was named.
    """

    fault: str
    robot: int
    others: int
    others_in_force: int
    positions: int
    headings: int
    named: str
    missed: int
    wrong: str


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("mrclam_sweep", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option, a file of the data, or the output folder cannot be used.
    """
    keep_within(options, seed=(0, np.inf))
    every, folder = cases(options), output_folder(options.out)
    with executor(options.workers) as pool:
        outcomes = gathered([pool.submit(judged, options, *case) for case in every], "runs")
    write_summary(folder, summary_of(outcomes))
    show(outcomes)
    return int(any(outcome.others_in_force for outcome in outcomes))


def cases(options: Options) -> list[tuple[str, int]]:
    """Return the faults with their robots; there is one run without a fault if any.

    Raises:
        InvalidInput: A robot is no number, or there is no such fault or robot.
    """
    try:
        robots = [int(word) for word in options.fault_robots.split(",")]
    except ValueError:
        raise InvalidInput("robots as numbers with commas, 1,2,3", repr(options.fault_robots)) from None
    tables, found = read_tables(options.data), []
    for fault in options.faults.split(","):
        found += [(fault, robot) for robot in (robots if fault != "none" else robots[:1])]
        if fault != "none":
            faulty(tables, fault, robots[0])
    for robot in robots:
        faulty(tables, "duplicated", robot)
    return found


def judged(options: Options, fault: str, robot: int) -> Outcome:
    """Return what came of one fault."""
    tables = read_tables(options.data)
    team, data = sorted(tables.logs), run_of(tables if fault == "none" else faulty(tables, fault, robot))
    pair = (robot, next_to(robot, team)) if fault in {"swapped", "exchanged"} else (robot,)
    guilty = np.isin(team, pair if fault != "none" else ())
    names = [f"r{team.index(body)}" for body in sorted(pair)]
    wanted = [words.format(*names) for words in NAMES.get(fault, ())]
    out, times = np.zeros(4, dtype=np.int64), dict[str, float]()
    for step in followed(options, data, team):
        out += counts(step, guilty)
        for name in step.put_aside:
            times.setdefault(name, step.frame.time - max(BEGINS.get(fault, 0.0), options.start))
    named = [f"{name} {times[name]:.0f} s" for name in wanted if name in times]
    wrong = [f"{name} {times[name]:.0f} s" for name in times if name not in wanted]
    others, in_force, positions, headings = out.tolist()
    told = ", ".join(named), int(bool(wanted) and not named), ", ".join(wrong)
    return Outcome(fault, robot, others, in_force, positions, headings, *told)


def followed(options: Options, data: Run, team: Sequence[int]) -> Iterator[Followed]:
    """Follow a run with the robust filter, which has evidence on cameras."""
    bounds, generator = Bounds().chained(), np.random.default_rng(options.seed)
    scenario = frames(data, team, options.start, options.duration, bounds=bounds, generator=generator)
    return team_filter(scenario, Motions(data, team, bounds), which="robust")


def counts(step: Followed, guilty: Mask) -> Integers:
    """Return (4,) at one frame: others outside, and in force; positions and headings of the guilty, (n,), outside."""
    truth, belief = step.frame.truth, step.belief
    if truth is None:
        return np.zeros(4, dtype=np.int64)
    known = np.isfinite(truth.positions).all(axis=1) & np.isfinite(truth.headings)
    pairs = zip(belief.regions, truth.positions, strict=True)
    lost = known & ~np.array([bool(region.outer.contains(place)) for region, place in pairs])
    turned = known & ~belief.headings.contains(truth.headings)
    others = (lost | turned) & ~guilty
    return np.array([part.sum() for part in (others, others & ~step.suspended, lost & guilty, turned & guilty)])


def summary_of(outcomes: Sequence[Outcome]) -> dict[str, Value]:
    """Return the figures, flat."""
    found: dict[str, Value] = {
        "runs": len(outcomes),
        "others_outside": sum(outcome.others for outcome in outcomes),
        "others_outside_in_force": sum(outcome.others_in_force for outcome in outcomes),
        "guilty_positions_outside": sum(outcome.positions for outcome in outcomes),
        "guilty_headings_outside": sum(outcome.headings for outcome in outcomes),
        "sensors_missed": sum(outcome.missed for outcome in outcomes),
        "sensors_wrongly_named": sum(bool(outcome.wrong) for outcome in outcomes),
    }
    for outcome in outcomes:
        name = f"{outcome.fault}_{outcome.robot}"
        found |= {f"{name}_{key}": value for key, value in vars(outcome).items() if key not in {"fault", "robot"}}
    return found


def show(outcomes: Sequence[Outcome]) -> None:
    """Print the table: of frames with others outside, of them in force, with the guilty one's position or heading outside."""
    heads = ("fault", "robot", "others", "in force", "places", "headings", "named after", "missed", "wrong")
    table = Table(*heads, title="Frames with the truth outside, and who was named", title_justify="left", padding=0)
    for outcome in outcomes:
        table.add_row(*(str(value) for value in vars(outcome).values()))
    show_table(table)


if __name__ == "__main__":
    sys.exit(main())
