"""Every constraint is a half-plane on one robot or on a pair, normal . (x_j - x_i) <= offset, kept in one sorted table."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, Self

import numpy as np
import scipy
from numpy.typing import NDArray

from filter.arrays import Array, Integers, Mask, Table, read_only, settle
from filter.compiled import compiled
from filter.geometry.convex import EPSILON

WORLD = -1

Columns = tuple[Integers, Integers, Array, Array]  # i, j, normal and offset of all rows, as compiled functions take them


@dataclass(frozen=True, eq=False)
class Constraints(Table):
    """Rows normal . (x_j - x_i) <= offset; with i = WORLD, normal . x_j <= offset.

    They are sorted by i and j, in whatever order they come; within a robot or a pair they keep their order.

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
        super().__post_init__()
        if not _are_in_order(self.i, self.j):
            order = np.lexsort((self.j, self.i))
            settle(
                self,
                **{
                    name: read_only(column[order]) for name, column in zip(self.__dataclass_fields__, self.columns, strict=True)
                },
            )

    @classmethod
    def between(cls, i: Integers, j: Integers, normal: Array, offset: Array, source: Integers) -> Constraints:
        """Return rows on pairs in either order, turned so that i is below j."""
        swapped = i > j
        sign = np.where(swapped, -1.0, 1.0)[:, None]
        return cls(np.where(swapped, j, i), np.where(swapped, i, j), sign * normal, offset, source)

    @property
    def rows(self) -> Columns:
        """The rows without their sources."""
        return self.i, self.j, self.normal, self.offset

    def shifted(self, by: Array) -> Constraints:
        """Return the rows with offsets changed by (r,) amounts [m], the sum's rounding on the outer side."""
        offset = self.offset + by
        outward = offset + np.where(by == 0, 0.0, 4 * EPSILON * (np.abs(self.offset) + np.abs(by)))
        return self._with(offset=outward)

    def with_sources(self, source: Integers) -> Constraints:
        """Return the rows with other sources (r,)."""
        return self._with(source=source)

    def _with(self, **columns: NDArray[Any]) -> Constraints:
        """Return the rows, which are sorted already, with other columns than those they are sorted by."""
        rows = object.__new__(Constraints)
        settle(rows, **self.__dict__ | {name: read_only(column) for name, column in columns.items()})
        return rows

    def select(self, index: Integers | Mask) -> Self:
        """Return some of the rows, by index or mask."""
        if index.dtype != bool:
            return super().select(index)
        some = object.__new__(type(self))  # in order as they were
        settle(
            some,
            **{name: read_only(column[index]) for name, column in zip(self.__dataclass_fields__, self.columns, strict=True)},
        )
        return some

    def rows_of(self, i: int, j: int) -> Integers:
        """Return the rows on one pair, or with i = WORLD on one robot."""
        (begin,), (end,) = self.groups(np.array([i]), np.array([j]))
        return np.arange(begin, end)

    def groups(self, i: Integers, j: Integers) -> tuple[Integers, Integers]:
        """Return where the rows of each of (g) pairs, or of robots where i is WORLD, begin and end, (g,) and (g,)."""
        begin, end = i.copy(), j.copy()
        _find(begin, end, self.i, self.j)
        return begin, end

    def grouped(self) -> tuple[Integers, Integers, Integers]:
        """Return i and j of each robot and each pair that has rows (g,), and where these begin (g + 1,)."""
        return self._grouped

    @cached_property
    def _grouped(self) -> tuple[Integers, Integers, Integers]:
        first = _begins(self.i, self.j)
        return self.i[first[:-1]], self.j[first[:-1]], first

    def matrix(self, bodies: int) -> scipy.sparse.csr_array:
        """Return A (r, 2 bodies) of A x <= offset, with x = (x_0, y_0, x_1, y_1, ...)."""
        pair = self.i != WORLD
        there = np.repeat(np.stack([pair, np.ones_like(pair)], axis=1), 2, axis=1)
        column = np.stack([2 * self.i, 2 * self.i + 1, 2 * self.j, 2 * self.j + 1], axis=1)[there]
        value = np.concatenate([-self.normal, self.normal], axis=1)[there]
        begin = np.concatenate([[0], np.cumsum(np.where(pair, 4, 2))])
        return scipy.sparse.csr_array((value, column, begin), shape=(len(self), 2 * bodies))


@compiled
def _are_in_order(i: Integers, j: Integers) -> bool:
    """Return whether rows on i and j (r,) are sorted by both."""
    in_order = True
    for k in range(1, len(i)):
        in_order &= i[k - 1] < i[k] or (i[k - 1] == i[k] and j[k - 1] <= j[k])
    return in_order


@compiled
def _begins(i: Integers, j: Integers) -> Integers:
    """Return where the rows on each robot or pair begin, of sorted ones, and where the last ones end."""
    first, count = np.zeros(len(i) + 1, dtype=np.int64), 0
    for k in range(len(i)):
        if k == 0 or i[k] != i[k - 1] or j[k] != j[k - 1]:
            first[count] = k
            count += 1
    first[count] = len(i)
    return first[: count + 1].copy()


@compiled
def _find(begin: Integers, end: Integers, i: Integers, j: Integers) -> None:
    """Write where the rows on pairs begin and end, of sorted ones, in place of the pairs' own i and j (g,)."""
    for g in range(len(begin)):
        one, other = begin[g], end[g]
        begin[g] = _place(one, other, i, j)
        end[g] = _place(one, other + 1, i, j)


@compiled
def _place(one: int, other: int, i: Integers, j: Integers) -> int:
    """Return how many of sorted rows come before those on a pair."""
    low, high = 0, len(i)
    while low < high:
        middle = (low + high) // 2
        if i[middle] < one or (i[middle] == one and j[middle] < other):
            low = middle + 1
        else:
            high = middle
    return low
