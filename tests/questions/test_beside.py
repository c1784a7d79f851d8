"""The Kalman filter beside a run leaves a trajectory, and never stops the run."""

from dataclasses import replace

import numpy as np
import pytest

import experiments.following.beside
from experiments.following.beside import Beside
from experiments.following.scenarios import Scenario
from experiments.following.steps import steps
from experiments.logs import Header, InitialSet
from filter import Compass, ExtendedKalmanFilter, Frame, InvalidInput, Team


def scenario(robots=2):
    square = np.array([[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]])
    frames = [Frame(0.1 * k, None, [Compass(0.1 * k, 0, 0.1, 0.2)]) for k in range(5)]
    header = Header(Team(robots), 0.0, 10.0)
    return Scenario(header, (InitialSet(square),) * robots, iter(frames), 5, np.zeros((0, 4)), 0.0, None)


def test_it_is_the_kalman_filter_on_the_same_frames():
    beside, alone = Beside(scenario()), steps(ExtendedKalmanFilter(Team(2)), scenario())
    for frame, step in zip(scenario().frames, alone, strict=True):
        assert (beside.estimate(frame).mean == step.belief.mean).all()
    assert beside.failure is None


def test_where_it_cannot_go_on_it_ends_and_says_why(monkeypatch):
    def fails(filter_, belief, measurements):
        if belief.time > 0.15:
            raise InvalidInput("smaller numbers", 1e300)
        return belief

    monkeypatch.setattr(experiments.following.beside.ExtendedKalmanFilter, "update", fails)
    beside = Beside(scenario())
    assert [beside.estimate(frame) is None for frame in scenario().frames] == [False, False, True, True, True]
    assert "smaller numbers" in beside.failure


@pytest.mark.parametrize(("robots", "follows"), [(30, True), (31, False)])
def test_a_team_that_is_too_large_has_none(robots, follows):
    beside = Beside(replace(scenario(robots)))
    assert (beside.estimate(Frame(0.0)) is not None) == follows
    assert (beside.failure is None) == follows
