"""What a run amounts to: escapes, areas, performance ratios, times."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from experiments.following.checks import Checks, Escapes, Known
from experiments.following.located import points, there
from filter import (
    Belief,
    Doubted,
    Fallback,
    Frame,
    GaussianBelief,
    Guarantee,
    StartsOver,
    Suspect,
    Truth,
)

Value = float | int | str | bool | None
Words = Callable[[object], str]  # how something is said: `Team.words`, or `str` where robots have no names
DIGITS = 6  # significant ones in a summary, of means and times; counts are exact


@dataclass
class Metrics(Checks):
    """Counts and collects, a step at a time. Of a Kalman filter there is nothing to check: it claims nothing.

    Attributes:
        steps: Steps so far.
        rows_max: Greatest number of constraints of a belief.
        rejected: Measurements that were dropped for others to agree.
        doubts: How often something was proved to be wrong: suspects were looked at, or robots started over.
        aside: Who was found guilty, and is not listened to at the end.
        fallbacks: How often a solver's answers were no good.
    """

    steps: int = 0
    rows_max: int = 0
    rejected: int = 0
    doubts: int = 0
    aside: tuple[Suspect, ...] = ()
    fallbacks: int = 0
    _areas: list[float] = field(default_factory=list)
    _ratios: list[float] = field(default_factory=list)
    _searches: list[int] = field(default_factory=list)
    _seconds: list[float] = field(default_factory=list)
    _square_errors: list[float] = field(default_factory=list)

    def add(self, frame: Frame, belief: Known, seconds: float) -> Escapes:
        """Take one step in.

        Args:
            frame: What the filter was given, with the truth or without.
            belief: What the filter made of it.
            seconds: How long that took.

        Returns:
            Who escaped at this step.
        """
        self.steps += 1
        self.promised(belief)
        for record in frame.measurements:
            self.measured(record)
        self._seconds.append(seconds)
        if isinstance(belief, GaussianBelief):
            self.rejected = belief.rejected  # so far
        else:
            self._add_projections(belief)
        if frame.truth is None:
            return Escapes()
        self._miss(belief, frame.truth)
        return Escapes() if isinstance(belief, GaussianBelief) else self.check(belief, frame.truth)

    def _miss(self, belief: Known, truth: Truth) -> None:
        """Take in how far the truth is from what is believed as a point."""
        off = ((points(belief) - truth.positions) ** 2).sum(axis=1)
        self._square_errors += off[np.isfinite(off)].tolist()

    def _add_projections(self, belief: Belief) -> None:
        self.rows_max = max(self.rows_max, len(belief.constraints))
        self.fallbacks += sum(isinstance(event, Fallback) for event in belief.events)
        self.doubts += sum(isinstance(event, Doubted | StartsOver) for event in belief.events)
        self.aside = belief.aside
        regions, here = belief.regions, there(belief)
        self._areas += regions.outer.areas[here].tolist()
        self._ratios += regions.performance_ratios[here].tolist()
        self._searches += regions.searches[here].tolist()

    def summary(self, words: Words = str) -> dict[str, Value]:
        """Return flat values with units in their names; None for what nothing is known of, as in windows from inside.

        Words are those of the team, which has names.
        """
        ratios = self._ratios if any(self._ratios) else []
        return {
            **self.counts(),
            **guarantee_summary(self.suspended, words),
            "measurements": self.measurements,
            "rejected": self.rejected,
            "doubts": self.doubts,
            "put_aside": "; ".join(map(words, self.aside)) or None,
            "solver_fallbacks": self.fallbacks,
            "outer_area_mean_m2": _mean(self._areas),
            "outer_area_p95_m2": _quantile(self._areas, 0.95),
            "performance_ratio_mean": _mean(ratios),
            "performance_ratio_min": rounded(min(ratios)) if ratios else None,
            "searches_mean": _mean(self._searches),
            "rows_max": self.rows_max or None,
            "step_median_ms": _quantile(self._seconds, 0.5, 1e3),
            "step_p95_ms": _quantile(self._seconds, 0.95, 1e3),
            "point_rmse_m": rounded(float(np.sqrt(np.mean(self._square_errors)))) if self._square_errors else None,
        }


def guarantee_summary(suspended: Guarantee | None, words: Words) -> dict[str, Value]:
    """Return whether a guarantee was in force all the time, or since when it first was not, and why; None for all the time."""
    since = None if suspended is None else float(suspended.suspended_since.min())
    return {
        "guarantee_in_force": suspended is None,
        "guarantee_suspended_since_s": since if since is None or np.isfinite(since) else None,
        "guarantee_suspended_because": None if suspended is None else words(suspended),
    }


def rounded(value: float) -> float:
    """Return the value to `DIGITS` significant digits: what people read, not what anything is computed from."""
    return float(f"{value:.{DIGITS}g}")


def _mean(values: Sequence[float]) -> float | None:
    return rounded(float(np.mean(values))) if values else None


def _quantile(values: Sequence[float], share: float, unit: float = 1.0) -> float | None:
    return rounded(float(np.quantile(values, share)) * unit) if values else None
