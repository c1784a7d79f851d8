"""Ties narrow headings as far as they can, and no farther: the truth stays inside, and no tie is left that says more."""

import numpy as np
import pytest

from filter.geometry.angles import ANGLE_ROUNDING, intersection, turned, wrap
from filter.sensing.ties import LEAST, Ties, tie


def drawn(seed, count=6, ties=9):
    """Return headings, arcs around them, and ties that hold among them, some of which close rings."""
    rng = np.random.default_rng(seed)
    truth, bounds = rng.uniform(-np.pi, np.pi, count), rng.choice([0.05, 0.5, 2.0, np.pi], count)
    first = rng.integers(0, count, ties)
    last = (first + rng.integers(1, count, ties)) % count
    off = rng.choice([0.01, 0.2, 1.0], ties)
    turn = wrap(truth[last] - truth[first] + off * rng.uniform(-0.99, 0.99, ties))
    arcs = np.stack([wrap(truth + bounds * rng.uniform(-0.99, 0.99, count)), bounds])
    return truth, arcs, Ties(first, last, np.stack([turn, off], axis=1))


@pytest.mark.parametrize("seed", range(40))
def test_the_truth_stays_inside_and_nothing_is_left_to_narrow(seed):
    truth, arcs, ties = drawn(seed)
    before = arcs.copy()
    assert tie(arcs, ties) == -1
    assert (np.abs(wrap(truth - arcs[0])) <= arcs[1] + ANGLE_ROUNDING).all()
    assert (arcs[1] <= before[1]).all()
    for first, last, (by, off) in zip(ties.first, ties.last, ties.turn, strict=True):
        for whose, other, way in ((last, first, by), (first, last, -by)):
            narrowed = intersection(*arcs[:, whose], *turned(*arcs[:, other], way, off))
            assert narrowed[1] >= arcs[1, whose] - LEAST


def test_what_leaves_nothing_is_named():
    arcs = np.array([[0.0, 0.0, 3.0], [0.1, 3.0, 0.1]])
    ties = Ties(np.array([0, 1]), np.array([1, 2]), np.array([[1.0, 0.1], [1.0, 0.1]]))
    assert tie(arcs, ties) in (0, 1)
