"""Where one robot can be if at most one recent vote is wrong: slices, each of which does without one vote, or without none.

A vote is what one pair says in a while: sightings of one target by one robot, seconds apart at most, are right or wrong
together, as a barcode is misread for some frames in a row and a robot that stands repeats its error. A slice that has to agree
with every vote is AGREED. When a vote opens, the agreed slices are copied; the copies do without that vote, but not without
others. So the truth is in the agreed slices if no vote is wrong, and in one of all slices if at most one is: the relaxed
intersection (Jaulin, Robust set-membership state estimation, Automatica 2009) by recursion.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from filter.arrays import Array, Integers, Mask, Table
from filter.geometry.angles import narrowest
from filter.geometry.polygon import Polygon
from filter.poses.slices import AGREED, COUNT, DIRECTIONS, QUARTER, STRETCHED
from filter.robust.slices import regrid

Cut = Callable[[Array, Array, Array], Mask]  # cuts low, high, reach of slices in place, and says which are left


@dataclass(frozen=True, eq=False)
class Hypotheses(Table):
    """Slices of one robot's poses.

    Attributes:
        without: (s,) the vote that each does without, AGREED for none, EARLIER for one that is over.
        low: (s,) first heading [rad].
        high: (s,) last one, not before the first [rad].
        reach: (s, COUNT) supports of the polygon around the positions [m].
    """

    without: Integers
    low: Array
    high: Array
    reach: Array

    @classmethod
    def agreed(cls, reach: Array, low: float = -np.pi, high: float = np.pi) -> Hypotheses:
        """Return one agreed slice: a polygon by its supports (COUNT,) [m], any heading from low to high [rad]."""
        return cls(np.array([AGREED]), np.array([low]), np.array([high]), reach.reshape(1, COUNT).copy())

    def renamed(self, without: int, rows: Mask | bool = True) -> Hypotheses:
        """Return the same slices, all or some of them as ones that do without this vote."""
        return replace(self, without=np.where(rows, without, self.without))

    def cut(self, cut: Cut) -> Hypotheses:
        """Return what a cut leaves of the slices."""
        low, high, reach = self.low.copy(), self.high.copy(), self.reach.copy()
        left = cut(low, high, reach)
        return Hypotheses(self.without[left], low[left], high[left], reach[left])

    def cut_anew(self, cells: int) -> Hypotheses:
        """Return a set around this one on a grid of headings with so many cells in a circle, one vote apart from the other."""
        names, group = np.unique(self.without, return_inverse=True)
        grid = len(names), cells
        low, high, reach = np.full(grid, np.inf), np.full(grid, -np.inf), np.full((*grid, COUNT), -np.inf)
        regrid((low, high, reach), group, self.low, self.high, self.reach)
        some = low <= high
        return Hypotheses(names[np.nonzero(some)[0]], low[some], high[some], reach[some])

    def refitted(self, cells: int) -> Hypotheses:
        """Return the same set, cut anew if its slices have become wide."""
        width, wide = self.high - self.low, STRETCHED * 2 * np.pi / cells
        return self.cut_anew(cells) if len(self) and (width.mean() > wide or width.max() > 2 * wide) else self

    def hull(self) -> Array:
        """Return (COUNT,) supports of the polygon around all positions [m]."""
        return np.asarray(self.reach.max(axis=0))

    def heading(self) -> tuple[float, float]:
        """Return centre and bound of the narrowest arc around all headings [rad]."""
        return narrowest(self.low, self.high)


def polygon_of(reach: Array) -> Polygon:
    """Return the polygon with these supports (COUNT,) [m]."""
    return Polygon.from_half_planes(DIRECTIONS, reach, -reach[[2 * QUARTER, 3 * QUARTER]], reach[[0, QUARTER]])


def reach_of(polygon: Polygon) -> Array:
    """Return (COUNT,) supports of the smallest polygon of this kind around another one [m]."""
    return polygon.support(DIRECTIONS)
