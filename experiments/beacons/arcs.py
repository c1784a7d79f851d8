"""The convex hull of a set that circles and a box bound, from inside and from around: a judge that knows its own error.

Nothing here is the filter's. The border of such a set is made of pieces of the circles and of the box's sides. Where a circle
meets the others, and the sides, it is cut; a piece between two cuts is in the set as a whole or not at all, so its middle
tells. The corners of the hull are on the border. So points along the pieces span a hull inside the exact one, and together
with the points where neighbouring tangents meet a hull around it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np

from experiments.following.frozen import freeze
from filter import Array, Mask

ROUNDING = 1e-12  # of a point on a circle, relative to all lengths
POINTS = (32, 128, 512)  # along a piece; more where the two hulls differ by too much
ENOUGH = 1e-3  # that the area of one hull is larger than that of the other
SIDES = ((0, 1), (1, 3), (3, 2), (2, 0))  # of a box, by its corners


@dataclass(frozen=True, eq=False)
class RoundSet:
    """A closed set within a box, whose border is made of pieces of circles and of the box's sides.

    Attributes:
        circles: (c, 3) centres and radii of all circles that have a part in the border [m].
        box: (2, 2) lower and upper corner of a box [m].
        excess: Takes (p, 2) points within the box [m]; returns (p,) numbers, at most 0 in the set.
        margin: What a number above 0 may be from rounding alone.
    """

    circles: Array
    box: Array
    excess: Callable[[Array], Array]
    margin: float

    def __post_init__(self) -> None:
        freeze(self)

    def contains(self, points: Array) -> Mask:
        """Return (p,) whether (p, 2) points are in the set, up to rounding."""
        slack = ROUNDING * np.abs(self.box).max()
        boxed = ((points >= self.box[0] - slack) & (points <= self.box[1] + slack)).all(axis=1)
        return np.asarray(boxed & (self.excess(points) <= self.margin))


@dataclass(frozen=True, eq=False)
class Hull:
    """The convex hull of a set, between two polygons.

    Attributes:
        inside: (v, 2) corners of a polygon inside the hull, counter-clockwise; none where the set may be empty [m].
        around: (w, 2) corners of one around it; none where the set is empty for sure [m].
    """

    inside: Array
    around: Array

    def __post_init__(self) -> None:
        freeze(self)

    @property
    def least(self) -> float:
        """An area that the hull has at least [m2]."""
        return area_of(self.inside)

    @property
    def most(self) -> float:
        """An area that the hull has at most [m2]."""
        return area_of(self.around)

    @property
    def error(self) -> float:
        """By what share the area may be larger than its least; infinite where nothing is known of it."""
        return self.most / self.least - 1 if self.least > 0 else np.inf


def hull_between(narrow: list[RoundSet], wide: list[RoundSet]) -> Hull:
    """Return the hull of a union of sets, each between a narrower and a wider one of which rounding makes no difference."""
    for count in POINTS:
        hull = Hull(_hull_of(narrow, count)[0], _hull_of(wide, count)[1])
        if hull.error <= ENOUGH:
            break
    return hull


def _hull_of(sets: list[RoundSet], count: int) -> tuple[Array, Array]:
    """Return the corners of a hull inside that of a union, and of one around it."""
    pieces = [piece for each in sets for piece in _border(each, count)]
    on = np.concatenate([np.zeros((0, 2)), *(piece[0] for piece in pieces)])
    beyond = np.concatenate([on, *(piece[1] for piece in pieces)])
    return corners_of(on), corners_of(beyond)


def _border(each: RoundSet, count: int) -> Iterator[tuple[Array, Array]]:
    """Yield, of each piece of the border, points on it and points where its tangents meet."""
    corners = np.array([(x, y) for y in each.box[:, 1] for x in each.box[:, 0]])
    for begin, end in SIDES:
        yield from _of_side(each, corners[begin], corners[end])
    for x, y, radius in each.circles:
        yield from _of_circle(each, np.array([x, y]), radius, count)


def _of_side(each: RoundSet, begin: Array, end: Array) -> Iterator[tuple[Array, Array]]:
    cuts = np.sort(np.concatenate([[0.0, 1.0], _shares(each.circles, begin, end)]))
    points = begin + cuts[:, None] * (end - begin)
    held = each.contains((points[1:] + points[:-1]) / 2)
    for one, other in zip(points[:-1][held], points[1:][held], strict=True):
        yield np.array([one, other]), np.zeros((0, 2))


def _shares(circles: Array, begin: Array, end: Array) -> Array:
    """Return how far along a segment circles meet it, as shares of it in (0, 1)."""
    way, off = end - begin, begin - circles[:, :2]
    a, b, c = way @ way, off @ way, (off * off).sum(axis=1) - circles[:, 2] ** 2
    if a == 0:
        return np.zeros(0)
    root = np.sqrt(np.maximum(0, b * b - a * c))  # a side that is only touched is cut once too often, which does no harm
    found = np.concatenate([(-b - root) / a, (-b + root) / a])
    return found[(found > 0) & (found < 1)]


def _of_circle(each: RoundSet, centre: Array, radius: float, count: int) -> Iterator[tuple[Array, Array]]:
    turns = np.sort(np.concatenate([[-np.pi, np.pi], _turns(each, centre, radius)]))
    middle = (turns[1:] + turns[:-1]) / 2
    held = each.contains(centre + radius * _unit(middle))
    for begin, end in zip(turns[:-1][held], turns[1:][held], strict=True):
        along = np.linspace(begin, end, 1 + max(count, int(8 * (end - begin))))
        half = (along[1] - along[0]) / 2
        yield centre + radius * _unit(along), centre + radius / np.cos(half) * _unit(along[:-1] + half)


def _turns(each: RoundSet, centre: Array, radius: float) -> Array:
    """Return the angles at which a circle meets the others and the lines along the box's sides [rad]."""
    apart = each.circles[:, :2] - centre
    distance = np.hypot(apart[:, 0], apart[:, 1])
    others = distance > 0
    apart, distance, other = apart[others], distance[others], each.circles[others, 2]
    way, cosine = np.arctan2(apart[:, 1], apart[:, 0]), (radius**2 + distance**2 - other**2) / (2 * radius * distance)
    to_sides = np.concatenate([each.box[:, 0] - centre[0], each.box[:, 1] - centre[1]]) / radius
    way, cosine = np.concatenate([way, [0, 0, np.pi / 2, np.pi / 2]]), np.concatenate([cosine, to_sides])
    met = np.abs(cosine) < 1 + 1e-6  # circles that only touch are cut where they are nearest
    half = np.arccos(np.clip(cosine[met], -1, 1))
    return _wrapped(np.concatenate([way[met] - half, way[met] + half]))


