"""A Kalman filter beside the filter of a run: it is given the same frames, and where it fails only its trajectory ends."""

from __future__ import annotations

from experiments.following.scenarios import Scenario
from experiments.logs import first_belief
from filter import CorralError, ExtendedKalmanFilter, Frame, GaussianBelief, follow

MOST_ROBOTS = 30  # a step grows with the cube of the team; with so many it takes about as long as that of the sets


class Beside:
    """Follows a scenario with a Kalman filter, if the team is not too large.

    Attributes:
        failure: Why it has ended, or None.
    """

    def __init__(self, scenario: Scenario) -> None:
        self._kalman, self._scenario = ExtendedKalmanFilter(scenario.team), scenario
        self._belief: GaussianBelief | None = None
        self.failure = f"more than {MOST_ROBOTS} robots" if scenario.team.robots > MOST_ROBOTS else None

    def estimate(self, frame: Frame) -> GaussianBelief | None:
        """Return what the Kalman filter believes after the next frame; None if it has ended."""
        if self.failure is None:
            try:
                self._belief = self._next(frame)
            except CorralError as error:
                self.failure = self._scenario.team.words(error)
        return self._belief if self.failure is None else None

    def _next(self, frame: Frame) -> GaussianBelief:
        known = self._belief or first_belief(self._kalman, self._scenario.header, self._scenario.initial)
        (step,) = follow(self._kalman, known, [frame])
        return step.belief
