"""The set-membership filter: predict, then headings, merge, prune, project. A belief goes in and a new belief comes out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Self, get_args

import numpy as np

from filter.arrays import Array, Integers, function, instance, number, settle, shown, whole_number
from filter.errors import Inconsistent, InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import SIDES, Polygon
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.linear.pruning import prune
from filter.linear.solvers import Solver, check_solver, checked_solvers
from filter.measurements import Bearing, Compass, Measurement, Odometry, Range
from filter.projection.budget import Budget, IsOver, never
from filter.projection.polygons_of import Stop
from filter.projection.projector import EXACT
from filter.projection.window import Window
from filter.sensing.motion import Displacements, displacements, turned_headings
from filter.sensing.rows import (
    TANGENT_SPACING,
    bearing_rows,
    on_robots,
    range_rows,
    spans_of_targets,
    world_arcs,
)
from filter.sets.belief import Belief, Source, Sources
from filter.sets.corners import with_corners
from filter.sets.headings import narrowed_headings
from filter.sets.pairs import with_pairs
from filter.sets.refine import Scope, regions_at_a_glance, searched
from filter.sets.rejection import agreeing
from filter.team import Team

Policy = Literal["raise", "reject"]
CORNER_SPACING = np.pi / 36  # [rad]


PHASES = ("predict", "headings", "merge", "prune", "project", "forget")


def _unheard(phase: str) -> None:
    """Let a phase begin."""


@dataclass(frozen=True, eq=False)
class SetMembershipFilter:
    """Keeps a belief about a moving team that contains the truth as long as every declared bound holds.

    Attributes:
        team: The robots, the landmarks and their limits.
        solver: "exact" for exact projections; "piqp", or any solver that qpsolvers has installed, or what makes a
            `Workspace`, for searches.
        stop: When a robot's region is good enough.
        rows_per_robot: How many rows on one robot survive pruning, from 4 on.
        rows_per_pair: How many rows on one pair survive pruning, from 4 on.
        pairs: How many pairs of robots are projected in an update, too, from 0 on: what the team knows of them then survives
            the motion of both. Those just measured come first; pairs without rows come last.
        corner_spacing: Rows are added through the corners of regions and projected pairs, for neighbouring rows to turn by no
            more than this before they are moved, in [0.01, pi/2] [rad]; None for no such rows.
        tangent_spacing: Greatest angle between the tangents that replace the far side of a range, in [0.01, pi/2] [rad];
            a smaller one means smaller regions and more rows.
        scope: "team" for regions from all that the team knows; a `Window` for regions from what each robot would hear.
        policy: What to do when measurements are proved to disagree: "raise", or "reject" the fewest and newest of those
            in conflict that let the rest agree, each one an event of the belief.
        fallbacks: Solvers that are asked in turn where the first one's answers are no good.
        budget: How long an update may take, or None; robots whose turn has not come keep their propagated regions.
        on_phase: Told the name of each phase of a step as it begins, one of PHASES; for whoever wants to take the time.
        threads: How many windows are projected at a time, from 1 on; None for as many as there are cores. The result
            does not depend on it.

    Raises:
        InvalidInput: An attribute is of another type, no such solver is installed, no such policy, a budget is too small, or
            the spacing out of its range.
    """

    team: Team
    solver: Solver = EXACT
    stop: Stop = field(default_factory=Stop)
    rows_per_robot: int = 20
    rows_per_pair: int = 12
    pairs: int = 21
    corner_spacing: float | None = CORNER_SPACING
    tangent_spacing: float = TANGENT_SPACING
    scope: Scope = "team"
    policy: Policy = "raise"
    fallbacks: tuple[Solver, ...] = ("piqp", "highs")
    budget: Budget | None = None
    threads: int | None = None
    on_phase: Callable[[str], object] = _unheard

    def __post_init__(self) -> None:
        instance("team", self.team, Team)
        instance("stop", self.stop, Stop)
        instance("budget", self.budget, Budget, type(None))
        function("on_phase", self.on_phase)
        check_solver(self.solver, [EXACT])
        if not isinstance(self.scope, Window) and not (isinstance(self.scope, str) and self.scope == "team"):
            raise InvalidInput('a scope, "team" or a Window', shown(self.scope))
        if not isinstance(self.policy, str) or self.policy not in get_args(Policy):
            raise InvalidInput(f"a policy among {', '.join(get_args(Policy))}", shown(self.policy))
        corners = self.corner_spacing
        settle(
            self,
            rows_per_robot=whole_number("rows_per_robot", self.rows_per_robot, 4),
            rows_per_pair=whole_number("rows_per_pair", self.rows_per_pair, 4),
            pairs=whole_number("pairs", self.pairs),
            corner_spacing=corners if corners is None else number("corner spacing [rad]", corners, 0.01, np.pi / 2),
            tangent_spacing=number("tangent spacing [rad]", self.tangent_spacing, 0.01, np.pi / 2),
            fallbacks=checked_solvers(self.fallbacks),
            threads=self.threads if self.threads is None else whole_number("threads", self.threads, 1),
        )

    @classmethod
    def light(cls, team: Team, **options: Any) -> Self:
        """Return a filter that takes less along from step to step, for large teams: faster, with regions larger by little.

        Args:
            team: The robots, the landmarks and their limits.
            options: The filter's other attributes, and those of these that are to be different after all.
        """
        return cls(team, **{"rows_per_robot": 12, "rows_per_pair": 8, "pairs": 0, "corner_spacing": None, **options})

    def start(self, time: float, positions: Sequence[Polygon], headings: AngularIntervals | None = None) -> Belief:
        """Return the belief before any measurement.

        Args:
            time: When [s].
            positions: (n) a polygon around each robot; a point anchors it.
            headings: (n) arcs around the headings, or None when nothing is known.

        Raises:
            InvalidInput: Something is no polygon or no arc, the numbers of sets and robots differ, or a set is empty.
        """
        begin, robots = number("time [s]", time), self.team.robots
        polygons, known = self.team.initial(positions, headings)
        corners = np.array([polygon.bounds for polygon in polygons])
        lower, upper = np.maximum(corners[:, 0], self.team.arena[0]), np.minimum(corners[:, 1], self.team.arena[1])
        if (lower > upper).any():
            outside = int(np.flatnonzero((lower > upper).any(axis=1))[0])
            raise InvalidInput("initial polygons that reach into the arena", f"robot {outside} wholly outside")
        sources, numbers = Sources().extended("initial set", begin, np.arange(robots))
        rows = [
            Constraints.on_robot(k, polygon.normals, polygon.offsets, np.full(len(polygon.offsets), numbers[k]))
            for k, polygon in enumerate(polygons)
        ]
        polytope = Polytope(Constraints.concatenate(rows), lower, upper, numbers)
        return Belief(begin, polytope, known, regions_at_a_glance(polytope), sources).compact()

    def predict(self, belief: Belief, time: float, odometry: Odometry | None = None) -> Belief:
        """Return the belief at a later time, after the robots have moved.

        A robot that the odometry does not name can have moved within the team's limits.

        Args:
            belief: Stays as it is.
            time: When [s].
            odometry: The motion from the belief's time to `time`, or None.

        Raises:
            OutOfOrder: `time` is earlier than the belief's, or the odometry starts at another time.
            InvalidInput: The odometry ends at another time, or names an unknown robot.
            Inconsistent: A robot has left the arena for sure.
        """
        self.on_phase("predict")
        self.team.check_belief(belief, Belief, "headings")
        time = self.team.check_motion(belief.time, time, odometry)
        duration = time - belief.time
        moves = displacements(odometry, belief.headings, self.team, duration)
        headings = turned_headings(odometry, belief.headings, self.team, duration)
        lower, upper = self._moved_box(belief, time, moves)
        polytope = Polytope(moves.moved(belief.constraints), lower, upper, belief.polytope.origin)
        return Belief(time, polytope, headings, regions_at_a_glance(polytope), belief.sources).compact()

    def update(self, belief: Belief, measurements: Sequence[Measurement] = ()) -> Belief:
        """Return the belief after merging measurements taken at its time, with every region searched anew.

        Args:
            belief: Stays as it is.
            measurements: Records, in any order: it makes no difference but to arcs wider than half a circle.

        Raises:
            OutOfOrder: A record is of another time than the belief.
            InvalidInput: A record names an unknown robot or landmark.
            Inconsistent: The measurements are proved to exclude one another or what is known; some bound is broken.
                With the policy "reject": and none of these measurements is in the conflict.
        """
        self.on_phase("headings")
        self.team.check_belief(belief, Belief, "headings")
        records = self.team.checked(belief.time, measurements)
        is_over = self.budget.begin() if self.budget else never
        if self.policy == "raise":
            return self._updated(belief, records, is_over)
        return agreeing(lambda kept: self._updated(belief, kept, is_over), records)

    def _updated(self, belief: Belief, measurements: tuple[Measurement, ...], is_over: IsOver) -> Belief:
        self.on_phase("headings")
        sources, numbered = _numbered(belief.sources, measurements)
        headings = narrowed_headings(belief, measurements, self.team.landmarks)
        self.on_phase("merge")
        merged = self._merged(belief.polytope, headings, numbered)
        self.on_phase("prune")
        polytope = self._pruned(merged)
        self.on_phase("project")
        found = searched(
            belief.time,
            polytope,
            sources,
            self.solvers,
            stop=self.stop,
            scope=self.scope,
            is_over=is_over,
            threads=self.threads,
        )
        self.on_phase("forget")
        found = with_pairs(
            belief.time,
            found,
            self.pairs,
            stop=self.stop,
            scope=self.scope,
            is_over=is_over,
            threads=self.threads,
        )
        polytope, sources = self._pruned(found.polytope), found.sources
        if self.corner_spacing is not None:
            polytope, sources = with_corners(belief.time, polytope, sources, found.proofs, self.corner_spacing)
        return Belief(belief.time, polytope, headings, found.regions, sources, found.events, found.proofs).compact()

    @property
    def solvers(self) -> tuple[Solver, ...]:
        """The solver and then its fallbacks."""
        return tuple(dict.fromkeys((self.solver, *self.fallbacks)))

    def _pruned(self, polytope: Polytope) -> Polytope:
        """Prune before a search, for the solver's time, and after it, when regions have become rows."""
        return polytope.with_constraints(prune(polytope, self.rows_per_robot, self.rows_per_pair))

    def _moved_box(self, belief: Belief, time: float, moves: Displacements) -> tuple[Array, Array]:
        robots = np.arange(self.team.robots)
        right, top, left, bottom = (moves.support(robots, np.broadcast_to(side, (len(robots), 2))) for side in SIDES)
        lower = _moved(belief.polytope.lower, -np.stack([left, bottom], axis=1), -np.inf)
        upper = _moved(belief.polytope.upper, np.stack([right, top], axis=1), np.inf)
        lower, upper = np.maximum(lower, self.team.arena[0]), np.minimum(upper, self.team.arena[1])
        outside = np.flatnonzero((lower > upper).any(axis=1))
        if len(outside):
            robot = int(outside[0])
            raise Inconsistent(f"robot {robot} has left the arena by {time} s", [Source("region", belief.time, robot)])
        return lower, upper

    def _merged(self, polytope: Polytope, headings: AngularIntervals, numbered: list[tuple[Measurement, Integers]]) -> Polytope:
        """Add the rows of all bearings, then those of all ranges, whose directions the bearings have narrowed."""
        rows = []
        for record, source in numbered:
            if isinstance(record, Bearing):
                arcs = world_arcs(record, headings[record.robot])
                rows.append(bearing_rows(record.robot, record.target, arcs, source))
        polytope = self._with_rows(polytope, rows)
        rows = []
        for record, source in numbered:
            if isinstance(record, Range):
                arcs = spans_of_targets(polytope, self.team.landmarks, record.robot, record.target)
                rows.append(range_rows(record, arcs, source, self.tangent_spacing))
        return self._with_rows(polytope, rows)

    def _with_rows(self, polytope: Polytope, rows: list[Constraints]) -> Polytope:
        more = [on_robots(each, polytope, self.team.landmarks) for each in rows]
        return polytope.with_constraints(Constraints.concatenate([polytope.constraints, *more]))


def _moved(corner: Array, by: Array, outward: float) -> Array:
    """Return corners moved by so much, rounded outward (an infinity); those that do not move stay as they are."""
    return np.asarray(np.where(by == 0, corner, np.nextafter(corner + by, outward)))


def _numbered(sources: Sources, measurements: Sequence[Measurement]) -> tuple[Sources, list[tuple[Measurement, Integers]]]:
    """Enter the records that make rows into the table; return it and each of these records with its (k,) numbers."""
    numbered: list[tuple[Measurement, Integers]] = []
    for record in measurements:
        if not isinstance(record, Compass):
            kind = "bearing" if isinstance(record, Bearing) else "range"
            sources, numbers = sources.extended(kind, record.time, record.robot, record.target)
            numbered.append((record, numbers))
    return sources, numbered
