"""Ties each step of a run to its measurements and to the step before: exact arithmetic, standard library only.

Every row that a certificate rests on has to follow from something: an edge that was proved in this step or in an earlier one
(moved outward by what the robots can have driven since), two such edges that meet in a corner, an initial set, or a
measurement in the log. Boxes likewise. What is taken on trust is counted: headings narrowed by bearings, and near sides of
ranges over arcs narrower than one bearing's own.
"""

from collections import Counter
from fractions import Fraction
from math import atan2, pi
from pathlib import Path
from typing import Any

from experiments.proof.exact import PI, PI_ROUNDING, Motion, Vector, length
from experiments.proof.log import Log, compass

SIDES = (("upper", 0, (1, 0)), ("upper", 1, (0, 1)), ("lower", 0, (-1, 0)), ("lower", 1, (0, -1)))
WORLD = -1
NEIGHBOURS = 3  # edges to either side of a normal that are tried for the corner it goes through
Record = dict[str, Any]
Edges = dict[tuple[int, int], dict[Vector, Fraction]]  # of each robot (WORLD, j) or pair i, j: offsets by normals


class Broken(Exception):
    """Something is not proved."""


class Chain:
    """Checks one step after the other. Without log and headings beside the certificates it says so, and checks nothing.

    Attributes:
        links: How many links of each kind there were; those whose name begins with "on trust" are not proved.
    """

    def __init__(self, folder: Path) -> None:
        self.links: Counter[str] = Counter()
        there = all((folder / name).exists() for name in ("log.jsonl", "headings.jsonl.gz"))
        self._log = Log(folder) if there else None
        self._since: float | None = None
        self._history: list[list[Motion] | None] = []  # by the log's frames
        self._proved: dict[float | None, Edges] = {}  # what was proved at each time of each robot or pair
        self._now: Edges = {}  # and so far in this step
        self._grown: dict[tuple[Any, ...], tuple[int, Fraction]] = {}  # up to which frame, and by how much
        self._seen: set[str] = set()

    def report(self) -> list[str]:
        """Return what has been proved and what has been taken on trust, in words."""
        if self._log is None:
            return ["on trust: where the rows come from; there is no log.jsonl with headings.jsonl.gz beside the certificates"]
        return [f"{count:8d} {name}" for name, count in sorted(self.links.items())]

    def check(self, step: list[Record]) -> None:
        """Check the rows and the boxes of one step's certificates, each of them proved in itself.

        Raises:
            Broken: A row or a box does not follow from anything before it.
        """
        if self._log is None:
            return
        time = float.fromhex(step[0]["t"])
        frame = len(self._history)
        if self._log.times[frame : frame + 1] != [time]:
            raise Broken(f"t = {time} s: the log has another frame there")
        self._history.append(self._log.motions(self._since, time))
        self._now, self._seen = {}, set()
        self._proved[time] = self._now
        for line in step:
            try:
                self._check_boxes(self._log, line)
                for row, source in zip(line["rows"], line["sources"], strict=True):
                    self._check_row(self._log, row, source)
            except (Broken, KeyError, IndexError, TypeError, ValueError, OverflowError) as error:
                raise Broken(f"t = {time} s, an edge of robot {line['robot']}: {error}") from None
            self._claim((line["from"], line["robot"]), plane(line["normal"]), exact(line["offset"]))
        self._close(self._log, time)

    def _close(self, log: Log, time: float) -> None:
        for robot in range(log.header["robots"]):
            self.links[_heading_link(log, robot, self._since, time)] += 1
        self._since = time

    def _claim(self, pair: tuple[int, int], normal: Vector, offset: Fraction) -> None:
        edges = self._now.setdefault(pair, {})
        edges[normal] = min(offset, edges.get(normal, offset))

    def _support(self, frame: int, body: int, normal: Vector) -> Fraction:
        motions = self._history[frame]
        return motions[body].support(normal) if motions else Fraction(0)

    def _check_boxes(self, log: Log, line: Record) -> None:
        """Check the box of every robot that a line names: moved with the robot, cut by the last step's edges and the arena."""
        for body in line["upper"]:
            if (key := str((body, line["lower"][body], line["upper"][body]))) in self._seen:
                continue
            if not 0 <= int(body) < log.header["robots"]:
                raise Broken(f"the box of a robot {body} that there is not")
            self._seen.add(key)
            for side, k, direction in SIDES:
                sign, robot, normal = (1 if side == "upper" else -1), int(body), plane(direction)
                if self._since is None:
                    before = max(sign * corner[k] for corner in log.vertices[robot])
                else:
                    before = self._proved[self._since][WORLD, robot][normal]
                needed = before + self._support(-1, robot, normal)
                limit = log.header["arena"][side == "upper"][k]
                needed = needed if limit is None else min(needed, sign * Fraction(limit))
                needed = min(needed, self._now.get((WORLD, robot), {}).get(normal, needed))
                offset = sign * exact(line[side][body][k])
                if offset < needed:
                    raise Broken(f"the {side} side of robot {body}'s box lies {float(needed - offset):.3g} m too far inside")
                self._claim((WORLD, robot), normal, offset)
            self.links["boxes, from edges, motion and the arena"] += 1

    def _check_row(self, log: Log, row: Record, source: Record) -> None:
        if (key := str((row["i"], row["j"], row["normal"], row["offset"], source))) in self._seen:
            return
        self._seen.add(key)
        offset, normal = exact(row["offset"]), plane(row["normal"])
        pair, taken = (row["i"], row["j"]), float.fromhex(source["t"])
        link = self._of_edges(log, pair, normal, offset, taken if source["kind"] == "region" else self._since)
        if link is None and row["i"] < 0 and self._since is None:
            start = max(normal[0] * x + normal[1] * y for x, y in log.vertices[row["j"]])
            link = "rows of initial sets" if start + self._support(-1, row["j"], normal) <= offset else None
        if link is None and source["kind"] in ("bearing", "range"):
            link = of_measurement(log, row, source, offset - self._growth(log, (*pair, normal, taken)))
        if link is None:
            raise Broken(f"a row on {row['i']}, {row['j']} follows from nothing known; it says it is of {source}")
        self.links[link] += 1

    def _of_edges(self, log: Log, pair: tuple[int, int], normal: Vector, offset: Fraction, taken: float | None) -> str | None:
        """Return why a row holds, if it is an edge proved in this step or at a time before, or goes through a corner."""
        edge = self._now.get(pair, {}).get(normal)
        if edge is not None and edge <= offset:
            return "rows that are edges proved in the same step"
        before = self._proved.get(taken, {}) if taken is not None else {}
        if taken is None or pair not in before:
            return None
        then = offset - self._growth(log, (*pair, normal, taken))
        edge = before[pair].get(normal)
        if edge is not None and edge <= then:
            return "rows that are edges of an earlier step, moved"
        corner = through_corner(all_edges(before, pair), normal)
        return "rows through corners of an earlier step, moved" if corner is not None and corner <= then else None

    def _growth(self, log: Log, row: tuple[int, int, Vector, float]) -> Fraction:
        """Return how much a row has moved outward since it was measured or proved."""
        i, j, normal, taken = row
        frame, total = self._grown.get(row, (log.times.index(taken), Fraction(0)))
        back = (-normal[0], -normal[1])
        for later in range(frame + 1, len(self._history)):
            total += self._support(later, j, normal) + (self._support(later, i, back) if i >= 0 else 0)
        self._grown[row] = len(self._history) - 1, total
        return total


