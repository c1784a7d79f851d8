"""What several cases leave when they become one: places, headings, pairs, and poses of wide headings."""

import numpy as np
import pytest
from helpers.drawn.broken import stepped
from helpers.drawn.tolerant import tolerant

from experiments.beacons.scenes import DRIVES
from filter import SetMembershipFilter

ROUNDING = 1e-9  # [m]


@pytest.mark.parametrize("seed", [0])
def test_what_becomes_one_contains_every_case(seed):
    """When a window ends: places, headings, pairs, and poses of wide headings together."""
    drive = DRIVES[seed].drawn([seed, 8], 6, 0.1)
    filter_ = tolerant(drive.team, window=9.0)
    belief = filter_.start(0.0, drive.initial, drive.headings)
    for frame in drive.frames:
        belief = stepped(filter_, belief, frame)
    before = belief
    after = filter_._begun_for(before, before.time + 9.0)
    assert after.alternatives is None
    i, j = np.triu_indices(drive.team.robots, 1)
    mutual = SetMembershipFilter.relative(filter_, after, i, j)
    for one in before.alternatives.each:
        for around, region in zip(after.regions, one.belief.regions, strict=True):
            assert (region.outer.support(around.outer.normals) <= around.outer.offsets + ROUNDING).all()
        for around, part in zip(mutual, filter_.relative(one.belief, i, j), strict=True):
            assert (part.support(around.normals) <= around.offsets + 1e-6).all()
        for robot in np.unique(after.slices.robot).tolist():
            for part in poses(one.belief, robot):
                assert is_covered(part, after.slices.of(robot))


def poses(belief, robot):
    """Yield the middle of arcs of a robot's poses, and polygons' supports there."""
    mine = belief.slices.of(robot)
    for k in range(len(mine)):
        for share in (-0.99, 0.0, 0.99):
            yield mine.centre[k] + share * mine.bound[k], mine.reach[k]


def is_covered(pose, slices):
    """Return whether one of some slices has a heading, and contains a polygon."""
    angle, reach = pose
    here = slices.select(np.flatnonzero(slices.arcs.contains(np.full(len(slices), angle))))
    return bool((reach <= here.reach + ROUNDING).all(axis=1).any())
