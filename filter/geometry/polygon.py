"""Convex polygons in the plane, as half-planes and as vertices.

The half-planes are the truth of an outer polygon: each one is kept exactly as it was proved. The vertices are computed
from them, within `margin` outward: the hull of the vertices, widened by the margin, contains the polygon.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from filter.arrays import Array, Floats, Frozen, Integers, Mask, finite
from filter.errors import InvalidInput
from filter.geometry.convex import EPSILON, area_of, centroid_of, clip_box_into, hull_of

# Sides of a box in the order of its edges: right, top, left, bottom.
SIDES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])


@dataclass(frozen=True, eq=False)
class Polygon(Frozen):
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
        vertices = hull_of(array)
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
        return np.array(centroid_of(self.vertices))

    @cached_property
    def bounds(self) -> tuple[Array, Array]:
        """Lower and upper corner (2,) of a box around the polygon; errs outward [m]."""
        return self.vertices.min(axis=0) - self.margin, self.vertices.max(axis=0) + self.margin

    def contains(self, points: Floats) -> Mask:
        """Return whether (..., 2) points satisfy every half-plane."""
        return np.all(np.asarray(points) @ self.normals.T <= self.offsets, axis=-1)

    def support(self, directions: Floats) -> Array:
        """Return (k,) upper bounds of direction . x over the polygon for (k, 2) directions [m]."""
        wanted = np.asarray(directions, dtype=float)
        rounding = 4 * EPSILON * np.abs(self.vertices).max()
        return (wanted @ self.vertices.T).max(axis=-1) + (self.margin + rounding) * np.abs(wanted).sum(axis=-1)

    def intersection(self, other: Polygon) -> Polygon | None:
        """Return what two polygons have in common, or None when that is proved to be nothing."""
        normals, offsets = np.concatenate([self.normals, other.normals]), np.concatenate([self.offsets, other.offsets])
        kept = clip(normals, offsets, *self.bounds)
        return kept[0] if kept else None


def clip(normals: Array, offsets: Array, lower: Array, upper: Array) -> tuple[Polygon, Integers] | None:
    """Return what half-planes leave of a box as a polygon, and what is behind each edge, both as in `clip_box`.

    It errs outward alone, also where it is thin or a point. None proves that nothing is left.
    """
    vertices, behind = np.empty((len(offsets) + 4, 2)), np.empty(len(offsets) + 4, dtype=np.int64)
    size, margin = clip_box_into((vertices, behind), (normals, offsets), lower, upper)
    if not size:
        return None
    everything, edges = (np.concatenate([normals, SIDES]), np.concatenate([offsets, upper, -lower])), behind[:size].copy()
    return Polygon(everything[0][edges], everything[1][edges], vertices[:size].copy(), margin), edges
