"""What two kinds of estimators did in one run: how often they held the truth, how large their regions, how far their points.

Containment, consistency and proofs count robot-steps: one robot at one step.
"""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from scipy.special import gammaincinv

from experiments.following.metrics import Metrics, rounded
from filter import Array, Belief, Floats, Frame, GaussianBelief, SetMembershipFilter, Truth, watch, wrap

Row = dict[str, float | int | str | None]

DIMENSION = 2  # of the error whose normalised square is reported: a position
USUAL, WIDE = 0.95, 0.997  # what the ellipses are said to contain
WIDE_SIZE = 2 * float(gammaincinv(DIMENSION / 2, WIDE))  # chi-square quantiles; scipy.stats takes a second to load
USUAL_SIZE = 2 * float(gammaincinv(DIMENSION / 2, USUAL))
WIDE_ANGLE = float(np.sqrt(2 * gammaincinv(1 / 2, WIDE)))
THINNEST = 1e-15  # deviation of what is said to be known exactly [m]
PAIRS_EVERY = 10  # steps between two looks at relative positions: each needs searches of its own


def normalised_squares(errors: Array, covariances: Array) -> Array:
    """Return (k,) e' P^-1 e of errors (k, 2) [m] with covariances (k, 2, 2) [m2]; expected are 2 of a consistent filter."""
    variances, axes = np.linalg.eigh(covariances)
    return np.asarray((np.einsum("kij,ki->kj", axes, errors) ** 2 / np.maximum(variances, THINNEST**2)).sum(axis=1))


def ellipse_areas(covariances: Array, size: float = WIDE_SIZE) -> Array:
    """Return (k,) areas of ellipses e' P^-1 e <= size of covariances (k, 2, 2) [m2]."""
    return np.asarray(np.pi * size * np.sqrt(np.maximum(np.linalg.det(covariances), 0)))


def outside(belief: Belief, positions: Array) -> Array:
    """Return (n, 2) positions with NaN for those inside their outer polygons: they cannot be proved wrong."""
    inside = [bool(region.outer.contains(place)) for region, place in zip(belief.regions, positions, strict=True)]
    return np.where(np.array(inside)[:, None], np.nan, positions)


def neighbours(robots: int) -> list[tuple[int, int]]:
    """Return the pairs whose relative positions are compared: each robot and the next."""
    return [(robot, robot + 1) for robot in range(robots - 1)]


@dataclass
class Collected:
    """Named lists of numbers, one list for each quantity."""

    values: dict[str, list[float]] = field(default_factory=dict)

    def add(self, name: str, values: Floats) -> None:
        """Take in values of a quantity."""
        self.values.setdefault(name, []).extend(np.asarray(values, dtype=float).ravel().tolist())

    def mean(self, name: str) -> float | None:
        """Return the mean, or None of nothing."""
        values = self.values.get(name)
        return rounded(float(np.mean(values))) if values else None

    def root_mean(self, name: str) -> float | None:
        """Return the root of the mean, or None of nothing."""
        values = self.values.get(name)
        return rounded(float(np.sqrt(np.mean(values)))) if values else None


