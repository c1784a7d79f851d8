"""The paper's static case: a formation that measures bearings alone, localized in the frame of any of its robots.

Figures 3, 12 and 13 of the paper and the text around them. Run `python -m experiments.static_localization --help`. The exit
code is the guarantee: 0 only if no robot and no relative position was outside its polygon, in any frame; 1 otherwise; 2 for
bad input and where the anchors do not bound the formation.
"""

from __future__ import annotations

import sys
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from time import perf_counter

import numpy as np
from rich.table import Table

from experiments.following.metrics import Value, rounded
from experiments.paper.formations import Formation, draw_formation
from experiments.paper.frames import Localized, Relative, farthest_reference, localize, relative_regions, uncertain_pairs
from experiments.paper.merge_orders import Spread, spread_over_orders
from experiments.paper.range_sector import overestimate
from experiments.paper.recording import record_searches
from experiments.paper.static_figures import EXAMPLES, draw_frames, draw_range_bearing, draw_relative
from experiments.show.command import command
from experiments.show.output import output_folder, write_summary
from experiments.show.terminal import print_table, show_table
from filter import Array, Budget, Stop

ORDERS = 6  # random orders in which the bearings are merged


@dataclass(frozen=True)
class Options:
    """Localize a random formation that measures bearings alone, in the frame of any of its robots.

    Exit code 0 only if no robot and no relative position was outside its polygon, in any frame; 1 otherwise; 2 for bad input
    and where the anchors do not bound the formation.
    """

    robots: int = 12
    """Number of robots."""
    bearing_bound: tuple[float, ...] = (5.0,)
    """Largest error of a bearing [degrees]; several are dealt out to the robots in turn, as of different sensors."""
    reference: tuple[int, ...] = (0,)
    """Robots that are anchored. With a single one, a coordinate of a robot that it sees fixes the scale. None: no frame."""
    scale: bool = True
    """Anchor that coordinate; without it bearings do not tell the size of the formation."""
    alternate: int | None = None
    """Another robot, whose frame is shown beside; the farthest one that can be a reference if not given."""
    relative: tuple[tuple[int, int], ...] = ()
    """Pairs i j whose relative positions x_i - x_j are searched; of the least certain robots if not given."""
    performance_ratio: float = 0.95
    """A search ends when inner over outer area reaches this,"""
    area_gap: float = 0.0
    """or when outer less inner area is down to this [m2],"""
    searches: int = 16
    """or after so many searches,"""
    seconds: float | None = None
    """or when the formation, or a pair, has taken so long [s], whichever comes first; results then depend on the machine."""
    solver: str = "piqp"
    """What solves the linear programs: piqp, highs-simplex, or any solver that qpsolvers finds here."""
    seed: int = 0
    """Where all randomness comes from: the same seed, the same formation."""
    out: Path = Path("runs/static_localization")
    """Folder for summary, figures and recording."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the experiment with command-line arguments; return the exit code."""
    return command("static_localization", Options, run, arguments, stopped="there is no summary")


def run(options: Options) -> int:
    """Run the experiment; return the exit code.

    Raises:
        InvalidInput: An option or the output folder cannot be used.
        Unbounded: The anchors do not bound the formation.
    """
    stop = Stop(options.performance_ratio, options.area_gap, options.searches)
    folder = output_folder(options.out)
    generator = np.random.default_rng(options.seed)
    formation = draw_formation(generator, options.robots, np.radians(options.bearing_bound))
    common, *others = frames = frames_of(options, formation, stop)
    pairs = options.relative or uncertain_pairs(common)
    relatives = relative_regions(common, pairs, stop, options.solver, budget_of(options))
    orders = spread_over_orders(common.formation.case(common.anchors), ORDERS, generator)
    draw_frames(folder, frames)
    draw_relative(folder, common, relatives)
    draw_range_bearing(folder)
    record(folder / "static_localization.rrd", common, others)
    summary = summary_of(options, common, others, relatives, orders)
    write_summary(folder, summary)
    print_regions(common, relatives)
    print_table(f"static_localization, in {folder}", summary)
    return int(summary["escapes"] != 0 or not orders.set_contains)


