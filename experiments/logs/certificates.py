"""A run's proofs as `certificates.jsonl.gz`, for `python -m experiments.prove` and for anybody else's checker.

One JSON object a line, one line for every edge of every outer polygon, of robots and of pairs that were projected, and for
every side of a robot's box; every float as a C99 hexadecimal string, which is exact. It says: for every x within the box that
satisfies the rows, normal . (x_robot - x_from) <= offset, or of x_robot alone where `from` is -1. The rows are
normal . (x_j - x_i) <= offset, or of x_j alone where i is -1.

`headings.jsonl.gz` beside it holds each step's heading intervals, which the motion of the rows depends on.
"""

from __future__ import annotations

import gzip
import json
from collections.abc import Sequence
from pathlib import Path
from types import TracebackType
from typing import Any

from filter import Array, Belief, Proof, Source

FILE = "certificates.jsonl.gz"
HEADINGS = "headings.jsonl.gz"
VERSION = 1  # of the format, in every certificate
FAST = 3  # of gzip's nine levels: twice as fast as the usual one, and the file a tenth larger


class Certificates:
    """Writes a run's certificates as it goes on. Use as a context manager, or call `close`."""

    def __init__(self, folder: Path) -> None:
        self._file, self._headings = _packed(folder / FILE), _packed(folder / HEADINGS)

    def write(self, belief: Belief) -> None:
        """Append all that the belief's regions rest on."""
        for proof in (proof for proof in belief.proofs if isinstance(proof, Proof)):
            _write(self._file, records(belief.time, proof))
        arcs = belief.headings
        record = {"t": belief.time.hex(), "centre": hexadecimal(arcs.centre), "bound": hexadecimal(arcs.bound)}
        _write(self._headings, [record])

    def close(self) -> None:
        """Close the files."""
        self._file.close()
        self._headings.close()

    def __enter__(self) -> Certificates:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()


def _packed(path: Path) -> gzip.GzipFile:
    """Return a new file; the time it was made is not in it, so that the same run gives the same bytes."""
    return gzip.GzipFile(path, "wb", FAST, mtime=0)


def _write(file: gzip.GzipFile, lines: Sequence[dict[str, Any]]) -> None:
    file.write("".join(json.dumps(record) + "\n" for record in lines).encode())


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


def source_record(source: Source) -> dict[str, Any]:
    """Return what produced a row, as JSON."""
    return {"kind": source.kind, "t": source.time.hex(), "robot": source.robot, "target": source.target}


def hexadecimal(values: Array) -> list[str]:
    """Return floats as C99 hexadecimal strings."""
    return [value.hex() for value in values.tolist()]
