"""Logs of version 2, line by line: a team that drives in arcs, and says in every form of a record what it measures of that."""

import json
from collections.abc import Callable
from dataclasses import dataclass, field
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

Line = dict[str, object]
NAMES, MARKS = ("alice", "bob", "3rd"), {"gate": [0.5, 3.5], "door": [-2.25, 0.125]}
LENGTH = 1.0  # of a log [s]


@dataclass
class Team:
    """Robots that each drive at a speed and a turn rate of their own, one of them sideways."""

    rng: np.random.Generator
    carried: dict[int, tuple[float, NDArray[np.float64]]] = field(default_factory=dict)  # from when on, and by how much

    def __post_init__(self) -> None:
        self.first = self.rng.uniform(-2, 2, (3, 2))
        self.headings = self.rng.uniform(-np.pi, np.pi, 3)
        self.speeds, self.rates = self.rng.uniform(-0.6, 0.6, 3), self.rng.choice([-1, 1], 3) * self.rng.uniform(0.01, 1, 3)
        self.asides = np.array([0.0, 0.0, np.pi / 2])

    def at(self, robot: int, time: float) -> tuple[NDArray[np.float64], float]:
        """Return where a robot is and which way it looks."""
        turn = self.rates[robot] * time
        way = self.headings[robot] + turn / 2 + self.asides[robot]
        chord = self.speeds[robot] * time * np.sinc(turn / 2 / np.pi)
        since, by = self.carried.get(robot, (np.inf, np.zeros(2)))
        place = self.first[robot] + chord * np.array([np.cos(way), np.sin(way)]) + by * (time >= since)
        return place, self.headings[robot] + turn

    def placed(self, robot: int, time: float, *, known: bool) -> Line:
        """Return where a robot is put down at some time, its heading known or not."""
        place, heading = self.at(robot, time)
        corners = place + 0.5 * np.array([[-1, -0.6], [1, -0.6], [0.2, 1.1]]) + 0.1 * np.array([self.error(), self.error()])
        looks = {"centre": heading + 0.1 * self.error(), "bound": 0.11} if known else None
        return {"record": "initial", "time": time, "robot": NAMES[robot], "vertices": corners.tolist(), "heading": looks}

    def header(self, **more: object) -> Line:
        """Return a header with limits of each robot; not all of these are there."""
        limits = {"speed_limit": dict(zip(NAMES, (0.7, 0.7, 0.9), strict=True)), "turn_rate_limit": 1.2}
        if self.rng.uniform() < 0.7:
            limits["acceleration_limit"] = {"alice": 0.5, "bob": None, "3rd": 2}
            limits["turn_acceleration_limit"] = 0.3
        head = {"record": "header", "format": "corral-log", "version": 2, "robots": NAMES, "landmarks": MARKS, "start": 0.0}
        return {**head, "arena": [[-9, -9], [9, None]], **limits, **more}

    def initial(self) -> list[Line]:
        """Return an initial set of each robot; one knows nothing of its heading."""
        found = []
        for robot, name in enumerate(NAMES):
            corners = self.first[robot] + np.array([[-0.4, -0.3], [0.4, -0.3], [0.1, 0.5]])
            heading = {"centre": self.headings[robot] + 0.1 * self.error(), "bound": 0.11} if robot else None
            found.append({"record": "initial", "robot": name, "vertices": corners.tolist(), "heading": heading})
        return found

    def error(self) -> float:
        """Return an error from -1 to 1, often one of these."""
        return float(self.rng.choice([-1, 1, self.rng.uniform(-1, 1)]))

    def odometry(self, robot: int, start: float, time: float) -> Line:
        """Return what a robot's wheels say."""
        some = time - start
        distance, turn = self.speeds[robot] * some + 0.003 * self.error(), self.rates[robot] * some + 0.01 * self.error()
        bounds = {"distance_bound": 0.00301, "turn_bound": 0.0101, "direction_bound": 0.01, "slip_bound": 0.001}
        way = {"aside": self.asides[robot]} if self.asides[robot] else {}
        record = {"record": "odometry", "start": start, "time": time, "robot": NAMES[robot], "distance": distance}
        return {**record, "turn": turn, **bounds, **way}

    def twist(self, robot: int, time: float) -> Line:
        """Return a command that a robot follows."""
        speed, rate = self.speeds[robot] + 0.02 * self.error(), self.rates[robot] + 0.05 * self.error()
        bounds = {"speed_bound": 0.021, "turn_rate_bound": 0.051, "direction_bound": 0.01, "slip_rate": 0.01}
        record = {"record": "twist", "time": time, "robot": NAMES[robot], "speed": speed, "turn_rate": rate}
        return {**record, **bounds, "hold": 0.3, "aside": self.asides[robot]}

    def measured(self, time: float) -> Line:
        """Return one measurement, of any kind and form."""
        robot, kind = (
            int(self.rng.integers(3)),
            self.rng.choice(["compass", "bearing", "bearing", "range", "range", "position"]),
        )
        place, heading = self.at(robot, time)
        record = {"record": str(kind), "time": time, "robot": NAMES[robot]}
        if kind == "position":
            return {**record, **self._position(place)}
        pair = bool(self.rng.uniform() < 0.5)
        low, high = (-0.02, 0.06) if pair else (-0.05, 0.05)
        off, bound = (
            self.rng.choice([low, high, self.rng.uniform(low, high)]),
            [low - 1e-9, high + 1e-9] if pair else high + 1e-9,
        )
        if kind == "compass":
            return {**record, "heading": heading + off, "bound": bound}
        mark, mate = str(self.rng.choice(list(MARKS))), int((robot + self.rng.integers(1, 3)) % 3)
        seen = bool(self.rng.uniform() < 0.5)
        way = (np.array(MARKS[mark]) if seen else self.at(mate, time)[0]) - place
        whom = {"landmark": mark} if seen else {"target": NAMES[mate]}
        if kind == "bearing":
            return {**record, **whom, "bearing": np.arctan2(way[1], way[0]) - heading + off, "bound": bound}
        far = np.hypot(*way)
        return {
            **record,
            **whom,
            "range": max(0.0, far + off + 0.01 * far * self.error()),
            "bound": bound,
            "relative_bound": 0.0101,
        }

    def _position(self, place: NDArray[np.float64]) -> Line:
        x, y = (place + 0.2 * np.array([self.error(), self.error()])).tolist()
        normal = self.rng.uniform(-3, 3, 2)
        square = (place + 0.3 * np.array([[-1, -1], [1, -1], [1, 1.2], [0, 2], [-1, 1]])).tolist()
        forms: list[Line] = [
            {"position": [x, y], "bound": 0.21},
            {"position": [x, y], "bound": [0.21, 0.3]},
            {"position": [x, y], "radius": 0.3},
            {"vertices": square},
            {"normal": normal.tolist(), "offset": normal @ place + 0.1},
            {"normal_x": [0.6, 0], "normal_y": [0.8, -1], "offset": [0.6 * x + 0.8 * y + 0.3, 0.21 - y]},
        ]
        return forms[self.rng.integers(len(forms))]

    def truth(self, robot: int, time: float) -> Line:
        """Return where a robot is; which way it looks nobody knows now and then."""
        place, heading = self.at(robot, time)
        looks = heading if self.rng.uniform() < 0.7 else None
        return {"record": "truth", "time": time, "robot": NAMES[robot], "position": place.tolist(), "heading": looks}


