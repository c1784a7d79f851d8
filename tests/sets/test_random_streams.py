"""The truth is inside, whatever a stream is like: `STREAMS=10000 pytest tests/sets/test_random_streams.py` draws as many."""

import os

import numpy as np
import pytest
from helpers.drawn.streams import RandomStream

from filter import SetMembershipFilter, follow, frames_of


@pytest.mark.parametrize("seed", range(int(os.environ.get("STREAMS", "12"))))
def test_the_truth_is_inside_whatever_a_stream_is_like(seed):
    rng = np.random.default_rng(seed)
    stream = RandomStream(rng)
    filter_ = SetMembershipFilter(stream.team) if rng.uniform() < 0.5 else SetMembershipFilter.light(stream.team)
    belief = filter_.start(0.0, stream.start, stream.headings)
    frames = frames_of(stream.team, 0.0, stream.arrivals(), hold=stream.hold)
    checks = 0
    for step in follow(filter_, belief, frames, every=float(rng.choice([0, 0.05, 0.3]))):
        for robot in set(range(stream.robots)) - step.belief.guarantee.away:
            place, looks = stream.drives[robot].place(step.frame.time), stream.drives[robot].heading(step.frame.time)
            assert step.belief.regions[robot].outer.contains(place), (robot, step.frame.time)
            assert step.belief.headings[[robot]].contains(looks).all(), (robot, step.frame.time)
            checks += 1
    assert checks
