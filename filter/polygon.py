"""Convex polygons in the plane, as half-planes and as vertices.

The half-planes are the truth of an outer polygon: each one is kept exactly as it was proved. The vertices are computed
from them, within `margin` outward: the hull of the vertices, widened by the margin, contains the polygon.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from filter.angles import ROUNDING, AngularIntervals
from filter.arrays import Array, Floats, Integers, Mask, finite, read_only
from filter.errors import InvalidInput

EPSILON = float(np.finfo(float).eps)
# Sides of a box in the order of its edges: right, top, left, bottom.
SIDES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


@dataclass(frozen=True, eq=False)
class Polygon:
    """A bounded convex polygon; a segment and a point are polygons too.

    Attributes:
        normals: (e, 2) outward normals of the edges, of length 1 to rounding, counter-clockwise.
        offsets: (e,) the polygon is {x : normals x <= offsets} [m].
        vertices: (e, 2) counter-clockwise; vertex k is where edge k begins [m].
        margin: The hull of the vertices widened by this contains the polygon [m].
    """

    normals: Array
    offsets: Array
    vertices: Array
    margin: float = 0.0

    def __post_init__(self) -> None:
        for name in ("normals", "offsets", "vertices"):
            object.__setattr__(self, name, read_only(getattr(self, name)))

    @classmethod
    def box(cls, lower: Floats, upper: Floats) -> Polygon:
        """Return the rectangle between two corners, each (2,) [m].

        Raises:
            InvalidInput: A corner is not finite, or a lower one is above the upper one (an empty set).
        """
        low, high = finite("lower corner [m]", lower), finite("upper corner [m]", upper)
        if low.shape != (2,) or high.shape != (2,) or (low > high).any():
            corners = f"{low.tolist()}, {high.tolist()}"
            raise InvalidInput("a box with its lower corner (2,) below its upper corner (2,)", corners)
        vertices = np.array([[high[0], low[1]], high, [low[0], high[1]], low])
        return cls(SIDES, np.concatenate([high, -low]), vertices)

    @classmethod
    def from_vertices(cls, points: Floats) -> Polygon:
        """Return a polygon around the convex hull of (k, 2) points [m]; it errs outward by rounding.

        Raises:
            InvalidInput: There is no point (an empty set), or a coordinate is not finite.
        """
        hull = cls.hull(points)
        lower, upper = hull.bounds
        if (lower == upper).all():
            return cls.box(lower, upper)
        allowance = 8 * EPSILON * np.abs(hull.vertices).sum(axis=1).max()
        return cls.from_half_planes(hull.normals, hull.offsets + allowance, lower - allowance, upper + allowance)

    @classmethod
    def hull(cls, points: Floats) -> Polygon:
        """Return the convex hull of (k, 2) points [m]; its vertices are among them, its half-planes right to rounding.

        Raises:
            InvalidInput: There is no point (an empty set), or a coordinate is not finite.
        """
        array = finite("vertices [m]", points)
        if array.ndim != 2 or array.shape[1] != 2 or not len(array):
            raise InvalidInput("at least one point, as (k, 2) coordinates", f"shape {array.shape}")
        vertices = convex_hull(array)
        edges = np.roll(vertices, -1, axis=0) - vertices
        if len(vertices) < 3:  # a point or a segment: bounded by caps, too
            along = edges[0] if len(vertices) == 2 else np.array([1.0, 0.0])
            edges = np.array([along, [-along[1], along[0]], -along, [along[1], -along[0]]])
            vertices = vertices[[0, 1, 1, 0]] if len(vertices) == 2 else vertices[[0, 0, 0, 0]]
        normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
        return cls(normals, (array @ normals.T).max(axis=0), vertices)

    @classmethod
    def from_half_planes(cls, normals: Floats, offsets: Floats, lower: Floats, upper: Floats) -> Polygon:
        """Return the part of a box that lies in all half-planes {x : normals x <= offsets}.

        Raises:
            InvalidInput: Nothing is left, or the box is not one.
        """
        box = cls.box(lower, upper)
        kept = clip(finite("normals", normals).reshape(-1, 2), finite("offsets [m]", offsets).reshape(-1), *box.bounds)
        if kept is None:
            raise InvalidInput("half-planes with a point of the box in common", "an empty set")
        return kept[0]

    @cached_property
    def area(self) -> float:
        """Area of the hull of the vertices [m2]."""
        return area_of(self.vertices)

    @cached_property
    def centroid(self) -> Array:
        """(2,) centre of mass [m]; of a polygon without area, the middle of its vertices."""
        origin = self.vertices.mean(axis=0)
        x, y = (self.vertices - origin).T
        cross = x * np.roll(y, -1) - np.roll(x, -1) * y
        total = cross.sum()
        if total <= 64 * EPSILON * (x @ x + y @ y):
            return origin
        return origin + np.array([(x + np.roll(x, -1)) @ cross, (y + np.roll(y, -1)) @ cross]) / (3 * total)

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper corner (2,) of a box around the polygon; errs outward [m]."""
        return self.vertices.min(axis=0) - self.margin, self.vertices.max(axis=0) + self.margin

    def contains(self, points: Floats) -> Mask:
        """Return whether (..., 2) points satisfy every half-plane."""
        return np.all(np.asarray(points) @ self.normals.T <= self.offsets, axis=-1)

    def mirrored(self, point: Array) -> Polygon:
        """Return {point - x}: a fixed point (2,) as seen from every x of the polygon; errs outward [m]."""
        rounding = 4 * EPSILON * float(np.abs(point).sum() + np.abs(self.vertices).max())
        offsets = self.offsets - self.normals @ point + rounding
        return Polygon(-self.normals, offsets, point - self.vertices, self.margin + rounding)

    def support(self, directions: Floats) -> Array:
        """Return (k,) upper bounds of direction . x over the polygon for (k, 2) directions [m]."""
        wanted = np.asarray(directions, dtype=float)
        rounding = 4 * EPSILON * np.abs(self.vertices).max()
        return (wanted @ self.vertices.T).max(axis=-1) + (self.margin + rounding) * np.abs(wanted).sum(axis=-1)

    def span(self) -> tuple[float, float]:
        """Return centre and bound of an arc that contains the direction from the origin to every point; errs outward [rad].

        The bound is pi when the origin is inside, or so near that no direction is excluded for sure.
        """
        doubt = 2 * self.margin + 8 * EPSILON * float(np.abs(self.vertices).max())
        nearest = self._distance_of_edges() - doubt
        angles = np.sort(np.arctan2(self.vertices[:, 1], self.vertices[:, 0]))
        gaps = np.append(angles[1:], angles[0] + 2 * np.pi) - angles
        widest = int(np.argmax(gaps))  # what is not seen is one gap; from the inside none is as wide as half a turn
        half = np.pi - gaps[widest] / 2
        if nearest <= 2 * doubt or half >= np.pi / 2:
            return 0.0, np.pi
        return float(angles[widest] + gaps[widest] + half), float(half + 2 * doubt / nearest + 4 * ROUNDING)

    def _distance_of_edges(self) -> float:
        """Return the distance of the origin from the nearest edge [m]."""
        edges = np.roll(self.vertices, -1, axis=0) - self.vertices
        lengths = np.maximum((edges**2).sum(axis=1), np.finfo(float).tiny)
        along = np.clip(-(self.vertices * edges).sum(axis=1) / lengths, 0, 1)
        nearest = self.vertices + along[:, None] * edges
        return float(np.hypot(nearest[:, 0], nearest[:, 1]).min())

    def intersection(self, other: Polygon) -> Polygon | None:
        """Return what two polygons have in common, or None when that is proved to be nothing."""
        normals, offsets = np.concatenate([self.normals, other.normals]), np.concatenate([self.offsets, other.offsets])
        kept = clip(normals, offsets, *self.bounds)
        return kept[0] if kept else None


