"""One run of the comparison: the same log through the set-membership filter and through Kalman filters."""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from itertools import tee
from typing import Any

import numpy as np

from experiments.against_ekf.tuning import CONSERVATIVE, TUNED
from experiments.following.ellipses import EllipseTally, Row, SetTally, ellipse_areas, normalised_squares
from experiments.following.metrics import rounded
from experiments.following.scenarios import Scenario
from experiments.following.simulated import from_simulator
from experiments.following.steps import steps
from filter import Belief, ExtendedKalmanFilter, GaussianBelief, Inconsistent, SetMembershipFilter, Step, Team
from sim.episode import episode
from sim.errors import ErrorKind

BASELINES = ("ekf", "ekf_conservative")
SERIES = ("set_area_m2", "ekf_area_997_m2", "ekf_nees")


@dataclass(frozen=True)
class Case:
    """A run to compare filters on.

    Attributes:
        errors: The kind of the sensors' errors.
        seed: Where all randomness comes from.
        robots: Number of robots.
        duration: How long [s].
        rate: Steps a second [Hz].
    """

    errors: ErrorKind
    seed: int
    robots: int
    duration: float
    rate: float = 10.0

    @property
    def name(self) -> str:
        """The name of its result."""
        return f"{self.errors}-{self.seed}"

    def scenario(self) -> Scenario:
        """Return the run, simulated as its frames are taken.

        Raises:
            InvalidInput: The simulator cannot do this.
        """
        simulated = episode(robots=self.robots, duration=self.duration, rate=self.rate, seed=self.seed, errors=self.errors)
        return from_simulator(simulated, self.rate)


def baselines(team: Team, errors: ErrorKind) -> dict[str, ExtendedKalmanFilter]:
    """Return the Kalman filters to compare with, by the names in `BASELINES`: tuned to the errors, and to bounds alone."""
    return {"ekf": ExtendedKalmanFilter(team, TUNED[errors]), "ekf_conservative": ExtendedKalmanFilter(team, CONSERVATIVE)}


def side_by_side(
    team_filter: SetMembershipFilter, kalmans: Mapping[str, ExtendedKalmanFilter], scenario: Scenario
) -> Iterator[tuple[Step[Belief], dict[str, Step[GaussianBelief]]]]:
    """Yield each step of the set-membership filter with those of the Kalman filters, by name, at the same frame.

    Raises:
        CorralError: What the scenario or a filter raises.
    """
    own, *others = (replace(scenario, frames=frames) for frames in tee(scenario.frames, 1 + len(kalmans)))
    estimates = {name: steps(kalman, other) for (name, kalman), other in zip(kalmans.items(), others, strict=True)}
    for step in steps(team_filter, own):
        yield step, {name: next(estimate) for name, estimate in estimates.items()}


def compare(case: Case) -> dict[str, Any]:
    """Return a run's `row` of results, its `timings`, and means over the robots in every second as `series`.

    Raises:
        InvalidInput: The simulator cannot do this.
    """
    scenario = case.scenario()
    team_filter = SetMembershipFilter(scenario.team)
    sets, tallies = SetTally(team_filter), {name: EllipseTally() for name in BASELINES}
    series: dict[str, list[float]] = defaultdict(list)
    conflict = 0
    try:
        for step, estimates in side_by_side(team_filter, baselines(scenario.team, case.errors), scenario):
            sets.add(step.frame, step.belief, step.seconds)
            for name, estimate in estimates.items():
                tallies[name].add(step.frame, estimate.belief, step.belief, estimate.seconds)
            _extend(series, step, estimates["ekf"].belief)
    except Inconsistent:
        conflict = 1
    expected = case.robots * (scenario.count or 0)
    row: Row = {"errors": case.errors, "seed": case.seed, **sets.row(expected), "set_inconsistent": conflict}
    for name, tally in tallies.items():
        row |= tally.row(name)
    milliseconds = {name: _median_ms(tally.seconds) for name, tally in tallies.items()}
    timings = {"set_step_ms": sets.metrics.summary()["step_median_ms"], "ekf_step_ms": milliseconds["ekf"]}
    return {"row": row, "timings": timings, "series": _by_second(series, round(case.rate))}


def _extend(series: dict[str, list[float]], step: Step[Belief], estimate: GaussianBelief) -> None:
    covariances = estimate.position_covariances
    series["set_area_m2"].append(float(np.mean([region.outer.area for region in step.belief.regions])))
    series["ekf_area_997_m2"].append(float(ellipse_areas(covariances).mean()))
    if step.frame.truth is not None:
        errors = estimate.mean[:, :2] - step.frame.truth.positions
        series["ekf_nees"].append(float(normalised_squares(errors, covariances).mean()))


def _by_second(series: Mapping[str, list[float]], rate: int) -> dict[str, list[float]]:
    """Return the mean of each second that has begun."""
    return {
        name: [rounded(float(np.mean(series[name][k : k + rate]))) for k in range(0, len(series[name]), max(rate, 1))]
        for name in SERIES
    }


def _median_ms(seconds: list[float]) -> float | None:
    return rounded(1e3 * float(np.median(seconds))) if seconds else None
