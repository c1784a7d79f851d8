"""Random formations of robots that stand and see their near neighbours: the setting of the paper's section 8.

Bearings only, in a known common frame, each within its robot's bound. One robot is the reference, anchored at the origin; one
coordinate of another fixes the scale. A draw that this does not bound (a robot seen by one neighbour alone can be anywhere
along a ray) has no finite regions, and is drawn anew.
"""

from __future__ import annotations

from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from experiments.paper.merge_orders import StaticCase, places
from experiments.paper.reference import Unbounded, bounded_box
from filter import Bearing
from filter.arrays import Array, Floats, Integers, finite, read_only, whole
from filter.errors import InvalidInput
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.linear.polytope import Polytope
from filter.linear.program import LinearProgram
from filter.linear.solvers import Workspace, deepest_point, workspace
from filter.projection.proved import Projection
from filter.projection.search import project
from filter.projection.stop import Budget, Stop, never
from filter.sensing.rows import bearing_rows, on_robots, world_arcs

SPACING = 2.0  # a formation's square has room for one robot in each square of this side [m]
APART = 1.0  # least distance between two robots [m]
SIGHT = 1.6 * SPACING  # robots that are nearer see one another [m]
INSIDE = 1 - 1e-9  # errors keep their bounds when floats are rounded
LEAST_BOUND = 1e-6  # of a bearing [rad]
DRAWS = 1000  # of formations, before drawing is given up
NOWHERE = np.zeros((0, 2))  # no landmark


