"""The regions of a team, one at a time and all at once."""

import numpy as np
import pytest
from helpers.worlds import World

from filter.projection.window import Window
from filter.sets.set_membership import SetMembershipFilter


@pytest.mark.parametrize("scope", ["team", Window()])
def test_one_region_is_what_the_arrays_say(scope):
    world = World(np.random.default_rng(4), robots=4)
    estimator = SetMembershipFilter(world.team, scope=scope)
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    regions = belief.regions
    assert len(list(regions)) == len(regions) == 4
    for robot, region in enumerate(regions):
        assert region.outer.area == regions.outer.areas[robot]
        assert len(region.causes) == len(region.outer.offsets)
        assert all(len(causes) and (np.diff(causes) > 0).all() for causes in region.causes)
    assert regions[1:3][1].outer.area == regions[2].outer.area == regions[-2].outer.area
    assert regions.contains(world.positions).all()
    far = world.positions + np.array([[0, 0], [99, 0], [0, 0], [0, -99]])
    assert regions.contains(far).tolist() == [True, False, True, False]
    with pytest.raises(IndexError):
        regions[4]
    with pytest.raises(ValueError, match="read-only"):
        regions.searches[0] = 9
