"""The errors Corral raises: one base, subclasses that carry data.

Nothing a solver throws escapes, and no input is checked by `assert`. An error leaves every belief as it was.
"""

from collections.abc import Iterable, Sequence
from typing import Any


class CorralError(Exception):
    """Base of every error that Corral raises on purpose. Errors can be copied and pickled, with all that they carry."""

    def __reduce__(self) -> tuple[Any, ...]:
        # Not by `__init__`, which finds the words anew from what they were made from.
        return type(self).__new__, (type(self), *self.args), self.__dict__


class InvalidInput(CorralError, ValueError):
    """Something that was handed in cannot be used.

    Attributes:
        expected: What would have been accepted, in words.
        came: What was handed in.
    """

    def __init__(self, expected: str, came: Any) -> None:
        super().__init__(f"expected {expected}; came {came}")
        self.expected, self.came = expected, came


class OutOfRange(InvalidInput, IndexError):
    """An index is that of nothing; as an `IndexError` it also ends a loop over a sequence."""


class OutOfOrder(CorralError, ValueError):
    """A record belongs to another time than the belief's.

    Attributes:
        time: Time of the record [s].
        belief_time: Time of the belief [s].
    """

    def __init__(self, what: str, time: float, belief_time: float) -> None:
        remedy = "it comes too late to be merged" if time < belief_time else f"predict to {time!r} s first"
        super().__init__(f"{what} at {time!r} s, but the belief is at {belief_time!r} s: {remedy}")
        self.time, self.belief_time = time, belief_time


class Inconsistent(CorralError):
    """Measurements, motion bounds and prior knowledge are proved to exclude one another: some declared bound is broken.

    Attributes:
        what: When that was found, or, of a robot, that it has left the arena, in words.
        sources: What is proved to exclude one another, the newest last; without any one of them it is not.
        robot: Which one has left the arena, or None.
        evidence: Why the strict filter says so, if it kept that: its proofs up to the contradiction.
    """

    def __init__(self, what: str, sources: Sequence[Any], robot: int | None = None, evidence: Sequence[Any] = ()) -> None:
        super().__init__(_conflict(what if robot is None else f"robot {robot} {what}", map(str, sources)))
        self.what, self.sources, self.robot, self.evidence = what, tuple(sources), robot, tuple(evidence)

    def named(self, team: Any) -> str:
        """Return it in words, with the names that a team has for robots, landmarks and sensors."""
        what = self.what if self.robot is None else f"{team.words(self.robot)} {self.what}"
        return _conflict(what, map(team.words, self.sources))


def _conflict(what: str, sources: Iterable[str]) -> str:
    return f"{what}: no configuration satisfies all of: {'; '.join(sources)}"
