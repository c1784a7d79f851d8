"""Boxes around polygons: proved in exact arithmetic, and as small as they can be."""

import numpy as np
import pytest
from helpers.worlds import World, exact_claim

from filter.projection.window import Window
from filter.sets.set_membership import SetMembershipFilter


@pytest.mark.parametrize("scope", ["team", Window(1, 3)])
@pytest.mark.parametrize(("errors", "origin"), [("uniform", 0.0), ("extreme", 0.0), ("uniform", 5e6)])
def test_every_side_is_proved_and_touches_the_polygon(scope, errors, origin):
    world = World(np.random.default_rng(8), robots=4, errors=errors, origin=np.full(2, origin))
    estimator = SetMembershipFilter(world.team, scope=scope)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(2):
        belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
    _, boxes, *_ = belief.proofs
    assert boxes.j.tolist() == np.repeat(range(4), 4).tolist()
    for claim in range(len(boxes)):
        assert exact_claim(boxes, claim) <= 0
        outer = belief.regions[boxes.j[claim]].outer
        extent = (boxes.normal[claim] * outer.vertices).sum(axis=1).max()
        assert boxes.offset[claim] == pytest.approx(extent, abs=1e-9 + 1e-14 * origin)
    found = boxes.offset.reshape(4, 4)
    assert (belief.polytope.upper <= found[:, :2]).all()
    assert (belief.polytope.lower >= -found[:, 2:]).all()
