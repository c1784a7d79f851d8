"""A filter goes through a run, step by step, with whatever keeps something of it."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from dataclasses import dataclass
from typing import Any

from experiments.following.beside import Beside
from experiments.following.checks import Checks, Escapes
from experiments.following.metrics import Metrics, Value
from experiments.following.scenarios import Scenario
from experiments.following.steps import steps
from experiments.logs import LogWriter
from experiments.show.command import SUSPENDED
from experiments.show.terminal import StepProgress
from filter import Filter, GaussianBelief, Inconsistent, Step

OF_ALL = ("seed", "errors", "solver", "policy", "measurements_mode", "replay", "warm_up_s")  # of every summary


@dataclass(frozen=True, eq=False)
class Moment:
    """What there is to keep of one step.

    Attributes:
        step: The filter's.
        escapes: Whose truth was outside.
        beside: What the Kalman filter beside it believes; None without one, or where it has ended.
    """

    step: Step[Any]
    escapes: Escapes
    beside: GaussianBelief | None


class Keeper(AbstractContextManager["Keeper"]):
    """Keeps something of a run; as a context manager it learns at the end what has stopped the run, if anything has."""

    @abstractmethod
    def keep(self, moment: Moment) -> None:
        """Take one step in."""


class Told(Keeper):
    """Keeps what the summary tells of it in the end."""

    @abstractmethod
    def summary(self) -> dict[str, Value]:
        """Return flat values with units in their names."""


@dataclass(frozen=True, eq=False)
class Running:
    """A filter goes through a scenario, with a Kalman filter beside it or without.

    Attributes:
        scenario: The run.
        metrics: What it amounts to.
        beside: The Kalman filter, or None.
        log: Where the frames are written as they come, or None.
        warm: See `steps`.
        every: See `steps`.
    """

    scenario: Scenario
    metrics: Metrics
    beside: Beside | None = None
    log: LogWriter | None = None
    warm: bool = True
    every: float = 0.0

    def through(self, filter_: Filter[Any], keepers: Sequence[Keeper]) -> str | None:
        """Go to the end; return None, or what was proved to disagree and stopped the filter.

        Raises:
            CorralError: A frame cannot be used.
            OSError: Something cannot be written.
        """
        try:
            with ExitStack() as held, StepProgress(self.scenario.count) as progress:
                for each in (self.log or nullcontext(), *keepers):
                    held.enter_context(each)
                for step in steps(filter_, self.scenario, self.log, warm=self.warm, every=self.every):
                    moment = self._moment(step)
                    for keeper in keepers:
                        keeper.keep(moment)
                    progress.advance(step.frame.time - self.scenario.header.start, step.seconds)
        except Inconsistent as error:
            return self.scenario.team.words(error)
        return None

    def summary(self, told: Mapping[str, Value], conflict: str | None) -> dict[str, Value]:
        """Return the summary of the run, with what else is told of it; what nobody tells is None."""
        robots, rate = self.scenario.team.robots, self.scenario.header.rate
        known: dict[str, Value] = {"robots": robots, "duration_s": self.metrics.steps / rate if rate else None, "rate_hz": rate}
        return {
            **known,
            **dict.fromkeys(OF_ALL),
            **told,
            **self.metrics.summary(self.scenario.team.words),
            "inconsistent": conflict,
        }

    def _moment(self, step: Step[Any]) -> Moment:
        escapes = self.metrics.add(step.frame, step.belief, step.seconds)
        return Moment(step, escapes, self.beside.estimate(step.frame) if self.beside else None)


def exit_code(checks: Checks, conflict: bool) -> int:
    """Return what a run was worth: 1 for a broken promise, else `SUSPENDED` if nothing was promised for a while, else 0."""
    if checks.broken or conflict:
        return 1
    return 0 if checks.suspended is None else SUSPENDED
