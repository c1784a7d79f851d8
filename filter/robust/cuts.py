"""What sightings do to the slices of a robot, to be used with `functools.partial`: all but the slices are given beforehand.

Each takes first (s,), last (s,) headings [rad] and supports (s, COUNT) [m], cuts them in place, and says which are left, (s,).
A sector (4,) is a bearing in the robot's frame and its bound [rad], least and greatest range [m].
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from filter.arrays import Array, Mask
from filter.robust.slices import narrow, see_body, see_place, stay_within


def narrowed(sector: Array, low: Array, high: Array, _reach: Array) -> Mask:
    """Cut slices down to the headings that a compass says, as the bearing of a sector."""
    return narrow(low, high, sector[0], sector[1])


def seeing_place(place: Array, sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    """Cut slices down to the poses from which a place (2,) [m] is in the sector."""
    return see_place(low, high, reach, place, sector)


def seeing_body(body: Array, sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    """Cut slices down to the poses from which a body, by its supports (COUNT,) [m], is in the sector."""
    return see_body(low, high, reach, body, sector)


def seeing_any(bodies: Sequence[Array], sector: Array, low: Array, high: Array, reach: Array) -> Mask:
    """Cut slices down to the poses from which one of several bodies is in the sector, each (COUNT,) supports [m]."""
    each = [(low.copy(), high.copy(), reach.copy()) for _ in bodies]
    left = np.array([see_body(*mine, body, sector) for mine, body in zip(each, bodies, strict=True)])
    low[:] = np.where(left, [mine[0] for mine in each], np.inf).min(axis=0)
    high[:] = np.where(left, [mine[1] for mine in each], -np.inf).max(axis=0)
    reach[:] = np.where(left[:, :, None], [mine[2] for mine in each], -np.inf).max(axis=0)
    return np.asarray(left.any(axis=0))


def within(place: Array, _low: Array, _high: Array, reach: Array) -> Mask:
    """Cut slices down to the positions in a polygon, by its supports (COUNT,) [m]."""
    return stay_within(reach, place)
