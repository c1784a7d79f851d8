"""Every constraint is a half-plane on one robot or on a pair: normal . (x_j - x_i) <= offset.

Kept as a struct of arrays, never as a list of objects, so that prediction, pruning and the cut-out of sub-teams are a
few array expressions.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields
from functools import cached_property

import numpy as np
from scipy import sparse

from filter.arrays import Array, Integers, Mask, read_only
from filter.compiled import compiled
from filter.geometry.convex import EPSILON

WORLD = -1

Columns = tuple[Integers, Integers, Array, Array]  # i, j, normal and offset, as compiled functions take them


@dataclass(frozen=True, eq=False)
class Constraints:
    """Rows normal . (x_j - x_i) <= offset; with i = WORLD, normal . x_j <= offset.

    Attributes:
        i: (r,) robot, or WORLD; always below j.
        j: (r,) robot.
        normal: (r, 2) of length 1 to rounding.
        offset: (r,) [m].
        source: (r,) what produced the row, a number in the belief's table of sources.
    """

    i: Integers
    j: Integers
    normal: Array
    offset: Array
    source: Integers

    def __post_init__(self) -> None:
        for column in fields(self):
            object.__setattr__(self, column.name, read_only(getattr(self, column.name)))

    @classmethod
    def between(cls, i: Integers, j: Integers, normal: Array, offset: Array, source: Integers) -> Constraints:
        """Return rows on pairs in either order, turned so that i is below j."""
        swapped = i > j
        sign = np.where(swapped, -1.0, 1.0)[:, None]
        return cls(np.where(swapped, j, i), np.where(swapped, i, j), sign * normal, offset, source)

    @classmethod
    def on_robot(cls, robot: int, normal: Array, offset: Array, source: Integers) -> Constraints:
        """Return absolute rows on one robot."""
        return cls(np.full(len(offset), WORLD), np.full(len(offset), robot), normal, offset, source)

    @classmethod
    def concatenate(cls, parts: Sequence[Constraints]) -> Constraints:
        """Return all rows of the parts, in their order."""
        return cls(*(np.concatenate([getattr(part, column.name) for part in parts]) for column in fields(cls)))

    def __len__(self) -> int:
        return len(self.offset)

    @property
    def columns(self) -> Columns:
        """The rows without their sources."""
        return self.i, self.j, self.normal, self.offset

    def select(self, rows: Integers | Mask) -> Constraints:
        """Return some of the rows, by index or mask."""
        return Constraints(*(getattr(self, column.name)[rows] for column in fields(self)))

    def shifted(self, by: Array) -> Constraints:
        """Return the rows with offsets changed by (r,) amounts [m], the sum's rounding on the outer side."""
        offset = self.offset + by
        outward = offset + np.where(by == 0, 0.0, 4 * EPSILON * (np.abs(self.offset) + np.abs(by)))
        return Constraints(self.i, self.j, self.normal, outward, self.source)

    def rows_of(self, i: int, j: int) -> Integers:
        """Return the rows on one pair, or with i = WORLD on one robot."""
        order, begin, end = self.groups(np.array([i]), np.array([j]))
        return order[begin[0] : end[0]]

    def groups(self, i: Integers, j: Integers) -> tuple[Integers, Integers, Integers]:
        """Return the rows of each of (g) pairs, or of robots where i is WORLD.

        Returns:
            All rows in the order of their groups (r,), and where in it those of each pair begin and end, (g,) and (g,).
        """
        order, keys = self._groups
        # A robot beyond every row has none; its key would be another pair's.
        key = np.where(j < self._stride, (i + 1) * self._stride + j, -1)
        return order, np.searchsorted(keys, key), np.searchsorted(keys, key, side="right")

    def grouped(self) -> tuple[Integers, Integers, Integers, Integers]:
        """Return all rows in the order of their robots and pairs (r,), and i, j and number of rows of each of these (g,)."""
        order, keys = self._groups
        first = np.flatnonzero(np.diff(keys, prepend=-1))
        return order, keys[first] // self._stride - 1, keys[first] % self._stride, np.diff(first, append=len(keys))

    @cached_property
    def _stride(self) -> int:
        return int(self.j.max(initial=0)) + 1

    @cached_property
    def _groups(self) -> tuple[Integers, Integers]:
        keys = (self.i + 1) * self._stride + self.j
        order = np.argsort(keys, kind="stable")
        return order, keys[order]

    def matrix(self, bodies: int) -> sparse.csr_array:
        """Return A (r, 2 bodies) of A x <= offset, with x = (x_0, y_0, x_1, y_1, ...)."""
        pair = self.i != WORLD
        there = np.stack([pair, pair, np.ones_like(pair), np.ones_like(pair)], axis=1)
        column = np.stack([2 * self.i, 2 * self.i + 1, 2 * self.j, 2 * self.j + 1], axis=1)[there]
        value = np.concatenate([-self.normal, self.normal], axis=1)[there]
        begin = np.concatenate([[0], np.cumsum(np.where(pair, 4, 2))])
        return sparse.csr_array((value, column, begin), shape=(len(self), 2 * bodies))


def rounding_of_rows(rows: Constraints, lower: Array, upper: Array) -> Array:
    """Return (r,) how much the rounding of normals and offsets can cut off within a box [m].

    Angles carry their own allowance. What is left is the rounding of a sine, a cosine or a product: a few units in the
    last place of the normal times the greatest difference of the two positions, and of the offset.

    Args:
        rows: Rows just built, all of them on pairs.
        lower: (bodies, 2) least coordinates [m].
        upper: (bodies, 2) greatest coordinates [m].
    """
    difference = np.maximum(upper[rows.j] - lower[rows.i], upper[rows.i] - lower[rows.j])
    return 4 * EPSILON * (np.abs(rows.offset) + np.abs(difference).sum(axis=1))


@compiled
def may_be_broken(rows: Columns, lower: Array, upper: Array) -> bool:
    """Return whether some row seems to hold nowhere in boxes (n, 2) around the robots; a look that is cheap, and no proof."""
    i, j, normal, offset = rows
    for row in range(len(offset)):
        least = 0.0
        for m in range(2):
            coefficient = normal[row, m]
            least += coefficient * (lower[j[row], m] if coefficient > 0 else upper[j[row], m])
            if i[row] != WORLD:
                least -= coefficient * (upper[i[row], m] if coefficient > 0 else lower[i[row], m])
        if least > offset[row]:
            return True
    return False
