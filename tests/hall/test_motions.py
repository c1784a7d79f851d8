"""Odometry at stamps of its own, joined and cut: what a robot can have done in between is within what is said of it."""

from itertools import pairwise

import numpy as np
import pytest
from helpers.drives import TICK, Drive
from hypothesis import given, settings
from hypothesis import strategies as st

from filter import AngularIntervals, Motions, Team
from filter.sensing.motion import displacements, turned_headings

WAYS = np.linspace(-np.pi, np.pi, 181)
DIRECTIONS = np.stack([np.cos(WAYS), np.sin(WAYS)], axis=1)


def holds(team, odometry, drive, begin, end):
    """Check that what was said of the motion between two ticks contains it."""
    heading = AngularIntervals([0.3], [0.0])
    turned = turned_headings(odometry, heading, team, (end - begin) * TICK)
    assert turned.contains(np.array([0.3 + drive.heading[end] - drive.heading[begin]])).all()
    c, s = np.cos(0.3 - drive.heading[begin]), np.sin(0.3 - drive.heading[begin])
    moved = np.array([[c, -s], [s, c]]) @ (drive.place[end] - drive.place[begin])
    support = displacements(odometry, heading, team, (end - begin) * TICK).support(np.zeros(len(WAYS), dtype=int), DIRECTIONS)
    assert (DIRECTIONS @ moved <= support + 1e-9).all()


@pytest.mark.parametrize("kind", ["driving", "standing", "on the spot", "sideways"])
@settings(max_examples=16, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_what_is_said_of_any_interval_contains_what_was_done_in_it(kind, seed):
    rng = np.random.default_rng(seed)
    drive = Drive(rng, kind)
    team = Team(1, **drive.limits)
    motions, stamps = Motions(team), np.unique(rng.integers(0, len(drive.path), 12))
    spans = [span for span in pairwise(stamps) if span[1] - span[0] < 150 and rng.random() < 0.9]
    for begin, end in rng.permutation(np.array(spans, dtype=int).reshape(-1, 2)).tolist():
        motions = motions.merged(drive.record(begin, end))
    for _ in range(8):
        begin, end = np.sort(rng.integers(0, len(drive.path), 2)).tolist()
        if rng.random() < 0.3 and spans:
            begin, end = spans[rng.integers(len(spans))]
        if begin < end:
            holds(team, motions.between(begin * TICK, end * TICK), drive, begin, end)
