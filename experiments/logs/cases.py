"""What was found case by case, as a certificate: how a robot's poses were split, and what none of the pieces reaches beyond."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

from experiments.logs.exactly import hexadecimal, row_record, source_record
from filter import ByCases, Source
from filter.poses.branch import FEW_EDGES
from filter.poses.cells import START_EDGES, few_rows
from filter.poses.slices import Slices
from filter.sensing.readings import Readings


def case_record(case: ByCases, readings: Readings, before: Mapping[int, ByCases]) -> dict[str, Any]:
    """Return the certificate of what was found in cells of one robot, given what was found of others before in that round."""
    time, known, mates = readings.ranges.time, case.known, _mates(readings, case.robot, len(case.headings))
    others = np.array([mate for mate in mates if mate not in before], dtype=np.int64)
    rows = [few_rows(known, np.array([case.robot]), START_EDGES), few_rows(known, others, FEW_EDGES)]
    records = [row_record(each, k) for each in rows for k in range(len(each))]
    sources = [case.sources[number] for each in rows for number in each.source.tolist()]
    for mate in (mate for mate in mates if mate in before):
        few = before[mate].constraints(0).select(before[mate].rows[:, 3] > 0)
        records += [row_record(few, k) for k in range(len(few))]
        sources += [Source("cells", time, mate)] * len(few)
    return {
        "robot": case.robot,
        "rows": records,
        "sources": [source_record(source) for source in sources],
        "lower": {str(body): hexadecimal(known.lower[body]) for body in (case.robot, *mates)},
        "upper": {str(body): hexadecimal(known.upper[body]) for body in (case.robot, *mates)},
        "said": [source_record(source) for source in readings.concerning(case.robot) if source.kind in ("bearing", "range")],
        "spacing": float(case.spacing).hex(),
        "pieces": list(_pieces(case)),
        "claims": [{"normal": hexadecimal(row[:2]), "offset": row[2].hex()} for row in case.rows],
        "heading": hexadecimal(case.heading),
        "roots": slice_records(case.roots),
        "slices": slice_records(Slices.of_table(np.full(len(case.slices), case.robot), case.slices)),
    }


def slice_records(slices: Slices) -> list[dict[str, Any]]:
    """Return slices, each with its arc and how far it reaches."""
    arcs = np.stack([slices.centre, slices.bound], axis=1)
    return [{"arc": hexadecimal(arc), "reach": hexadecimal(reach)} for arc, reach in zip(arcs, slices.reach, strict=True)]


def _mates(readings: Readings, robot: int, robots: int) -> list[int]:
    """Return the robots that measured one, or were measured by it."""
    found = set[int]()
    for record in (readings.bearings, readings.ranges):
        found |= set(record.target[record.robot == robot].tolist()) | set(record.robot[record.target == robot].tolist())
    return sorted(mate for mate in found if mate < robots)


def _pieces(case: ByCases) -> Iterator[dict[str, Any]]:
    """Yield how often each piece was cut, and along which line it was then split; a piece comes before its two parts."""
    waiting = list(reversed(range(max(1, len(case.roots)))))
    while waiting:
        node = waiting.pop()
        piece: dict[str, Any] = {"rounds": int(case.tree.rounds[node])}
        if first := int(case.tree.child[node]):
            piece["line"] = hexadecimal(case.tree.line[node])
            waiting += [first + 1, first]
        yield piece