@dataclass
class SetTally:
    """Judges the set-membership filter."""

    team_filter: SetMembershipFilter
    metrics: Metrics = field(default_factory=Metrics)
    _pairs: Collected = field(default_factory=Collected)

    def add(self, frame: Frame, belief: Belief, seconds: float) -> None:
        """Take one step in."""
        if frame.truth is None:
            return
        if self.metrics.steps % PAIRS_EVERY == 0:
            self._add_pairs(belief, frame.truth)
        self.metrics.add(frame, belief, seconds)

    def _add_pairs(self, belief: Belief, truth: Truth) -> None:
        pairs = neighbours(len(belief.regions))
        for (i, j), outer in zip(pairs, self.team_filter.relative(belief, *np.array(pairs)[:, ::-1].T), strict=True):
            apart = truth.positions[i] - truth.positions[j]
            self._pairs.add("inside", [outer.contains(apart)])
            self._pairs.add("area", [outer.area])
            self._pairs.add("square", [((outer.centroid - apart) ** 2).sum()])

    def row(self, expected: int) -> Row:
        """Return the set's part of a run's row.

        Args:
            expected: Robot-steps of the whole run; what a filter that stopped has not reached is not contained.
        """
        known, pairs = self.metrics.summary(), self._pairs
        contained = self.metrics.checks - self.metrics.escapes
        inside = self.metrics.heading_checks - self.metrics.heading_escapes
        return {
            "checks": expected,
            "set_contained": contained,
            "set_headings_contained": inside,
            "set_containment": contained / expected,
            "set_heading_containment": inside / expected,
            "set_area_m2": known["outer_area_mean_m2"],
            "set_rmse_m": known["point_rmse_m"],
            "set_relative_containment": pairs.mean("inside"),
            "set_relative_area_m2": pairs.mean("area"),
            "set_relative_rmse_m": pairs.root_mean("square"),
        }


@dataclass
class EllipseTally:
    """Judges a Kalman filter by the truth, and by what the sets prove.

    Attributes:
        seconds: How long each step took.
    """

    seconds: list[float] = field(default_factory=list)
    _robots: Collected = field(default_factory=Collected)
    _steps: int = 0

    def add(self, frame: Frame, estimate: GaussianBelief, belief: Belief, seconds: float) -> None:
        """Take one step in: what the filter believes, and what is possible."""
        if frame.truth is None:
            return
        collected, covariances = self._robots, estimate.position_covariances
        self.seconds.append(seconds)
        errors = estimate.mean[:, :2] - frame.truth.positions
        self._add("", errors, covariances)
        turned = np.abs(wrap(estimate.mean[:, 2] - frame.truth.headings))
        collected.add("heading", turned <= WIDE_ANGLE * estimate.heading_deviations)
        alarms = watch(belief, outside(belief, estimate.mean[:, :2]), covariances, WIDE)
        collected.add("proved", [len(alarms) / len(errors)])
        collected.add("proved_wholly", [sum(alarm.everything for alarm in alarms) / len(errors)])
        if self._steps % PAIRS_EVERY == 0:
            self._add_pairs(estimate, frame.truth)
        self._steps += 1

    def _add_pairs(self, estimate: GaussianBelief, truth: Truth) -> None:
        for i, j in neighbours(len(truth.positions)):
            mean, covariance = estimate.relative(i, j)
            self._add("relative_", (mean - truth.positions[i] + truth.positions[j])[None], covariance[None])

    def _add(self, prefix: str, errors: Array, covariances: Array) -> None:
        squares = normalised_squares(errors, covariances)
        self._robots.add(f"{prefix}nees", squares)
        self._robots.add(f"{prefix}usual", squares <= USUAL_SIZE)
        self._robots.add(f"{prefix}wide", squares <= WIDE_SIZE)
        self._robots.add(f"{prefix}area", ellipse_areas(covariances))
        self._robots.add(f"{prefix}square", (errors**2).sum(axis=1))

    def row(self, prefix: str) -> Row:
        """Return this filter's part of a run's row, each name with the prefix before it."""
        collected = self._robots
        columns: Row = {
            "containment_95": collected.mean("usual"),
            "containment_997": collected.mean("wide"),
            "heading_containment_997": collected.mean("heading"),
            "area_997_m2": collected.mean("area"),
            "rmse_m": collected.root_mean("square"),
            "nees_mean": collected.mean("nees"),
            "proved_wrong_share": collected.mean("proved"),
            "ellipse_proved_wrong_share": collected.mean("proved_wholly"),
            "relative_containment_95": collected.mean("relative_usual"),
            "relative_containment_997": collected.mean("relative_wide"),
            "relative_area_997_m2": collected.mean("relative_area"),
            "relative_rmse_m": collected.root_mean("relative_square"),
            "relative_nees_mean": collected.mean("relative_nees"),
        }
        return {f"{prefix}_{name}": value for name, value in columns.items()}