def spans_of(polygons: Sequence[Polygon]) -> AngularIntervals:
    """Return the arcs in which (k) polygons are seen from the origin."""
    spans = np.array([polygon.span() for polygon in polygons]).reshape(-1, 2)
    return AngularIntervals(spans[:, 0], spans[:, 1])


def area_of(vertices: Array) -> float:
    """Return the area of a simple polygon with (k, 2) counter-clockwise vertices, from 0 on [m2]."""
    x, y = (vertices[1:] - vertices[0]).T
    return max(0.0, float(x[:-1] @ y[1:] - x[1:] @ y[:-1]) / 2)


def convex_hull(points: Array) -> Array:
    """Return the corners of the convex hull of (k, 2) points, counter-clockwise (monotone chain; Andrew, 1979)."""
    ordered = sorted(set(map(tuple, points.tolist())))
    if len(ordered) < 3:
        return np.array(ordered)
    halves = []
    for chain in (ordered, ordered[::-1]):
        hull: list[tuple[float, ...]] = []
        for point in chain:
            while len(hull) > 1 and not _turns_left(hull[-2], hull[-1], point):
                hull.pop()
            hull.append(point)
        halves += hull[:-1]
    return np.array(halves)


def _turns_left(a: Sequence[float], b: Sequence[float], c: Sequence[float]) -> bool:
    return (b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0]) > 0