@dataclass(frozen=True, eq=False)
class Formation:
    """Robots that stand, and the bearings they measured of their neighbours.

    Attributes:
        positions: (n, 2) where they are [m].
        headings: (n,) their headings, known [rad].
        bearings: All bearings, in the robots' own frames.
        redrawn: How many draws before this one were unbounded.
    """

    positions: Array
    headings: Array
    bearings: Bearing
    redrawn: int = 0

    def __post_init__(self) -> None:
        for name in ("positions", "headings"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    def __len__(self) -> int:
        return len(self.positions)

    def neighbours(self, robot: int) -> list[int]:
        """Return the robots that one sees, in the order of their numbers."""
        return sorted(self.bearings.target[self.bearings.robot == robot].tolist())

    def seen_from(self, robot: int) -> Formation:
        """Return the same formation with the origin at one robot; what was measured is the same.

        Raises:
            InvalidInput: There is no such robot.
        """
        self._check([robot])
        return Formation(self.positions - self.positions[robot], self.headings, self.bearings, self.redrawn)

    def scale(self, reference: int) -> tuple[int, int]:
        """Return the neighbour of a reference and the coordinate (0 for x, 1 for y) in which they are the farthest apart."""
        neighbours = self.neighbours(reference)
        if not neighbours:
            raise InvalidInput("a reference that sees another robot, for the scale", f"robot {reference}, which sees none")
        apart = np.abs(self.positions[neighbours] - self.positions[reference])
        place, axis = np.unravel_index(np.argmax(apart), apart.shape)
        return neighbours[place], int(axis)

    def anchors(self, references: Sequence[int], scaled: bool = True) -> Array:
        """Return (n, 2) anchors: both coordinates of each reference and, with a single one, its `scale` [m]; NaN elsewhere.

        Raises:
            InvalidInput: There is no such robot, or it sees none that could fix the scale.
        """
        robots = self._check(references)
        anchors = np.full((len(self), 2), np.nan)
        anchors[robots] = self.positions[robots]
        if scaled and len(robots) == 1:
            place = self.scale(int(robots[0]))
            anchors[place] = self.positions[place]
        return anchors

    def _check(self, references: Sequence[int]) -> Integers:
        robots = whole("reference", np.array(references, dtype=np.int64))
        if (robots >= len(self)).any():
            raise InvalidInput(f"references among robots 0 to {len(self) - 1}", f"{robots.tolist()}")
        return robots

    @cached_property
    def arcs(self) -> AngularIntervals:
        """(k) arcs that contain the directions of the seen robots in the common frame."""
        known = AngularIntervals(self.headings, np.zeros(len(self)))
        return world_arcs(self.bearings, known[self.bearings.robot])

    def polytope(self, anchors: Array) -> Polytope:
        """Return the set of configurations that the bearings allow, in the frame of the anchors.

        Raises:
            Unbounded: The anchors do not bound it.
        """
        seen = self.bearings
        rows = bearing_rows(seen.robot, seen.target, self.arcs, np.arange(len(seen.robot)))
        empty = rows.select(np.zeros(0, dtype=np.int64))
        box = Polytope(empty, *bounded_box(rows, anchors))
        return box.with_constraints(on_robots(rows, box, NOWHERE))

    def case(self, anchors: Array) -> StaticCase:
        """Return what a filter is given: the anchors' box as initial sets, and a record for each bearing.

        Raises:
            Unbounded: The anchors do not bound the formation.
        """
        box = self.polytope(anchors)
        initial = tuple(Polygon.box(low, high) for low, high in zip(box.lower, box.upper, strict=True))
        return StaticCase(self.positions, initial, AngularIntervals(self.headings, np.zeros(len(self))), records(self.bearings))


def records(bearings: Bearing) -> tuple[Bearing, ...]:
    """Return a record of its own for each of (k) bearings."""
    one = [slice(k, k + 1) for k in range(len(bearings.robot))]
    return tuple(
        Bearing(bearings.time, bearings.robot[k], bearings.target[k], bearings.bearing[k], bearings.bound[k]) for k in one
    )


def draw_formation(generator: np.random.Generator, robots: int, bounds: Floats) -> Formation:
    """Return a random formation that its robot 0, as the reference, bounds.

    Args:
        generator: Where all randomness comes from.
        robots: How many, from 3 on.
        bounds: Bound of each robot's bearings, in [1e-6, pi/2) [rad]; repeated over the robots when there are fewer.

    Raises:
        InvalidInput: A number is out of its range, or almost no formation of this kind is bounded.
    """
    whole("number of robots", robots, low=3)
    several = np.atleast_1d(finite("bearing bound [rad]", bounds, LEAST_BOUND, np.nextafter(np.pi / 2, 0)))
    if several.ndim != 1 or not len(several):
        raise InvalidInput("at least one bearing bound", bounds)
    each = np.resize(several, robots)
    for redrawn in range(DRAWS):
        formation = _drawn(generator, robots, each, redrawn)
        with suppress(Unbounded):
            if formation.neighbours(0) and formation.polytope(formation.anchors([0])):
                return formation
    raise InvalidInput(f"formations that are bounded once in {DRAWS} draws", f"none with +-{np.degrees(several)} degrees")


def _drawn(generator: np.random.Generator, robots: int, bounds: Array, redrawn: int) -> Formation:
    positions = places(generator, robots, SPACING * np.sqrt(robots), APART)
    headings = generator.uniform(-np.pi, np.pi, robots)
    away = positions - positions[:, None]
    distance = np.hypot(away[..., 0], away[..., 1])
    robot, target = np.nonzero((distance < SIGHT) & (distance > 0))
    direction = np.arctan2(away[robot, target, 1], away[robot, target, 0])
    error = bounds[robot] * INSIDE * generator.uniform(-1, 1, len(robot))
    bearings = Bearing(0.0, robot, target, wrap(direction - headings[robot] + error), bounds[robot])
    return Formation(positions - positions[0], headings, bearings, redrawn)


@dataclass(frozen=True, eq=False)
class Searcher:
    """Projects one polytope, again and again.

    Attributes:
        polytope: What is projected.
        solver: What solves the linear programs.
    """

    polytope: Polytope
    solver: str = "piqp"

    def project(self, D: Array, stop: Stop, budget: Budget | None = None) -> Projection:
        """Return the projection {D x}, with D (2, v)."""
        is_over = budget.begin() if budget else never
        return project(self._program, self._workspace, D, self._interior, stop=stop, is_over=is_over)

    @cached_property
    def _program(self) -> LinearProgram:
        return self.polytope.program()

    @cached_property
    def _workspace(self) -> Workspace:
        return workspace(self._program, self.solver)

    @cached_property
    def _interior(self) -> Array:
        deepest = deepest_point(self._program, self.solver)
        return self._program.centre if deepest is None else deepest.point