def _wrapped(angles: Array) -> Array:
    return (angles + np.pi) % (2 * np.pi) - np.pi


def _unit(angles: Array) -> Array:
    return np.stack([np.cos(angles), np.sin(angles)], axis=1)


def corners_of(points: Array) -> Array:
    """Return the corners (v, 2) of the convex hull of (p, 2) points, counter-clockwise: by two chains."""
    ordered = points[np.lexsort((points[:, 1], points[:, 0]))].tolist()
    if len(ordered) < 3:
        return np.reshape(np.array(ordered, dtype=float), (-1, 2))
    chains = []
    for row in (ordered, ordered[::-1]):
        chain = list[list[float]]()
        for x, y in row:
            while len(chain) > 1 and _turns_right(chain[-2], chain[-1], x, y):
                chain.pop()
            chain.append([x, y])
        chains.append(chain[:-1])
    return np.array(chains[0] + chains[1])


def _turns_right(before: list[float], last: list[float], x: float, y: float) -> bool:
    return (last[0] - before[0]) * (y - before[1]) <= (last[1] - before[1]) * (x - before[0])


def area_of(corners: Array) -> float:
    """Return the area of the polygon with (v, 2) corners, counter-clockwise [m2]; 0 of fewer than three."""
    if len(corners) < 3:
        return 0.0
    x, y = (corners - corners[0]).T
    return float(x @ np.roll(y, -1) - y @ np.roll(x, -1)) / 2
