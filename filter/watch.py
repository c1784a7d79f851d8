"""A guaranteed region proves other estimators wrong: an integrity monitor for whatever filter runs beside this one."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from filter.arrays import LARGEST, Array, Floats, Frozen, finite, floats, instance, number, shown
from filter.errors import InvalidInput
from filter.geometry.convex import EPSILON
from filter.geometry.polygon import Polygon
from filter.linear.sources import Source
from filter.records.names import InWords
from filter.sets.belief import Belief

SAME_DIRECTION = 1e-6  # an edge whose normal is within this of the separating line's carries it alone [rad]
SYMMETRIC = 1e-9  # a covariance whose halves differ by more than this share is none
THINNEST = 1e-100  # an ellipse that is thinner counts as just so thin, as a point does [m]


@dataclass(frozen=True, eq=False)
class Alarm(InWords, Frozen):
    """Proof that an estimate of one robot is wrong, as long as every declared bound holds.

    Attributes:
        time: When [s].
        robot: Whose estimate it is.
        everything: True when the whole ellipse of the estimate is impossible, False when only its centre is.
        normal: (2,) of length 1, across a line that separates what is possible from the estimate.
        offset: What is possible satisfies normal . x <= offset [m].
        distance: How far the estimate, or the nearest point of its ellipse, is beyond the line [m].
        edges: Which edges of the robot's outer polygon the line rests on, one or two.
        sources: What these edges were proved from.
    """

    time: float
    robot: int
    everything: bool
    normal: Array
    offset: float
    distance: float
    edges: tuple[int, ...]
    sources: tuple[Source, ...]

    def _in_words(self, words: Callable[[Any], str]) -> str:
        what = "the whole ellipse" if self.everything else "the estimate"
        because = "; ".join(map(words, self.sources)) or "the box that it was known to be in"
        return f"{what} of {words(self.robot)} at {self.time:.3f} s is impossible by {self.distance:.3f} m, proved by {because}"


def watch(
    belief: Belief, positions: Floats, covariances: Floats | None = None, probability: float = 0.997, moved: Floats = 0.0
) -> tuple[Alarm, ...]:
    """Return an alarm for each robot whose estimate is proved to be wrong; `InvalidInput` if something is not as it should be.

    Args:
        belief: What is possible.
        positions: (n, 2) another estimator's positions [m]; NaN for a robot of which it says nothing. Of one that is
            away nothing is proved.
        covariances: (n, 2, 2) of these positions, symmetric and positive definite [m2], or None for points alone.
        probability: What the ellipses are said to contain, in [0, 1).
        moved: (n,) or one for all, how far robots can be from where the belief has them, for positions of another time [m].
    """
    instance("belief", belief, Belief)
    robots, points = len(belief.regions), floats("positions [m]", positions)
    travel = finite("moved [m]", moved, 0)
    if points.shape != (robots, 2) or travel.shape not in ((), (robots,)):
        expected = f"positions of {robots} robots, (n, 2), moved by (n,) or one length"
        raise InvalidInput(expected, f"shapes {points.shape} and {travel.shape}")
    if (np.abs(points) > LARGEST).any():
        raise InvalidInput("finite positions [m], or NaN where nothing is said", shown(points.tolist()))
    size = np.sqrt(-2 * np.log1p(-number("probability", probability, 0, np.nextafter(1.0, 0))))  # chi-square, 2 degrees
    roots = [None] * robots if covariances is None else list(size * _roots(covariances, robots))
    further, said = np.broadcast_to(travel, robots).tolist(), np.flatnonzero(np.isfinite(points).all(axis=1))
    there = [robot for robot in said.tolist() if robot not in belief.guarantee.away]
    alarms = (_alarm(belief, k, points[k], roots[k], further[k]) for k in there)
    return tuple(alarm for alarm in alarms if alarm is not None)


def _roots(covariances: Floats, robots: int) -> Array:
    matrices = finite("covariances [m2]", covariances)
    if matrices.shape != (robots, 2, 2):
        raise InvalidInput(f"covariances of {robots} robots, (n, 2, 2)", f"shape {matrices.shape}")
    try:
        roots = np.asarray(np.linalg.cholesky(matrices))
    except np.linalg.LinAlgError:
        roots = None
    if roots is None or not np.allclose(matrices, matrices.transpose(0, 2, 1), rtol=SYMMETRIC, atol=0):
        raise InvalidInput("symmetric and positive definite covariances [m2]", shown(matrices.tolist()))
    return roots


def _alarm(belief: Belief, robot: int, point: Array, root: Array | None, moved: float) -> Alarm | None:
    """Return the gravest alarm: on the ellipse, point + root u over |u| <= 1, else on the point, else None."""
    outer = belief.regions.outer[robot]
    for ellipse in (root, None) if root is not None else (None,):
        normal = _separating_normal(outer, point, np.eye(2) if ellipse is None else ellipse)
        if normal is None:
            continue
        reach = 0.0 if ellipse is None else float(np.hypot(*(normal @ ellipse)))
        offset = float(np.nextafter(outer.support(normal[None])[0] + (1 + 8 * EPSILON) * moved, np.inf))
        distance = float(normal @ point) - reach - offset - 16 * EPSILON * (float(np.abs(point).sum()) + reach)
        if distance > 0:
            edges = _edges_behind(outer, normal)
            sources = dict.fromkeys(source for edge in edges for source in belief.causes(robot, edge))
            return Alarm(belief.time, robot, ellipse is not None, normal, offset, distance, edges, tuple(sources))
    return None


def _separating_normal(polygon: Polygon, point: Array, root: Array) -> Array | None:
    """Return a candidate: the normal of the line that keeps the polygon farthest from a point, in units of an ellipse."""
    with np.errstate(over="ignore", invalid="ignore"):
        whitening = np.linalg.inv(root + THINNEST * np.eye(2))
        corners = (polygon.vertices - point) @ whitening.T
        edges = np.roll(corners, -1, axis=0) - corners
        lengths = np.maximum((edges**2).sum(axis=1), np.finfo(float).tiny)
        along = np.clip(-(corners * edges).sum(axis=1) / lengths, 0, 1)
        nearest = corners + along[:, None] * edges
        normal = -nearest[np.argmin((nearest**2).sum(axis=1))] @ whitening
        length = float(np.hypot(*normal))
    return normal / length if 0 < length < np.inf and not polygon.contains(point) else None


def _edges_behind(polygon: Polygon, normal: Array) -> tuple[int, ...]:
    """Return the edge with that normal, or the two whose normals are next to it on either side."""
    turns = np.arctan2(polygon.normals @ [-normal[1], normal[0]], polygon.normals @ normal)
    if np.abs(turns).min() <= SAME_DIRECTION:
        return (int(np.abs(turns).argmin()),)
    return int(np.where(turns < 0, -turns, np.inf).argmin()), int(np.where(turns > 0, turns, np.inf).argmin())