def in_step(team: Team) -> list[Line]:
    """Return a log in lock-step, with frames."""
    lines, times = [team.header(rate=10), *team.initial()], (np.arange(6) / 10).tolist()
    for before, time in pairwise([None, *times]):
        moving = [] if before is None else [robot for robot in range(3) if team.rng.uniform() < 0.8]
        lines += [team.odometry(robot, before, time) for robot in moving]
        lines += [team.measured(time) for _ in range(7)] + [team.truth(robot, time) for robot in (0, 2)]
        lines.append({"record": "frame", "time": time})
    return lines


def as_it_comes(team: Team, late: float = 0.4) -> list[Line]:
    """Return a log of records at stamps of their own, up to so much late: wheels of two robots, commands of one."""
    rng, lines = team.rng, list[Line]()
    for robot in range(2):
        stamps = np.cumsum(np.concatenate([[0.0], rng.uniform(0.02, 0.15, int(LENGTH / 0.085))])).tolist()
        lines += [team.odometry(robot, *span) for span in pairwise(stamps) if rng.uniform() < 0.9]
    lines += [team.twist(2, float(time)) for time in np.cumsum(rng.uniform(0.1, 0.4, 4)) - 0.2]
    stamps = np.sort(rng.uniform(0.01, LENGTH, 7)).tolist()
    lines += [team.measured(time) for time in stamps for _ in range(4)] + [team.truth(1, time) for time in stamps[::2]]
    lines.append({"record": "frame", "time": LENGTH / 2})
    due = [rng.uniform(0, late) + line["time"] for line in lines]
    return [team.header(), *team.initial(), *(lines[k] for k in np.argsort(due, kind="stable"))]


