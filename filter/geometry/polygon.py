"""Convex polygons in the plane, as half-planes and as vertices.

The half-planes are the truth of an outer polygon: each one is kept exactly as it was proved. The vertices are computed
from them, within `margin` outward: the hull of the vertices, widened by the margin, contains the polygon.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from filter.arrays import Array, Floats, Frozen, Integers, Mask, finite, floats, instance, number, settle
from filter.errors import InvalidInput
from filter.geometry.convex import EPSILON, area_of, centroid_of, clip_box, hull_of

SIDES = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])  # of a box, in the order of its edges
BY_HAND = 1e-9  # what is made by hand is right to this share of its size


@dataclass(frozen=True, eq=False)
class Polygon(Frozen):
    """A bounded convex polygon; a segment and a point are polygons too.

    Made by `box`, `from_vertices` or `from_half_planes`, as a rule. One that is made by hand is looked at: InvalidInput is
    raised if a value is not finite, or edges and vertices do not go round one bounded polygon.

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
        normals, offsets = finite("normals", self.normals), finite("offsets [m]", self.offsets)
        vertices, margin = finite("vertices [m]", self.vertices), number("margin [m]", self.margin, 0)
        if offsets.ndim != 1 or not normals.shape == vertices.shape == (len(offsets), 2):
            shapes = f"shapes {normals.shape}, {offsets.shape} and {vertices.shape}"
            raise InvalidInput("a normal (2,), an offset and a vertex (2,) for each edge of a polygon", shapes)
        if not _fit(normals, offsets, vertices, margin):
            expected = "normals of length 1, once round counter-clockwise, each vertex where an edge ends and the next begins"
            raise InvalidInput(f"{expected} (see Polygon.from_half_planes)", f"{len(offsets)} edges that bound no such set")
        settle(self, normals=normals, offsets=offsets, vertices=vertices, margin=margin)
        super().__post_init__()

    @classmethod
    def _of(cls, normals: Array, offsets: Array, vertices: Array, margin: float = 0.0) -> Polygon:
        """Return a polygon that is known to be one, without a look; its arrays are owned."""
        polygon = object.__new__(cls)
        settle(polygon, normals=normals, offsets=offsets, vertices=vertices, margin=margin)
        Frozen.__post_init__(polygon)
        return polygon

    @classmethod
    def box(cls, lower: Floats, upper: Floats) -> Polygon:
        """Return the rectangle between two corners (2,) [m]; InvalidInput if one is not finite, or lower is above upper."""
        low, high = finite("lower corner [m]", lower), finite("upper corner [m]", upper)
        if low.shape != (2,) or high.shape != (2,) or (low > high).any():
            corners = f"{low.tolist()}, {high.tolist()}"
            raise InvalidInput("a box with its lower corner (2,) below its upper corner (2,)", corners)
        vertices = np.array([[high[0], low[1]], high, [low[0], high[1]], low])
        return cls._of(SIDES, np.concatenate([high, -low]), vertices)

    @classmethod
    def from_vertices(cls, points: Floats) -> Polygon:
        """Return a polygon around the convex hull of (k, 2) points [m]; it errs outward by rounding. Raises as `hull`."""
        hull = cls.hull(points)
        lower, upper = hull.bounds
        if (lower == upper).all():
            return cls.box(lower, upper)
        allowance = 8 * EPSILON * np.abs(hull.vertices).sum(axis=1).max()
        return cls.from_half_planes(hull.normals, hull.offsets + allowance, lower - allowance, upper + allowance)

    @classmethod
    def hull(cls, points: Floats) -> Polygon:
        """Return the convex hull of (k, 2) points [m]; its vertices are among them, its half-planes right to rounding.

        Raises InvalidInput if there is no point (an empty set), or a coordinate is not finite.
        """
        array = finite("vertices [m]", points)
        if array.ndim != 2 or array.shape[1] != 2 or not len(array):
            raise InvalidInput("at least one point, as (k, 2) coordinates", f"shape {array.shape}")
        vertices = hull_of(array)
        edges = np.roll(vertices, -1, axis=0) - vertices
        if len(vertices) < 3:  # a point or a segment: bounded by caps, too
            x, y = edges[0] if len(vertices) == 2 else (1.0, 0.0)
            edges, vertices = np.array([[x, y], [-y, x], [-x, -y], [y, -x]]), vertices[[0, -1, -1, 0]]
        normals = np.stack([edges[:, 1], -edges[:, 0]], axis=1) / np.hypot(edges[:, 0], edges[:, 1])[:, None]
        return cls._of(normals, (array @ normals.T).max(axis=0), vertices)

    @classmethod
    def from_half_planes(cls, normals: Floats, offsets: Floats, lower: Floats, upper: Floats) -> Polygon:
        """Return the part of a box that lies in all half-planes {x : normals x <= offsets}.

        Normals (k, 2) are of any length, offsets (k,) and the corners of the box (2,) in [m]. Raises InvalidInput if nothing is
        left, the box is not one, or a value is not finite.
        """
        across, offset = finite("normals", normals), np.atleast_1d(finite("offsets [m]", offsets))
        if across.size == 0 == offset.size:
            across = np.zeros((0, 2))
        if offset.ndim != 1 or across.shape != (len(offset), 2):
            raise InvalidInput("a normal (2,) and an offset for each half-plane", f"shapes {across.shape} and {offset.shape}")
        kept = clip(across, offset, *cls.box(lower, upper).bounds)
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
        """Return whether (..., 2) points satisfy every half-plane, none that is not finite; InvalidInput if they are none."""
        places = floats("points [m]", points)
        if not places.ndim or places.shape[-1] != 2:
            raise InvalidInput("points as (..., 2) coordinates", f"shape {places.shape}")
        with np.errstate(invalid="ignore", over="ignore"):
            return np.all(places @ self.normals.T <= self.offsets, axis=-1)

    def support(self, directions: Floats) -> Array:
        """Return (k,) upper bounds of direction . x over the polygon [m] for (k, 2) vectors; InvalidInput if they are none."""
        wanted = finite("directions", directions)
        if wanted.ndim != 2 or wanted.shape[1] != 2:
            raise InvalidInput("directions as (k, 2) vectors", f"shape {wanted.shape}")
        rounding = 4 * EPSILON * np.abs(self.vertices).max()
        return (wanted @ self.vertices.T).max(axis=-1) + (self.margin + rounding) * np.abs(wanted).sum(axis=-1)

    def intersection(self, other: Polygon) -> Polygon | None:
        """Return what two polygons have in common, None when that is proved to be nothing; InvalidInput if one is none."""
        instance("another polygon", other, Polygon)
        normals, offsets = np.concatenate([self.normals, other.normals]), np.concatenate([self.offsets, other.offsets])
        kept = clip(normals, offsets, *self.bounds)
        return kept[0] if kept else None


