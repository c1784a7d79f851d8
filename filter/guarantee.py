"""Whether what a filter says is guaranteed: for which robots it is not, since when, and why."""

from collections.abc import Callable, Collection
from dataclasses import dataclass, field, replace
from typing import Any, Self

import numpy as np

from filter.arrays import Array, Frozen, Mask, checked, instance
from filter.records.names import InWords
from filter.records.odometry import Odometry


@dataclass(frozen=True, eq=False)
class Guarantee(InWords, Frozen):
    """Whether what a belief says of each robot is guaranteed: it is in force, or suspended.

    Attributes:
        suspended_since: (n,) since when it is suspended [s]; infinite where it is in force, -inf where it never was.
        because: (n) why it is suspended, in words with the names of the team; empty where it is not.
        away: Robots that have left, of which nothing is said.
        assuming: What is assumed besides every bound that is not named in it, as "if only one of these is wrong ..."; empty if
            nothing is.
        tolerating: What the filter tolerates, in words, "if at most 1 of these is wrong within any 5 s: ..."; empty if nothing.
    """

    suspended_since: Array
    because: tuple[str, ...]
    away: frozenset[int] = field(default=frozenset(), metadata=checked(instance, "robots that are away", frozenset))
    assuming: str = ""
    tolerating: str = ""

    @classmethod
    def full(cls, robots: int) -> Self:
        """Return one that is in force for every robot."""
        return cls(np.full(robots, np.inf), ("",) * robots)

    @property
    def lapsed(self) -> Mask:
        """(n,) for which robots it is suspended."""
        return np.asarray(self.suspended_since < np.inf)

    @property
    def in_force(self) -> Mask:
        """(n,) for which robots it is in force: those that are there, and for which it is not suspended."""
        held = ~self.lapsed
        held[list(self.away)] = False
        return held

    def suspended(self, since: float, because: str, robots: Collection[int] | None = None) -> Self:
        """Return it suspended for some robots, or for every one, where it is not already."""
        some = np.ones(len(self.because), dtype=bool) if robots is None else np.isin(np.arange(len(self.because)), list(robots))
        since_when = np.where(self.lapsed | ~some, self.suspended_since, since)
        told = tuple(before or (because if now else "") for before, now in zip(self.because, some, strict=True))
        return replace(self, suspended_since=since_when, because=told)

    def restored(self, robot: int) -> Self:
        """Return it in force again for one robot."""
        others = np.arange(len(self.because)) != robot
        told = tuple(because if other else "" for because, other in zip(self.because, others, strict=True))
        return replace(self, suspended_since=np.where(others, self.suspended_since, np.inf), because=told)

    def under(self, assuming: str) -> Self:
        """Return it under an assumption, or with an empty one under none."""
        return replace(self, assuming=assuming)

    def without(self, robot: int) -> Self:
        """Return what is said when a robot is away."""
        return replace(self, away=self.away | {robot})

    def with_again(self, robot: int) -> Self:
        """Return what is said when a robot is there."""
        return replace(self, away=self.away - {robot})

    def of_those_there(self, odometry: Odometry | None) -> Odometry | None:
        """Return the odometry of robots that are not away: what is said of one that is shall not be in conflict with it."""
        return odometry.without(self.away) if odometry is not None and self.away else odometry

    def _in_words(self, words: Callable[[Any], str]) -> str:
        told: dict[str, list[str]] = {}
        for robot in np.flatnonzero(self.lapsed).tolist():
            told.setdefault(f"since {self.suspended_since[robot]:.3f} s, as {self.because[robot]}", []).append(words(robot))
        lapsed = [f"suspended for {', '.join(who)} {why}" for why, who in told.items()]
        conditions = " and besides ".join(filter(None, (self.tolerating, self.assuming)))
        held = [f"in force {conditions}".rstrip()] if conditions or not lapsed else []
        return "; ".join(lapsed + held)
