"""From measurements to constraints (section 3 of the paper, with its signs mended).

Errata: the paper's first bearing row has a wrong sign (as printed it cuts off the truth in half of random draws), and
its lower range row lacks a minus (as printed it says nothing).
"""

import numpy as np

from filter.arrays import Array, Integers
from filter.compiled import compiled, put
from filter.geometry.angles import AngularIntervals
from filter.geometry.convex import EPSILON
from filter.geometry.sector import far_and_near, sides
from filter.linear.constraints import WORLD, Columns, Constraints
from filter.linear.polytope import Polytope
from filter.records.measurements import Bearing, Position, Range
from filter.sensing.readings import Readings
from filter.sensing.since import Moves

# The far side of a range is a circle, replaced by tangents at most this far apart; 30 degrees cost 2.3 % of a whole disc.
TANGENT_SPACING = np.pi / 6
# Every bearing is widened by this [rad], every position [m], every range by this share: far above rounding, far below any
# sensor. So errors that just reach their bounds leave the polytope an interior, without which no solver can be accurate.
WIDENING = 1e-8


def world_arcs(record: Bearing, headings: AngularIntervals) -> AngularIntervals:
    """Return (k) arcs that contain the targets' directions in the world, given the (k) measuring robots' headings [rad]."""
    return headings.turned_by(record.bearing, record.bound)


def bearing_rows(robot: Integers, target: Integers, arcs: AngularIntervals, source: Integers) -> Constraints:
    """Return two rows for each (k) arc narrower than half a circle; wider ones are no convex set and give none."""
    narrow = np.flatnonzero(arcs.bound < np.pi / 2 - 2 * WIDENING)
    normal, twice = _sides(arcs.centre[narrow], arcs.bound[narrow] + WIDENING), np.repeat(narrow, 2)
    return Constraints.between(robot[twice], target[twice], normal, np.zeros(len(twice)), source[twice])


@compiled
def _sides(centre: Array, bound: Array) -> Array:
    """Return (2 k, 2) normals of both sides of (k) sectors."""
    normals = np.empty((2 * len(centre), 2))
    for k in range(len(centre)):
        both = sides(centre[k], bound[k])
        for side in range(2):
            put(both[side], normals[2 * k + side])
    return normals


def range_rows(record: Range, arcs: AngularIntervals, source: Integers, spacing: float = TANGENT_SPACING) -> Constraints:
    """Return the rows of ranges to targets whose directions lie in (k) arcs: tangents and near sides, see `far_and_near`."""
    least, greatest = record.interval()
    near, far = least * (1 - WIDENING), greatest * (1 + WIDENING)
    rows = _far_and_near(arcs.centre, np.minimum(arcs.bound + WIDENING, np.pi), near, far, spacing)
    which = rows[:, 0].astype(np.int64)
    return Constraints.between(record.robot[which], record.target[which], rows[:, 1:3], rows[:, 3].copy(), source[which])


@compiled
def _far_and_near(centre: Array, bound: Array, nearest: Array, farthest: Array, spacing: float) -> Array:
    """Return (r, 4) half-planes around the far and near sides of (k) sectors: which, normal and offset."""
    most = 0
    for k in range(len(centre)):
        most += int(np.ceil(2 * bound[k] / spacing)) + 2
    rows, count = np.empty((most, 4)), 0
    for k in range(len(centre)):
        normals, offsets = far_and_near(centre[k], bound[k], nearest[k], farthest[k], spacing)
        for m in range(len(offsets)):
            rows[count, 0], rows[count, 1], rows[count, 2], rows[count, 3] = k, normals[m, 0], normals[m, 1], offsets[m]
            count += 1
    return rows[:count].copy()


def position_rows(record: Position, polytope: Polytope, source: Integers) -> Constraints:
    """Return the half-planes of positions as rows, moved outward by `WIDENING` and all rounding within the polytope's box."""
    normal, extent = record.normals, np.maximum(np.abs(polytope.lower), np.abs(polytope.upper))
    allowance = 4 * EPSILON * (np.abs(record.offset) + extent[record.robot].sum(axis=1))
    world = np.full(len(record.robot), WORLD)
    return Constraints(world, record.robot, normal, record.offset, source).shifted(WIDENING + allowance)


def as_of_now(rows: Constraints, readings: Readings, moves: Moves | None, first: int) -> Constraints:
    """Return rows of readings, numbered from a first one on, as rows on where robots are now."""
    if moves is None:
        return rows
    return moves.moved(rows, np.concatenate(readings.at[1:])[rows.source - first])


def on_robots(rows: Constraints, polytope: Polytope, landmarks: Array) -> Constraints:
    """Return rows just built, on pairs of bodies, as rows on robots: landmarks (l, 2) are put in, all rounding is covered."""
    i, j, normal, offset = rows.i.copy(), rows.j.copy(), rows.normal.copy(), rows.offset.copy()
    _put_in((i, j, normal, offset), (polytope.lower, polytope.upper), landmarks)
    return Constraints(i, j, normal, offset, rows.source)


@compiled
def _put_in(rows: Columns, box: tuple[Array, Array], landmarks: Array) -> None:
    """Change rows on bodies into rows on robots.

    What normals and offsets were rounded by cuts off no more than a few units in the last place of the normal times the
    greatest difference of the two positions, and of the offset. Angles carry their own allowance.
    """
    (i, j, normal, offset), (lower, upper), robots = rows, box, len(box[0])
    for k in range(len(i)):
        fixed, size = j[k] >= robots, abs(offset[k])
        for axis in range(2):
            low, high = lower[i[k], axis], upper[i[k], axis]
            place = landmarks[j[k] - robots, axis] if fixed else 0.0
            least, greatest = (place, place) if fixed else (lower[j[k], axis], upper[j[k], axis])
            size += max(abs(greatest - low), abs(high - least)) + 2 * abs(place)
            offset[k] -= normal[k, axis] * place
        offset[k] += 8 * EPSILON * (size + abs(offset[k]))
        if fixed:
            i[k], j[k], normal[k, 0], normal[k, 1] = WORLD, i[k], -normal[k, 0], -normal[k, 1]


def spans_of_targets(
    polytope: Polytope, landmarks: Array, robot: Integers, target: Integers, moved: tuple[Array, Array] | None = None
) -> AngularIntervals:
    """Return (k) arcs that contain the directions from robots to targets, as far as the polytope tells at a glance [rad].

    If these are of other places, where robots were or their sensors are, the way from one to the other of which the polytope
    tells is another one by (k, 2), up to (k,) [m]. Rows that exclude one another say nothing here: to find that out, and the
    causes, is for the search that follows.
    """
    robots = len(polytope.lower)
    by, radius = (np.zeros((len(robot), 2)), np.zeros(len(robot))) if moved is None else moved
    fixed, one, other = target >= robots, np.minimum(robot, target), np.maximum(robot, target)
    outlines = polytope.of(np.where(fixed, WORLD, one), np.where(fixed, one, other)).polygons
    places = np.concatenate([np.zeros((robots, 2)), landmarks])[target]
    return outlines.spans(np.where(fixed | (robot > target), -1.0, 1.0), places, by, radius)
