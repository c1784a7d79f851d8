"""Signs that only a close look tells from their opposite; each was found by `python tests/mutate.py`."""

import numpy as np
import pytest

from filter.angles import AngularIntervals
from filter.measurements import Odometry
from filter.motion import displacements
from filter.team import Team


@pytest.mark.parametrize("slip", [1e-6, 0.3, 1e6])
def test_slip_alone_reaches_no_less_than_itself(slip):
    moves = displacements(Odometry(0.0, 1.0, 0, 0, 0, 0, 0, 0, slip), AngularIntervals([0.0], [0.1]), Team(1), 1.0)
    sides = np.array([[1.0, 0.0], [0.0, 1.0], [-1.0, 0.0], [0.0, -1.0]])
    support = moves.support(np.zeros(4, dtype=int), sides)
    assert (support > slip).all()
    assert support == pytest.approx(slip)
