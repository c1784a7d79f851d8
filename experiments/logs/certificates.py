"""A run's proofs as `certificates.jsonl.gz`, for `python -m experiments.prove` and for anybody else's checker.

One JSON object a line, one line for every edge of every outer polygon, of robots and of pairs that were projected, and for
every side of a robot's box; every float as a C99 hexadecimal string, which is exact. It says: for every x within the box that
satisfies the rows, normal . (x_robot - x_from) <= offset, or of x_robot alone where `from` is -1. The rows are
normal . (x_j - x_i) <= offset, or of x_j alone where i is -1.

A line with a `side` says of a robot's target, that one, that it is to one side of the robot: its direction is known then. If it
has `sensors`, by their numbers, that is said of the place of one as seen from the other.

A line with `pieces` was found case by case: a robot is behind all half-planes of its `claims`, as that is so of each piece that
its poses were split into, cut by all that was measured of it. Its `rows` are of the robot alone, or of a mate alone, without
multipliers.

`headings.jsonl.gz` beside it holds each step's heading intervals, as often as they became narrower, with the lines that have to
be proved before; `regions.jsonl.gz` the regions with the very numbers that recordings, trajectories and summaries show,
null for robots that are away.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from experiments.logs.cases import case_record
from experiments.logs.exactly import hexadecimal, region_record, row_record, source_record
from experiments.logs.sides import Sighted, Sights, boxes_at_a_glance, sides_of_bearings, sides_of_ranges
from filter import (
    AngularIntervals,
    Array,
    Belief,
    ByCases,
    Cases,
    Directions,
    Doubted,
    Evidence,
    Integers,
    InvalidInput,
    Proof,
    StartsOver,
    Step,
)
from filter.linear.sources import Sources

FILE = "certificates.jsonl.gz"
HEADINGS = "headings.jsonl.gz"
REGIONS = "regions.jsonl.gz"
VERSION = 3  # of the format, in every line
FAST = 3  # of gzip's nine levels: twice as fast as the usual one, and the file a tenth larger
Part = Proof | Sighted | ByCases | AngularIntervals


class Certificates:
    """Writes a run's certificates as it goes on. Use as a context manager, or call `close`."""

    def __init__(self, folder: Path, landmarks: Array) -> None:
        self._files = {name: _packed(folder / name) for name in (FILE, HEADINGS, REGIONS)}
        self._landmarks = landmarks

    def write(self, step: Step[Belief]) -> None:
        """Append all that the headings and regions of a step rest on, and the regions as they are shown.

        Raises `InvalidInput` where something is in doubt: what holds in several cases has no certificate yet.
        """
        doubt = next((event for event in step.belief.events if isinstance(event, Doubted | StartsOver)), None)
        if doubt is not None:
            raise InvalidInput("certificates of a run in which nothing is in doubt", str(doubt))
        belief, time = step.belief, {"version": VERSION, "t": step.belief.time.hex()}
        headings, lines, cases = list[dict[str, Any]](), list[dict[str, Any]](), dict[int, ByCases]()
        readings = next(each.readings for each in belief.proofs if isinstance(each, Directions))
        for part in self._parts(belief):
            if isinstance(part, AngularIntervals):
                columns = {"centre": hexadecimal(part.centre), "bound": hexadecimal(part.bound)}
                headings.append({**time, **columns, "lines": lines})
                lines, cases = [], {}
            elif isinstance(part, ByCases):
                lines.append({**time, **case_record(part, readings, cases)})
                cases[part.robot] = part
            else:
                found = records(part) if isinstance(part, Proof) else side_records(part)
                lines += [{**time, **line} for line in found]
        self._write(HEADINGS, headings)
        self._write(FILE, lines)
        shown = enumerate(region_record(region.outer) for region in belief.regions)
        gone = belief.guarantee.away
        self._write(REGIONS, [{**time, "regions": [None if robot in gone else record for robot, record in shown]}])

    def _parts(self, belief: Belief) -> list[Part]:
        """Return all that has to be proved of a step, in order; headings are proved from what is before them.

        Of ranges those sides are there that something later rests on.
        """
        parts, used = list[Part](), ranges_at(belief.time, belief.sources, belief.constraints.source)
        for before, each in reversed(list(pairwise((None, *belief.proofs)))):
            now = self._read(each, before, used) if isinstance(each, Directions) else _found(each, before)
            parts = now + parts
            for proof in (part.proof if isinstance(part, Sighted) else part for part in now):
                if isinstance(proof, Proof):
                    used |= ranges_at(belief.time, proof.sources, proof.polytope.constraints.source[proof.weights.row])
        return parts

    def _read(self, read: Directions, before: Evidence | None, used: Sights) -> list[Part]:
        """Return what a pass has read, if another one was before it, from the boxes that one left."""
        boxes: list[Part] = [boxes_at_a_glance(read, before)] if isinstance(before, Directions) else []
        sides = sides_of_bearings(read, self._landmarks), sides_of_ranges(read, self._landmarks, used)
        return [*boxes, sides[0], read.headings, sides[1]]

    def close(self) -> None:
        """Close the files."""
        for file in self._files.values():
            file.close()

    def __enter__(self) -> Certificates:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _write(self, name: str, lines: Sequence[dict[str, Any]]) -> None:
        self._files[name].write("".join(json.dumps(record) + "\n" for record in lines).encode())


