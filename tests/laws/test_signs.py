"""Signs that only a close look tells from their opposite; each was found by `python tests/house/mutate.py`."""

import numpy as np
import pytest

from filter import Odometry
from filter.geometry.angles import AngularIntervals
from filter.sensing.motion import displacements
from filter.team import Team


@pytest.mark.parametrize("slip", [1e-6, 0.3, 1e6])
def test_slip_alone_reaches_no_less_than_itself(slip):
    moves = displacements(Odometry(0.0, 1.0, 0, 0, 0, 0, 0, 0, slip), AngularIntervals([0.0], [0.1]), Team(1), 1.0)
    sides = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    support = moves.support(np.zeros(4, dtype=int), sides)
    assert (support > slip).all()
    assert support == pytest.approx(slip)


def test_a_turn_that_may_be_a_whole_one_can_lead_back():
    """Beyond a whole turn the chord points the other way; the bound alone takes this turn there."""
    turned, length = 2 * np.pi + 0.04, 100.0
    chord = length * np.sin(turned / 2) / (turned / 2) * np.array([np.cos(turned / 2), np.sin(turned / 2)])
    assert chord[0] > 0.6
    seen = Odometry(0.0, 1.0, 0, length, 0.0, 2 * np.pi - 0.05, 0.1, 0.0, 0.0)
    moves = displacements(seen, AngularIntervals([0.0], [0.0]), Team(1), 1.0)
    assert moves.support(np.array([0]), np.array([[1.0, 0.0]]))[0] > chord[0]
