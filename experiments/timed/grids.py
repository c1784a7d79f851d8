"""Teams on a grid, as windows of a large team are: everybody measures bearing and range of the nearest."""

from __future__ import annotations

import numpy as np

from filter import Bearing, Range
from filter.arrays import Array
from filter.geometry.angles import AngularIntervals
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.sensing.rows import bearing_rows, on_robots, range_rows, world_arcs

COLUMNS = 4
SPACING, JITTER = 2.0, 0.4  # [m]
NEIGHBOURS = 6
BEARING_BOUND, RANGE_BOUND = np.radians(5), 0.05
REACH = 1.0  # what is known of each robot before: a square of so many metres to each side

NO_LANDMARKS = np.zeros((0, 2))


def draw_grid(generator: np.random.Generator, robots: int = 12) -> Polytope:
    """Return what such a team knows after everybody has measured the six nearest; errors are uniform within their bounds."""
    place = np.stack(np.divmod(np.arange(robots), COLUMNS), axis=1).astype(float)
    truth = SPACING * place + generator.uniform(-JITTER, JITTER, (robots, 2))
    middle = truth + REACH * generator.uniform(-1, 1, (robots, 2))
    nothing = np.zeros(0, dtype=np.int64)
    rows = Constraints(nothing, nothing, np.zeros((0, 2)), np.zeros(0), nothing)
    known = Polytope(rows, middle - REACH, middle + REACH)
    bearings, ranges = measured(truth, generator)
    source = np.zeros(len(bearings.robot), dtype=np.int64)
    arcs = world_arcs(bearings, AngularIntervals(np.zeros(len(source)), np.zeros(len(source))))
    fresh = Constraints.concatenate(
        [bearing_rows(bearings.robot, bearings.target, arcs, source), range_rows(ranges, arcs, source)]
    )
    return known.with_constraints(on_robots(fresh, known, NO_LANDMARKS))


def measured(truth: Array, generator: np.random.Generator) -> tuple[Bearing, Range]:
    """Return what robots at (n, 2), all of them heading along +x, measure of their nearest."""
    apart = truth[None] - truth[:, None]
    distances = np.hypot(apart[..., 0], apart[..., 1])
    count = min(NEIGHBOURS, len(truth) - 1)
    target = np.argsort(distances, axis=1, kind="stable")[:, 1 : count + 1].ravel()
    robot = np.repeat(np.arange(len(truth)), count)
    to, distance = apart[robot, target], distances[robot, target]
    wrong = generator.uniform(-1, 1, (2, len(robot)))
    bearing = np.arctan2(to[:, 1], to[:, 0]) + BEARING_BOUND * wrong[0]
    length = distance * (1 + RANGE_BOUND * wrong[1])
    nothing, share = np.zeros(len(robot)), np.full(len(robot), RANGE_BOUND)
    return Bearing(0.0, robot, target, bearing, nothing + BEARING_BOUND), Range(0.0, robot, target, length, nothing, share)
