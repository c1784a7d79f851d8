"""How does a step grow with the team? The filter in windows, from ten robots to a thousand and beyond.

Run `python -m experiments.scaling --help`. The exit code is the guarantee: 0 only if no position and no heading of any team was
ever outside what the filter claimed; 1 for an escape or for measurements proved to disagree; 2 for bad input.
"""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.box import SIMPLE_HEAD
from rich.table import Table

from experiments.following.frozen import keep_within
from experiments.following.metrics import Value, rounded
from experiments.growth.figures import draw_scaling
from experiments.growth.recording import record_size
from experiments.growth.run import measure
from experiments.growth.size import LEFT_OUT, RATE, Case, Size
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import StepProgress, print_table, show_table, tell, too_short
from experiments.sweep.executors import cores
from experiments.sweep.own_process import in_own_process
from filter import PHASES, InvalidInput
from sim.episode import WorldKind
from sim.errors import ErrorKind

MUJOCO_UP_TO = 100  # robots
STEPS, STEPS_OF_LARGE = 100, 60  # measured by default; the second for teams beyond MuJoCo
ENOUGH = 50  # steps: with fewer, a busy second of the machine decides
GROWTH = (100, 1000)  # robots between which growth is told
LISTED = (  # what the summary has lists of, one entry for each size
    "robots",
    "world",
    "steps",
    "compile_seconds",
    "simulate_ms",
    "step_median_ms",
    "step_p95_ms",
    "rows",
    "window_robots_mean",
    "window_robots_max",
    "memory_mib",
    "area_m2",
    "area_ratio_to_team",
    "ekf_step_median_ms",
)


@dataclass(frozen=True)
class Options:
    """Measure the filter's step in windows for teams of several sizes, each in a process of its own.

    Up to 100 robots drive in MuJoCo, more in the kinematic world, and 100 in both. Exit code 0 only if no position and no
    heading of any team was ever outside what the filter claimed; 1 for an escape or for measurements proved to disagree; 2 for
    bad input.
    """

    robots: str = "10,30,100,300,1000"
    """Sizes of the teams, with commas between."""
    steps: int | None = None
    """Measured steps of each size; 100 up to 100 robots and 60 beyond if not given. The ten before them are left out."""
    errors: ErrorKind = "uniform"
    """Kind of the sensors' errors, always within their bounds."""
    seed: int = 0
    """Where all randomness comes from: the same seed, the same runs."""
    alone: bool = False
    """Leave out the comparisons: with the whole team's linear program (up to 100 robots), with the Kalman filter (to 1000)."""
    recording: bool = False
    """Record the largest team, with its layers to be switched on and off; it is followed once more for that."""
    out: Path = Path("runs/scaling")
    """Folder for the summary, the figure and the recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("scaling", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option or the output folder cannot be used, or a process is lost.
    """
    cases = cases_of(options)
    folder = output_folder(options.out)
    sizes = measure_all(cases)
    summary = summary_of(options, sizes)
    asked = sizes[: len(sizes_of(options))]
    listed: dict[str, Value | list[Value]] = {key: [getattr(size, key) for size in asked] for key in LISTED}
    listed |= {f"{name}_median_ms": [size.phases_median_ms[name] for size in asked] for name in PHASES}
    summary["too_short"] = too_short("ratios of times", steps=(min(size.steps for size in sizes), ENOUGH))
    write_summary(folder, {**summary, **listed})
    draw_scaling(folder, asked)
    print_sizes(sizes)
    print_table(f"scaling, in {folder}", summary)
    for size in sizes:
        if size.conflict:
            tell(f"{size.robots} robots: the filter stopped: {size.conflict}")
    if options.recording:
        record_size(cases[len(asked) - 1], folder / "scaling.rrd")
    return int(any(size.escapes or size.conflict for size in sizes))


def sizes_of(options: Options) -> list[int]:
    """Return the sizes that are asked for, the smallest first.

    Raises:
        InvalidInput: They are not whole numbers from 1 on, or one comes twice.
    """
    try:
        sizes = sorted(int(size) for size in options.robots.split(","))
    except ValueError:
        raise InvalidInput("sizes of teams: whole numbers with commas between", repr(options.robots)) from None
    if sizes[0] < 1 or len(set(sizes)) < len(sizes):
        raise InvalidInput("sizes of teams from 1 on, each once", repr(options.robots))
    return sizes


