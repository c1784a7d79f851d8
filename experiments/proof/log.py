"""What a filter was given, in exact numbers, for `experiments.proof.chain`: standard library only."""

import gzip
import json
from fractions import Fraction
from itertools import product
from math import pi
from pathlib import Path
from typing import Any

from experiments.proof.exact import PI, PI_ROUNDING, Arc, Motion

CIRCLE = Fraction(4)  # more than half a turn
Record = dict[str, Any]


def numbers(values: list[float] | float, count: int) -> list[Fraction]:
    """Return a record's column; one number stands for all."""
    return [Fraction(value) for value in (values if isinstance(values, list) else [values] * count)]


class Log:
    """What the filter was given, and the headings that it had after each step.

    Attributes:
        header: The log's first record.
        vertices: For each robot the corners of its initial set [m].
        frames: For each time, as a float, the records of its frame.
        times: All times, in order.
        headings: For each time the robots' heading intervals; those of the start under None.
    """

    def __init__(self, folder: Path) -> None:
        records = [json.loads(text) for text in (folder / "log.jsonl").read_text(encoding="utf-8").splitlines()]
        self.header: Record = records[0]
        robots = self.header["robots"]
        initial = sorted(records[1 : robots + 1], key=lambda record: record["robot"])
        arena = list(product(*zip(*self.header["arena"], strict=True)))
        self.vertices = [[(Fraction(x), Fraction(y)) for x, y in record["vertices"] or arena] for record in initial]
        known = [record["heading"] or {"centre": 0.0, "bound": pi} for record in initial]
        self.headings: dict[float | None, list[Arc]] = {None: [_arc(one["centre"], one["bound"]) for one in known]}
        self.frames: dict[float, list[Record]] = {}
        for record in records[robots + 1 :]:
            self.frames.setdefault(record["time"], []).append(record)
        self.times = list(self.frames)
        with gzip.open(folder / "headings.jsonl.gz", "rt", encoding="utf-8") as file:
            for line in map(json.loads, file):
                arcs = zip(map(float.fromhex, line["centre"]), map(float.fromhex, line["bound"]), strict=True)
                self.headings[float.fromhex(line["t"])] = [_arc(centre, bound) for centre, bound in arcs]

    def motions(self, since: float | None, time: float) -> list[Motion] | None:
        """Return how each robot can have moved up to a time, or None where there is no motion."""
        duration = Fraction(time) - Fraction(self.header["start"] if since is None else since)
        if not duration:
            return None
        circle, slip = _arc(0.0, pi), Fraction(self.header["speed_limit"]) * duration
        found = [Motion(circle, Fraction(0), Fraction(0), CIRCLE, slip)] * self.header["robots"]
        for record in self.frames[time]:
            if record["record"] == "odometry":
                count = len(record["robot"]) if isinstance(record["robot"], list) else 1
                names = ("robot", "distance", "distance_bound", "turn", "turn_bound", "direction_bound", "slip_bound")
                columns = (numbers(record[name], count) for name in names)
                for robot, way, error, turn, turned, skew, slid in zip(*columns, strict=True):
                    heading, full = self.headings[since][int(robot)], abs(turn) + turned >= 2 * (PI - PI_ROUNDING)
                    arc = circle if full else heading.widened(turn / 2, turned / 2 + skew)
                    found[int(robot)] = Motion(arc, way - error, way + error, (abs(turn) + turned) / 2 + skew, slid)
        return found

    def turned(self, robot: int, since: float | None, time: float) -> Arc:
        """Return a robot's heading at a time as it follows from the one before."""
        duration = Fraction(time) - Fraction(self.header["start"] if since is None else since)
        turn, bound = Fraction(0), Fraction(self.header["turn_rate_limit"]) * duration
        for record in self.frames[time] if duration else ():
            if record["record"] == "odometry":
                robots = [record["robot"]] if isinstance(record["robot"], int) else record["robot"]
                for k in (k for k, one in enumerate(robots) if one == robot):
                    turn, bound = (numbers(record[name], len(robots))[k] for name in ("turn", "turn_bound"))
        return self.headings[since][robot].widened(turn, bound)

    def readings(self, time: float, kind: str, robot: int, target: int | None) -> list[dict[str, Fraction]]:
        """Return all that one robot measured of a target, in numbers."""
        found, mates = [], self.header["robots"]
        for record in (record for record in self.frames.get(time, ()) if record["record"] == kind):
            count = len(record["robot"]) if isinstance(record["robot"], list) else 1
            columns = {name: value if isinstance(value, list) else [value] * count for name, value in record.items()}
            for k in range(count):
                mate, mark = (columns.get(name, [None] * count)[k] for name in ("target", "landmark"))
                if columns["robot"][k] == robot and target == (mate if mark is None else mates + mark):
                    values = {name: column[k] for name, column in columns.items() if isinstance(column[k], float | int)}
                    found.append({name: Fraction(value) for name, value in values.items()})
        return found


def compass(reading: dict[str, Fraction]) -> Arc:
    """Return the arc that a compass reading leaves for the heading."""
    return Arc(reading["heading"] - reading["bound"], reading["heading"] + reading["bound"])


def _arc(centre: float, bound: float) -> Arc:
    """Return an arc; a bound of half a turn, as nearly as floats say it, is the whole circle."""
    reach = Fraction(bound) if bound < pi else CIRCLE
    return Arc(Fraction(centre) - reach, Fraction(centre) + reach)
