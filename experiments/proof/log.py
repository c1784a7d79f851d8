"""What a filter was given, in exact numbers: all that a proof starts from. Standard library only.

Read as strictly as the filter's own reader does (docs/log.md): every bound, time and number of a robot is looked at.
"""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field
from fractions import Fraction
from itertools import product
from pathlib import Path
from typing import Any

from experiments.proof.exact import CIRCLE, Arc, Motion, Vector, arc_around
from experiments.proof.reading import Broken, Record, body, located, number, records, shown

HEADER = {"format", "version", "robots", "landmarks", "arena", "speed_limit", "turn_rate_limit", "start", "rate"}
# The columns of each record; what is in BOUNDS is not negative, and SHARES are below 1.
COLUMNS = {
    "odometry": ("distance", "distance_bound", "turn", "turn_bound", "direction_bound", "slip_bound"),
    "compass": ("heading", "bound"),
    "bearing": ("bearing", "bound"),
    "range": ("range", "bound", "relative_bound"),
    "position": ("normal_x", "normal_y", "offset"),
}
ASIDE = "aside"  # a column of odometry that need not be there
BOUNDS = {"distance_bound", "turn_bound", "direction_bound", "slip_bound", "bound", "relative_bound", "range"}
Reading = dict[str, Fraction]
Who = tuple[str, int, int | None]  # kind, robot, target


@dataclass
class Frame:
    """What came with one frame.

    Attributes:
        time: [s].
        readings: Of each kind, robot and target (None for compass and odometry): the numbers of every reading.
        truth: Where the robots were and which way they looked, or None.
        measurements: How many numbers were measured.
    """

    time: float
    readings: dict[Who, list[dict[str, float]]] = field(default_factory=dict)
    truth: tuple[list[Vector], list[Fraction]] | None = None
    measurements: int = 0

    def of(self, kind: str, robot: int, target: int | None = None) -> list[Reading]:
        """Return all that one robot measured of a target, in numbers."""
        found = self.readings.get((kind, robot, target), ())
        return [{name: Fraction(value) for name, value in one.items()} for one in found]


