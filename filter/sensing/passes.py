"""Merging what was measured at one time, until it says nothing more at a glance.

Which rows a bearing makes depends on the heading, and which a range makes on the direction of its target. What the rows say of
positions narrows both. So where a direction is wide there is another pass, from what the pass before has left of each robot's
own polygon. Only the rows of the last pass are kept.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace

import numpy as np

from filter.arrays import Array, Frozen, Integers
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Source
from filter.sensing.cell import WORTH_A_SLICE
from filter.sensing.cells import ByCases, Told, by_cases
from filter.sensing.headings import narrowed_headings
from filter.sensing.readings import Readings
from filter.sensing.rows import bearing_rows, on_robots, range_rows, spans_of_targets, world_arcs

PASSES = 8  # at most; more than three are seldom worth it
GAIN = 0.98  # another pass is worth it if something becomes smaller by this factor
# Another pass may be worth it where the chord of a range is so far inside its circle, in widths of the band of the range,
SAGITTA = 1.0
# or where a bearing would leave this share of a heading.
LEFT_OF_A_HEADING = 0.8
# Cells are worth it where a chord is so far inside, or a heading is wider than several bearings' bounds by this factor; and,
INSIDE, WIDE_HEADING = 0.5, 1.0
# where no more than a share of a robot's box is left, sooner: from these shares on.
NEW, SOON, SOON_WIDE = 0.7, 0.03, 0.1
TINY = 1e-12  # what is divided by is never smaller [m]


@dataclass(frozen=True, eq=False)
class Merged(Frozen):
    """What came of it.

    Attributes:
        polytope: Where the team is, with the rows of what was measured.
        headings: (n) the robots' headings [rad].
        cases: What was proved case by case.
    """

    polytope: Polytope
    headings: AngularIntervals
    cases: tuple[ByCases, ...] = ()


@dataclass(frozen=True, eq=False)
class Merging(Frozen):
    """What is merged, and into what.

    Attributes:
        polytope: Where the team is before.
        headings: (n) the robots' headings before [rad].
        readings: What was measured.
        numbers: (b + r + n,) the numbers of bearings, of ranges and of robots' cells in the belief's table of sources.
        landmarks: (l, 2) [m].
        spacing: Greatest angle between two tangents of a range's far side [rad].
        cells: Into how many a robot's poses are split at most; 0 for never, and for one pass.
        again: (c,) robots that were found in cells before, from the same readings.
    """

    polytope: Polytope
    headings: AngularIntervals
    readings: Readings
    numbers: Integers
    landmarks: Array
    spacing: float
    cells: int
    again: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def merged(self, is_over: Callable[[], bool] = lambda: False) -> Merged:
        """Return the team's polytope with the rows of bearings and ranges, and the headings.

        Raises `Inconsistent` if what is known and measured of a heading, or of one robot's pose, is proved to have nothing in
        common.
        """
        known, headings, arcs = self._settled(is_over)
        cold = self._cold(known, headings, arcs) if self.cells else self.again
        if not len(cold) or is_over():
            return Merged(known, headings)
        fewer, cases = self._in_cells(cold, is_over)
        known, headings, _ = fewer._settled(is_over)
        return Merged(known, headings, cases)

    def _settled(self, is_over: Callable[[], bool]) -> tuple[Polytope, AngularIntervals, AngularIntervals]:
        """Return the polytope with rows, the headings, and (r) directions of ranges, after as many passes as are worth it."""
        known, before = self.polytope, np.full(0, np.inf)
        for _ in range(PASSES if self.cells else 1):
            merged, headings, arcs = self._pass(known)
            if not self._may_gain(merged, headings, arcs) or is_over():
                break
            known = boxed_at_a_glance(replace(merged, lower=known.lower, upper=known.upper))
            now = np.concatenate([(known.upper - known.lower).sum(axis=1), headings.bound])
            if len(before) and (now >= GAIN * before).all():
                break
            before = now
        return merged, headings, arcs

    def _cold(self, merged: Polytope, headings: AngularIntervals, arcs: AngularIntervals) -> Integers:
        """Return the robots whose poses are worth to be found in cells: something is wide for what was measured."""
        (_, bearings, ranges), (least, greatest), robots = self.readings, self.readings.ranges.interval(), len(headings)
        worst, (who, whom) = np.zeros(robots + len(self.landmarks)), (ranges.robot, ranges.target)
        inside = least * (1 - np.cos(arcs.bound)) / np.maximum(greatest - least, TINY)
        np.maximum.at(worst, np.concatenate([who, whom]), np.tile(inside, 2))
        several = np.flatnonzero(np.bincount(bearings.robot, minlength=robots)[bearings.robot] >= WORTH_A_SLICE)
        wide, seer = np.zeros(robots), bearings.robot[several]
        np.maximum.at(wide, seer, headings.bound[seer] / np.maximum(bearings.bound[several], TINY))
        suspects = np.flatnonzero((worst[:robots] > SOON) | (wide > SOON_WIDE))
        if not len(suspects):
            return suspects
        before, now = self.polytope, boxed_at_a_glance(merged)
        new = (now.upper - now.lower).sum(axis=1) < NEW * (before.upper - before.lower).sum(axis=1)
        new[self.again] = True
        return suspects[(new | (worst[:robots] > INSIDE) | (wide > WIDE_HEADING))[suspects]]

    def _in_cells(self, robots: Integers, is_over: Callable[[], bool]) -> tuple["Merging", tuple[ByCases, ...]]:
        """Return what is merged into what cells leave of some robots' poses, and why."""
        nothing = AngularIntervals.circles(len(self.readings.bearings.robot))
        headings, known, cases = narrowed_headings(self.headings, self.readings, nothing), self.polytope, list[ByCases]()
        told = Told.of(self.readings, headings, self.landmarks, self.spacing)
        numbers = self.numbers[len(self.numbers) - len(headings) :]
        for robot in robots.tolist():
            if is_over():
                break
            case = by_cases(known, headings, told, robot, self.cells)
            if case is None:
                time = self.readings.ranges.time
                before = Source("region", time, robot), Source("heading", time, robot)
                raise Inconsistent(f"at {time} s", [*before, *self.readings.concerning(robot)])
            known = known.with_constraints(Constraints.concatenate([known.constraints, case.constraints(numbers[robot])]))
            headings = headings.replaced(np.array([robot]), AngularIntervals(*case.heading[:, None]))
            cases.append(case)
        return replace(self, polytope=known, headings=headings), tuple(cases)

    def _pass(self, known: Polytope) -> tuple[Polytope, AngularIntervals, AngularIntervals]:
        """Return the polytope with rows, the headings, and the (r) directions of ranges, from what is known of the team.

        The directions that an earlier pass has made narrow are rows as well: the tangents of an arc do not bound its sides.
        """
        (_, bearings, ranges), count = self.readings, len(self.readings.bearings.robot)
        spans = spans_of_targets(known, self.landmarks, bearings.robot, bearings.target)
        headings = narrowed_headings(self.headings, self.readings, spans)
        ways = world_arcs(bearings, headings[bearings.robot])
        of_bearings = self._on_robots(bearing_rows(bearings.robot, bearings.target, ways, self.numbers[:count]))
        seen = known.with_constraints(Constraints.concatenate([known.constraints, of_bearings]))
        arcs = self._with_bearings(spans_of_targets(seen, self.landmarks, ranges.robot, ranges.target), ways)
        numbers = self.numbers[count : count + len(ranges.robot)]
        rows = [self.polytope.constraints, of_bearings, self._on_robots(range_rows(ranges, arcs, numbers, self.spacing))]
        if known is not self.polytope:
            rows.append(self._on_robots(bearing_rows(ranges.robot, ranges.target, arcs, numbers)))
        return self.polytope.with_constraints(Constraints.concatenate(rows)), headings, arcs

    def _on_robots(self, rows: Constraints) -> Constraints:
        return on_robots(rows, self.polytope, self.landmarks)

    def _with_bearings(self, spans: AngularIntervals, ways: AngularIntervals) -> AngularIntervals:
        """Return the directions of the ranges' targets, narrowed by (b) directions of bearings of the same two, from either."""
        (_, bearings, ranges), bodies = self.readings, len(self.headings) + len(self.landmarks)
        if not len(bearings.robot) or not len(ranges.robot):
            return spans
        keys = [
            bodies * np.minimum(each.robot, each.target) + np.maximum(each.robot, each.target) for each in (bearings, ranges)
        ]
        order = np.argsort(keys[0], kind="stable")
        turned = [np.where(each.robot > each.target, np.pi, 0.0) for each in (bearings, ranges)]
        begin, end = (np.searchsorted(keys[0][order], keys[1], side) for side in ("left", "right"))
        return spans.turned(turned[1]).narrowed(begin, end, ways.turned(turned[0])[order]).turned(turned[1])

    def _may_gain(self, merged: Polytope, headings: AngularIntervals, arcs: AngularIntervals) -> bool:
        """Return whether some direction is wide for its range, or some bearing would narrow a heading now."""
        bearings, (least, greatest) = self.readings.bearings, self.readings.ranges.interval()
        if (least * (1 - np.cos(arcs.bound)) > SAGITTA * (greatest - least)).any():
            return True
        left = LEFT_OF_A_HEADING * headings.bound[bearings.robot] - bearings.bound
        some = np.flatnonzero(left > 0)
        spans = spans_of_targets(merged, self.landmarks, bearings.robot[some], bearings.target[some])
        return bool((spans.bound < left[some]).any())


def boxed_at_a_glance(polytope: Polytope) -> Polytope:
    """Return a polytope with a box around what each robot's own rows leave of its box; where that is nothing, as it was."""
    clipped = polytope.of_robots(np.arange(len(polytope.lower)))
    outlines, begin = clipped.polygons, clipped.polygons.first[:-1]
    lower = np.minimum.reduceat(outlines.vertices, begin) - outlines.margin[:, None]
    upper = np.maximum.reduceat(outlines.vertices, begin) + outlines.margin[:, None]
    empty = clipped.empty[:, None]
    lower = np.where(empty, polytope.lower, np.maximum(lower, polytope.lower))
    upper = np.where(empty, polytope.upper, np.minimum(upper, polytope.upper))
    return replace(polytope, lower=np.minimum(lower, upper), upper=upper)
