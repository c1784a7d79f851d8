"""Pieces of a robot's motion, one after the other, as one."""

import numpy as np

from filter.arrays import Array
from filter.compiled import compiled, put, sum_of

COLUMNS = 11  # of a part: see `filter.motions.Motions`
RESULT = 7  # columns of odometry: distance, its bound, turn, its bound, bounds of direction and slip, aside
WIDEST_DIRECTION = 1.5  # the widest direction bound of a motion; beyond it is a disc [rad]
OF_SUMS = 1e-12  # far above that of all sums here, far below any sensor


@compiled
def joined(parts: Array, limits: Array, span: Array) -> Array:
    """Return (1 + RESULT, k) which robots are told of within a span (2,) of time [s], and how they moved in it.

    Args:
        parts: (m, COLUMNS) of robots in order, those of each in order of time.
        limits: (n, 4) of all robots: of speed, turn rate, acceleration and turn acceleration.
        span: From when to when [s].

    Algorithm:
        Each piece drives s in d +- D in the direction a +- b from the heading at the start, where b grows with what the turns
        before it can be off. Three sets contain the sum of the displacements, and the smallest is returned: a sector about the
        mean displacement, within what the pieces can be off along it and across; a sector about all directions, with the sum of
        all s, and slip for pieces that drive to and fro; and a disc.
    """
    found, count, end = np.empty((len(parts), 1 + RESULT)), 0, 0
    while end < len(parts):
        robot, first = parts[end, 0], end
        while end < len(parts) and parts[end, 0] == robot:
            first += parts[end, 2] <= span[0]
            end += 1
        last = first
        while last < end and parts[last, 1] < span[1]:
            last += 1
        if last > first:
            pieces = _pieces(parts[first:last], limits[int(robot)], span)
            found[count, 0] = robot
            if len(pieces) == 1:
                put(pieces[0], found[count, 1:])
            else:
                _sum(pieces, found[count, 1:])
            count += 1
    return found[:count].T.copy()


@compiled
def inserted(parts: Array, new: Array) -> Array:
    """Return (m + k, COLUMNS) parts (m, COLUMNS), by robots and then in order of time, with new ones (k, COLUMNS) among them.

    Of two with the same robot and beginning the new one comes last.
    """
    every = np.empty((len(parts) + len(new), COLUMNS))
    for k in range(len(parts)):
        put(parts[k], every[k])
    for k in range(len(new)):
        place = len(parts) + k
        while place and _is_before(new[k], every[place - 1]):
            put(every[place - 1], every[place])
            place -= 1
        put(new[k], every[place])
    return every


@compiled
def later(parts: Array, time: float) -> Array:
    """Return those of parts (m, COLUMNS) that end after a time [s]."""
    kept, count = np.empty(parts.shape), 0
    for k in range(len(parts)):
        if parts[k, 2] > time:
            put(parts[k], kept[count])
            count += 1
    return kept[:count].copy()


@compiled
def overlap(parts: Array) -> bool:
    """Return whether any parts (m, COLUMNS) of a robot overlap, where they are in order."""
    found = False
    for k in range(1, len(parts)):
        found |= parts[k, 0] == parts[k - 1, 0] and parts[k, 1] < parts[k - 1, 2]
    return found


@compiled
def _is_before(one: Array, other: Array) -> bool:
    return one[0] < other[0] or (one[0] == other[0] and one[1] < other[1])


@compiled
def _pieces(parts: Array, limits: Array, span: Array) -> Array:
    """Return (p, RESULT) what lies within the span, gaps included."""
    pieces, count, now = np.empty((2 * len(parts) + 1, RESULT)), 0, span[0]
    for k in range(len(parts)):
        begin, end = max(now, parts[k, 1]), min(span[1], parts[k, 2])
        if begin > now:
            put(_gap(begin - now, limits), pieces[count])
            count += 1
        whole = begin == parts[k, 1] and end == parts[k, 2]
        put(parts[k, 3:10] if whole else _cut(parts[k], limits, begin, end), pieces[count])
        count, now = count + 1, end
    if now < span[1]:
        put(_gap(span[1] - now, limits), pieces[count])
        count += 1
    return pieces[:count]


@compiled
def _gap(duration: float, limits: Array) -> Array:
    """Return what a robot can have done of which nothing is known but its limits."""
    return np.array([0.0, 0.0, 0.0, limits[1] * duration, 0.0, limits[0] * duration, 0.0])


@compiled
def _cut(part: Array, limits: Array, begin: float, end: float) -> Array:
    """Return the piece of a part from one time to another [s]."""
    piece, whole, some, steady = part[3:10].copy(), part[2] - part[1], end - begin, part[10] > 0
    if steady:
        piece[5] *= some / whole
    for column, limit in ((0, 0), (2, 1)):
        value, bound = part[3 + column], part[4 + column]
        share, rest = some / whole, max(0.0, whole - some)
        low, high = share * (value - bound), share * (value + bound)
        if not steady:
            off = limits[limit + 2] * some * rest / 2 if rest > 0 else 0.0
            most = max(limits[limit], (abs(value) + bound) / whole)
            low = max(low - off, -most * some, value - bound - most * rest)
            high = min(high + off, most * some, value + bound + most * rest)
        piece[column] = (low + high) / 2
        piece[column + 1] = max(0.0, high - low) / 2 + OF_SUMS * (abs(value) + bound)
    return piece