def cases_of(options: Options) -> list[Case]:
    """Return what is to be measured: every size, and the largest of MuJoCo in the kinematic world, too, to compare them.

    Raises:
        InvalidInput: An option cannot be used.
    """
    keep_within(options, steps=(1, np.inf), seed=(0, np.inf))
    sizes = sizes_of(options)
    cases = [_case(options, robots, robots > MUJOCO_UP_TO) for robots in sizes]
    return cases + [_case(options, robots, True, baselines=False) for robots in sizes if robots == MUJOCO_UP_TO]


def _case(options: Options, robots: int, light: bool, baselines: bool = True) -> Case:
    measured = options.steps or (STEPS_OF_LARGE if robots > MUJOCO_UP_TO else STEPS)
    world: WorldKind = "kinematic" if light else "mujoco"
    return Case(robots, world, options.errors, options.seed, measured, baselines and not options.alone)


def measure_all(cases: Sequence[Case]) -> list[Size]:
    """Return what the sizes came to, one after the other, each in a process of its own, with a progress bar."""
    sizes = []
    with StepProgress(sum(case.frames for case in cases)) as progress:
        for case in cases:
            for count, told in enumerate(in_own_process(measure, case)):
                if isinstance(told, Size):
                    sizes.append(told)
                else:
                    progress.advance(count / RATE, told)
    return sizes


def summary_of(options: Options, sizes: Sequence[Size]) -> dict[str, Value]:
    """Return what all sizes come to together."""
    asked, again = sizes[: len(sizes_of(options))], sizes[len(sizes_of(options)) :]
    step = {size.robots: size.step_median_ms for size in asked}
    light = step | {size.robots: size.step_median_ms for size in again}
    return {
        "seed": options.seed,
        "errors": options.errors,
        "cores": cores(),  # as many threads has the filter; the Kalman filter's linear algebra has one
        "steps_left_out": LEFT_OUT,
        "escapes": sum(size.escapes for size in sizes),
        "conflicts": sum(size.conflict is not None for size in sizes),
        "kernel_fallback_share": sum(size.fallbacks for size in sizes) / max(1, sum(size.projections for size in sizes)),
        "growth_exponent": growth_exponent(step),
        "growth_exponent_kinematic": growth_exponent(light),
        **{f"kinematic_{size.robots}_step_median_ms": size.step_median_ms for size in again},
        **{f"kinematic_{size.robots}_rows": size.rows for size in again},
    }


def growth_exponent(step: Mapping[int, float | None]) -> float | None:
    """Return with which power of the team's size the time of a step grows, from 100 to 1000 robots; None without these two."""
    few, many = (step.get(robots) for robots in GROWTH)
    return rounded(float(np.log(many / few) / np.log(GROWTH[1] / GROWTH[0]))) if few and many else None


def _of_phase(name: str) -> Callable[[Size], str]:
    return lambda size: _words(size.phases_median_ms[name])


COLUMNS: dict[str, Callable[[Size], str]] = {
    "robots": lambda size: f"{size.robots}",
    "world": lambda size: size.world,
    "step [ms]": lambda size: _words(size.step_median_ms),
    "95 %": lambda size: _words(size.step_p95_ms),
    "EKF": lambda size: _words(size.ekf_step_median_ms),
    "rows": lambda size: _words(size.rows),
    "window": lambda size: _words(size.window_robots_mean),
    "MiB": lambda size: _words(size.memory_mib),
    "to team's": lambda size: _words(size.area_ratio_to_team, 4),
}


PHASE_COLUMNS: dict[str, Callable[[Size], str]] = {
    "robots": COLUMNS["robots"],
    "world": COLUMNS["world"],
    **{name: _of_phase(name) for name in PHASES},
}


def print_sizes(sizes: Sequence[Size]) -> None:
    """Print two lines for each size: the whole, and the phases."""
    _print(f"a step by the size of the team, {LEFT_OUT} steps left out", COLUMNS, sizes)
    _print("its phases [ms]", PHASE_COLUMNS, sizes)


def _print(title: str, columns: Mapping[str, Callable[[Size], str]], sizes: Sequence[Size]) -> None:
    table = Table(*columns, box=SIMPLE_HEAD, title=title, title_justify="left")
    for column in table.columns:
        column.justify = "right"
    for size in sizes:
        table.add_row(*(words(size) for words in columns.values()))
    show_table(table)


def _words(value: float | None, digits: int = 3) -> str:
    return "-" if value is None else f"{value:.{digits}g}" if value < 1000 else f"{value:.0f}"


if __name__ == "__main__":
    sys.exit(main())
