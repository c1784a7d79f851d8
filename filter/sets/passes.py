"""Merges what was measured at one time, until it says nothing more at a glance.

Which rows a bearing makes depends on the heading, and which a range makes on the direction of its target. What the rows say of
positions narrows both. So where a direction is wide there is another pass, from what the pass before has left of each robot's
own polygon. Only the rows of the last pass are kept.
"""

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from filter.arrays import Array, Frozen, Integers
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.linear.sources import Source, Sources
from filter.poses.cells import Cases, Most, Scene, Told
from filter.poses.slices import NARROW_HEADING, Slices
from filter.poses.split import WORTH_A_SLICE
from filter.sensing.arms import Arms
from filter.sensing.headings import narrowed_headings
from filter.sensing.looks import Look, narrowed_by_bearings
from filter.sensing.readings import BEARINGS, RANGES, Readings
from filter.sensing.rows import as_of_now, bearing_rows, on_robots, position_rows, range_rows, spans_of_targets, world_arcs
from filter.sensing.since import Moves
from filter.sets.merged import Directions, Merged
from filter.sets.proof import After
from filter.sets.worth import matter

PASSES = 8  # at most; more than three are seldom worth it
GAIN = 0.98  # another pass is worth it if enough robots' boxes or headings become smaller by this factor
# Another pass may be worth it where the chord of a range is so far inside its circle, in widths of the band of the range,
SAGITTA = 1.0
# or where a bearing would leave this share of a heading.
LEFT_OF_A_HEADING = 0.8
# Cells are worth it where a chord is so far inside, or a heading is wider than several bearings' bounds by this factor (more
# than 1, as a compass is often as good as a bearing, and may say nothing new for minutes); and,
INSIDE, WIDE_HEADING = 0.5, 1.05
# where no more than a share of a robot's box is left, sooner: from these shares on.
NEW, SOON, SOON_HEADING = 0.7, 0.03, 0.1
SMALLEST_BAND = 1e-12  # what is divided by is never smaller [m]
ONE_PASS = Most(0, 0)
NO_ROBOTS = np.zeros(0, dtype=np.int64)