def _fit(normals: Array, offsets: Array, vertices: Array, margin: float) -> bool:
    """Return whether edges go once round a bounded set, never by half a turn, and the vertices are on the edges they join."""
    if not len(normals) or (np.abs(np.hypot(normals[:, 0], normals[:, 1]) - 1) > BY_HAND).any():
        return False
    before, edges = np.roll(normals, 1, axis=0), np.arange(len(normals))
    across, along = before[:, 0] * normals[:, 1] - before[:, 1] * normals[:, 0], (before * normals).sum(axis=1)
    once = round(np.arctan2(across, along).sum() / (2 * np.pi)) == 1 and ((across > 0) | (along > 0)).all()
    beyond = vertices @ normals.T - offsets
    off = max(beyond.max(), -beyond[edges, edges].min(), -beyond[edges, edges - 1].min())
    return bool(once and off - BY_HAND * np.abs(vertices).max() <= 2 * margin)


def clip(normals: Array, offsets: Array, lower: Array, upper: Array) -> tuple[Polygon, Integers] | None:
    """Return what half-planes leave of a box as a polygon, and what is behind each edge, both as in `clip_box`.

    It errs outward alone, also where it is thin or a point. None proves that nothing is left.
    """
    vertices, behind = np.empty((len(offsets) + 4, 2)), np.empty(len(offsets) + 4, dtype=np.int64)
    size, margin = clip_box((vertices, behind), (normals, offsets), lower, upper)
    if not size:
        return None
    everything, edges = (np.concatenate([normals, SIDES]), np.concatenate([offsets, upper, -lower])), behind[:size].copy()
    return Polygon._of(everything[0][edges], everything[1][edges], vertices[:size].copy(), margin), edges