def all_edges(proved: Edges, pair: tuple[int, int]) -> dict[Vector, Fraction]:
    """Return what was proved of a robot, or of a pair with what the two boxes say of it."""
    edges, (i, j) = dict(proved[pair]), pair
    for _, _, direction in SIDES if i != WORLD else ():
        normal, back = plane(direction), plane((-direction[0], -direction[1]))
        if normal in proved.get((WORLD, j), {}) and back in proved.get((WORLD, i), {}):
            side = proved[WORLD, j][normal] + proved[WORLD, i][back]
            edges[normal] = min(side, edges.get(normal, side))
    return edges


def through_corner(edges: dict[Vector, Fraction], normal: Vector) -> Fraction | None:
    """Return the least offset in a direction that two edges prove, one to either side of it; None if there are no such two."""
    angle = atan2(normal[1], normal[0])
    turn = {edge: (atan2(edge[1], edge[0]) - angle) % (2 * pi) for edge in edges}
    order, found = sorted(edges, key=lambda edge: turn[edge]), []
    for a in order[-NEIGHBOURS:]:
        for b in order[:NEIGHBOURS]:
            turned = across(a, b)
            weights = (across(normal, b), across(a, normal)) if turned > 0 else (Fraction(-1),) * 2
            if min(weights) >= 0:
                found.append((weights[0] * edges[a] + weights[1] * edges[b]) / turned)
    return min(found, default=None)