def _found(each: Proof | Cases | None, before: Evidence | None) -> list[Part]:
    """Return a proof, or all cases, after the headings that they began with if others were found before in cells."""
    if isinstance(each, Cases):
        return [*([each.told.headings] if isinstance(before, Cases) else []), *each]
    return [each] if each else []


def _packed(path: Path) -> gzip.GzipFile:
    """Return a new file; the time it was made is not in it, so that the same run gives the same bytes."""
    return gzip.GzipFile(path, "wb", FAST, mtime=0)


def records(proof: Proof) -> list[dict[str, Any]]:
    """Return the certificate of every claim of a proof."""
    rows = proof.polytope.constraints
    of_rows = {row: row_record(rows, row) for row in set(proof.weights.row.tolist())}
    lower, upper = proof.polytope.lower, proof.polytope.upper
    found = []
    for claim, (robot, seen_from) in enumerate(zip(proof.j.tolist(), proof.i.tolist(), strict=True)):
        used, multipliers = proof.rests_on(claim)
        numbers = used.tolist()
        bodies = sorted({robot, seen_from, *rows.i[used].tolist(), *rows.j[used].tolist()} - {-1})
        found.append(
            {
                "robot": robot,
                "from": seen_from,
                "normal": hexadecimal(proof.normal[claim]),
                "offset": float(proof.offset[claim]).hex(),
                "rows": [of_rows[k] | {"multiplier": y.hex()} for k, y in zip(numbers, multipliers.tolist(), strict=True)],
                "lower": {str(body): hexadecimal(lower[body]) for body in bodies},
                "upper": {str(body): hexadecimal(upper[body]) for body in bodies},
                "sources": [source_record(proof.sources[int(rows.source[k])]) for k in numbers],
            }
        )
    return found


def side_records(sides: Sighted) -> list[dict[str, Any]]:
    """Return the certificates of sides, each with the target that it is about, and the sensors if they are mounted."""
    found = [{**line, "side": target} for line, target in zip(records(sides.proof), sides.about.tolist(), strict=True)]
    if sides.sensors is None:
        return found
    return [{**line, "sensors": pair} for line, pair in zip(found, sides.sensors.tolist(), strict=True)]


def ranges_at(time: float, sources: Sources, numbers: Integers) -> set[tuple[int, int | None]]:
    """Return robot and target of each range of a time among some sources."""
    named = map(sources.__getitem__, np.unique(numbers).tolist())
    return {(one.robot, one.target) for one in named if one.kind == "range" and one.time == time}
