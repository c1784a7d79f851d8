"""How much do ranges alone tell? Robots that stand or drive among anchors, held against the exact sets of all that is possible.

Run `python -m experiments.range_only --help`. The exit code is the guarantee: 0 only if no position and no heading was ever
outside what the filter claimed; 1 for one that was; 4 if the guarantee was suspended; 2 for bad input. What is drawn, how the
judges work and what came out is in docs/performance.md.

The key `area_over_exact_standing` of the summary is the strictest there is: of all robots that stand alone among anchors, the
greatest ratio of the filter's area to the area of the exact convex hull, and the hull's at the least that its error allows.
Beside it are the 95 % and the median. `bearings_over_exact` is the same of bearings without a compass. Of a team nobody knows
the exact set: `team_area_over_exact_at_most` is the ratio to a hull that is inside it. `tolerance_over_exact_any` and `_long`
are the greatest ratios of what the filter leaves if one range may lie, or be too long, to the hull of all that can be then.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from experiments.beacons.climbing import at_most
from experiments.beacons.figures import draw_figure
from experiments.beacons.outcomes import Outcome, Verdict, followed, judged
from experiments.beacons.prices import Price, prices_of, print_prices, summary_of_prices
from experiments.beacons.recording import record
from experiments.beacons.scenes import DRIVES, Scene, alone, bearings_alone, team_that_stands
from experiments.beacons.summary import KINDS, Found, of_kind, print_scenes, summary_of
from experiments.following.frozen import keep_within
from experiments.following.metrics import Value
from experiments.following.steps import warmed_up
from experiments.show.command import SUSPENDED, command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import Counting, print_table, tell, too_short
from filter import Inconsistent, SetMembershipFilter

ANCHORS = (3, 4, 5, 6, 8)  # around a robot that stands alone
JUDGES = {"alone": judged, "bearings": judged, "standing": at_most}
ENOUGH_DRAWS, ENOUGH_STEPS = 20, 30


@dataclass(frozen=True)
class Options:
    """Localize robots by ranges alone: standing alone or as a team, driving with and without a known heading.

    Exit code 0 only if no position and no heading was ever outside what the filter claimed; 1 for one that was; 4 if the
    guarantee was suspended; 2 for bad input.
    """

    draws: int = 20
    """Robots that stand alone, for each number of anchors; as many teams that stand, and robots with bearings alone."""
    runs: int = 3
    """Teams that drive, of each kind."""
    steps: int = 60
    """Steps of a team that drives, of 0.2 s; the first ten are left out of areas and headings."""
    range_bound: float = 0.1
    """Largest error of a range [m]."""
    seed: int = 0
    """Where all randomness comes from: the same seed, the same scenes."""
    out: Path = Path("runs/range_only")
    """Folder for summary, figure and recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("range_only", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        CorralError: An option or the output folder cannot be used.
    """
    keep_within(options, draws=(1, np.inf), runs=(1, np.inf), steps=(11, np.inf), range_bound=(1e-3, 1.0))
    folder = output_folder(options.out)
    warmed_up()
    try:
        found, prices = compute(options)
    except Inconsistent as error:
        tell(f"records exclude one another: {error}")
        return 1
    few = too_short("ratios and areas", draws=(options.draws, ENOUGH_DRAWS), steps=(options.steps, ENOUGH_STEPS))
    summary = {**said(options), **summary_of(found), **summary_of_prices(prices), "too_short": few}
    write_summary(folder, summary)
    draw_figure(folder, found, prices)
    scene = of_kind(found, "moving")[0].scene
    record(folder / "range_only.rrd", SetMembershipFilter(scene.team), scene)
    print_scenes(summary)
    if prices:
        print_prices(summary, KINDS)
    print_table(f"range_only, in {folder}", summary)
    return exit_code([*(outcome for outcome, _ in found), *(price.tolerant for price in prices)])


def exit_code(outcomes: Sequence[Outcome]) -> int:
    """Return 1 for a truth that was outside while the guarantee was in force, else whether that was suspended, else 0."""
    if any(outcome.checks.broken for outcome in outcomes):
        return 1
    return SUSPENDED if any(outcome.checks.suspended for outcome in outcomes) else 0


def said(options: Options) -> dict[str, Value]:
    """Return the options, by their names in the summary."""
    return {
        "draws": options.draws,
        "runs": options.runs,
        "steps": options.steps,
        "range_bound_m": options.range_bound,
        "seed": options.seed,
    }


def compute(options: Options) -> tuple[Found, list[Price]]:
    """Return what the filter makes of every scene, the verdict where there is a judge, and what it costs to tolerate a lie.

    Raises what the filter raises.
    """
    scenes = list(scenes_of(options))
    found, prices, drawn = list[Any](), list[Price](), Counter[str]()
    with Counting(len(scenes), "scenes") as progress:
        for scene in scenes:
            outcome = followed(SetMembershipFilter(scene.team), scene)
            verdict = JUDGES.get(scene.kind, no_judge)(outcome)
            found.append((outcome, verdict))
            prices += prices_of(outcome, verdict if isinstance(verdict, Verdict) else None, drawn[scene.kind])
            drawn[scene.kind] += 1
            progress.advance()
    return found, prices


def no_judge(_: Outcome) -> None:
    """Say nothing of a scene of which nobody knows what is possible."""


def scenes_of(options: Options) -> Iterator[Scene]:
    """Yield all scenes; each is drawn by a generator of its own, so that more of one kind change none of another."""
    seeds, bound = [options.seed], options.range_bound
    for draw in range(options.draws):
        for anchors in ANCHORS:
            yield alone(np.random.default_rng([*seeds, draw, anchors]), anchors, bound)
        yield team_that_stands(np.random.default_rng([*seeds, draw, 1]), bound)
        yield bearings_alone(np.random.default_rng([*seeds, draw, 2]))
    for draw in range(options.runs):
        yield from (drive.drawn([*seeds, draw], options.steps, bound) for drive in DRIVES)


if __name__ == "__main__":
    sys.exit(main())