@dataclass(frozen=True, eq=False)
class Merger(Frozen):
    """What is merged, and into what.

    Attributes:
        polytope: Where the team is before.
        headings: (n) the robots' headings before [rad].
        readings: What was measured.
        sources: The belief's table of sources, with those of
        numbers: (b + r + p + n,) bearings, ranges, positions and robots' cells.
        landmarks: (l, 2) [m].
        spacing: Greatest angle between two tangents of a range's far side [rad].
        most: Into how many parts a robot's poses are cut at most; with no cells never, and in one pass.
        slices: Of the poses of robots before.
        again: (c,) robots that were found in cells before, from the same readings.
        last: Of readings of several instants those of the last one, if slices are to be cut by them.
    """

    polytope: Polytope
    headings: AngularIntervals
    readings: Readings
    sources: Sources
    numbers: Integers
    landmarks: Array
    spacing: float
    most: Most = ONE_PASS
    slices: Slices = field(default_factory=Slices.none)
    again: Integers = field(default_factory=lambda: NO_ROBOTS)
    last: Readings | None = None

    def merged(self, is_over: Callable[[], bool] = lambda: False) -> Merged:
        """Return the team's polytope with the rows of positions, bearings and ranges, and the headings.

        Raises `Inconsistent` if what is known and measured of a heading, or of one robot's pose, is proved to have nothing in
        common.
        """
        placed = self._placed()
        sliced = placed._sliced()
        start, evidence = placed, list[Cases]()
        if len(sliced):
            start, cases = start._in_cells(sliced, self.most, is_over)
            evidence.append(cases)
        with After(evidence):
            merged, passes = start._settled(is_over)
        wide = placed._wide(merged, passes[-1], sliced) if self.most.cells else NO_ROBOTS
        others = np.setdiff1d(wide, sliced)
        if self.readings.since is None and len(others) and not is_over():
            with After(evidence):
                start, cases = start._in_cells(others, Most(self.most.cells, 0), is_over)
            evidence.append(cases)
            with After(evidence):
                merged, passes = start._settled(is_over)
        headings = passes[-1].headings
        slices = start.slices.without(np.flatnonzero(headings.bound <= NARROW_HEADING))
        return Merged(merged, headings, slices, (*evidence, *passes), wide)

    def _sliced(self) -> Integers:
        """Return the robots of whose poses there are to be slices: with a wide heading, and something to narrow it by."""
        bearings, ranges = self._now.bearings, self._now.ranges
        if not self.most.taken_along or (self.readings.since is not None and self.last is None):
            return NO_ROBOTS
        heard = np.zeros(len(self.headings) + len(self.landmarks), dtype=bool)
        for each in (bearings.robot, bearings.target, ranges.robot, ranges.target):
            heard[each] = True
        return np.flatnonzero(heard[: len(self.headings)] & (self._looks.bound > NARROW_HEADING))

    @property
    def _now(self) -> Readings:
        """Readings of the last instant."""
        return self.last or self.readings

    @cached_property
    def _looks(self) -> AngularIntervals:
        """(n) headings as far as compasses tell [rad]."""
        with After((self._torn(self.polytope),)):
            return narrowed_headings(self.headings, self._now, AngularIntervals.circles(len(self._now.bearings.robot)))

    def _placed(self) -> "Merger":
        """Return what is merged into what positions leave, as far as compasses and odometry tell where their sensors are.

        Raises `Inconsistent` if some are nowhere: how far sensors are from centres, or motion since, may make room for them.
        """
        if not len(self.readings.positions.robot):
            return self
        farthest = float(np.abs([self.polytope.lower, self.polytope.upper]).max())
        if nowhere := self.readings.placed_nowhere(self._positions.offset, farthest):
            raise Inconsistent(f"at {self.readings.positions.time} s", nowhere)
        with After((self._torn(self.polytope),)):
            look = Look.of_compasses(self.headings, self.readings)
        of_positions = self._centred(self._positions, look)
        rows = Constraints.concatenate([self.polytope.constraints, of_positions])
        return replace(self, polytope=self.polytope.with_constraints(rows))

    def _settled(self, is_over: Callable[[], bool]) -> tuple[Polytope, list[Directions]]:
        """Return the polytope with rows, and what was read in each pass; there are as many as are worth it."""
        known, before, passes = self.polytope, np.full((2, len(self.headings)), np.inf), list[Directions]()
        with After((self._torn(known),)):
            arms = Look.of_compasses(self.headings, self.readings).arms if self.readings.mountings is not None else None
        for _ in range(PASSES if self.most.cells else 1):
            with After(passes):
                merged, read = self._pass(known, arms)
            passes.append(read)
            if not self._may_gain(merged, read) or is_over():
                break
            known, arms = boxed_at_a_glance(replace(merged, lower=known.lower, upper=known.upper)), read.arms
            extent = known.upper - known.lower
            now = np.stack([extent.sum(axis=1), read.headings.bound])
            if not matter(np.flatnonzero((now < GAIN * before).any(axis=0)), extent.prod(axis=1)):
                break
            before = now
        return merged, passes

    def _wide(self, merged: Polytope, read: Directions, sliced: Integers) -> Integers:
        """Return the robots that something is wide of, for what was measured: they are worth cells, or another round.

        Those that are sliced were cut by everything already; of them it has to be new.
        """
        bearings, ranges, robots = self.readings.bearings, self.readings.ranges, len(self.headings)
        worst, by_heading = np.zeros(robots + len(self.landmarks)), np.zeros(robots)
        np.maximum.at(worst, np.concatenate([ranges.robot, ranges.target]), np.tile(self._inside(read), 2))
        several = np.flatnonzero(np.bincount(bearings.robot, minlength=robots)[bearings.robot] >= WORTH_A_SLICE)
        seer, bound = bearings.robot[several], np.maximum(bearings.bound[several], SMALLEST_BAND)
        np.maximum.at(by_heading, seer, read.headings.bound[seer] / bound)
        by_range = worst[:robots]
        if self.readings.since is not None:  # a step for each instant costs more than what is little in doubt is worth
            return np.flatnonzero(by_range > INSIDE)
        suspects = np.flatnonzero((by_range > SOON) | (by_heading > SOON_HEADING))
        if not len(suspects):
            return suspects
        before, now = self.polytope, boxed_at_a_glance(merged)
        is_new = (now.upper - now.lower).sum(axis=1) < NEW * (before.upper - before.lower).sum(axis=1)
        is_new[self.again] = True
        is_wide = (by_range > INSIDE) | (by_heading > WIDE_HEADING)
        is_wide[sliced] = False
        wide = suspects[(is_new | is_wide)[suspects]]
        areas = (now.upper - now.lower).prod(axis=1)
        return wide if matter(wide, areas) else NO_ROBOTS

    def _inside(self, read: Directions) -> Array:
        """Return (r,) how far the chords of ranges are inside their circles, in widths of their bands."""
        least, greatest = self.readings.ranges.interval()
        return np.asarray(least * (1 - np.cos(read.arcs.bound)) / np.maximum(greatest - least, SMALLEST_BAND))

    def _in_cells(self, robots: Integers, most: Most, is_over: Callable[[], bool]) -> tuple["Merger", Cases]:
        """Return what is merged into what cells leave of some robots' poses, and why."""
        headings, now = self._looks, self._now
        told = Told.of(now, headings, self.spacing, Arms.of(now, headings, len(headings)))
        scene = Scene(self.polytope, self.sources, told, self.landmarks, self.slices)
        cases, nowhere = scene.in_cells(robots, most, is_over)
        looks = headings[cases.robot].intersection(cases.headings)  # the hull of cells may have lost a gap that was known
        if nowhere < 0 and looks.empty.any():
            nowhere = int(cases.robot[looks.empty][0])
        if nowhere >= 0:
            time = now.ranges.time
            before = Source("region", time, nowhere), Source("heading", time, nowhere)
            raise Inconsistent(f"at {time} s", [*before, *now.concerning(nowhere)], evidence=(cases, self._torn(self.polytope)))
        numbers = self.numbers[len(self.numbers) - len(headings) :][cases.robot]
        known = self.polytope.with_constraints(Constraints.concatenate([self.polytope.constraints, cases.constraints(numbers)]))
        slices = self.slices.replaced(cases.robot, cases.slices) if most.taken_along else self.slices
        return replace(self, polytope=known, headings=headings.replaced(cases.robot, looks), slices=slices), cases

    def _pass(self, known: Polytope, arms: Arms | None) -> tuple[Polytope, Directions]:
        """Return the polytope with rows, from what is known of the team and of sensors' places, and what of that was read.

        The directions that an earlier pass has made narrow are rows as well: the tangents of an arc do not bound its sides.
        """
        bearings, ranges, count = self.readings.bearings, self.readings.ranges, len(self.readings.bearings.robot)
        with After((self._torn(known, arms),)):
            look = Look.of(self.headings, self.readings, self._spans(known, BEARINGS, (self.readings.moves, arms)))
        ways = world_arcs(bearings, look.sights)
        of_bearings = self._on_robots(bearing_rows(bearings.robot, bearings.target, ways, self.numbers[:count]), look)
        seen = known.with_constraints(Constraints.concatenate([known.constraints, of_bearings]))
        spans, bodies = self._spans(seen, RANGES, (look.moves, look.arms)), len(self.headings) + len(self.landmarks)
        arcs = narrowed_by_bearings(spans, ways, self.readings, bodies)
        numbers = self.numbers[count : count + len(ranges.robot)]
        rows = [self.polytope.constraints, of_bearings, self._on_robots(range_rows(ranges, arcs, numbers, self.spacing), look)]
        if self.readings.mountings is not None:  # where sensors are is known better now
            mounted = self.readings.mountings.spot[self.readings.positions.sensor] > 0
            rows.append(self._centred(self._positions, look).select(mounted))
        if known is not self.polytope:
            rows.append(self._on_robots(bearing_rows(ranges.robot, ranges.target, arcs, numbers), look))
        merged = self.polytope.with_constraints(Constraints.concatenate(rows))
        return merged, Directions(self.readings, self.sources, known, seen, look.headings, arcs, look.moves, look.arms, arms)

    def _torn(self, known: Polytope, arms: Arms | None = None) -> Directions:
        """Return what is read of directions where something is found to be torn, from what is known of the team then."""
        circles = AngularIntervals.circles(len(self.readings.ranges.robot))
        return Directions(self.readings, self.sources, known, known, self.headings, circles, None, arms, arms, is_torn=True)

    def _spans(
        self, known: Polytope, kind: int, apart: tuple[Moves | None, Arms | None], some: Integers | None = None
    ) -> AngularIntervals:
        """Return the directions of targets as readings of a kind saw them, of all or of some (see `spans_of_targets`).

        What lies between their places and where robots are now are moves and arms, as in `Look`.
        """
        bearings, (moves, arms) = self.readings.bearings, apart
        record, at = bearings if kind == BEARINGS else self.readings.ranges, self.readings.at[kind]
        which = np.arange(len(at)) if some is None else some
        robot, target = record.robot[which], record.target[which]
        moved = None if moves is None else moves.between(robot, target, at[which])
        if arms is not None:
            by, radius = arms.between(which if kind == BEARINGS else len(bearings.robot) + which)
            moved = (by, radius) if moved is None else (moved[0] + by, moved[1] + radius)
        return spans_of_targets(known, self.landmarks, robot, target, moved)

    def _on_robots(self, rows: Constraints, look: Look) -> Constraints:
        return self._centred(on_robots(rows, self.polytope, self.landmarks), look)

    @cached_property
    def _positions(self) -> Constraints:
        first, positions = len(self.readings.bearings.robot) + len(self.readings.ranges.robot), self.readings.positions
        return position_rows(positions, self.polytope, self.numbers[first : first + len(positions.robot)])

    def _centred(self, rows: Constraints, look: Look) -> Constraints:
        """Return rows on the places of sensors, when they measured, as rows on where robots are now."""
        first = int(self.numbers[0])
        centred = rows if look.arms is None else look.arms.moved(rows, rows.source - first)
        return as_of_now(centred, self.readings, look.moves, first)

    def _may_gain(self, merged: Polytope, read: Directions) -> bool:
        """Return whether some direction is wide for its range, or some bearing would narrow a heading now."""
        if (self._inside(read) > SAGITTA).any():
            return True
        if self.readings.since is not None:  # that costs more than it is worth
            return False
        bearings = self.readings.bearings
        left = LEFT_OF_A_HEADING * read.headings.bound[bearings.robot] - bearings.bound
        some = np.flatnonzero(left > 0)
        spans = self._spans(merged, BEARINGS, (read.moves, read.arms), some)
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
