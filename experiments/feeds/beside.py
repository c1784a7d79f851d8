"""What goes on beside the answers, after each of them, when it holds nobody up any more."""

from __future__ import annotations

from abc import abstractmethod
from contextlib import AbstractContextManager
from dataclasses import dataclass

from experiments.feeds.now import Now
from experiments.following.checks import Escapes
from filter import Arrival, Frame


@dataclass(frozen=True, eq=False)
class Answered:
    """A batch that was answered.

    Attributes:
        now: What is known.
        records: What was merged.
        checked: Truths that were held against what was known, and whose was outside.
    """

    now: Now
    records: tuple[Arrival, ...]
    checked: tuple[tuple[Frame, Escapes], ...]


class Beside(AbstractContextManager["Beside"]):
    """Does something with every answer; as a context manager it learns at the end what has stopped the run, if anything has."""

    @abstractmethod
    def keep(self, answered: Answered) -> None:
        """Take one answer in."""
