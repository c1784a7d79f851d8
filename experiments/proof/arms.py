"""From the centres of robots to the places of their sensors: where a sensor can be, given how its robot can look.

A sensor that is mounted at m on a robot with heading h is at x + R(h) m: on an arc about x, or no farther from it than the
mounting can be off. So what holds of the places of sensors holds of the centres, moved by the support of this arc, and the
other way round. Exact arithmetic, standard library only.
"""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from fractions import Fraction
from math import floor

from experiments.proof.exact import KEPT, Arc, Vector, Whole, angle_of, length, once_around, sector, steps, unit, whole
from experiments.proof.given.frame import Behind, Place, most_of
from experiments.proof.given.sensors import CENTRE, Mount
from experiments.proof.shown import hull_of

Two = tuple[Mount, Mount]  # on the robot that measures, or comes first, and on the other
NO, FINEST = Fraction(0), Fraction(4, 1 << KEPT)  # lengths are not larger than what they are of by as much [m]
# Corners around an arc, as the filter has them: at both ends and where tangents meet, in half-widths from its beginning; in how
# many of these from there they touch it. All rounding, to a grid as well, is far less than a share of 1 m and of the radius.
TANGENTS, ROUNDING, GRID = 6, Fraction(1, 1 << 90), 1 << KEPT
PLACES = [NO, *(Fraction(2 * k + 1, TANGENTS) for k in range(TANGENTS)), Fraction(2)]
# Corners of an octagon around a disc of radius 1: (1, 0), (1, 1) / sqrt(2) and so on, by 1 / cos(pi / 8) and a little more.
ON_AXIS, BETWEEN = Fraction(1082392200292394, 10**15), Fraction(765366864730180, 10**15)
OCTAGON = [(x * ON_AXIS, y * ON_AXIS) for x, y in ((1, 0), (0, 1), (-1, 0), (0, -1))]
OCTAGON += [(x * BETWEEN, y * BETWEEN) for x in (-1, 1) for y in (-1, 1)]


def reach(mount: Mount, heading: Arc, normal: Vector) -> Fraction:
    """Return a number no smaller than normal . R(h) m, over headings h of an arc and all places m of a sensor [m]."""
    if mount.is_at_the_centre:
        return NO
    far, along = length(mount.place), NO
    if any(mount.place):
        x, y, unit_of = whole(*normal)
        along = Fraction(sector((x, y), _ways(mount, heading), steps(max(NO, far - FINEST)), steps(far)), unit_of << 2 * KEPT)
    return along + mount.off * length(normal)


def beyond(mounts: Two, who: tuple[int, int], looks: Sequence[Arc], normal: Vector) -> Fraction:
    """Return a number no smaller than normal . v [m], by v the way between two centres is more than that between sensors.

    Args:
        mounts: How the sensors are mounted.
        who: On which robots; a landmark has no sensor, but is one.
        looks: How the robots can look.
        normal: Any vector.
    """
    own, other = mounts
    more = reach(own, looks[who[0]], normal)
    return more if other is CENTRE else more + reach(other, looks[who[1]], (-normal[0], -normal[1]))


def of_centre(placed: tuple[Place, Mount], heading: Arc, normal: Vector, edges: dict[Vector, Fraction]) -> Fraction | None:
    """Return a number no smaller than normal . x of a robot whose sensor is in a place; None if nothing says one.

    The centre is back from the sensor by R(h) m. That moves a line of a half-plane, from which it follows as in `most_of`.
    """
    place, mount = placed
    if isinstance(place, Behind):
        x, y = place.normal
        return most_of(replace(place, offset=place.offset + reach(mount, heading, (-x, -y))), normal, edges)
    return place.most(normal) + reach(mount, heading, (-normal[0], -normal[1]))


def around(places: Sequence[Vector], mounts: Two, who: tuple[int, int], looks: Mapping[int, Arc]) -> list[Vector]:
    """Return corners around where a target would be if the centre of a robot saw it as its sensor does [m].

    Its places are moved by all that the way to it can be more between the sensors than between the centres.
    """
    here, there = (_corners(mount, looks.get(body)) for mount, body in zip(mounts, who, strict=True))
    more = hull_of([(q[0] - p[0], q[1] - p[1]) for p in here for q in there])
    whole = hull_of([(x + u, y + v) for x, y in map(_on_grid, places) for u, v in more])
    return [(Fraction(x, GRID), Fraction(y, GRID)) for x, y in whole]


def _ways(mount: Mount, heading: Arc) -> Arc:
    aside = angle_of(mount.place)
    return Arc(heading.first + aside.first, heading.last + aside.last)


def _corners(mount: Mount, heading: Arc | None) -> list[Whole]:
    """Return corners around all places of a sensor, as seen from the centre: no farther out than the filter's."""
    if mount.is_at_the_centre or heading is None:
        return [(0, 0)]
    far, found = length(mount.place), [(0, 0)]
    if any(mount.place):
        arc = once_around(_ways(mount, heading))
        half = (arc.high - arc.low) / 2
        tangent = far / unit(half / TANGENTS)[0][0]
        found = [_at(arc.low + half * place, far if place in (0, 2) else tangent) for place in PLACES]
    radius = mount.off + ROUNDING * (1 + far)
    octagon = [_on_grid((radius * u, radius * v)) for u, v in OCTAGON]
    return hull_of([(x + u, y + v) for x, y in found for u, v in octagon])


def _at(angle: Fraction, far: Fraction) -> Whole:
    (cosine, _), (sine, _) = unit(angle)
    return _on_grid((far * cosine, far * sine))


def _on_grid(place: Vector) -> Whole:
    return floor(place[0] * GRID), floor(place[1] * GRID)