PUT, LEFT, BACK, JOINED = 0.5, 0.1, 0.4, 0.3  # when alice is put elsewhere, bob leaves and is back, and 3rd joins [s]
NOWHERE = {"bob": (LEFT, BACK), "3rd": (-1.0, JOINED)}  # from when on, and until when, nobody knows


def coming_and_going(team: Team, make: Callable[[Team], list[Line]]) -> list[Line]:
    """Return a log in which one robot is put elsewhere, one leaves and is back elsewhere, and one joins late."""
    team.carried = {0: (PUT, np.array([1.5, -0.7])), 1: (BACK, np.array([-0.9, 2.0]))}
    lines = [line for line in make(team) if not (line["record"] == "initial" and line["robot"] == "3rd")]
    lines = [line for line in lines if not _is_of_nobody(line)]
    changes = [
        team.placed(0, PUT, known=False),
        {"record": "leave", "time": LEFT, "robot": "bob"},
        team.placed(1, BACK, known=True),
        team.placed(2, JOINED, known=True),
    ]
    for change in changes:  # before whatever is measured then, or later
        at = next(k for k, line in enumerate(lines) if k > 2 and _time(line) >= _time(change))
        lines.insert(at, change)
    return lines


def _time(line: Line) -> float:
    return float(str(line.get("time", -np.inf)))


def _is_of_nobody(line: Line) -> bool:
    """Return whether something is measured by or of a robot that is away."""
    if line["record"] not in ("compass", "bearing", "range", "position"):
        return False
    gone = [name for name, (since, until) in NOWHERE.items() if since <= _time(line) < until]
    return line["robot"] in gone or line.get("target") in gone


def with_mates(lines: list[Line], team: Team, rng: np.random.Generator) -> list[Line]:
    """Return a log in which whoever measures a mate tells its heading as well, now and then, and of a few anything."""
    found = list[Line]()
    for line in lines:
        found.append(line)
        if "target" in line and rng.uniform() < 0.7:
            robot, mate = (NAMES.index(str(line[name])) for name in ("robot", "target"))
            (_, looks), (_, seen) = (team.at(body, _time(line)) for body in (robot, mate))
            record = {"record": "relative_heading", "time": line["time"], "robot": line["robot"], "target": line["target"]}
            low, high = rng.choice([-0.03, -0.6]), 0.04
            off = rng.choice([low, high, rng.uniform(low, high)])
            found.append({**record, "heading": seen - looks + off, "bound": [low - 1e-9, high + 1e-9]})
    return found


def written(path, lines: list[Line]):
    """Write a log; return its path."""
    path.write_text("".join(json.dumps(line) + "\n" for line in lines))
    return path
