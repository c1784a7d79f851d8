"""From the rows of many runs to files, a summary and a table."""

from __future__ import annotations

import csv
import io
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from rich.markup import escape
from rich.table import Table

from experiments.following.ellipses import DIMENSION, Row
from experiments.following.metrics import Value, rounded
from experiments.following.side_by_side import BASELINES
from experiments.show.terminal import show_table
from sim.errors import ERROR_KINDS

SETS, TUNED_NAME, CONSERVATIVE_NAME = "sets", "EKF, tuned", "EKF, bound = 3 deviations"


@dataclass(frozen=True)
class Line:
    """A line of the table.

    Attributes:
        quantity: What it shows, with its unit; a line with the same quantity as the one before belongs to it.
        better: Which way is better.
        whose: Whose value it is.
        key: Its key in the summary, after the kind of errors.
    """

    quantity: str
    better: str
    whose: str
    key: str


def _of_each(quantity: str, better: str, sets: str | None, kalman: str) -> tuple[Line, ...]:
    first = (Line(quantity, better, SETS, sets),) if sets else ()
    names = zip((TUNED_NAME, CONSERVATIVE_NAME), BASELINES, strict=True)
    return (*first, *(Line(quantity, better, name, f"{prefix}_{kalman}") for name, prefix in names))


LINES = (
    *_of_each("containment: outer polygon, 99.7 % ellipse", "1 is all", "set_containment", "containment_997"),
    *_of_each("containment: 95 % ellipse", "0.95", None, "containment_95"),
    *_of_each("headings contained: interval, 99.7 %", "1 is all", "set_heading_containment", "heading_containment_997"),
    *_of_each("area: outer polygon, 99.7 % ellipse [m2]", "smaller", "set_area_m2", "area_997_m2"),
    *_of_each("RMSE: centroid, mean [m]", "smaller", "set_rmse_m", "rmse_m"),
    *_of_each("NEES of positions", f"{DIMENSION}", None, "nees_mean"),
    *_of_each("point proved wrong, share of robot-steps", "0", None, "proved_wrong_share"),
    *_of_each("99.7 % ellipse proved wrong, share", "0", None, "ellipse_proved_wrong_share"),
    *_of_each("relative positions contained", "1 is all", "set_relative_containment", "relative_containment_997"),
    *_of_each("relative area [m2]", "smaller", "set_relative_area_m2", "relative_area_997_m2"),
    *_of_each("relative RMSE [m]", "smaller", "set_relative_rmse_m", "relative_rmse_m"),
    Line("step time [ms]", "smaller", SETS, "set_step_ms"),
    Line("step time [ms]", "smaller", TUNED_NAME, "ekf_step_ms"),
)


def summary_of(rows: Sequence[Row], timings: Sequence[Row]) -> dict[str, Value]:
    """Return the flat summary of a sweep: every column of the rows and the timings for every kind of errors.

    Containment of the sets is the quotient of two counts, exactly 1 only if every single check held.
    """
    summary: dict[str, Value] = {}
    for kind in ERROR_KINDS:
        mine = [{**row, **timing} for row, timing in zip(rows, timings, strict=True) if row["errors"] == kind]
        for key in [key for key in (mine[0] if mine else {}) if key not in ("errors", "seed")]:
            summary[f"{kind}_{key}"] = _over_runs(key, [row[key] for row in mine])
        checks = summary.get(f"{kind}_checks")
        for name, counted in (("set_containment", "set_contained"), ("set_heading_containment", "set_headings_contained")):
            if checks:
                summary[f"{kind}_{name}"] = float(str(summary[f"{kind}_{counted}"])) / float(str(checks))
    return summary


def _over_runs(key: str, values: Iterable[Value]) -> Value:
    known = [float(str(value)) for value in values if value is not None]
    if not known:
        return None
    if key == "checks" or key.endswith("contained") or key.endswith("inconsistent"):
        return int(sum(known))
    if key.endswith("rmse_m"):
        return rounded(float(np.sqrt(np.mean(np.square(known)))))
    return rounded(float(np.median(known) if key.endswith("_ms") else np.mean(known)))


def kept_every_truth(rows: Sequence[Row]) -> bool:
    """Return whether every position and every heading of every run was inside its set."""
    return bool(rows) and all(
        row["set_contained"] == row["set_headings_contained"] == row["checks"]
        and row["set_relative_containment"] == 1
        and not row["set_inconsistent"]
        for row in rows
    )


def write_csv(path: Path, rows: Sequence[Row]) -> None:
    """Write rows of the same columns, sorted by kind of errors and seed; floats come back exactly."""
    text = io.StringIO()
    ordered = sorted(rows, key=lambda row: (str(row["errors"]), int(str(row["seed"]))))
    writer = csv.DictWriter(text, list(ordered[0]) if ordered else [], lineterminator="\n")
    writer.writeheader()
    writer.writerows(ordered)
    path.write_text(text.getvalue(), encoding="utf-8")


def _cell(value: Value) -> str:
    if value is None:
        return "-"
    return (
        f"{value:.4g}" if isinstance(value, float) and value != 1 else f"{value:g}" if isinstance(value, float) else str(value)
    )


def _cells(summary: Mapping[str, Value]) -> list[list[str]]:
    cells, before = [], ""
    for line in LINES:
        head = ["", ""] if line.quantity == before else [line.quantity, line.better]
        cells.append([*head, line.whose, *(_cell(summary.get(f"{kind}_{line.key}")) for kind in ERROR_KINDS)])
        before = line.quantity
    return cells


def print_comparison(title: str, summary: Mapping[str, Value]) -> None:
    """Print the table to stdout."""
    table = Table("quantity", "better", "whose", *ERROR_KINDS, title=title, title_justify="left")
    for column in table.columns[3:]:
        column.justify = "right"
    for cells in _cells(summary):
        table.add_row(*map(escape, cells))
    show_table(table)


def write_markdown(path: Path, summary: Mapping[str, Value]) -> None:
    """Write the table as Markdown."""
    head = ["quantity", "better", "whose", *ERROR_KINDS]
    lines = [head, ["---"] * 3 + ["---:"] * len(ERROR_KINDS), *_cells(summary)]
    path.write_text("".join(f"| {' | '.join(cells)} |\n" for cells in lines), encoding="utf-8")
