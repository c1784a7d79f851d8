"""A run's proofs as `certificates.jsonl.gz`, for `python -m experiments.prove` and for anybody else's checker.

One JSON object a line, one line for every edge of every outer polygon, of robots and of pairs that were projected, and for
every side of a robot's box; every float as a C99 hexadecimal string, which is exact. It says: for every x within the box that
satisfies the rows, normal . (x_robot - x_from) <= offset, or of x_robot alone where `from` is -1. The rows are
normal . (x_j - x_i) <= offset, or of x_j alone where i is -1.

A line with a `side` says of a robot's target, that one, that it is to one side of the robot: its direction is known then.

`headings.jsonl.gz` beside it holds each step's heading intervals, and the sides that bearings have narrowed them by;
`regions.jsonl.gz` the regions with the very numbers that recordings, trajectories and summaries show.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from experiments.logs.sides import Sighted, sides_behind_headings, sides_behind_ranges
from filter import Array, Belief, InvalidInput, Polygon, Proof, Source, Step
from filter.sensing.cells import ByCases

FILE = "certificates.jsonl.gz"
HEADINGS = "headings.jsonl.gz"
REGIONS = "regions.jsonl.gz"
VERSION = 2  # of the format, in every line
FAST = 3  # of gzip's nine levels: twice as fast as the usual one, and the file a tenth larger


class Certificates:
    """Writes a run's certificates as it goes on. Use as a context manager, or call `close`."""

    def __init__(self, folder: Path, landmarks: Array) -> None:
        self._files = {name: _packed(folder / name) for name in (FILE, HEADINGS, REGIONS)}
        self._landmarks = landmarks

    def write(self, step: Step[Belief]) -> None:
        """Append all that the headings and regions of a step rest on, and the regions as they are shown."""
        belief, time = step.belief, {"version": VERSION, "t": step.belief.time.hex()}
        arcs, landmarks = belief.headings, self._landmarks
        columns = {"centre": hexadecimal(arcs.centre), "bound": hexadecimal(arcs.bound)}
        self._write(HEADINGS, [{**time, **columns, "sides": side_records(belief.time, sides_behind_headings(step, landmarks))}])
        lines = [line for proof in self._proofs(belief) for line in records(belief.time, proof)]
        self._write(FILE, [*side_records(belief.time, sides_behind_ranges(step, landmarks)), *lines])
        self._write(REGIONS, [{**time, "regions": [region_record(region.outer) for region in belief.regions]}])

    def _proofs(self, belief: Belief) -> list[Proof]:
        """Return what can be proved again."""
        if any(isinstance(proof, ByCases) for proof in belief.proofs):
            raise InvalidInput("a belief of a filter with cells=0, as certificates know no cells", "one with cells")
        return [proof for proof in belief.proofs if isinstance(proof, Proof)]

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


def _packed(path: Path) -> gzip.GzipFile:
    """Return a new file; the time it was made is not in it, so that the same run gives the same bytes."""
    return gzip.GzipFile(path, "wb", FAST, mtime=0)


def records(time: float, proof: Proof) -> list[dict[str, Any]]:
    """Return the certificate of every claim of a proof."""
    rows = proof.polytope.constraints
    of_rows = {
        row: {
            "i": int(rows.i[row]),
            "j": int(rows.j[row]),
            "normal": hexadecimal(rows.normal[row]),
            "offset": float(rows.offset[row]).hex(),
        }
        for row in set(proof.weights.row.tolist())
    }
    lower, upper = proof.polytope.lower, proof.polytope.upper
    found = []
    for claim, (robot, seen_from) in enumerate(zip(proof.j.tolist(), proof.i.tolist(), strict=True)):
        used, multipliers = proof.rests_on(claim)
        numbers = used.tolist()
        bodies = sorted({robot, seen_from, *rows.i[used].tolist(), *rows.j[used].tolist()} - {-1})
        found.append(
            {
                "version": VERSION,
                "t": float(time).hex(),
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


def side_records(time: float, sides: Sighted) -> list[dict[str, Any]]:
    """Return the certificates of sides, each with the target that it is about."""
    proof, about = sides
    return [{**line, "side": target} for line, target in zip(records(time, proof), about.tolist(), strict=True)]


def region_record(outer: Polygon) -> dict[str, Any]:
    """Return a region as recordings, trajectories and summaries show it."""
    vertices = [hexadecimal(vertex) for vertex in outer.vertices]
    return {"vertices": vertices, "area": float(outer.area).hex(), "estimate": hexadecimal(outer.centroid)}


def source_record(source: Source) -> dict[str, Any]:
    """Return what produced a row, as JSON."""
    return {"kind": source.kind, "t": source.time.hex(), "robot": source.robot, "target": source.target}


def hexadecimal(values: Array) -> list[str]:
    """Return floats as C99 hexadecimal strings."""
    return [value.hex() for value in values.tolist()]
