"""The reference frame of a team that stands: anchored coordinates, and the box that the rows prove around the others.

What robots measure of one another says where they are only relative to some of them, and bearings do not even tell the
scale. Anchors decide: another frame is nothing but other anchors (section 8 of the paper). Where they do not suffice,
there is no finite region to be found, and the error says which robots are adrift, and which way.
"""

from __future__ import annotations

import numpy as np
from scipy import sparse
from scipy.sparse.csgraph import connected_components

from filter.arrays import Array, Floats, Integers, Mask
from filter.errors import CorralError, InvalidInput
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.program import LinearProgram
from filter.linear.solvers import deepest_point, workspace

# So many times the anchors' own spread is far: what is not proved to be nearer is not called bounded.
FAR = 1e4
# A bound this near to the side of the box says nothing of its own.
NEARLY = 0.99
# Rows hold a direction back when it leaves them by more than this, of a direction of size 1.
HELD = 1e-6


class Unbounded(CorralError):
    """Measurements and anchors do not hold some robots: these could be infinitely far away.

    Attributes:
        direction: (n, 2) how the robots can go on for ever together, the farthest at 1; 0 for those that are held.
        robots: Those that are not held.
    """

    def __init__(self, why: str, direction: Array) -> None:
        self.direction = direction
        self.robots = tuple(np.flatnonzero(direction.any(axis=1)).tolist())
        alike: dict[str, list[str]] = {}
        for robot in self.robots:
            x, y = direction[robot]
            alike.setdefault(f"along ({x:+.2f}, {y:+.2f})", []).append(str(robot))
        ways = "; ".join(f"robot{'s' * (len(who) > 1)} {', '.join(who)} {way}" for way, who in alike.items())
        super().__init__(f"unbounded, as {why}: without end can go {ways}")


def free_coordinates(anchors: Floats) -> Mask:
    """Return (n, 2) which coordinates are variables: those whose anchor is NaN.

    Raises:
        InvalidInput: The anchors are not (n, 2) numbers or NaN.
    """
    values = np.asarray(anchors, dtype=float)
    if values.ndim != 2 or values.shape[1] != 2 or not len(values) or np.isinf(values).any():
        raise InvalidInput("anchors as (n, 2) coordinates, NaN where free", f"shape {values.shape}")
    return np.isnan(values)


def bounded_box(rows: Constraints, anchors: Array, solver: str = "piqp") -> tuple[Array, Array]:
    """Return lower and upper corners (n, 2) of boxes around the robots, proved from the rows and the anchors alone [m].

    Args:
        rows: On n robots, and valid however far apart these are, as rows of bearings are.
        anchors: (n, 2) known coordinates [m], NaN for those to be found.
        solver: What solves the linear programs.

    Raises:
        InvalidInput: The anchors are not (n, 2) numbers or NaN, or there is no such solver.
        Unbounded: Some coordinate is not bounded, or not within 1e4 times the anchors' spread.

    Algorithm:
        Within a provisional box every free coordinate is bounded from both sides. If no bound is at the box, then the box
        has cut off nothing: a convex set with a point inside a box and none on its sides lies in it.
    """
    free = free_coordinates(anchors)
    middle = np.where(free, _middle(anchors), anchors)
    reach = np.where(free, FAR * _spread(rows, anchors), 0.0)
    far = Polytope(rows, middle - reach, middle + reach)
    program = far.program()
    deepest = deepest_point(program, solver)
    if deepest is not None and program.proves_empty(deepest.multipliers):
        return far.lower, far.upper  # any box does; the rows that disagree are named by whoever searches them
    coordinates = np.flatnonzero(free)
    lower, upper = _bounds(program, coordinates, solver)
    side, centre = NEARLY * program.radius[coordinates], program.centre[coordinates]
    open_ended = (upper > centre + side) | (lower < centre - side)
    if open_ended.any() or deepest is None or not program.holds(deepest.point[None])[0]:
        raise _unbounded(rows, free, coordinates[open_ended], solver)
    box = np.stack([middle, middle])
    box[:, free] = lower, upper
    return box[0], box[1]