@compiled
def _sum(pieces: Array, found: Array) -> None:
    """Write the sum of several pieces as one."""
    angle, off, turn, turned, slip = np.empty(len(pieces)), np.empty(len(pieces)), 0.0, 0.0, 0.0
    x = y = 0.0
    for k in range(len(pieces)):
        distance, _, by, bound, direction, slipped, aside = pieces[k]
        angle[k], off[k] = turn + by / 2 + aside, turned + bound / 2 + direction
        x, y = x + distance * np.cos(angle[k]), y + distance * np.sin(angle[k])
        turn, turned, slip = turn + by, turned + bound, slip + slipped
    found[2], found[3] = turn, turned + OF_SUMS * (1 + abs(turn))
    mean, cone = _about_the_mean(pieces, angle, off, x, y), _within_a_cone(pieces, angle, off)
    size = np.abs(pieces[:, 0]) + pieces[:, 1]
    best = mean if mean[5] <= cone[5] else cone
    if best[5] < sum_of(size):
        found[0], found[1], found[4], found[5], found[6] = best[0], best[1], best[2], best[3] + slip, best[4] - turn / 2
        found[4] = max(0.0, found[4] - turned / 2)  # which odometry has in its direction by itself
    else:
        found[0], found[1], found[4], found[5], found[6] = 0.0, 0.0, 0.0, sum_of(size) + slip, 0.0
    found[6] -= 2 * np.pi * np.rint(found[6] / (2 * np.pi))
    found[1] += OF_SUMS * sum_of(size)
    found[4] += OF_SUMS
    found[5] += OF_SUMS * (sum_of(size) + slip)


@compiled
def _about_the_mean(pieces: Array, angle: Array, off: Array, x: float, y: float) -> Array:
    """Return distance, its bound, direction bound, slip and direction of a sector about the mean, and its size."""
    way, length = np.arctan2(y, x), np.hypot(x, y)
    along = across = 0.0
    for k in range(len(pieces)):
        distance, bound, by, turned, direction = pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3], pieces[k, 4]
        most, bend = abs(distance) + bound, (abs(by) + turned) / 2 + direction
        chord = np.cos(min(np.pi, off[k]))
        if chord > 0:  # or else the longest one goes farthest back
            chord *= np.cos(min(np.pi / 2, bend))
        ahead, aside = bound + most * (1 - chord), most * np.sin(min(np.pi / 2, off[k]))
        c, s = abs(np.cos(angle[k] - way)), abs(np.sin(angle[k] - way))
        along, across = along + ahead * c + aside * s, across + ahead * s + aside * c
    nearest, farthest = length - along, np.hypot(length + along, across)
    width = np.arctan2(across, max(nearest, 1e-300))
    if nearest <= 0 or width >= WIDEST_DIRECTION:
        return np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.inf])
    forwards = abs(way) <= np.pi / 2
    sign, way = (1.0, way) if forwards else (-1.0, way - np.sign(way) * np.pi)
    middle, half = (nearest + farthest) / 2, (farthest - nearest) / 2
    return np.array([sign * middle, half, width, 0.0, way, half + across])


@compiled
def _within_a_cone(pieces: Array, angle: Array, off: Array) -> Array:
    """Return the same of a sector about all directions."""
    low, high = np.inf, -np.inf
    for k in range(len(pieces)):
        if abs(pieces[k, 0]) + pieces[k, 1] > 0:
            low, high = min(low, angle[k] - off[k]), max(high, angle[k] + off[k])
    if low > high:
        return np.zeros(6)
    width = (high - low) / 2
    if width >= WIDEST_DIRECTION:
        return np.array([0.0, 0.0, 0.0, 0.0, 0.0, np.inf])
    least = greatest = forth = back = 0.0
    chord = np.cos(width)
    for k in range(len(pieces)):
        distance, bound, by, turned, direction = pieces[k, 0], pieces[k, 1], pieces[k, 2], pieces[k, 3], pieces[k, 4]
        chord = min(chord, np.cos(width) * np.cos(min(np.pi / 2, (abs(by) + turned) / 2 + direction)))
        least, greatest = least + distance - bound, greatest + distance + bound
        forth, back = forth + max(0.0, distance + bound), back + max(0.0, bound - distance)
    least, greatest = (least * chord if least > 0 else least), (greatest * chord if greatest < 0 else greatest)
    to_and_fro = min(forth, back) * (2 * np.sin(width) + 1 - chord)
    half = (greatest - least) / 2
    size = half + max(abs(least), abs(greatest)) * np.sin(width) + to_and_fro
    return np.array([(least + greatest) / 2, half, width, to_and_fro, (low + high) / 2, size])
