"""Boxes around polygons: proved in exact arithmetic, and as small as they can be."""

from fractions import Fraction

import numpy as np
import pytest
from worlds import World

from filter.set_membership import SetMembershipFilter
from filter.window import Window


def exact_bound(proof, claim):
    """Return the least offset that the claim's multipliers prove, without any rounding."""
    rows, box = proof.polytope.constraints, (proof.polytope.lower, proof.polytope.upper)
    robot = int(proof.robot[claim])
    left, bound = [Fraction(float(x)) for x in proof.normal[claim]], Fraction(0)
    used, prices = proof.rests_on(claim)
    for row, price in zip(used.tolist(), map(Fraction, prices.tolist()), strict=True):
        assert (rows.i[row], rows.j[row]) == (-1, robot)
        bound += price * Fraction(rows.offset[row])
        left = [x - price * Fraction(n) for x, n in zip(left, rows.normal[row].tolist(), strict=True)]
    return bound + sum(max(x * Fraction(box[0][robot, m]), x * Fraction(box[1][robot, m])) for m, x in enumerate(left))


@pytest.mark.parametrize("scope", ["team", Window(1, 3)])
@pytest.mark.parametrize(("errors", "origin"), [("uniform", 0.0), ("extreme", 0.0), ("uniform", 5e6)])
def test_every_side_is_proved_and_touches_the_polygon(scope, errors, origin):
    world = World(np.random.default_rng(8), robots=4, errors=errors, origin=np.full(2, origin))
    estimator = SetMembershipFilter(world.team, scope=scope)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(2):
        belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
    _, boxes = belief.proofs
    assert boxes.robot.tolist() == np.repeat(range(4), 4).tolist()
    for claim in range(len(boxes)):
        assert exact_bound(boxes, claim) <= Fraction(boxes.offset[claim])
        outer = belief.regions[boxes.robot[claim]].outer
        extent = (boxes.normal[claim] * outer.vertices).sum(axis=1).max()
        assert boxes.offset[claim] == pytest.approx(extent, abs=1e-9 + 1e-14 * origin)
    found = boxes.offset.reshape(4, 4)
    assert (belief.polytope.upper <= found[:, :2]).all()
    assert (belief.polytope.lower >= -found[:, 2:]).all()
