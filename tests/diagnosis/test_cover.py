"""What holds in each of several cases: arcs around headings; and places, pairs, and poses when they become one."""

import numpy as np
import pytest
from helpers.drawn.broken import stepped
from helpers.drawn.tolerant import tolerant

from experiments.beacons.scenes import DRIVES
from filter import SetMembershipFilter
from filter.diagnosis.cover import arcs_around
from filter.geometry.angles import AngularIntervals

ROUNDING = 1e-9  # [m]


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


@pytest.mark.parametrize("seed", [0])
def test_what_becomes_one_contains_every_case(seed):
    """When a window ends: places, headings, pairs, and poses of wide headings together."""
    drive = DRIVES[seed].drawn([seed, 8], 6, 0.1)
    filter_ = tolerant(drive.team, window=9.0)
    belief = filter_.start(0.0, drive.initial, drive.headings)
    for frame in drive.frames:
        belief = stepped(filter_, belief, frame)
    before = belief
    after = filter_._begun_for(before, before.time + 9.0, before.time).alternatives.united
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
