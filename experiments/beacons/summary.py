"""What the experiment says in numbers: of each kind of scene, and in ratios to the exact sets."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
from rich.table import Table

from experiments.beacons.climbing import AtMost
from experiments.beacons.outcomes import Outcome, Verdict, is_known, total
from experiments.following.metrics import Value, rounded
from experiments.show.terminal import show_table
from filter import Array

Found = Sequence[tuple[Outcome, Verdict | AtMost | None]]
# Each kind of scene, in words, and how many of its steps are left out of areas and headings.
KINDS = {
    "alone": ("one robot stands among 3 to 8 anchors", 0),
    "standing": ("four robots stand among 3 anchors", 0),
    "bearings": ("one robot stands, bearings to 4, no compass", 0),
    "moving": ("three robots drive among 3 anchors", 10),
    "moving_known": ("the same, headings known to 10 degrees at the start", 10),
    "moving_six": ("six robots drive among 2 anchors", 10),
}


def of_kind(found: Found, kind: str) -> list[Outcome]:
    """Return what came of all scenes of a kind."""
    return [outcome for outcome, _ in found if outcome.scene.kind == kind]


def verdicts_on(found: Found, kind: str) -> list[tuple[Outcome, Verdict]]:
    """Return what came of the scenes of a kind with the verdicts of judges that know enough."""
    judged = [(outcome, verdict) for outcome, verdict in found if isinstance(verdict, Verdict) and outcome.scene.kind == kind]
    return [(outcome, verdict) for outcome, verdict in judged if is_known(verdict)]


def summary_of(found: Found) -> dict[str, Value]:
    """Return flat values with units in their names."""
    verdicts = [verdict for _, verdict in found if isinstance(verdict, Verdict)]
    teams = np.array([verdict.ratios for _, verdict in found if isinstance(verdict, AtMost)]).ravel()
    known = [verdict for verdict in verdicts if is_known(verdict)]
    summary: dict[str, Value] = {
        **total([outcome for outcome, _ in found]),
        **_ratios("area_over_exact_standing", [verdict.ratio for _, verdict in verdicts_on(found, "alone")]),
        **_ratios("team_area_over_exact_at_most", teams[np.isfinite(teams)]),
        **_ratios("bearings_over_exact", [verdict.ratio for _, verdict in verdicts_on(found, "bearings")]),
        **{f"exact_price_of_one_lie_{lies}_median": _price(found, lies) for lies in ("any", "long")},
        "judge_error_max": max((rounded(verdict.error) for verdict in known), default=None),
        "not_judged": len(verdicts) - len(known) + int(np.isinf(teams).sum()),
        "standing_again_over_first": _again(of_kind(found, "standing")),
    }
    for kind in KINDS:
        summary |= _of_kind(kind, of_kind(found, kind))
    return summary


def _ratios(name: str, ratios: Sequence[float] | Array) -> dict[str, Value]:
    """Return the greatest ratio of areas under the name itself, and beside it the 95 % and the median."""
    return {
        name: _quantile(ratios, 1.0),
        f"{name}_p95": _quantile(ratios, 0.95),
        f"{name}_median": _quantile(ratios, 0.5),
    }


def _price(found: Found, lies: str) -> float | None:
    return _quantile([verdict.price(lies) for _, verdict in verdicts_on(found, "alone")], 0.5)


def _again(outcomes: Sequence[Outcome]) -> float | None:
    """Return what the same readings, merged once more, leave of the areas: 1 where one update has found all there is."""
    areas = np.array([outcome.areas for outcome in outcomes])
    return rounded(float(areas[:, -1].sum() / areas[:, 0].sum())) if len(areas) else None


def _of_kind(kind: str, outcomes: Sequence[Outcome]) -> dict[str, Value]:
    skipped = KINDS[kind][1]
    of_scene: dict[str, Value] = {
        f"{kind}_area_median_m2": _quantile(_all([each.areas[skipped:] for each in outcomes]), 0.5),
        f"{kind}_step_median_ms": _quantile(_all([1e3 * each.seconds for each in outcomes]), 0.5),
    }
    if kind not in ("alone", "standing"):  # ranges tell nothing of how a robot stands
        degrees = np.degrees(_all([each.arcs[skipped:] for each in outcomes]))
        of_scene[f"{kind}_heading_median_deg"] = _quantile(degrees, 0.5)
    return of_scene


def _all(arrays: Sequence[Array]) -> Array:
    return np.concatenate([array.ravel() for array in arrays]) if arrays else np.zeros(0)


def _quantile(values: Sequence[float] | Array, share: float) -> float | None:
    return rounded(float(np.quantile(values, share))) if len(values) else None


def print_scenes(summary: Mapping[str, Value]) -> None:
    """Print what the filter makes of each kind of scene."""
    names = ("scene", "area, m2", "heading, +- degrees", "step, ms")
    table = Table(*names, title="ranges alone: medians of what the filter leaves", title_justify="left")
    for kind, (words, _) in KINDS.items():
        values = [summary.get(f"{kind}_{what}") for what in ("area_median_m2", "heading_median_deg", "step_median_ms")]
        table.add_row(words, *("-" if value is None else f"{value:.4g}" for value in values))
    for column in table.columns[1:]:
        column.justify = "right"
    show_table(table)
