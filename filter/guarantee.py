"""Whether what a filter says is guaranteed: for which robots it is not, since when, and why."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from filter.arrays import Array, Frozen, Mask


@dataclass(frozen=True, eq=False)
class Guarantee(Frozen):
    """Whether what a belief says of each robot is guaranteed: it is in force, or suspended.

    Attributes:
        suspended_since: (n,) since when it is suspended [s]; infinite where it is in force, -inf where it never was.
        because: (n) why it is suspended; empty where it is in force.
    """

    suspended_since: Array
    because: tuple[str, ...]

    @classmethod
    def full(cls, robots: int) -> Self:
        """Return one that is in force for every robot."""
        return cls(np.full(robots, np.inf), ("",) * robots)

    @property
    def in_force(self) -> Mask:
        """(n,) for which robots it is in force."""
        return np.asarray(self.suspended_since == np.inf)

    def suspended(self, since: float, because: str) -> Self:
        """Return it suspended for every robot, where it is not already."""
        since_when = np.where(self.in_force, since, self.suspended_since)
        return type(self)(since_when, tuple(before or because for before in self.because))

    def __str__(self) -> str:
        told: dict[str, list[str]] = {}
        for robot in np.flatnonzero(~self.in_force).tolist():
            told.setdefault(f"since {self.suspended_since[robot]:.3f} s, as {self.because[robot]}", []).append(str(robot))
        return "; ".join(f"suspended for robots {', '.join(who)} {why}" for why, who in told.items()) or "in force"
