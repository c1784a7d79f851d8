"""Hyperbolas: what of a polygon has a difference of distances from two places, as half-planes.

With the places a and b at (-D/2, 0) and (D/2, 0), f(x) = |x - a| - |x - b| is the difference. Where it is at most -d < 0 is the
convex inside of the branch around a, {|x - a| + d <= |x - b|}. Squared, and with |x - a| >= u . (x - a) for every unit
vector u, that is a half-plane for each u. By its own unit normal v, v_x >= 0 along the axis and |v_y| <= d / D, it is

    v . x <= -sqrt(d^2 - D^2 v_y^2) / 2,

a tangent of the branch; the last ones are its asymptotes. With d > D, which no place has, v_y goes to 1, and they exclude
one another.

Where f is at most d >= 0 is all but the convex inside C of the branch around b. Who stands within a polygon and not in C
can go along a line that C does not reach (a tangent, for one on the rim of C) both ways until the polygon ends, and one of
these ways goes no less far in a given direction. So in every direction the farthest points of what is left are on the
polygon's rim: corners outside C, and points where edges go into C. Their hull is the hull of what is left.
"""

import numpy as np

from filter.arrays import Array
from filter.geometry.convex import EPSILON
from filter.geometry.polygon import Polygon, clip

HALVINGS = 60  # by then the part of an edge in which it goes into C is as short as rounding
FLAT = 1e-6  # a branch whose asymptotes are closer, in units of its axis, counts as so wide where tangents are chosen


def of_difference(within: Polygon, places: Array, least: float, greatest: float, tangents: int) -> tuple[Array, Array]:
    """Return half-planes that hold every x of a polygon with |x - a| - |x - b| in [least, greatest] [m].

    Those that cut nothing off the polygon are left out. If none of it has such a difference, all tangents are kept, and one
    more half-plane is beyond the polygon.

    Args:
        within: A polygon.
        places: (2, 2) a and b, not the same [m].
        least: Of the difference [m].
        greatest: [m].
        tangents: To each branch that it is inside of, besides the one across the axis and the asymptotes.

    Returns:
        Normals (k, 2) of length 1 to rounding, and offsets (k,) [m].
    """
    middle, axis = places.mean(axis=0), places[1] - places[0]
    distance = float(np.hypot(*axis))
    frame = np.array([axis, [-axis[1], axis[0]]]) / distance
    corners = (within.vertices - middle) @ frame.T
    size = float(np.abs(corners).max()) + distance
    near = within.margin + 32 * EPSILON * (size + float(np.abs(places).max() + np.abs(within.vertices).max()))
    least, greatest = least - 4 * near, greatest + 4 * near  # of a point that is so near to one of the polygon
    normals, offsets = _left(Polygon.from_vertices(corners), distance, least, greatest, tangents)
    across = normals @ frame
    return across, offsets + across @ middle + near


def _left(within: Polygon, distance: float, least: float, greatest: float, tangents: int) -> tuple[Array, Array]:
    """Return the half-planes in the frame of the places, with the polygon there."""
    sides = [(1.0, greatest), (-1.0, -least)]  # side * f <= most, and with -x for x the places change sides
    normals, offsets = np.zeros((0, 2)), np.zeros(0)
    for side, most in sides:
        if most < 0:
            more = _tangents(within, side, -most, distance, tangents)
            normals, offsets = np.concatenate([normals, more[0]]), np.concatenate([offsets, more[1]])
    kept = clip(np.concatenate([within.normals, normals]), np.concatenate([within.offsets, offsets]), *within.bounds)
    left: Polygon | None = None if kept is None else kept[0]
    for side, most in sides:
        if left is not None and 0 <= most < distance:
            left = _without(left, side, most, distance)
    if left is None:
        lower, upper = within.bounds
        return np.concatenate([normals, [[1.0, 0.0]]]), np.append(offsets, lower[0] - (upper[0] - lower[0]) - distance)
    cuts = left.offsets < within.support(left.normals) - 64 * EPSILON * (np.abs(within.vertices).max() + distance)
    return left.normals[cuts], left.offsets[cuts]


def _tangents(within: Polygon, side: float, least: float, distance: float, count: int) -> tuple[Array, Array]:
    """Return half-planes around the branch where -side * f >= least > 0.

    They touch it evenly in its own parameter t, at (-cosh t, sinh t) in units of its axes, so far as the polygon reaches to its
    sides: so many tangents leave little area beside it (an even t is an even affine length).
    """
    half = np.sqrt(max(distance**2 - least**2, (FLAT * distance) ** 2))
    asymptote = min(least / distance, 1.0)
    first, last = np.arcsinh(2 * np.array([within.vertices[:, 1].min(), within.vertices[:, 1].max()]) / half).tolist()
    t = np.linspace(first, last, count)
    slopes = least / half * np.tanh(t)
    aside = np.concatenate([[0.0, asymptote, -asymptote], np.clip(slopes / np.hypot(1, slopes), -asymptote, asymptote)])
    inside = np.maximum((1 - 16 * EPSILON) * least**2 - (distance * aside) ** 2, 0)
    size = np.abs(within.vertices).max() + distance
    normals = np.stack([side * np.sqrt(1 - aside**2), aside], axis=1)
    return normals, -np.sqrt(inside) / 2 + 32 * EPSILON * size


def _without(within: Polygon, side: float, most: float, distance: float) -> Polygon | None:
    """Return the hull of a polygon without where side * f > most >= 0; None if that is everything."""

    def depth(points: Array) -> Array:  # concave, and positive in the branch alone: |x - a|^2 - (|x - b| + most)^2
        from_focus = np.hypot(side * points[:, 0] - distance / 2, points[:, 1])
        return 2 * distance * side * points[:, 0] - most**2 - 2 * most * from_focus - doubt

    vertices = within.vertices
    doubt = 64 * EPSILON * distance * (np.abs(vertices).max() + distance)
    following = np.roll(vertices, -1, axis=0)
    deepest = _deepest(vertices * [side, 1], following * [side, 1], most, distance) * [side, 1]
    found = [vertices[depth(vertices) <= 0]]
    for ends, others in ((vertices, following), (following, vertices)):
        within_it = np.where((depth(others) > 0)[:, None], others, deepest)
        enters = (depth(ends) <= 0) & (depth(within_it) > 0)
        outer, inner = ends[enters], within_it[enters]
        for _ in range(HALVINGS if len(inner) else 0):
            middle = (outer + inner) / 2
            beyond = (depth(middle) > 0)[:, None]
            outer, inner = np.where(beyond, outer, middle), np.where(beyond, middle, inner)
        found.append(inner)
    points = np.concatenate(found)
    return Polygon.from_vertices(points) if len(points) else None


def _deepest(begin: Array, end: Array, most: float, distance: float) -> Array:
    """Return where (k) edges are deepest in the branch around b: 2 D x - 2 most |x - b| is greatest there."""
    along = end - begin
    length = np.maximum(np.hypot(along[:, 0], along[:, 1]), np.finfo(float).tiny)
    unit = along / length[:, None]
    to_focus = np.array([distance / 2, 0.0]) - begin
    foot, aside = (to_focus * unit).sum(axis=1), np.abs(to_focus[:, 0] * unit[:, 1] - to_focus[:, 1] * unit[:, 0])
    rise = distance * unit[:, 0]
    level = np.sqrt(np.maximum(most**2 - rise**2, 0))
    where = np.where(level > 0, foot + aside * rise / np.where(level > 0, level, 1), np.where(rise > 0, length, 0))
    return begin + np.clip(where / length, 0, 1)[:, None] * along