class Log:
    """What the filter was given.

    Attributes:
        robots: How many.
        landmarks: Where they are [m].
        arena: Lower and upper corner, None for a coordinate without a limit [m].
        speed, turn_rate: The limits of each robot, where it has no odometry [m/s] [rad/s].
        start: When the initial sets hold [s].
        rate: Frames a second [Hz], or None.
        vertices: For each robot the corners of its initial set [m].
        initial: For each robot its heading at the start.
        frames: All frames, in order.
    """

    def __init__(self, folder: Path) -> None:
        lines = records(folder / "log.jsonl")
        place, header = next(lines, ("log.jsonl", {}))
        with located(place):
            self._read_header(header)
        known: dict[int, tuple[list[Vector], Arc]] = {}
        for _ in range(self.robots):
            place, record = next(lines, ("log.jsonl", {}))
            with located(place):
                robot, what = self._initial(record)
                if robot in known:
                    raise Broken(f"a second initial set of robot {robot}")
                known[robot] = what
        self.vertices = [known[robot][0] for robot in range(self.robots)]
        self.initial = [known[robot][1] for robot in range(self.robots)]
        self.frames = list(self._frames(lines))
        if not self.frames:
            raise Broken("log.jsonl: at least one frame was expected")

    def _read_header(self, header: Record) -> None:
        fields = _fields(header, "header", HEADER)
        if (fields["format"], fields["version"]) != ("corral-log", 1):
            raise Broken(f"a log of version 1 was expected, not {shown(fields['format'])}, version {shown(fields['version'])}")
        self.robots = body(fields["robots"], 10**6)
        self.landmarks = [_point(point) for point in fields["landmarks"]]
        least, greatest = fields["arena"]
        self.arena = [[None if value is None else number(value) for value in (x, y)] for x, y in (least, greatest)]
        self.speed, self.turn_rate = (self._limits(fields[name]) for name in ("speed_limit", "turn_rate_limit"))
        self.start, rate = number(fields["start"]), fields["rate"]
        self.rate = None if rate is None else number(rate, 0)

    def _limits(self, value: Any) -> list[Fraction]:
        """Return a limit of each robot: one for all, or a list."""
        each = value if isinstance(value, list) else [value] * self.robots
        if len(each) != self.robots:
            raise Broken(f"a limit for each of {self.robots} robots was expected, not {len(each)}")
        return [Fraction(number(limit, 0)) for limit in each]

    def _initial(self, record: Record) -> tuple[int, tuple[list[Vector], Arc]]:
        fields = _fields(record, "initial", {"robot", "vertices", "heading"})
        corners, heading = fields["vertices"], fields["heading"] or {"centre": 0.0, "bound": 4.0}
        if corners is None:
            corners = list(product(*zip(*self.arena, strict=True)))
        if not corners:
            raise Broken("an initial set without a point")
        arc = arc_around(number(heading["centre"]), number(heading["bound"], 0))
        return body(fields["robot"], self.robots), ([_point(corner) for corner in corners], arc)

    def _frames(self, lines: Iterator[tuple[str, Record]]) -> Iterator[Frame]:
        before, first, frame, place = self.start, True, None, "log.jsonl"
        for place, record in lines:
            with located(place):
                kind, time = record["record"], number(record["time"])
                if frame is None:
                    if time < before or (time == before and not first):
                        raise Broken(f"t = {time} s does not come after {before} s")
                    frame, since, before, first = Frame(time), before, time, False
                if time != frame.time:
                    raise Broken(f"t = {time} s in a frame of t = {frame.time} s")
                self._add(frame, since, kind, record)
            if kind == "frame":
                yield frame
                frame = None
        if frame is not None:
            raise Broken(f"{place}: the log ends within a frame")

    def _add(self, frame: Frame, since: float, kind: str, record: Record) -> None:
        if kind == "frame":
            _fields(record, kind, {"time"})
        elif kind == "truth":
            fields = _fields(record, kind, {"time", "positions", "headings"})
            if frame.truth is not None or not len(fields["positions"]) == len(fields["headings"]) == self.robots:
                raise Broken(f"one truth of {self.robots} robots was expected")
            headings = [Fraction(number(value)) for value in fields["headings"]]
            frame.truth = [_point(point) for point in fields["positions"]], headings
        elif kind in COLUMNS:
            for who, reading in self._readings(kind, record, since):
                frame.readings.setdefault(who, []).append(reading)
                frame.measurements += kind != "odometry"
                if kind == "odometry" and len(frame.readings[who]) > 1:
                    raise Broken(f"a second odometry of robot {who[1]}")
        else:
            raise Broken(f"a record {shown(kind)} that there is not")

    def _readings(self, kind: str, record: Record, since: float) -> Iterator[tuple[Who, dict[str, float]]]:
        seen = {"target", "landmark"} & set(record) if kind in ("bearing", "range") else set()
        seen |= {ASIDE} & set(record) if kind == "odometry" else set()
        others = {"time", "robot", *(("start",) if kind == "odometry" else ())}
        fields = _fields(record, kind, {*others, *COLUMNS[kind], *seen})
        names = (*COLUMNS[kind], *({ASIDE} & seen))
        if kind == "odometry" and (fields["start"] != since or since == fields["time"]):
            raise Broken(f"odometry from t = {shown(fields['start'])} s on, where the frame before is of {since} s")
        whose = [*_columns([fields["robot"], fields.get("target"), fields.get("landmark")])]
        numbers = [*_columns([fields[name] for name in names], len(whose))]
        for (robot, mate, mark), row in zip(whose, numbers, strict=True):
            values = {name: number(value, 0 if name in BOUNDS else None) for name, value in zip(names, row, strict=True)}
            if values.get("relative_bound", 0) >= 1:
                raise Broken("a relative bound of 1 or more")
            target = self._target(mate, mark) if kind in ("bearing", "range") else None
            yield (kind, body(robot, self.robots), target), values

    def _target(self, mate: Any, mark: Any) -> int:
        if (mate is None) == (mark is None):
            raise Broken("either a target or a landmark was expected")
        return body(mate, self.robots) if mark is None else self.robots + body(mark, len(self.landmarks))

    def motions(self, frame: Frame, since: float, headings: Sequence[Arc]) -> list[Motion] | None:
        """Return how each robot can have moved up to a frame, with these headings before; None where there is no motion."""
        duration = Fraction(frame.time) - Fraction(since)
        if not duration:
            return None
        circle, found = Arc(-CIRCLE, CIRCLE), list[Motion]()
        for robot, heading in enumerate(headings):
            driven = frame.of("odometry", robot)
            anyhow = Motion(circle, Fraction(0), Fraction(0), CIRCLE, self.speed[robot] * duration)
            found.append(Motion.of_odometry(driven[0], heading) if driven else anyhow)
        return found

    def turned(self, frame: Frame, since: float, headings: Sequence[Arc]) -> list[Arc]:
        """Return the robots' headings at a frame as they follow from those before."""
        duration = Fraction(frame.time) - Fraction(since)
        anyhow = [{"turn": Fraction(0), "turn_bound": limit * duration} for limit in self.turn_rate]
        driven = [(frame.of("odometry", robot) or [anyhow[robot]])[0] for robot in range(self.robots)]
        return [arc.widened(one["turn"], one["turn_bound"]) for arc, one in zip(headings, driven, strict=True)]


def _fields(record: Record, kind: str, names: set[str]) -> Record:
    """Return a record of a kind that has just these fields."""
    if record.get("record") != kind or set(record) - {"record"} != names:
        raise Broken(f"a record {kind} of {sorted(names)} was expected, not {shown(sorted(record))}")
    return record


def _columns(values: Sequence[Any], count: int | None = None) -> Iterator[tuple[Any, ...]]:
    """Return columns of one length as rows; a value that is no list stands for all."""
    lengths = {len(value) for value in values if isinstance(value, list)} | ({count} if count is not None else set())
    if len(lengths) > 1:
        raise Broken("columns of one length were expected")
    rows = lengths.pop() if lengths else 1
    return zip(*(value if isinstance(value, list) else [value] * rows for value in values), strict=True)


def _point(value: Any) -> Vector:
    x, y = value
    return Fraction(number(x)), Fraction(number(y))
