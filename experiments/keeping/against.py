"""What a Kalman filter did in a run: how far its points were from the truth, and how many of them the regions exclude."""

from __future__ import annotations

from types import TracebackType
from typing import Any

import numpy as np

from experiments.following.ellipses import WIDE_SIZE, Collected, ellipse_areas, normalised_squares
from experiments.following.located import inside, points, there
from experiments.following.metrics import Value
from experiments.keeping.running import Moment, Told
from filter import Array, GaussianBelief, Truth


class Against(Told):
    """Judges the Kalman filter of a run: by the truth where it is known, and by the regions of the filter that it is beside.

    A point outside a region that is guaranteed is proved wrong, whatever the truth is.
    """

    def __init__(self) -> None:
        self._collected, self._points, self._outside = Collected(), 0, 0

    def keep(self, moment: Moment) -> None:
        """Take one step in."""
        belief, beside = moment.step.belief, moment.beside
        if isinstance(belief, GaussianBelief):
            self._add(belief, moment.step.frame.truth)
        elif beside is not None:
            self._add(beside, moment.step.frame.truth)
            self._compare(beside, belief)

    def _add(self, estimate: GaussianBelief, truth: Truth | None) -> None:
        covariances = estimate.position_covariances
        self._collected.add("area", ellipse_areas(covariances))
        if truth is not None:
            known = np.isfinite(truth.positions).all(axis=1) & there(estimate)
            self._add_errors((points(estimate) - truth.positions)[known], covariances[known])

    def _add_errors(self, errors: Array, covariances: Array) -> None:
        self._collected.add("square", (errors**2).sum(axis=1))
        self._collected.add("contained", normalised_squares(errors, covariances) <= WIDE_SIZE)

    def _compare(self, estimate: GaussianBelief, belief: Any) -> None:
        in_force = belief.guarantee.in_force
        self._points += int(in_force.sum())
        self._outside += int((in_force & ~inside(belief, points(estimate))).sum())

    def summary(self) -> dict[str, Value]:
        """Return flat values with units in their names; None for what nothing is known of."""
        return {
            "ekf_point_rmse_m": self._collected.root_mean("square"),
            "ekf_containment_997": self._collected.mean("contained"),
            "ekf_area_997_mean_m2": self._collected.mean("area"),
            "ekf_points_judged": self._points,
            "ekf_points_proved_wrong": self._outside,
        }

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        """Do nothing: there is no file."""
