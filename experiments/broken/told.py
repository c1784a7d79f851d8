"""What all episodes amount to: a summary, a table by kind, a sentence."""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from rich.table import Table

from experiments.broken.fault import KINDS
from experiments.broken.outcome import SOON, Outcome
from experiments.following.metrics import Value, rounded
from experiments.show.terminal import show_table

AREAS = ("area_before", "area_most", "area_end")  # of regions: before a fault, where they are largest after it, in the end

Counted = Callable[[Outcome], bool]
Told = Value | list[Value] | dict[str, Value]


def share(outcomes: Sequence[Outcome], counted: Counted) -> float | None:
    """Return which share of outcomes counts; None if there are none."""
    return rounded(sum(map(counted, outcomes)) / len(outcomes)) if outcomes else None


def by_kind(outcomes: Sequence[Outcome]) -> dict[str, list[Outcome]]:
    """Return the outcomes of each kind that there is, in the order of `KINDS`."""
    sorted_out = {kind: [outcome for outcome in outcomes if outcome.fault.kind == kind] for kind in KINDS}
    return {kind: some for kind, some in sorted_out.items() if some}


def is_right(outcome: Outcome) -> bool:
    """Return whether it is: in force with the truth inside, soon enough and at the end, the culprit of what lasts named."""
    return outcome.right


def is_proved(outcome: Outcome) -> bool:
    """Return whether the judge proves in some frame that a bound is broken."""
    return outcome.provable is not None


def of_size(outcomes: Sequence[Outcome], *, below: bool) -> list[Outcome]:
    """Return the outcomes of small faults, or of large ones."""
    return [outcome for outcome in outcomes if outcome.fault.below == below]


def summary_of(landmarks: int, seed: int, outcomes: Sequence[Outcome]) -> dict[str, Told]:
    """Return the figures; shares of faults beyond half a metre or 15 degrees, and with `below` in their names of others."""
    beyond, below = of_size(outcomes, below=False), of_size(outcomes, below=True)
    lasting = [outcome for outcome in beyond if outcome.fault.lasts]
    return {
        "episodes": len(outcomes),
        "episodes_below": len(below),
        "kinds": list[Value](by_kind(outcomes)),
        "landmarks": landmarks,
        "seed": seed,
        "outside_in_force": sum(outcome.outside_in_force for outcome in outcomes),
        "outside_before_provable": sum(outcome.outside_before for outcome in outcomes),
        "outside_in_force_episodes": sum(outcome.outside_in_force > 0 for outcome in outcomes),
        "right_share": share(beyond, is_right),
        "right_share_by_kind": _shares(beyond),
        "right_share_below": share(below, is_right),
        "right_share_below_by_kind": _shares(below),
        "share_proved": share(beyond, is_proved),
        "share_proved_below": share(below, is_proved),
        "frames_until_right_median": frames_until_right(beyond),
        "culprit_named_share": share(lasting, lambda outcome: outcome.named),
        "innocent_named_share": share(outcomes, lambda outcome: outcome.innocent),
        "suspended_frames_mean": rounded(float(np.mean([outcome.suspended for outcome in outcomes]))),
        "frames_without_cause": sum(outcome.without_cause for outcome in outcomes),
        "gave_up": sum(outcome.gave_up for outcome in outcomes),
        **{f"{name}_median_m2": area(outcomes, name) for name in AREAS},
    }


def frames_until_right(outcomes: Sequence[Outcome]) -> float | None:
    """Return the median number of good frames before the first right one, of those that were right soon enough."""
    frames = [outcome.first_right for outcome in outcomes if outcome.right and outcome.first_right is not None]
    return float(np.median(frames)) if frames else None


def area(outcomes: Sequence[Outcome], name: str) -> float | None:
    """Return the median of one of the `AREAS` of all outcomes that have one [m2]."""
    areas = [getattr(outcome, name) for outcome in outcomes if getattr(outcome, name) is not None]
    return rounded(float(np.median(areas))) if areas else None


def _shares(outcomes: Sequence[Outcome]) -> dict[str, Value]:
    return {kind: share(some, is_right) for kind, some in by_kind(outcomes).items()}


def print_kinds(outcomes: Sequence[Outcome]) -> None:
    """Print a line for each kind of fault, and one for all: of large ones first, then how many small ones are right."""
    found = ("fault", "large", "proved", "right", "frames", "named", "suspended", "outside in force", "before", "small right")
    title = f"what broke, and whether the filter was right {SOON} good frames later"
    table = Table(*found, "m2 before", "most", "end", title=title, title_justify="left")
    for kind, some in {**by_kind(outcomes), "all": list(outcomes)}.items():
        table.add_row(kind, *_row(some))
    for column in table.columns[1:]:
        column.justify = "right"
    show_table(table)


def _row(outcomes: Sequence[Outcome]) -> list[str]:
    beyond, below = of_size(outcomes, below=False), of_size(outcomes, below=True)
    lasting, median = [outcome for outcome in beyond if outcome.fault.lasts], frames_until_right(beyond)
    return [
        str(len(beyond)),
        _percent(share(beyond, is_proved)),
        _percent(share(beyond, is_right)),
        "-" if median is None else f"{median:g}",
        _percent(share(lasting, lambda outcome: outcome.named)),
        _percent(share(beyond, lambda outcome: outcome.suspended > 0)),
        str(sum(outcome.outside_in_force for outcome in outcomes)),
        str(sum(outcome.outside_before for outcome in outcomes)),
        f"{sum(map(is_right, below))} of {len(below)}" if below else "-",
        *("-" if value is None else f"{value:.2g}" for value in (area(beyond, name) for name in AREAS)),
    ]


def _percent(part: float | None) -> str:
    return "-" if part is None else f"{100 * part:.0f} %"


def sentence(outcomes: Sequence[Outcome]) -> str:
    """Return what came out, in words."""
    beyond, wrong = of_size(outcomes, below=False), [outcome for outcome in outcomes if outcome.outside_in_force]
    frames, right = sum(outcome.outside_in_force for outcome in wrong), sum(map(is_right, beyond))
    kept = "No truth was outside while the guarantee was said to be in force and the fault could be proved"
    lost = (
        f"In {len(wrong)} of {len(outcomes)} episodes, {frames} frames, a truth was outside while the guarantee was said to be"
    )
    told = f"{lost} in force and the fault could be proved" if wrong else kept
    median = frames_until_right(beyond)
    soon = "" if median is None else f", in the median after {median:g} frames"
    share_right = f"After {right} of {len(beyond)} large faults the filter was right within {SOON} good frames and at the end"
    return f"{told}. {share_right}{soon}."
