"""A run in a folder of its own, whole, as `experiments.prove` proves it: what the filter was given, what it says, and why."""

from __future__ import annotations

from contextlib import AbstractContextManager, ExitStack
from dataclasses import replace
from pathlib import Path
from types import TracebackType
from typing import Any

import numpy as np

from experiments.following.metrics import Metrics
from experiments.following.scenarios import Scenario
from experiments.keeping.files import Poses, Proofs, check_provable
from experiments.keeping.running import Keeper, Moment, Running
from experiments.logs import LogWriter
from experiments.logs.records import SECOND
from experiments.show.output import output_folder, write_summary
from filter import Frame, Step, Tolerance, Truth

CERTIFIED = "certified"  # the folder, within that of a run with figures of its own


class Provable(AbstractContextManager["Provable"]):
    """Keeps a run whose filter is told of other headings than the true ones: of the truth its log has the positions alone."""

    def __init__(self, folder: Path, scenario: Scenario, tolerance: Tolerance | None = None) -> None:
        """Open the files, for a filter with a tolerance or without.

        Raises:
            InvalidInput: The folder cannot be written to, a sensor's clock may be off, or of the tolerance there are no proofs.
        """
        check_provable(scenario.team)
        self._tolerated, self._folder = str(tolerance or ""), output_folder(folder)
        self._running = Running(scenario, Metrics())
        header = replace(scenario.header, version=SECOND)
        self._log = LogWriter(self._folder / "log.jsonl", header, scenario.initial)
        self._keepers: tuple[Keeper, ...] = Poses(self._folder, scenario.team), Proofs(self._folder, scenario.team)

    def keep(self, step: Step[Any]) -> None:
        """Take one step in."""
        placed = replace(step, frame=_without_headings(step.frame))
        self._log.write(placed.frame)
        moment = Moment(placed, self._running.metrics.add(placed.frame, step.belief, step.seconds), None)
        for keeper in self._keepers:
            keeper.keep(moment)

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        with ExitStack() as held:
            held.enter_context(self._log)
            for keeper in self._keepers:
                held.enter_context(keeper)
        if kind is None:
            write_summary(self._folder, self._running.summary({"recording": None, "tolerated": self._tolerated}, None))


def _without_headings(frame: Frame) -> Frame:
    truth = frame.truth
    return frame if truth is None else replace(frame, truth=Truth(truth.positions, np.full(len(truth.headings), np.nan)))
