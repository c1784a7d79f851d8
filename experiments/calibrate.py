"""Which bounds would a run with known truth have kept? Errors of every sensor and robot, and bounds to declare.

Run `python -m experiments.calibrate --help`. Exit code 0 if the run could be judged, 2 for bad input. What comes out fits this
run: declare what several runs have in common, with a margin.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from pathlib import Path

import matplotlib as mpl
import numpy as np
from matplotlib.figure import Figure
from rich.table import Table

from experiments.against_ekf.figures import LOOK
from experiments.following.frozen import keep_within
from experiments.following.metrics import Value
from experiments.following.scenarios import from_log
from experiments.mrclam import numbers_of
from experiments.real_robots.bounds import Bounds
from experiments.real_robots.carried import CarriedBounds
from experiments.real_robots.carried_bounds import proposed_carried
from experiments.real_robots.data import Run, read_run
from experiments.real_robots.error_bounds import proposed, said, statistics
from experiments.real_robots.errors import Errors, command_lag, measurement_delay, motion_errors, sensor_errors, speed_scale
from experiments.real_robots.frames import frames
from experiments.show.colours import colour_of
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Counting, Terminal, print_table, show_table
from filter import InvalidInput, Team

ANGLES = ("bearing", "compass", "turn")


@dataclass(frozen=True)
class Options:
    """Judge the sensors of a run whose truth is known, and propose bounds.

    Exit code 0 if the run could be judged, 2 for bad input. What comes out fits this run: declare what several runs have in
    common, with a margin.
    """

    data: Path | None = None
    """Folder of a run of the MRCLAM data set, with truth."""
    log: Path | None = None
    """Or a log.jsonl with truth, see docs/log.md: its declared bounds are judged, none are proposed."""
    robots: str = "1,2,3,4,5"
    """Which robots of the data set, by their numbers in the files."""
    share: float = 0.001
    """The share of a run's errors that may break a proposed bound."""
    margin: float = 1.25
    """Proposed bounds of motion are so many times what the share says."""
    seed: int = 0
    """Nothing here is random."""
    out: Path = Path("runs/calibrate")
    """Folder for summary.json, bounds.txt and the figures."""


