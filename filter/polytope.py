"""The team's polytope: constraints within a box, and what it says of one robot or one pair at a glance."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from filter.arrays import Array, Integers, read_only
from filter.constraints import WORLD, Constraints
from filter.lp import LinearProgram
from filter.polygon import Polygon, clip


@dataclass(frozen=True, eq=False)
class Polytope:
    """The set of configurations {x : constraints, lower <= x <= upper}.

    Attributes:
        constraints: Rows on the bodies.
        lower: (n, 2) least coordinates, finite [m].
        upper: (n, 2) greatest coordinates, finite; equal to the lower ones where anchored [m].
        origin: (n,) what each robot's box comes from, numbers in the belief's table of sources; (0,) when nobody asks.
    """

    constraints: Constraints
    lower: Array
    upper: Array
    origin: Integers = field(default_factory=lambda: np.zeros(0, dtype=np.int64))

    def __post_init__(self) -> None:
        object.__setattr__(self, "origin", read_only(self.origin))
        object.__setattr__(self, "lower", read_only(self.lower))
        object.__setattr__(self, "upper", read_only(self.upper))

    def with_constraints(self, constraints: Constraints) -> Polytope:
        """Return the same box with other rows."""
        return Polytope(constraints, self.lower, self.upper, self.origin)

    def source_of_box(self, robot: int) -> Integers:
        """Return the number of the source of a robot's box, (1,), or (0,) when it is not known."""
        return self.origin[robot : robot + 1]

    def program(self) -> LinearProgram:
        """Return the polytope as a linear program in (x_0, y_0, x_1, y_1, ...)."""
        return LinearProgram(
            self.constraints.matrix(len(self.lower)), self.constraints.offset, self.lower.ravel(), self.upper.ravel()
        )

    def of_robot(self, robot: int) -> tuple[Polygon, Integers] | None:
        """Return a polygon around one robot, from its own rows alone, and the row behind each edge (negative: the box).

        None when the rows are proved to exclude one another.
        """
        return self._clipped(self.constraints.rows_of(WORLD, robot), *self.box_of_robot(robot))

    def of_pair(self, i: int, j: int) -> tuple[Polygon, Integers] | None:
        """Return a polygon around x_j - x_i for i < j, from the pair's rows alone, and the row behind each edge.

        None when the rows are proved to exclude one another.
        """
        return self._clipped(self.constraints.rows_of(i, j), *self.box_of_pair(i, j))

    def box_of_robot(self, robot: int) -> tuple[Array, Array]:
        """Return lower and upper corner (2,) of the box around one robot [m]."""
        return self.lower[robot], self.upper[robot]

    def box_of_pair(self, i: int, j: int) -> tuple[Array, Array]:
        """Return lower and upper corner (2,) of a box around x_j - x_i [m]."""
        lower, upper = self.lower[j] - self.upper[i], self.upper[j] - self.lower[i]
        return np.nextafter(lower, -np.inf), np.nextafter(upper, np.inf)

    def _clipped(self, rows: Integers, lower: Array, upper: Array) -> tuple[Polygon, Integers] | None:
        kept = clip(self.constraints.normal[rows], self.constraints.offset[rows], lower, upper)
        if kept is None:
            return None
        polygon, edges = kept
        return polygon, np.append(rows, np.arange(-4, 0))[edges]  # a negative edge is itself, counted from the end
