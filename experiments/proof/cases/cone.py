"""In which directions places are, as seen from a polygon. Floats guess, whole numbers decide; standard library only."""

from __future__ import annotations

from fractions import Fraction
from math import atan2, cos, hypot, pi, sin

from experiments.proof.cases.polygon import Polygon
from experiments.proof.exact import ANGLES, ANYWHERE, CHOSEN, HALF, KEPT, ONE, Arc, Whole, below, direction, in_common

HAIR = 1e-12  # so far outward of the outermost places floats look for a side of a target [rad]
QUARTER = pi / 2
EPSILON = 1e-15  # differences of floats are not wrong by more, of the numbers in them
TINY = 1e-10  # places that are nearer, for their coordinates, are in no direction


def directions(polygon: Polygon, places: Polygon, nearest: int) -> Arc:
    """Return an arc of the directions of places as seen from a polygon, or `ANYWHERE`.

    Floats guess where they are, and whole numbers say how far they are beyond that. From so near at least [2^-110 m],
    what is beyond by a share s of that is turned by arcsin(s) <= 2 s.
    """
    found = ANYWHERE
    for angle in _guessed(polygon, places):
        normal, ahead = half_circle_about(angle)
        beyond = places.reach(normal) + polygon.reach((-normal[0], -normal[1]))
        if found is ANYWHERE and beyond >= 0 and nearest <= 6 * beyond:
            return ANYWHERE  # maybe in one place
        if beyond <= 0 or 6 * beyond < nearest:
            turned = -(-(2 * beyond << ANGLES) // (nearest - 2 * beyond)) if beyond > 0 else 0
            found = in_common(found, [Arc(ahead.first - turned, ahead.last + turned)])
    return found


def towards(angle: float) -> Whole:
    """Return a vector near a direction [rad], of nearly length 1, in steps of 2^-60."""
    return int(cos(angle) * ONE), int(sin(angle) * ONE)


def half_circle_about(angle: float) -> tuple[Whole, Arc]:
    """Return a normal nearly opposite to a direction [rad], likewise, and an arc around directions u with normal . u <= 0."""
    (x, y), middle = towards(angle), below(Fraction(angle))
    pairs = zip((x, y), direction(middle), strict=True)
    off = sum(max(abs((value << KEPT - CHOSEN) - end) for end in between) for value, between in pairs)
    reach = HALF // 2 + 2 + (2 * off << ANGLES - KEPT)
    return (-x, -y), Arc(middle - reach, middle + reach + 1)


def _guessed(polygon: Polygon, places: Polygon) -> list[float]:
    """Return the middles of half circles in which all places are, as seen from a polygon, and nearly nothing else [rad]."""
    apart = [(q[0] - p[0], q[1] - p[1]) for p in polygon.floats for q in places.floats]
    largest = max(polygon.largest, places.largest)
    doubt = TINY * largest
    away = [each for each in apart if hypot(*each) > doubt] or [(1.0, 0.0)]
    hair = HAIR + EPSILON * largest / min(abs(p) + abs(q) for p, q in away)
    first = last = away[0]
    for one in away:
        last = one if last[0] * one[1] > last[1] * one[0] else last
        first = one if first[0] * one[1] < first[1] * one[0] else first
    (x, y), (u, v) = first, last
    middle = atan2(y, x) + atan2(x * v - y * u, x * u + y * v) / 2
    if min(cos(middle) * p + sin(middle) * q for p, q in away) >= 0:
        return [middle, atan2(y, x) + QUARTER - hair, atan2(v, u) - QUARTER + hair]
    across = [angle for angle, length in _outward(polygon) if length > doubt]
    across += [angle + pi for angle, length in _outward(places) if length > doubt]
    least = {angle: min(0.0 if hypot(p, q) <= doubt else cos(angle) * p + sin(angle) * q for p, q in apart) for angle in across}
    return [max(least, key=lambda angle: least[angle])]


def _outward(polygon: Polygon) -> list[tuple[float, float]]:
    """Return the directions outward across the edges of a polygon [rad], and how long these are [m]."""
    ends = zip(polygon.floats, [*polygon.floats[1:], polygon.floats[0]], strict=True)
    return [(atan2(x - u, v - y), hypot(u - x, v - y)) for (x, y), (u, v) in ends]
