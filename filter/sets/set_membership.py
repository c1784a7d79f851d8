"""The set-membership filter: predict, then headings, merge, prune, project. A belief goes in and a new belief comes out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Literal, Self, get_args

import numpy as np

from filter.arrays import Integers, function, instance, number, settle, shown, whole, whole_number
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.many import Polygons
from filter.geometry.polygon import Polygon
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope, prune
from filter.linear.solvers import Solver, checked_solvers
from filter.linear.sources import Sources
from filter.measurements import Measurement, Odometry
from filter.projection.stop import Budget, IsOver, Stop, never
from filter.projection.team import Projector
from filter.projection.window import Window
from filter.sensing.headings import narrowed_headings
from filter.sensing.motion import displacements, turned_headings
from filter.sensing.rows import TANGENT_SPACING
from filter.sets.belief import Belief
from filter.sets.merge import merged, numbered_of
from filter.sets.predict import moved
from filter.sets.refine import refined, with_pairs
from filter.sets.rejection import agreeing
from filter.team import Team

Policy = Literal["raise", "reject"]
PHASES = ("predict", "headings", "merge", "prune", "project", "forget")


def _unheard(phase: str) -> None:
    """Let a phase begin."""


@dataclass(frozen=True, eq=False)
class SetMembershipFilter:
    """Keeps a belief about a moving team that contains the truth as long as every declared bound holds.

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
        tangent_spacing: Greatest angle between the tangents that replace the far side of a range, in [0.01, pi/2] [rad];
            a smaller one means smaller regions and more rows.
        scope: From how much of the team regions are found: all of it, or what each robot would hear.
        policy: What to do when measurements are proved to disagree: "raise", or "reject" the fewest and newest of those
            in conflict that let the rest agree, each one an event of the belief.
        budget: How long an update may take, or None; robots whose turn has not come keep their propagated regions.
        on_phase: Told the name of each phase of a step as it begins, one of PHASES; for whoever wants to take the time.
        threads: How many windows are projected at a time, from 1 on; None for as many as there are cores. The result
            does not depend on it.

    Raises:
        InvalidInput: An attribute is of another type, no such solver is installed, no such policy, too few rows may stay, or
            the spacing is out of its range.
    """

    team: Team
    exact: bool = True
    solvers: tuple[Solver, ...] = ("piqp", "highs")
    stop: Stop = field(default_factory=Stop)
    rows_per_robot: int = 20
    rows_per_pair: int = 12
    pairs: int = 21
    tangent_spacing: float = TANGENT_SPACING
    scope: Window = field(default_factory=Window.everybody)
    policy: Policy = "raise"
    budget: Budget | None = None
    threads: int | None = None
    on_phase: Callable[[str], object] = _unheard

    def __post_init__(self) -> None:
        instance("team", self.team, Team)
        instance("stop", self.stop, Stop)
        instance("scope", self.scope, Window)
        instance("budget", self.budget, Budget, type(None))
        instance("exact", self.exact, bool)
        function("on_phase", self.on_phase)
        if not isinstance(self.policy, str) or self.policy not in get_args(Policy):
            raise InvalidInput(f"a policy among {', '.join(get_args(Policy))}", shown(self.policy))
        settle(
            self,
            solvers=checked_solvers(self.solvers),
            rows_per_robot=whole_number("rows_per_robot", self.rows_per_robot, 4),
            rows_per_pair=whole_number("rows_per_pair", self.rows_per_pair, 4),
            pairs=whole_number("pairs", self.pairs),
            tangent_spacing=number("tangent spacing [rad]", self.tangent_spacing, 0.01, np.pi / 2),
            threads=self.threads if self.threads is None else whole_number("threads", self.threads, 1),
        )

    @classmethod
    def light(cls, team: Team, **options: Any) -> Self:
        """Return a filter that takes less along from step to step, for large teams: faster, with regions larger by little.

        Args:
            team: The robots, the landmarks and their limits.
            options: The filter's other attributes, and those of these that are to be different after all.
        """
        return cls(team, **{"rows_per_robot": 12, "rows_per_pair": 8, "pairs": 0, **options})

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
        return Belief(begin, polytope, known, sources)

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
        polytope, sources = moved(belief, time, moves, self.team.arena)
        return Belief(time, polytope, headings, sources).compact()

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

    def relative(self, belief: Belief, i: Integers, j: Integers) -> Polygons:
        """Return polygons that contain x_j - x_i, where one robot of each of (g) pairs is as seen from the other (eq. 3) [m].

        Args:
            belief: Stays as it is.
            i: (g,) from whom.
            j: (g,) who; another robot.

        Raises:
            InvalidInput: These are no pairs of two robots of the team.
        """
        one, other = whole("robots of pairs", i), whole("robots of pairs", j)
        largest = max(one.max(initial=0), other.max(initial=0))
        if one.ndim != 1 or one.shape != other.shape or (one == other).any() or largest >= self.team.robots:
            raise InvalidInput(f"(g,) robots below {self.team.robots} and (g,) others", f"{one.tolist()} and {other.tolist()}")
        first, second = np.minimum(one, other), np.maximum(one, other)
        seen = self._projector.pairs(belief.polytope, (first, second)).outlines.outer
        return seen.turned_about(one > other)

    def _updated(self, belief: Belief, measurements: tuple[Measurement, ...], is_over: IsOver) -> Belief:
        self.on_phase("headings")
        sources, numbered = numbered_of(belief.sources, measurements)
        headings = narrowed_headings(belief.headings, belief.polytope, measurements, self.team.landmarks)
        self.on_phase("merge")
        known = merged(belief.polytope, headings, numbered, self.team.landmarks, self.tangent_spacing)
        self.on_phase("prune")
        polytope = self._pruned(known)
        self.on_phase("project")
        found = refined(belief.time, polytope, sources, self._projector, is_over=is_over)
        self.on_phase("forget")
        found = with_pairs(belief.time, found, self.pairs, self._projector, is_over=is_over)
        polytope = self._pruned(found.polytope)
        return Belief(belief.time, polytope, headings, found.sources, found.regions, found.events, found.proofs).compact()

    @property
    def _projector(self) -> Projector:
        return Projector(self.scope, self.stop, self.exact, self.solvers, self.threads)

    def _pruned(self, polytope: Polytope) -> Polytope:
        """Prune before a search, for the solver's time, and after it, when regions have become rows."""
        return polytope.with_constraints(prune(polytope, self.rows_per_robot, self.rows_per_pair))