def clip(normals: Array, offsets: Array, lower: Array, upper: Array) -> tuple[Polygon, Integers] | None:
    """Cut a box by half-planes, one after the other.

    A vertex is cut away only where rounding leaves no doubt that it is outside, and new vertices lie outward of the cut
    by as much; half-planes that cut nothing are left out. So the result errs outward alone, also where it is thin or a
    point.

    Args:
        normals: (k, 2), of length 1 to rounding.
        offsets: (k,) [m].
        lower: (2,) corner of the box [m].
        upper: (2,) corner of the box [m].

    Returns:
        The polygon and the (e,) index of the half-plane behind each edge, with -4 to -1 for the box's right, top, left
        and bottom side; None when nothing is left, which proves that the set is empty.
    """
    origin = (lower + upper) / 2
    reach = upper - origin
    largest = float(np.abs(origin).max() + reach.max())
    doubts = (8 * EPSILON * (np.abs(offsets) + np.abs(normals).sum(axis=1) * largest)).tolist()
    levels = (offsets - normals @ origin).tolist()
    width, height = reach.tolist()
    corners = [(width, -height, -4), (width, height, -3), (-width, height, -2), (-width, -height, -1)]
    for k, ((a, b), level, doubt) in enumerate(zip(normals.tolist(), levels, doubts, strict=True)):
        corners = _cut(corners, a, b, level + doubt, k)
        if not corners:
            return None
    edges = np.array([corner[2] for corner in corners])
    everything = np.concatenate([normals, SIDES]), np.concatenate([offsets, upper, -lower])
    index = np.where(edges < 0, edges + 4 + len(normals), edges)
    vertices = np.array([corner[:2] for corner in corners]) + origin
    margin = 4 * EPSILON * (len(normals) + 4) * largest
    return Polygon(everything[0][index], everything[1][index], vertices, margin), edges


Corner = tuple[float, float, int]  # x, y, and the edge that begins here


def _cut(corners: list[Corner], a: float, b: float, level: float, edge: int) -> list[Corner]:
    """Return the corners of the part where a x + b y <= level (Sutherland and Hodgman, 1974)."""
    beyond = [a * x + b * y - level for x, y, _ in corners]
    if max(beyond) <= 0:
        return corners
    kept: list[Corner] = []
    for k, (x, y, edge_here) in enumerate(corners):
        before, here = k - 1, beyond[k]
        if (beyond[before] > 0) != (here > 0):
            x0, y0, edge_before = corners[before]
            share = beyond[before] / (beyond[before] - here)
            kept.append((x0 + share * (x - x0), y0 + share * (y - y0), edge if here > 0 else edge_before))
        if here <= 0:
            kept.append((x, y, edge_here))
    return kept
