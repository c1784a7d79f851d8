"""Whether a robot can be anywhere at all, by cutting the plane into cells: no rows, no solver, nothing of the filter's sets.

A cell is done with where one thing that is said of the robot holds nowhere in it, or no heading fits all that is said of it.
"""

import numpy as np

from filter import Bearing, Compass, Range

ROUNDING = 1e-9


def nowhere(box, polygon, heading, records, landmarks, *, most=400_000):
    """Return whether no place in a box, in a polygon or None, with a heading in an arc or None, agrees with single records.

    False also where that takes more than so many cells to tell.
    """
    cells, tried = np.array([box], dtype=float), 0
    while len(cells) and tried < most:
        tried += len(cells)
        cells = cells[_possible(cells, polygon, heading, records, landmarks)]
        cells = _halved(cells)
    return not len(cells)


def _possible(cells, polygon, heading, records, landmarks):
    low, high = cells[:, 0], cells[:, 1]
    possible = np.ones(len(cells), dtype=bool)
    if polygon is not None:
        least = sum(
            np.minimum(low[:, None, k] * polygon.normals[:, k], high[:, None, k] * polygon.normals[:, k]) for k in (0, 1)
        )
        possible &= (least <= polygon.offsets + ROUNDING).all(axis=1)
    arcs = [] if heading is None else [tuple(np.full(len(cells), value) for value in heading)]
    for record in records:
        if isinstance(record, Compass):
            arcs.append((np.full(len(cells), record.heading[0]), np.full(len(cells), record.bound[0])))
            continue
        mark = landmarks[int(record.target[0]) - 1]
        if isinstance(record, Range):
            nearest = np.hypot(*np.maximum(0, np.maximum(low - mark, mark - high)).T)
            farthest = np.hypot(*np.maximum(np.abs(low - mark), np.abs(high - mark)).T)
            (least,), (greatest,) = record.interval()
            possible &= (nearest <= greatest + ROUNDING) & (farthest >= least - ROUNDING)
        if isinstance(record, Bearing):
            centre, half = _directions(low, high, mark)
            arcs.append((centre - record.bearing[0], half + record.bound[0]))
    for k, (centre, half) in enumerate(arcs):
        for other, wide in arcs[:k]:
            apart = np.abs((centre - other + np.pi) % (2 * np.pi) - np.pi)
            possible &= apart <= half + wide + ROUNDING
    return possible


def _directions(low, high, mark):
    """Return arcs around the directions from all places of (k) cells to a mark."""
    inside = ((low <= mark) & (mark <= high)).all(axis=1)
    middle = mark - (low + high) / 2
    centre, half = np.arctan2(middle[:, 1], middle[:, 0]), np.zeros(len(low))
    for x in (low, high):
        for y in (low, high):
            way = np.arctan2(mark[1] - y[:, 1], mark[0] - x[:, 0])
            half = np.maximum(half, np.abs((way - centre + np.pi) % (2 * np.pi) - np.pi))
    return centre, np.where(inside, np.pi, half)


def _halved(cells):
    """Return each cell cut in two across its longer side."""
    which = np.arange(len(cells))
    side = np.argmax(cells[:, 1] - cells[:, 0], axis=1)
    middle = cells[which, :, side].mean(axis=1)
    one, other = cells.copy(), cells.copy()
    one[which, 1, side], other[which, 0, side] = middle, middle
    return np.concatenate([one, other])
