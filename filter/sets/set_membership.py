"""The strict filter: predict, then headings, merge, prune, project. A belief goes in and a new belief comes out."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from functools import reduce
from typing import Any, Self

import numpy as np

from filter.arrays import Array, Frozen, Integers, checked, function, instance, number, several, whole, whole_number
from filter.errors import Inconsistent, InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.guarantee import Guarantee
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope, prune
from filter.linear.solvers import Solver, checked_solvers
from filter.linear.sources import Sources
from filter.poses.cells import Most
from filter.poses.slices import NARROW_HEADING
from filter.projection.stop import Budget, IsOver, Stop, never
from filter.projection.team import Projector
from filter.projection.window import Window
from filter.records.frame import Frame
from filter.records.measurements import Measurement
from filter.records.odometry import Odometry
from filter.records.presence import Change, Left
from filter.sensing.headings import looks_at_a_glance
from filter.sensing.motion import Displacements, displacements, turned_headings
from filter.sensing.readings import Readings
from filter.sensing.rows import TANGENT_SPACING
from filter.sensing.since import Moves, Since
from filter.sets.belief import Belief, Event, Moved
from filter.sets.conflict import Motion, Premises, conflict_of
from filter.sets.passes import NO_ROBOTS, Merger
from filter.sets.predict import moved, with_robot, without_robot
from filter.sets.proof import After
from filter.sets.refine import refined, with_pairs
from filter.sets.worth import are_smaller, matter
from filter.team import Team

PHASES = ("predict", "headings", "merge", "prune", "project", "forget")


def _unheard(phase: str) -> None: ...


@dataclass(frozen=True, eq=False)
class StrictFilter(Frozen):
    """A `Filter`: keeps a belief about a moving team that contains the truth as long as every declared bound holds.

    What is proved to disagree raises `Inconsistent`. `SetMembershipFilter` is this one, and can go on after that.

    Raises `InvalidInput` if an attribute is of another type or out of its range, or no such solver is installed.

    Attributes:
        team: The robots, the landmarks and their limits.
        exact: Whether to project exactly, by walks over the vertices; otherwise solvers search (section 7 of the paper).
        solvers: They are asked in turn, where a walk is lost or from the first on: "piqp", "highs-simplex", any that qpsolvers
            has installed, or what makes a `Workspace`.
        stop: When a robot's region is good enough.
        rows_per_robot: How many rows on one robot survive pruning, from 4 on.
        rows_per_pair: How many rows on one pair survive pruning, from 4 on.
        pairs: How many pairs of robots are projected in an update, too, from 0 on: what the team knows of them then survives
            the motion of both. Those just measured come first; pairs without rows come last.
        corners: Whether a prediction moves rows through the corners of regions along, too: smaller regions, more rows.
        tangent_spacing: Greatest angle between the tangents that replace the far side of a range, in [0.01, pi/2] [rad];
            a smaller one means smaller regions and more rows.
        cells: Into how many a robot's poses are split at most, where directions or headings are wide for what was measured of
            them (see `filter.poses.cells`); with 0 an update is one pass.
        slices: In how many slices the poses of a wide heading are taken along at most (see `filter.poses.slices`).
        scope: From how much of the team regions are found: all of it, or what each robot would hear.
        budget: How long an update may take, or None; robots whose turn has not come keep their propagated regions.
        on_phase: Told the name of each phase of a step as it begins, one of PHASES; for whoever wants to take the time.
        threads: How many windows are projected at a time, from 1 on; None for as many as there are cores. The result
            does not depend on it.
    """

    team: Team = field(metadata=checked(instance, "team", Team))
    exact: bool = field(default=True, metadata=checked(instance, "exact", bool))
    solvers: tuple[Solver, ...] = field(default=("piqp", "highs"), metadata={"check": checked_solvers})
    stop: Stop = field(default_factory=Stop, metadata=checked(instance, "stop", Stop))
    rows_per_robot: int = field(default=20, metadata=checked(whole_number, "rows_per_robot", 4))
    rows_per_pair: int = field(default=12, metadata=checked(whole_number, "rows_per_pair", 4))
    pairs: int = field(default=21, metadata=checked(whole_number, "pairs"))
    corners: bool = field(default=True, metadata=checked(instance, "corners", bool))
    tangent_spacing: float = field(default=TANGENT_SPACING, metadata=checked(number, "tangent spacing [rad]", 0.01, np.pi / 2))
    cells: int = field(default=64, metadata=checked(whole_number, "cells", 0, 1024))
    slices: int = field(default=12, metadata=checked(whole_number, "slices", 0, 512))
    scope: Window = field(default_factory=Window.everybody, metadata=checked(instance, "scope", Window))
    budget: Budget | None = field(default=None, metadata=checked(instance, "budget", Budget, type(None)))
    threads: int | None = field(default=None, metadata=checked(whole_number, "threads", 1, optional=True))
    on_phase: Callable[[str], object] = field(default=_unheard, metadata=checked(function, "on_phase"))

    @classmethod
    def light(cls, team: Team, **options: Any) -> Self:
        """Return a filter that takes less along from step to step, for large teams: faster, with regions larger by little.

        The options are its other attributes, and those that are to be different after all.
        """
        light = {"rows_per_robot": 12, "rows_per_pair": 8, "pairs": 0, "corners": False, "cells": 20, "slices": 10}
        return cls(team, **light | options)

    def start(self, time: float, positions: Sequence[Polygon | None], headings: AngularIntervals | None = None) -> Belief:
        """Return the belief before any measurement; `InvalidInput` also if a polygon is wholly outside the arena."""
        begin = number("time [s]", time)
        polygons, known = self.team.initial(positions, headings)
        corners = np.array([polygon.bounds for polygon in polygons])
        lower, upper = np.maximum(corners[:, 0], self.team.arena[0]), np.minimum(corners[:, 1], self.team.arena[1])
        outside = np.flatnonzero((lower > upper).any(axis=1))
        if len(outside):
            raise InvalidInput("initial polygons that reach into the arena", f"{self.team.name(outside[0])} wholly outside")
        sources, numbers = Sources().extended("initial set", begin, np.arange(self.team.robots))
        j = np.repeat(numbers, [len(polygon.offsets) for polygon in polygons])
        normals, offsets = (np.concatenate([getattr(each, name) for each in polygons]) for name in ("normals", "offsets"))
        rows = Constraints(np.full(len(j), WORLD), j, normals, offsets, numbers[j])
        return Belief(begin, Polytope(rows, lower, upper, numbers), known, sources, Guarantee.full(self.team.robots))

    def placed(self, belief: Belief, robot: int, polygon: Polygon | None, heading: AngularIntervals | None = None) -> Belief:
        """Return the belief in which a robot is somewhere now, whatever was known of it: it joins, comes back, is put down.

        What is known of the others alone stays. Raises `InvalidInput` if there is no such robot, or no such set in the arena.

        Args:
            belief: What is known.
            robot: Which one.
            polygon: Contains it; None stands for the team's arena.
            heading: One arc that contains its heading, or None when nothing is known.
        """
        self.team.check_belief(belief, Belief, "headings")
        which = whole_number("robot", robot, 0, self.team.robots - 1)
        alone = replace(self, team=Team([self.team.name(which)], arena=self.team.arena)).start(belief.time, [polygon], heading)
        return with_robot(belief, which, alone)

    def changed(self, belief: Belief, change: Change) -> Belief:
        """Return the belief in which a robot is `placed`, or in which one has left.

        Of a robot that is away nothing is said, and measurements by it or of it are refused, until it is placed again. Raises
        `OutOfOrder` if the change is of another time, and `InvalidInput` if there is no such robot or no such set.
        """
        self.team.check_belief(belief, Belief, "headings")
        robot = self.team.checked_change(change, belief.time).robot
        if isinstance(change, Left):
            return without_robot(belief, robot)
        return self.placed(belief, robot, change.polygon, change.heading)

    def predict(self, belief: Belief, time: float, odometry: Odometry | None = None) -> Belief:
        """Return the belief at a later time [s]; raises `Inconsistent`, too, if a robot has left the arena for sure."""
        self.on_phase("predict")
        self.team.check_belief(belief, Belief, "headings")
        time, before = self.team.check_motion(belief.time, time, odometry), replace(belief, moved=None)
        odometry = belief.guarantee.of_those_there(odometry)
        try:
            after = self._predicted(before, (time, odometry), self.team.arena)
        except Inconsistent as error:
            conflict = conflict_of(error, [Premises(before, (time, odometry), (), self.team, self._excludes)])
            raise Inconsistent(error.what, conflict, error.robot) from None
        return replace(after, moved=Moved(before, odometry))

    def update(self, belief: Belief, measurements: Sequence[Measurement] = ()) -> Belief:
        """Return the belief after merging measurements taken at its time, with every region searched anew.

        Their order, and how they are split into records, makes no difference to any bit.

        Raises `Inconsistent` if they are proved to exclude one another or what is known, as some bound is broken.
        """
        self.on_phase("headings")
        self.team.check_belief(belief, Belief, "headings")
        records = self.team.checked(belief.time, measurements, belief.guarantee.away)
        is_over = self.budget.begin() if self.budget else never
        try:
            return self._updated(belief, records, is_over)
        except Inconsistent as error:
            raise self._named(belief, records, error) from None

    def _named(self, belief: Belief, measurements: tuple[Measurement, ...], error: Inconsistent) -> Inconsistent:
        """Return the error of an update that names what is in conflict."""
        cases = [Premises(belief, None, measurements, self.team, self._excludes)]
        if belief.moved:
            motion = belief.time, belief.moved.odometry
            cases.insert(0, Premises(belief.moved.before, motion, measurements, self.team, self._excludes))
        return Inconsistent(error.what, conflict_of(error, cases), error.robot)

    def advance(self, belief: Belief, frames: Sequence[Frame]) -> Belief:
        """Return the belief after several instants, at the last of them: by one prediction and one update.

        It costs about as much as one step, and says nearly as much as one for each. Where a robot is in doubt, of which cells
        would say more, or something is in conflict, it is a step for each, with the events of all. Raises what these raise.
        """
        self.team.check_belief(belief, Belief, "headings")
        steps = several("frames", frames, Frame)
        alike = len(steps) > 1 and not any(frame.changes for frame in steps)
        if alike and (together := self._together(belief, steps)) is not None:
            return together
        events = list[Event]()
        for frame in steps:
            moved = frame.time != belief.time or frame.odometry is not None
            belief = self.predict(belief, frame.time, frame.odometry) if moved else belief
            belief = self.update(reduce(self.changed, frame.changes, belief), frame.measurements)
            events += belief.events
        return replace(belief, events=tuple(events)) if steps else belief

    def _together(self, belief: Belief, frames: Sequence[Frame]) -> Belief | None:
        """Return the belief after several instants; None where a step for each may say more, or what is in conflict."""
        time, records = belief.time, list[Measurement]()
        for frame in frames:
            time = self.team.check_motion(time, frame.time, frame.odometry)
            records += self.team.checked(frame.time, frame.measurements, belief.guarantee.away)
        if belief.guarantee.away:
            frames = [replace(frame, odometry=belief.guarantee.of_those_there(frame.odometry)) for frame in frames]
        since = Since.of(self.team, belief.headings, belief.time, frames)
        readings = Readings.of(time, records, since, self.team.mountings)
        is_over = self.budget.begin() if self.budget else never
        try:
            looks, moves = looks_at_a_glance(since, readings)
            gone = self._gone(belief, (time, self.team.arena), moves, looks[-self.team.robots :])
            gone = replace(gone, slices=belief.slices.through(belief.time, frames, self.team))
            wide_looks = bool((gone.headings.bound > NARROW_HEADING).any())
            last = Readings.of(time, frames[-1].measurements, mountings=self.team.mountings) if wide_looks else None
            found, wide = self._round(gone, readings._replace(moves=moves), is_over, NO_ROBOTS, last=last)
        except Inconsistent:
            return None
        return None if len(wide) else found.compact()

    def _gone(
        self, belief: Belief, until: tuple[float, Array], moves: Displacements | Moves, headings: AngularIntervals
    ) -> Belief:
        """Return the belief after moves until some time [s], within an arena, and headings (n) then."""
        time, arena = until
        polytope, sources = moved(belief, time, moves, arena, self.corners)
        return Belief(time, polytope, headings, sources, belief.guarantee)

    def relative(self, belief: Belief, i: Integers, j: Integers) -> Polygons:
        """Return (g) polygons that contain x_j - x_i of robots i, j (g,) (eq. 3) [m]; `InvalidInput` if these are no pairs."""
        one, other = whole("robots of pairs", i), whole("robots of pairs", j)
        largest = max(one.max(initial=0), other.max(initial=0))
        if one.ndim != 1 or one.shape != other.shape or (one == other).any() or largest >= self.team.robots:
            raise InvalidInput(f"(g,) robots below {self.team.robots} and (g,) others", f"{one.tolist()} and {other.tolist()}")
        pairs = np.minimum(one, other), np.maximum(one, other)
        return self._projector.pairs(belief.polytope, pairs).outlines.outer.turned_about(one > other)

    def _predicted(self, belief: Belief, motion: Motion, arena: Array) -> Belief:
        time, odometry = motion
        duration = time - belief.time
        moves = displacements(odometry, belief.headings, self.team, duration)
        headings = turned_headings(odometry, belief.headings, self.team, duration)
        gone = self._gone(belief, (time, arena), moves, headings)
        return replace(gone, slices=belief.slices.moved(odometry, self.team, duration)).compact()

    def _excludes(self, belief: Belief, motion: Motion | None, arena: Array, measurements: tuple[Measurement, ...]) -> bool:
        """Return whether a belief, after a motion in an arena, is proved to exclude measurements (see `Premises`)."""
        try:
            self._updated(self._predicted(belief, motion, arena) if motion else belief, measurements, never)
        except Inconsistent:
            return True
        return False

    def _updated(self, belief: Belief, measurements: tuple[Measurement, ...], is_over: IsOver) -> Belief:
        """Merge and project; while what cells found of robots makes regions smaller by what rests on it, once more."""
        readings = Readings.of(belief.time, measurements, mountings=self.team.mountings)
        found, again = self._round(belief, readings, is_over, NO_ROBOTS)
        more = readings.tie_robots(self.team.robots) or readings.mountings is not None  # headings tell where sensors are
        while len(again) and more and not is_over():
            areas = found.regions.outer.areas
            if not matter(again, areas):
                break
            start = found.polytope.loosened().within(belief.polytope)
            with After(found.proofs):
                later, again = self._round(replace(found, polytope=start), readings, is_over, again)
            found = replace(later, proofs=found.proofs + later.proofs, events=found.events + later.events)
            if not are_smaller(found.regions.outer.areas, areas):
                break
        return found.compact()

    def _round(
        self, belief: Belief, readings: Readings, is_over: IsOver, again: Integers, *, last: Readings | None = None
    ) -> tuple[Belief, Integers]:
        """Return the belief, and the robots (c,) that are worth cells: they have got them if readings are of one instant."""
        self.on_phase("headings")
        sources, numbers = readings.numbered(belief.sources, self.team.robots)
        self.on_phase("merge")
        rules = self.team.landmarks, self.tangent_spacing, Most(self.cells, self.slices), belief.slices
        merged = Merger(belief.polytope, belief.headings, readings, sources, numbers, *rules, again, last).merged(is_over)
        self.on_phase("prune")
        kept = self._pruned(merged.polytope), merged.headings
        known = Belief(belief.time, *kept, sources, belief.guarantee, proofs=merged.evidence, slices=merged.slices)
        self.on_phase("project")
        found = refined(known, self._projector, is_over=is_over)
        self.on_phase("forget")
        found = with_pairs(found, self.pairs, self._projector, is_over=is_over)
        return replace(found, polytope=self._pruned(found.polytope), proofs=merged.evidence + found.proofs), merged.wide

    @property
    def _projector(self) -> Projector:
        return Projector(self.scope, self.stop, self.exact, self.solvers, self.threads)

    def _pruned(self, polytope: Polytope) -> Polytope:
        """Prune before a search, for the solver's time, and after it, when regions have become rows."""
        return polytope.with_constraints(prune(polytope, self.rows_per_robot, self.rows_per_pair))