@dataclass(frozen=True, eq=False)
class Judged:
    """What was found out.

    Attributes:
        team: The robots and landmarks.
        found: Errors, kind by kind.
        clocks: Delays, lags and scales, by name.
        proposed: Bounds of single records, and those that the filter for real robots takes; none where too little is known.
    """

    team: Team
    found: list[Errors]
    clocks: dict[str, Value]
    proposed: tuple[Bounds, CarriedBounds] | tuple[()]


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("calibrate", Options, run, arguments, stopped="nothing was written")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option, a file, or the output folder cannot be used, or there is no truth.
    """
    keep_within(options, share=(0, 0.5), margin=(1, np.inf))
    judged = _judged(options)
    if not any(len(errors.error) for errors in judged.found):
        raise InvalidInput("a run whose truth is known", "no measurement with truth")
    folder = output_folder(options.out)
    rows = [row for errors in judged.found for row in statistics(errors, judged.team)]
    _print_rows(rows)
    flat = {f"{row['sensor']} {row['robot']} {name}".replace(" ", "_"): row[name] for row in rows for name in list(row)[2:]}
    write_summary(folder, {"source": str(options.data or options.log), **judged.clocks, **flat})
    _draw(judged, folder / "errors.png")
    print_table(f"calibrate, in {folder}", judged.clocks)
    if judged.proposed:
        text = "\n".join(said(bounds) for bounds in judged.proposed)
        (folder / "bounds.txt").write_text(text + "\n", encoding="utf-8")
        Terminal().print(text, highlight=False, soft_wrap=True)
    return 0


def _judged(options: Options) -> Judged:
    if (options.data is None) == (options.log is None):
        raise InvalidInput("either --data or --log", "both" if options.data else "neither")
    if options.data is not None:
        return _of_data(read_run(options.data), numbers_of(options.robots), options)
    scenario = from_log(Path(str(options.log)))
    return Judged(scenario.team, sensor_errors(scenario.frames, scenario.team), {}, ())


def _of_data(data: Run, robots: Sequence[int], options: Options) -> Judged:
    scenario = frames(data, robots)
    with Counting(len(robots) + 2, "parts") as progress:
        found = [errors for errors in sensor_errors(scenario.frames, scenario.team) if errors.kind != "turn"]
        progress.advance()
        found += motion_errors(data, robots, Bounds())
        progress.advance()
        clocks: dict[str, Value] = {}
        for robot in robots:
            name = scenario.team.name(robots.index(robot))
            clocks[f"{name}_measurement_delay_s"] = measurement_delay(data, robot)
            clocks[f"{name}_command_lag_s"] = command_lag(data, robot)
            clocks[f"{name}_speed_scale"] = speed_scale(data, robot)
            progress.advance()
    enough = {errors.kind for errors in found if len(errors.error)} >= {"range", "bearing", "turn over 10 s"}
    if not enough:
        return Judged(scenario.team, found, clocks, ())
    known, share, margin = _with_clocks(clocks), options.share, options.margin
    carried = proposed_carried(data, robots, found, known, share=share, margin=margin)
    return Judged(scenario.team, found, clocks, (proposed(found, known, share, margin), carried))


def _with_clocks(clocks: dict[str, Value]) -> Bounds:
    """Return the default bounds with the robots' median delay, lag and scale."""

    def median(name: str, otherwise: float) -> float:
        values = [float(value) for key, value in clocks.items() if key.endswith(name) and isinstance(value, float)]
        return round(max(float(np.median(values)), 0.0), 3) if values else otherwise

    known = Bounds()
    fields = asdict(known) | {
        "measurement_delay": median("measurement_delay_s", known.measurement_delay),
        "command_lag": median("command_lag_s", known.command_lag),
        "speed_scale": median("speed_scale", known.speed_scale),
    }
    return Bounds(**fields)


def _print_rows(rows: Sequence[dict[str, Value]]) -> None:
    """Print the statistics, angles in degrees."""
    table = Table(*rows[0], title="Errors: said less true; angles in degrees", title_justify="left")
    for row in rows:
        angle = str(row["sensor"]).startswith(ANGLES)
        table.add_row(*(_shown(name, value, angle) for name, value in row.items()))
    show_table(table)


def _shown(name: str, value: Value, angle: bool) -> str:
    if not isinstance(value, float):
        return "-" if value is None else str(value)
    in_degrees = angle and name in ("median", "q90", "q99", "q99.9", "largest", "bias")
    return f"{np.degrees(value) if in_degrees else value:.3g}"


def _draw(judged: Judged, path: Path) -> None:
    """Draw how often an error is larger than so much, a panel a kind, a line a robot."""
    kinds = [errors for errors in judged.found if len(errors.error)]
    with mpl.rc_context(LOOK):
        figure = Figure(figsize=(11.0, 3.0 * -(-len(kinds) // 3)), layout="constrained")
        panels = figure.subplots(-(-len(kinds) // 3), 3, squeeze=False).ravel()
        for axes, errors in zip(panels, kinds, strict=False):
            angle = errors.kind.startswith(ANGLES)
            for robot in np.unique(errors.robot).tolist():
                size = np.sort(np.abs(errors.error[errors.robot == robot])) * (180 / np.pi if angle else 1)
                beyond = 1 - np.arange(len(size)) / len(size)
                colour = "#{:02x}{:02x}{:02x}".format(*colour_of(robot))
                axes.plot(size, beyond, color=colour, linewidth=1.2, label=judged.team.name(robot))
            axes.set(title=f"{errors.kind} [{'°' if angle else 'm'}]", yscale="log", xlim=(0, None))
        for axes in panels[len(kinds) :]:
            axes.set_visible(False)
        handles, labels = panels[0].get_legend_handles_labels()
        figure.legend(handles, labels, loc="outside lower center", ncols=len(labels), title="Share of errors that are larger")
        figure.savefig(path)


if __name__ == "__main__":
    sys.exit(main())
