"""A run's proofs as `certificates.jsonl.gz`, for `python -m experiments.prove` and for anybody else's checker.

One JSON object a line, one line for every edge of every outer polygon, of robots and of pairs that were projected, and for
every side of a robot's box; every float as a C99 hexadecimal string, which is exact. It says: for every x within the box that
satisfies the rows, normal . (x_robot - x_from) <= offset, or of x_robot alone where `from` is -1. The rows are
normal . (x_j - x_i) <= offset, or of x_j alone where i is -1.

A line with a `side` says of a robot's target, that one, that it is to one side of the robot: its direction is known then. If it
has `sensors`, by their numbers, that is said of the place of one as seen from the other.

A line with `pieces` was found case by case: a robot is behind all half-planes of its `claims`, as that is so of each piece that
its poses were split into, cut by all that was measured of it. Its `rows` are of the robot alone, or of a mate alone, without
multipliers. A line with `cases` says what votes leave of a robot's poses, without each of them (`experiments.logs.votes`).

`headings.jsonl.gz` beside it holds each step's heading intervals, as often as they became narrower, with the lines that have to
be proved before; `regions.jsonl.gz` the regions with the very numbers that recordings, trajectories and summaries show,
null for robots that are away. In the time of a doubt the first two hold what is said, and `alternatives.jsonl.gz` what is
proved in each case (`experiments.logs.alternatives`).
"""

from __future__ import annotations

import gzip
import json
from pathlib import Path
from types import TracebackType

from experiments.logs.alternatives import Alternatives, said
from experiments.logs.evidence import Records, proved
from experiments.logs.exactly import VERSION, region_record
from filter import Belief, Step, Team

FILE = "certificates.jsonl.gz"
HEADINGS = "headings.jsonl.gz"
REGIONS = "regions.jsonl.gz"
ALTERNATIVES = "alternatives.jsonl.gz"
FAST = 3  # of gzip's nine levels: twice as fast as the usual one, and the file a tenth larger


class Certificates:
    """Writes a run's certificates as it goes on. Use as a context manager, or call `close`."""

    def __init__(self, folder: Path, team: Team) -> None:
        self._files = {name: _packed(folder / name) for name in (FILE, HEADINGS, REGIONS, ALTERNATIVES)}
        self._team, self._alternatives = team, Alternatives(team)

    def write(self, step: Step[Belief]) -> None:
        """Append all that the headings and regions of a step rest on, and the regions as they are shown.

        Raises `InvalidInput` where that has no certificates (see docs/soundness.md).
        """
        belief, time = step.belief, {"version": VERSION, "t": step.belief.time.hex()}
        others = self._alternatives.of(step)
        headings, lines = said(belief) if self._alternatives.is_in_doubt else proved(belief, self._team.landmarks)
        self._write(HEADINGS, headings)
        self._write(FILE, lines)
        self._write(ALTERNATIVES, [{**time, **record} for record in others])
        shown = enumerate(region_record(region.outer) for region in belief.regions)
        gone = belief.guarantee.away
        self._write(REGIONS, [{**time, "regions": [None if robot in gone else record for robot, record in shown]}])

    def close(self) -> None:
        """Close the files."""
        for file in self._files.values():
            file.close()

    def __enter__(self) -> Certificates:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def _write(self, name: str, lines: Records) -> None:
        self._files[name].write("".join(json.dumps(record) + "\n" for record in lines).encode())


def _packed(path: Path) -> gzip.GzipFile:
    """Return a new file; the time it was made is not in it, so that the same run gives the same bytes."""
    return gzip.GzipFile(path, "wb", FAST, mtime=0)