def _middle(anchors: Array) -> Array:
    """Return (2,) the middle of the anchors, 0 where there is none [m]."""
    known = np.where(np.isnan(anchors), 0.0, anchors)
    return np.asarray(known.sum(axis=0) / np.maximum(1, (~np.isnan(anchors)).sum(axis=0)))


def _spread(rows: Constraints, anchors: Array) -> float:
    """Return how large the formation is, roughly, as anchors and rows tell; 1 where nothing tells it [m]."""
    known = [column[~np.isnan(column)] for column in anchors.T]
    apart = [float(np.ptp(column)) for column in known if len(column)]
    return max([*apart, float(np.abs(rows.offset).max(initial=0))]) or 1.0


def _bounds(program: LinearProgram, coordinates: Integers, solver: str) -> tuple[Array, Array]:
    """Return (k,) proved lower and upper bounds of (k,) coordinates [m]."""
    count = len(coordinates)
    objectives = np.zeros((2 * count, len(program.centre)))
    objectives[np.arange(2 * count), np.tile(coordinates, 2)] = np.repeat([1.0, -1.0], count)
    work = workspace(program, solver)
    multipliers = np.zeros((2 * count, len(program.b)))
    for k, objective in enumerate(objectives):
        found = work.maximize(objective)
        if found is not None:
            multipliers[k] = found.multipliers
    greatest = program.certified_bounds(objectives, multipliers)
    upper, lower = greatest[:count], -greatest[count:]
    return np.minimum(lower, upper), np.maximum(lower, upper)


def _unbounded(rows: Constraints, free: Mask, open_ended: Integers, solver: str) -> Unbounded:
    """Return the error that tells a direction in which the rows let robots go on for ever."""
    adrift = _adrift(rows, free)
    if adrift is not None:
        return Unbounded("no anchor holds this part of the team", adrift)
    direction = _recession(rows, free, solver)
    if direction is not None:
        return Unbounded("what was measured and anchored does not fix their scale", direction)
    axis = np.zeros(free.size)
    axis[open_ended[:1]] = 1.0
    return Unbounded(f"no bound within {FAR:g} times the anchors' spread is proved", axis.reshape(free.shape))


def _adrift(rows: Constraints, free: Mask) -> Array | None:
    """Return (n, 2) a translation of the first part of the team that is free to shift, or None.

    A part is what rows on pairs connect. No such row notices that all of it is shifted.
    """
    robots = len(free)
    pairs = rows.i != WORLD
    ends = np.ones(int(pairs.sum())), (rows.i[pairs], rows.j[pairs])
    count, part = connected_components(sparse.csr_array(ends, shape=(robots, robots)), directed=False)
    for k in range(count):
        members = part == k
        own = rows.normal[~pairs & members[rows.j]]
        for axis in np.eye(2):
            if free[members][:, axis > 0].all() and not (np.abs(own @ axis) > 0).any():
                return np.where(members[:, None], axis, 0.0)
    return None


def _recession(rows: Constraints, free: Mask, solver: str) -> Array | None:
    """Return (n, 2) a direction with A d <= 0 that moves some robot, checked by arithmetic, or None.

    Rows that hold no translation have A d < 0 somewhere for every direction d of their recession cone but 0: so the d of
    the cone, within a box, that leaves its rows the farthest behind is not 0 unless the cone is.
    """
    A = rows.matrix(len(free))
    limit = free.ravel().astype(float)
    cone = LinearProgram(A, np.zeros(len(rows)), -limit, limit)
    found = workspace(cone, solver).maximize(-np.asarray(A.sum(axis=0)).ravel())
    if found is None or np.abs(found.point).max(initial=0) < HELD:
        return None
    direction = found.point / np.abs(found.point).max()
    direction[np.abs(direction) < HELD] = 0.0
    holds = bool((A @ direction <= HELD).all())
    return direction.reshape(free.shape) if holds else None
