"""What a run amounts to: escapes, areas, performance ratios, times."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from experiments.following.located import inside, points, there
from filter import (
    Belief,
    Fallback,
    Frame,
    GaussianBelief,
    Guarantee,
    Mask,
    Measurement,
    Position,
    Rejected,
    RobustBelief,
    Truth,
)

Known = Belief | RobustBelief | GaussianBelief  # what a filter knows

Value = float | int | str | bool | None
DIGITS = 6  # significant ones in a summary, of means and times; counts are exact


@dataclass(frozen=True)
class Escapes:
    """Robots whose truth was outside at one step: a broken guarantee.

    Attributes:
        positions: Robots outside their outer polygon.
        headings: Robots whose heading is outside its interval.
    """

    positions: tuple[int, ...] = ()
    headings: tuple[int, ...] = ()

    def __bool__(self) -> bool:
        return bool(self.positions or self.headings)

    def in_force(self, belief: Known) -> int:
        """Return how many of them a belief has said its guarantee to be in force for: broken promises."""
        return sum(bool(belief.guarantee.in_force[robot]) for robot in (*self.positions, *self.headings))


def escapes_of(belief: Belief | RobustBelief, truth: Truth) -> Escapes:
    """Return who is outside; nobody whose truth is not known."""
    placed, turned = np.isfinite(truth.positions).all(axis=1), np.isfinite(truth.headings)
    within = belief.headings.contains(np.where(turned, truth.headings, 0.0)) | ~turned
    return Escapes(_missing(inside(belief, truth.positions) | ~placed), _missing(within))


@dataclass
class Metrics:
    """Counts and collects, a step at a time.

    A check is one robot at one step whose truth is known. Of a Kalman filter there is nothing to check: it claims nothing.

    Attributes:
        steps: Steps so far.
        checks: Positions that were checked.
        escapes: Positions outside their outer polygon.
        heading_checks: Headings that were checked.
        heading_escapes: Headings outside their interval.
        escapes_in_force: Those of both for which the guarantee was said to be in force: broken promises.
        suspended: The guarantee as it was when it first was not in force for every robot; None for never.
        measurements: Numbers that were measured and merged: a compass reading, a bearing or a range counts one each, and so
            does the position of a robot, however many half-planes it has.
        rows_max: Greatest number of constraints of a belief.
        rejected: Measurements that were dropped for others to agree.
        fallbacks: How often a solver's answers were no good.
    """

    steps: int = 0
    checks: int = 0
    escapes: int = 0
    heading_checks: int = 0
    heading_escapes: int = 0
    escapes_in_force: int = 0
    suspended: Guarantee | None = None
    measurements: int = 0
    rows_max: int = 0
    rejected: int = 0
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
        if self.suspended is None and belief.guarantee.lapsed.any():
            self.suspended = belief.guarantee
        self.measurements += sum(map(_count, frame.measurements))
        self._seconds.append(seconds)
        if isinstance(belief, GaussianBelief):
            self.rejected = belief.rejected  # so far
        else:
            self.rejected += sum(isinstance(event, Rejected) for event in belief.events)
        if isinstance(belief, RobustBelief):
            self._areas += [region.outer.area for region in belief.regions]
        if isinstance(belief, Belief):
            self._add_projections(belief)
        return Escapes() if frame.truth is None else self._check(belief, frame.truth)

    def _add_projections(self, belief: Belief) -> None:
        self.rows_max = max(self.rows_max, len(belief.constraints))
        self.fallbacks += sum(isinstance(event, Fallback) for event in belief.events)
        regions, here = belief.regions, there(belief)
        self._areas += regions.outer.areas[here].tolist()
        self._ratios += regions.performance_ratios[here].tolist()
        self._searches += regions.searches[here].tolist()

    def _check(self, belief: Known, truth: Truth) -> Escapes:
        here = there(belief)
        placed, turned_so = np.isfinite(truth.positions).all(axis=1) & here, np.isfinite(truth.headings) & here
        self._square_errors += ((points(belief) - truth.positions)[placed] ** 2).sum(axis=1).tolist()
        if isinstance(belief, GaussianBelief):
            return Escapes()
        found = escapes_of(belief, truth)
        self.checks += int(placed.sum())
        self.heading_checks += int(turned_so.sum())
        self.escapes += len(found.positions)
        self.heading_escapes += len(found.headings)
        self.escapes_in_force += found.in_force(belief)
        return found

    @property
    def broken(self) -> bool:
        """Whether any position or heading has escaped while the guarantee was said to be in force."""
        return self.escapes_in_force > 0

    def summary(self) -> dict[str, Value]:
        """Return flat values with units in their names; None for what nothing is known of, as in windows from inside."""
        ratios = self._ratios if any(self._ratios) else []
        return {
            "checks": self.checks,
            "escapes": self.escapes,
            "heading_checks": self.heading_checks,
            "heading_escapes": self.heading_escapes,
            "escapes_in_force": self.escapes_in_force,
            **guarantee_summary(self.suspended),
            "measurements": self.measurements,
            "rejected": self.rejected,
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


def guarantee_summary(suspended: Guarantee | None) -> dict[str, Value]:
    """Return whether a guarantee was in force all the time, or since when it first was not, and why; None for all the time."""
    since = None if suspended is None else float(suspended.suspended_since.min())
    return {
        "guarantee_in_force": suspended is None,
        "guarantee_suspended_since_s": since if since is None or np.isfinite(since) else None,
        "guarantee_suspended_because": None if suspended is None else str(suspended),
    }


def rounded(value: float) -> float:
    """Return the value to `DIGITS` significant digits: what people read, not what anything is computed from."""
    return float(f"{value:.{DIGITS}g}")


def _count(record: Measurement) -> int:
    return len(set(record.robot.tolist())) if isinstance(record, Position) else len(record.robot)


def _missing(holds: Mask) -> tuple[int, ...]:
    return tuple(np.flatnonzero(~holds).tolist())


def _mean(values: Sequence[float]) -> float | None:
    return rounded(float(np.mean(values))) if values else None


def _quantile(values: Sequence[float], share: float, unit: float = 1.0) -> float | None:
    return rounded(float(np.quantile(values, share)) * unit) if values else None
