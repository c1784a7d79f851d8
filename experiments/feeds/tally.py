"""What a run amounts to, in little memory, however long it goes on."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from experiments.feeds.spread import Spread
from experiments.following.checks import Checks
from experiments.following.located import there
from experiments.following.metrics import Value, Words, guarantee_summary, rounded
from filter import Belief, Measurement


@dataclass
class Tally(Checks):
    """Counts and collects; what has the name of a quantity of `Metrics` is the same here.

    Attributes:
        records: Lines that are records, those that were refused among them; truth, too.
        malformed: Lines that are none.
        too_long: Lines of more bytes than a line may have.
        refused: Odometry and twists that could not be merged, as they overlap or come too late; see `Lagged` for the others.
        unchecked: Truths that nothing was checked against: from before what is kept, or more than there was time for.
        answered: From the arrival of each record until the regions with it were written [s].
        behind: How far answers are behind the stamps, as compared with the best so far, at most [s].
    """

    records: int = 0
    malformed: int = 0
    too_long: int = 0
    refused: int = 0
    unchecked: int = 0
    behind: float = 0.0
    answered: Spread = field(default_factory=Spread)
    _areas: Spread = field(default_factory=Spread)
    _seconds: Spread = field(default_factory=Spread)
    _lead: float = np.inf

    def add(self, belief: Belief, seconds: float, now: float) -> None:
        """Take in what was known after a batch, how long that took and when it was written, by the clock of the process [s]."""
        self._seconds.add(seconds)
        self.promised(belief)
        for area in belief.regions.outer.areas[there(belief)].tolist():
            self._areas.add(area)
        self._lead = min(self._lead, now - belief.time)
        self.behind = max(self.behind, now - belief.time - self._lead)

    def count(self, record: object) -> None:
        """Count a record."""
        self.records += 1
        if isinstance(record, Measurement):
            self.measured(record)

    def summary(self, words: Words) -> dict[str, Value]:
        """Return flat values with units in their names, in the words of the team; None for what nothing is known of."""
        lines = ("records", "malformed", "too_long")
        return {
            **self.counts(),
            "truth_unchecked": self.unchecked,
            **guarantee_summary(self.suspended, words),
            **{name: getattr(self, name) for name in lines},
            "measurements": self.measurements,
            "outer_area_mean_m2": _rounded(self._areas.mean()),
            "outer_area_p95_m2": _rounded(self._areas.quantile(0.95)),
            "batches": self._seconds.count,
            "step_median_ms": _rounded(self._seconds.quantile(0.5), 1e3),
            "step_p95_ms": _rounded(self._seconds.quantile(0.95), 1e3),
            "answer_median_ms": _rounded(self.answered.quantile(0.5), 1e3),
            "answer_p99_ms": _rounded(self.answered.quantile(0.99), 1e3),
            "answer_most_ms": _rounded(self.answered.most, 1e3),
            "behind_most_s": _rounded(self.behind),
        }


def _rounded(value: float | None, unit: float = 1.0) -> float | None:
    return None if value is None else rounded(value * unit)
