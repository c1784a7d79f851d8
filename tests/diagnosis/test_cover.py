"""The arc around headings contains all of them, and not much more."""

import numpy as np
import pytest

from filter.diagnosis.cover import arcs_around
from filter.geometry.angles import AngularIntervals


@pytest.mark.parametrize("seed", range(60))
def test_an_arc_contains_each_arc_also_behind(seed):
    rng = np.random.default_rng(seed)
    count, middle = int(rng.integers(1, 6)), rng.choice([0.0, np.pi, rng.uniform(-np.pi, np.pi)])
    several = [
        AngularIntervals(middle + rng.uniform(-1, 1, 3), rng.choice([0.0, 0.3, 2.0, np.pi], 3, p=[0.3, 0.4, 0.2, 0.1]))
        for _ in range(count)
    ]
    around = arcs_around(several)
    for arcs in several:
        for share in (-1.0, -0.3, 0.0, 0.9, 1.0):
            angles = arcs.centre + share * np.minimum(arcs.bound, np.pi) * (1 - 1e-15)
            inside = arcs.contains(angles)
            assert (around.contains(angles) | ~inside).all()
    least = np.max([arcs.bound for arcs in several], axis=0)
    assert (around.bound >= least - 1e-12).all()


def test_arcs_on_both_sides_of_the_cut_are_joined_there():
    around = arcs_around([AngularIntervals([np.pi - 0.2], [0.1]), AngularIntervals([-np.pi + 0.3], [0.1])])
    assert around.bound[0] == pytest.approx(0.35)
    assert around.contains(np.pi)[0]
    assert not around.contains(0.0)[0]
