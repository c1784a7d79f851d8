"""Ties each step of a run to its measurements and to the step before: exact arithmetic, standard library only.

Every row that a certificate rests on has to follow from something: an edge that was proved in this step or in an earlier one
(moved outward by what the robots can have driven since), two such edges that meet in a corner, an initial set, or a
measurement in the log. Boxes likewise, and headings: from those before, turned by odometry, and from compasses and bearings.
"""

from collections import Counter
from collections.abc import Iterator, Sequence
from copy import copy
from fractions import Fraction
from math import pi

from experiments.proof.cases.cells import check_cases
from experiments.proof.cases.slices import Slice, check_roots, slices_in
from experiments.proof.edges import SIDES, WORLD, Edges, add, all_edges, plane, through_corner, unit_normal
from experiments.proof.exact import Arc, Vector, arc_around, are_apart, in_common
from experiments.proof.given.frame import Frame
from experiments.proof.given.log import Log
from experiments.proof.line import check
from experiments.proof.measured import Instant, of_measurement
from experiments.proof.motion import Displaced, turned
from experiments.proof.reading import VERSION, Broken, Record, exact, located, shown
from experiments.proof.sides import Sides, looking

Placed = tuple[str, Record]  # a record and its place in words


class Chain:
    """Checks one step after the other.

    Attributes:
        links: How many links of each kind there were, all of them proved.
        is_empty: Whether it was proved in the last step that nothing is possible.
        shown: What the last step's certificates have proved of each robot and pair, after all that its headings rest on.
    """

    def __init__(self, log: Log) -> None:
        self.links: Counter[str] = Counter()
        self.is_empty = False
        self.shown: Edges = {}
        self._log = log
        self._numbers = {frame.time: number for number, frame in enumerate(log.frames)}
        self._placed = [0] * log.robots  # at which frame each robot was put somewhere: nothing from before counts
        self._ended: list[tuple[list[int], dict[int, list[Slice]]]] = []  # that, and slices, when each frame began
        self._history: list[list[Displaced]] = []  # by frames, as are the next two
        self._proved: list[Edges] = []
        self._instants: list[Instant] = []
        self._grown: dict[tuple[int, int, Vector, int], tuple[int, Fraction]] = {}  # up to which frame, and by how much
        self._seen: set[str] = set()
        self._slices: dict[int, list[Slice]] = {}  # of robots, as proved so far
        self._looks: list[Arc] = []  # what is proved of the headings, which can be more than is claimed
        self._told: tuple[list[Arc], list[Arc]] = [], []  # these, and what is left of them by what `_looking` takes

    @property
    def frames(self) -> int:
        """How many frames there were."""
        return len(self._history)

    def branch(self, frames: int) -> "Chain":
        """Return one that goes on after so many frames; of what came later it knows nothing. Links are counted together."""
        other, is_now = copy(self), frames == self.frames
        other._history, other._proved, other._instants = self._history[:frames], self._proved[:frames], self._instants[:frames]
        if not is_now:
            other._placed, other._slices = self._ended[frames]
        other._ended, other._grown = self._ended[:frames], dict(self._grown) if is_now else {}
        return other

    def begun(self, headings: Sequence[Arc], edges: Edges) -> "Chain":
        """Return one of which at the last frame that is known, and nothing else."""
        other, now = self.branch(self.frames), self.frames - 1
        nothing = Frame(self._instants[now].frame.time)
        other._instants[now] = Instant(self._log, nothing, headings, Sides(self._log.robots, self._log.landmarks), edges)
        other._proved[now], other.shown, other._slices, other._placed = edges, edges, {}, [now] * self._log.robots
        return other

    @property
    def headings(self) -> Sequence[Arc]:
        """What has been proved of the robots' headings in this step so far."""
        return self._instants[-1].headings

    @property
    def sides(self) -> Sides:
        """Where targets are, as far as that has been proved in this step."""
        return self._instants[-1].sides

    @property
    def edges(self) -> Edges:
        """What has been proved of each robot and pair in this step so far."""
        return self._proved[-1]

    def check(self, headings: Sequence[Placed], lines: Sequence[Placed], frame: Frame | None = None) -> None:
        """Check the next step: its headings, as often as they became narrower, and then its certificates.

        If a frame is given, that is what was heard then, in place of the log's.

        Raises:
            Broken: Something does not follow from anything before it.
        """
        with located(f"step {len(self._history)}"):
            frame = self._begin(frame or self._log.frames[self.frames])
        for place, record in headings:
            with located(place):
                for line in record["lines"]:
                    self.prove(line)
                self._narrow(frame, record)
        self.shown = {}
        for place, line in lines:
            with located(f"{place} (t = {frame.time} s, robot {shown(line.get('robot'))})"):
                self.prove(line)

    def prove(self, line: Record) -> None:
        """Prove one line in itself, its boxes and its rows; what it says is known from then on.

        Raises:
            Broken: Something of it is not proved.
        """
        self.links["certificates"] += 1
        if float(exact(line["t"])) != self._instants[-1].frame.time:
            raise Broken("a line of another time than its frame's")
        if line["version"] != VERSION:
            raise Broken(f"version {shown(line['version'])}, where version {VERSION} is read")
        proved = check(line) if "pieces" not in line else None
        self._check_boxes(line)
        for row, source in zip(line["rows"], line["sources"], strict=True):
            self._check_row(row, source)
        if proved is None:
            self._case_by_case(line)
        elif "empty" in line:
            self.is_empty = True
        elif "side" in line:
            self.sides.add(line, proved, self._looking() if "sensors" in line else ())
        else:
            self._claim(line)

    def _looking(self) -> list[Arc]:
        """Return how robots look as far as it is proved without the bearings of this pass; found once for many lines."""
        if self._told[0] != self._looks:
            self._told = list(self._looks), looking(self._instants[-1].frame, self._looks)
        return self._told[1]

    def _case_by_case(self, line: Record) -> None:
        robot = line["robot"]
        if roots := slices_in(line, "roots"):
            check_roots(roots, self._slices.get(robot, ()))
        left = check_cases(line, self._instants[-1])
        if left is None or are_apart(self._looks[robot], left):
            self.is_empty = True
            return
        self._looks[robot] = in_common(self._looks[robot], [left])
        for claim in line["claims"]:
            add(self.edges, (WORLD, robot), unit_normal(claim["normal"]), exact(claim["offset"]))
        self._slices[robot] = slices_in(line, "slices")
        self.links["robots, case by case"] += 1

    def _begin(self, frame: Frame) -> Frame:
        log, number = self._log, self.frames
        self._ended.append(([*self._placed], self._slices))
        self._placed, self.is_empty = [*self._placed], False
        before = self.headings if number else [start.heading for start in log.starts]
        driven = list(zip(frame.pieces, before, strict=True))
        self._history.append([Displaced.of(*each) for each in driven] if any(frame.pieces) else [])
        self._proved.append({})
        looks, sides = [turned(*each) for each in driven], Sides(log.robots, log.landmarks, log.mounts)
        self._slices = {
            robot: [each.moved(frame.pieces[robot]) for each in slices]
            for robot, slices in self._slices.items()
            if robot not in frame.placed
        }
        for robot, start in frame.placed.items():
            looks[robot], self._placed[robot] = start.heading, number
        self._instants.append(Instant(log, frame, looks, sides, self.edges))
        self._seen, self._looks, self._told = set(), list(self.headings), ([], [])
        return frame

    def _narrow(self, frame: Frame, record: Record) -> None:
        """Check the headings of one record against all that is known so far, and take them over; or that there are none."""
        if "empty" in record:
            self.is_empty = self.is_empty or self.sides.are_torn(frame, self._looks)
            if not self.is_empty:
                raise Broken("headings that agree, where none is said to be left")
            return
        claimed = [
            arc_around(float(exact(centre)), float(exact(bound)))
            for centre, bound in zip(record["centre"], record["bound"], strict=True)
        ]
        if len(claimed) != self._log.robots:
            raise Broken(f"headings of {len(claimed)} robots, where there are {self._log.robots}")
        left = dict(enumerate(claimed))
        for link, looks in self._ways(frame):
            for robot in [robot for robot, claim in left.items() if claim.covers(looks[robot])]:
                self._looks[robot] = looks[robot]
                self.links[link] += 1
                del left[robot]
            if not left:
                break
        for robot, claim in left.items():
            told = f"{_degrees(claim)} is claimed, {_degrees(looks[robot])} proved"
            raise Broken(f"the heading of robot {robot} is not proved: {told}")
        self._instants[-1].headings = claimed

    def _ways(self, frame: Frame) -> Iterator[tuple[str, list[Arc]]]:
        """Yield how robots can look, without the bearings of this pass and with them."""
        now = list(self._looks)
        yield "headings, from odometry, compasses and mates", self._looking()
        yield "headings, from bearings, too", self.sides.looking(frame, now)

    def _claim(self, line: Record) -> None:
        pair, normal, offset = (line["from"], line["robot"]), plane(line["normal"]), exact(line["offset"])
        for edges in (self.edges, self.shown):
            add(edges, pair, normal, offset)

    def _support(self, number: int, body: int, normal: Vector) -> Fraction:
        motions = self._history[number]
        return motions[body].support(normal) if motions else Fraction(0)

    def _check_boxes(self, line: Record) -> None:
        """Check the box of every robot that a line names: moved with it, or where it was put, cut by edges and the arena."""
        for text in line["upper"]:
            if (key := str((text, line["lower"][text], line["upper"][text]))) in self._seen:
                continue
            if not 0 <= (robot := int(text)) < self._log.robots:
                raise Broken(f"the box of a robot {text} that there is not")
            self._seen.add(key)
            for side, k, direction in SIDES:
                sign, normal = (1 if side == "upper" else -1), plane(direction)
                needed = self._begun(robot, normal)
                if needed is None:
                    needed = self._proved[-2][WORLD, robot][normal] + self._support(-1, robot, normal)
                limit = self._log.arena[side == "upper"][k]
                needed = needed if limit is None else min(needed, sign * Fraction(limit))
                needed = min(needed, self.edges.get((WORLD, robot), {}).get(normal, needed))
                offset = sign * exact(line[side][text][k])
                if offset < needed:
                    raise Broken(f"the {side} side of robot {robot}'s box lies {float(needed - offset):.3g} m too far inside")
                add(self.edges, (WORLD, robot), normal, offset)
            self.links["boxes, from edges, motion and the arena"] += 1

    def _begun(self, robot: int, normal: Vector) -> Fraction | None:
        """Return how far in a direction a robot can be that was put somewhere, at the start or now; None if it was not."""
        if start := self._instants[-1].frame.placed.get(robot):
            return start.place.most(normal)
        if len(self._proved) > 1:
            return None
        return self._log.starts[robot].place.most(normal) + self._support(0, robot, normal)

    def _check_row(self, row: Record, source: Record) -> None:
        if (key := str((row["i"], row["j"], row["normal"], row["offset"], source))) in self._seen:
            return
        self._seen.add(key)
        offset, normal, pair = exact(row["offset"]), unit_normal(row["normal"]), (row["i"], row["j"])
        now, kind, time = len(self._proved) - 1, source["kind"], float(exact(source["t"]))
        link = self._of_edges(pair, normal, offset, self._number(time) if kind in ("region", "cells") else now - 1)
        if link is None and row["i"] < 0:
            start = self._begun(row["j"], normal)
            link = "rows of initial sets" if start is not None and start <= offset else None
        if link is None and kind in ("bearing", "range", "position"):
            taken = self._number(time)
            grown = self._growth((*pair, normal, taken))
            link = None if grown is None else of_measurement(self._instants[taken], pair, source, normal, offset - grown)
        if link is None:
            raise Broken(f"a row on {shown(pair)} follows from nothing known; it says it is of {shown(source)}")
        self.links[link] += 1

    def _number(self, time: float) -> int:
        """Return the number of the frame of a time [s]."""
        number = self._numbers.get(time, len(self._proved))
        if number >= len(self._proved):
            raise Broken(f"a row of t = {time} s, which is no frame so far")
        return number

    def _of_edges(self, pair: tuple[int, int], normal: Vector, offset: Fraction, taken: int) -> str | None:
        """Return why a row holds, if it is an edge proved in this step or in one before, or goes through a corner."""
        edge = self.edges.get(pair, {}).get(normal)
        if edge is not None and edge <= offset:
            return "rows that are edges proved in the same step"
        before = self._proved[taken] if taken >= 0 else {}
        grown = self._growth((*pair, normal, taken)) if pair in before else None
        if grown is None:
            return None
        then = offset - grown
        edge = before[pair].get(normal)
        if edge is not None and edge <= then:
            return "rows that are edges of an earlier step, moved"
        corner = through_corner(all_edges(before, pair), normal, then)
        return "rows through corners of an earlier step, moved" if corner is not None and corner <= then else None

    def _growth(self, row: tuple[int, int, Vector, int]) -> Fraction | None:
        """Return how much a row has moved outward since the frame that it was measured or proved at.

        None if one of its robots was put somewhere since: of where it is now the row says nothing.
        """
        i, j, normal, taken = row
        if taken < max(self._placed[body] for body in (i, j) if body >= 0):
            return None
        number, total = self._grown.get(row, (taken, Fraction(0)))
        back = (-normal[0], -normal[1])
        for later in range(number + 1, len(self._history)):
            total += self._support(later, j, normal) + (self._support(later, i, back) if i >= 0 else 0)
        self._grown[row] = len(self._history) - 1, total
        return total


def _degrees(arc: Arc) -> str:
    low, high = (round(float(end) * 180 / pi, 4) for end in (arc.low, arc.high))
    return f"{low} to {high} degrees"
