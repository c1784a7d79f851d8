"""Ties each step of a run to its measurements and to the step before: exact arithmetic, standard library only.

Every row that a certificate rests on has to follow from something: an edge that was proved in this step or in an earlier one
(moved outward by what the robots can have driven since), two such edges that meet in a corner, an initial set, or a
measurement in the log. Boxes likewise, and headings: from those before, turned by odometry, and from compasses and bearings.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from fractions import Fraction
from functools import partial
from math import pi

from experiments.proof.cases.cells import check_cases
from experiments.proof.cases.slices import DIRECTIONS, TakenAlong, check_roots, slices_in
from experiments.proof.cases.votes import Polls, check_votes
from experiments.proof.edges import SIDES, WORLD, add, plane, unit_normal
from experiments.proof.exact import Arc, Vector, are_apart, claimed, in_common
from experiments.proof.given.frame import Frame
from experiments.proof.known import Known
from experiments.proof.line import check
from experiments.proof.measured import of_measurement
from experiments.proof.reading import VERSION, Broken, Record, exact, located, shown
from experiments.proof.sides import looking

Placed = tuple[str, Record]  # a record and its place in words


class Chain(Known):
    """Checks one step after the other."""

    def check(self, headings: Sequence[Placed], lines: Sequence[Placed], frame: Frame | None = None) -> None:
        """Check the next step: its headings, as often as they became narrower, and then its certificates.

        If a frame is given, that is what was heard then, in place of the log's.

        Raises:
            Broken: Something does not follow from anything before it.
        """
        with located(f"step {len(self._history)}"):
            self._begin(frame or self._log.frames[self.frames])
        self.go_on(headings, lines)

    def go_on(self, headings: Sequence[Placed], lines: Sequence[Placed]) -> None:
        """Check, likewise, what else is proved of the last frame."""
        frame, self._is_mine, self._is_torn = self._instants[-1].frame, self._share.has_next(), False
        for place, record in headings:
            with located(place):
                for line in record["lines"]:
                    self.prove(line)
                self._narrow(frame, record)
        self.shown = {}
        for place, line in lines:
            with located(f"{place} (t = {frame.time} s, robot {shown(line.get('robot'))})"):
                self.prove(line)
        if self._is_torn and not self.is_empty:
            raise Broken(f"no case is left of a robot's poses at t = {frame.time} s, and nothing is said to be empty")

    def prove(self, line: Record) -> None:
        """Prove one line in itself, its boxes and its rows, if that is for this process; what it says is known from then on.

        Raises:
            Broken: Something of it is not proved.
        """
        if float(exact(line["t"])) != self._instants[-1].frame.time:
            raise Broken("a line of another time than its frame's")
        if line["version"] != VERSION:
            raise Broken(f"version {shown(line['version'])}, where version {VERSION} is read")
        by_cases = "pieces" in line or "cases" in line
        proved = check(line) if self._is_mine and not by_cases else None
        self._check_boxes(line)
        if self._is_mine:
            self.links["certificates"] += 1
            for row, source in zip(line["rows"], line["sources"], strict=True):
                self._check_row(row, source)
        if "cases" in line:
            self._by_votes(line)
        elif by_cases:
            self._case_by_case(line)
        elif "empty" in line:
            self.is_empty = True
        elif "side" in line:
            self.sides.add(line, proved, self._looking() if proved is not None and "sensors" in line else ())
        else:
            self._claim(line)

    def _looking(self) -> list[Arc]:
        """Return how robots look as far as it is proved without the bearings of this pass; found once for many lines."""
        if self._told[0] != self._looks:
            self._told = list(self._looks), looking(self._instants[-1].frame, self._looks)
        return self._told[1]

    def _case_by_case(self, line: Record) -> None:
        robot = line["robot"]
        if self._is_mine:
            self._check_cases(line)
        for claim in line["claims"]:
            add(self.edges, (WORLD, robot), unit_normal(claim["normal"]), exact(claim["offset"]))
        self._slices[robot] = TakenAlong(line, self.frames - 1)

    def _check_cases(self, line: Record) -> None:
        robot = line["robot"]
        if roots := slices_in(line, "roots"):
            check_roots(roots, self.slices_of(robot))
        left = check_cases(line, self._instants[-1], roots)
        if left is None or are_apart(self._looks[robot], left):
            self._is_torn = True
            return
        self._looks[robot] = in_common(self._looks[robot], [left])
        self.links["robots, case by case"] += 1

    def _by_votes(self, line: Record) -> None:
        if not self.is_voted:
            raise Broken("votes, where the summary says that nothing is tolerated")
        robot, then = line["robot"], replace(self._instants[-1], frame=self._heard)
        polls = Polls.of(line, self._polls.get(robot), then.frame.time, self.frames - 1)
        if self._is_mine:
            check_votes(line, then, polls, partial(self._now, robot))
            self.links["robots, by votes"] += 1
        self._polls[robot] = polls.left
        self._looks[robot] = in_common(self._looks[robot], [claimed(*line["heading"])])
        for normal, far in zip(DIRECTIONS, line["reach"], strict=True):
            add(self.edges, (WORLD, robot), normal, exact(far))
        self.windows.add(line, polls.cast, then.frame.time)

    def _narrow(self, frame: Frame, record: Record) -> None:
        """Check the headings of one record against all that is known so far, and take them over; or that there are none."""
        if "empty" in record:
            if self._is_mine and not (self.is_empty or self._is_torn or self.sides.are_torn(frame, self._looks)):
                raise Broken("headings that agree, where none is said to be left")
            self.is_empty = True
            return
        claims = [claimed(*each) for each in zip(record["centre"], record["bound"], strict=True)]
        if len(claims) != self._log.robots:
            raise Broken(f"headings of {len(claims)} robots, where there are {self._log.robots}")
        if self._is_mine:
            self._check_headings(frame, claims)
        self._instants[-1].headings = claims

    def _check_headings(self, frame: Frame, claims: Sequence[Arc]) -> None:
        left = dict(enumerate(claims))
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

    def _ways(self, frame: Frame) -> Iterator[tuple[str, list[Arc]]]:
        """Yield how robots can look, without the bearings of this pass and with them."""
        now = list(self._looks)
        yield "headings, from odometry, compasses and mates", self._looking()
        yield "headings, from bearings, too", self.sides.looking(frame, now)

    def _claim(self, line: Record) -> None:
        pair, normal, offset = (line["from"], line["robot"]), plane(line["normal"]), exact(line["offset"])
        for edges in (self.edges, self.shown):
            add(edges, pair, normal, offset)

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
                offset = sign * exact(line[side][text][k])
                if self._is_mine and (off := self._needed(robot, (side, k), normal) - offset) > 0:
                    raise Broken(f"the {side} side of robot {robot}'s box lies {float(off):.3g} m too far inside")
                add(self.edges, (WORLD, robot), normal, offset)
            self.links["boxes, from edges, motion and the arena"] += self._is_mine

    def _needed(self, robot: int, side: tuple[str, int], normal: Vector) -> Fraction:
        """Return how far in a direction, along an axis, the box of a robot has to reach."""
        needed = self._begun(robot, normal)
        if needed is None:
            needed = self._proved[-2][WORLD, robot][normal] + self._support(-1, robot, normal)
        limit = self._log.arena[side[0] == "upper"][side[1]]
        needed = needed if limit is None else min(needed, sum(normal) * Fraction(limit))
        return min(needed, self.edges.get((WORLD, robot), {}).get(normal, needed))

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
        link = self._of_edges(pair, normal, offset, self._number(time) if kind in ("region", "cells", "pair") else now - 1)
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


def _degrees(arc: Arc) -> str:
    low, high = (round(float(end) * 180 / pi, 4) for end in (arc.low, arc.high))
    return f"{low} to {high} degrees"