def across(a: Vector, b: Vector) -> Fraction:
    """Return the cross product of two vectors."""
    return a[0] * b[1] - a[1] * b[0]


def of_measurement(log: Log, row: Record, source: Record, offset: Fraction) -> str | None:
    """Return why a row holds with an offset at the time of its measurement, or None if it does not."""
    time, robot, target, mates = float.fromhex(source["t"]), source["robot"], source["target"], log.header["robots"]
    x, y = plane(row["normal"])
    if row["i"] < 0 and target is not None and target >= mates and robot == row["j"]:
        mark = [Fraction(value) for value in log.header["landmarks"][target - mates]]
        x, y, offset = -x, -y, offset - (x * mark[0] + y * mark[1])  # of the landmark, seen from the robot
    elif (robot, target) == (row["j"], row["i"]):
        x, y = -x, -y
    elif (robot, target) != (row["i"], row["j"]):
        return None
    for reading in log.readings(time, source["kind"], robot, target):
        if source["kind"] == "bearing":
            arc = log.headings[time][robot].widened(reading["bearing"], reading["bound"])
            if arc.narrow and arc.most((x, y)) <= 0 <= offset:
                return "rows of bearings, from the log"
        elif link := _of_range(log, source, reading, (x, y), offset):
            return link
    return None


def _of_range(log: Log, source: Record, reading: dict[str, Fraction], normal: Vector, offset: Fraction) -> str | None:
    time, robot, target = float.fromhex(source["t"]), source["robot"], source["target"]
    value, bound, share = reading["range"], reading["bound"], reading["relative_bound"]
    if offset >= (value + bound) / (1 - share) * length(normal):
        return "rows of ranges, far side, from the log"
    least = max(Fraction(0), (value - bound) / (1 + share))
    seen = [(normal, robot, one) for one in log.readings(time, "bearing", robot, target)]
    if target < log.header["robots"]:
        seen += [((-normal[0], -normal[1]), target, one) for one in log.readings(time, "bearing", target, robot)]
    for way, who, one in seen:
        arc = log.headings[time][who].widened(one["bearing"], one["bound"])
        if arc.narrow and arc.most(way) <= 0 and offset >= least * arc.most(way):
            return "rows of ranges, near side, from the log"
    # No near side is farther than the range itself; up to there its arc, of all that is known of the pair, is believed.
    return "on trust: rows of ranges, near side, over a narrower arc" if offset >= -least * length(normal) else None


def _heading_link(log: Log, robot: int, since: float | None, time: float) -> str:
    """Return whether odometry and compasses alone explain a heading interval."""
    claimed = log.headings[time][robot]
    least, greatest = [], []
    compasses = [compass(one) for one in log.readings(time, "compass", robot, None)]
    for arc in (log.turned(robot, since, time), *compasses):
        if arc.narrow:
            turns = round((claimed.low + claimed.high - arc.low - arc.high) / (4 * PI))
            least.append(arc.low + 2 * turns * PI - 2 * abs(turns) * PI_ROUNDING)
            greatest.append(arc.high + 2 * turns * PI + 2 * abs(turns) * PI_ROUNDING)
    whole = claimed.high - claimed.low > 2 * (PI + PI_ROUNDING)
    if whole or (least and claimed.low <= max(least) and min(greatest) <= claimed.high):
        return "headings, from odometry and compasses"
    return "on trust: headings that bearings have narrowed"


def exact(text: str) -> Fraction:
    """Return the number that a C99 hexadecimal string says, without rounding."""
    return Fraction(float.fromhex(text))


def plane(normal: list[str] | tuple[int, int]) -> Vector:
    """Return a normal as exact numbers."""
    x, y = (exact(value) if isinstance(value, str) else Fraction(value) for value in normal)
    return x, y