def frames_of(options: Options, formation: Formation, stop: Stop) -> list[Localized]:
    """Return the formation in the frame of the references and, if these are one robot, in that of another robot.

    Raises:
        InvalidInput: There is no such robot.
        Unbounded: The anchors do not bound the formation.
    """
    references = options.reference
    seen = formation.seen_from(references[0]) if references else formation
    frames = [localize(seen, seen.anchors(references, options.scale), stop, options.solver, budget_of(options))]
    other = options.alternate if options.alternate is not None else farthest_reference(seen, *references[:1])
    if other is not None and len(references) == 1:
        again = formation.seen_from(other)
        frames.append(localize(again, again.anchors([other]), stop, options.solver, budget_of(options)))
    return frames


def budget_of(options: Options) -> Budget | None:
    """Return how long a formation, or a pair, may take."""
    return None if options.seconds is None else Budget(options.seconds, perf_counter)


def record(path: Path, common: Localized, others: Sequence[Localized]) -> None:
    """Record the regions search by search, in every frame but with the robots where they are in the common one."""
    frames = {"common frame": common.anchors}
    for other in others:
        (reference,) = other.references
        frames[f"frame of robot {reference}"] = common.formation.anchors([reference])
    record_searches(path, common.formation, frames)


def summary_of(
    options: Options, common: Localized, others: Sequence[Localized], relatives: Sequence[Relative], orders: Spread
) -> dict[str, Value]:
    """Return the run's summary; means are over the robots of which no coordinate is anchored, in the common frame."""
    regions = [common.belief.regions[robot] for robot in common.free]
    reasons = Counter(region.reason for region in regions)
    positions, centroids = common.formation.positions[common.free], np.array([region.outer.centroid for region in regions])
    errors = np.hypot(*(centroids.reshape(-1, 2) - positions).T)
    summary: dict[str, Value] = {
        "robots": options.robots,
        "variables": common.variables,
        "bearings": len(common.formation.bearings.robot),
        "seed": options.seed,
        "solver": options.solver,
        "checks": len(common.formation) * (1 + len(others)) + len(relatives),
        "escapes": sum(len(each.escaped) for each in (common, *others)) + sum(each.escaped for each in relatives),
        "performance_ratio_mean": _mean([region.performance_ratio for region in regions]),
        "searches_mean": _mean([region.searches for region in regions]),
        "area_mean_m2": _mean([region.outer.area for region in regions]),
        "area_max_m2": rounded(max((region.outer.area for region in regions), default=0.0)),
        "centroid_error_mean_m": _mean(errors),
    }
    summary |= {f"stopped_by_{reason.replace(' ', '_')}": count for reason, count in sorted(reasons.items())}
    for other in others:
        areas = [other.belief.regions[robot].outer.area for robot in other.free]
        summary |= {"alternate_reference": other.references[0], "alternate_variables": other.variables}
        summary |= {"alternate_area_mean_m2": _mean(areas)}
    for each in relatives:
        summary[f"relative_{each.robot}_{each.other}_area_m2"] = rounded(each.region.outer.area)
    for range_error, degrees in EXAMPLES:
        share = float(overestimate(range_error, np.radians(degrees))) - 1
        summary[f"overestimate_{100 * range_error:g}_percent_{degrees:g}_deg"] = rounded(share)
    return summary | {
        "orders": ORDERS,
        "order_set_area_spread": float(f"{orders.set_area:.1g}"),
        "order_ekf_position_spread_m": rounded(orders.ekf_position),
        "order_ekf_position_spread_deviations": rounded(orders.ekf_deviation),
    }


def _mean(values: Sequence[float] | Array) -> float | None:
    return rounded(float(np.mean(values))) if len(values) else None


def print_regions(common: Localized, relatives: Sequence[Relative]) -> None:
    """Print every region: its area, how tight it is, and why its search ended."""
    table = Table("region of", "area [m2]", "inner / outer", "searches", "ended by", title="regions", title_justify="left")
    for column in table.columns[1:4]:
        column.justify = "right"
    for robot, region in enumerate(common.belief.regions):
        numbers = (f"{region.outer.area:.4g}", f"{region.performance_ratio:.3f}", str(region.searches))
        table.add_row(f"robot {robot}", *numbers, region.reason)
    for each in relatives:
        found = each.region
        numbers = (f"{found.outer.area:.4g}", f"{found.performance_ratio:.3f}", str(found.searches))
        table.add_row(f"robot {each.robot} from robot {each.other}", *numbers, found.reason)
    show_table(table)


if __name__ == "__main__":
    sys.exit(main())
