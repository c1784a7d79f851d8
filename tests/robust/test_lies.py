"""Whatever a solver says, no robot escapes and nothing is called inconsistent that is not."""

import numpy as np
import pytest
from helpers.liars import LIES, Liar
from helpers.worlds import World, escapes

from filter import Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent
from filter.geometry.polygon import Polygon
from filter.projection.fallback import Fallback
from filter.team import Team

# Two solvers give the same area to this share; the search stops at 95 % of what is possible.
ALIKE = 0.06
EVERY = pytest.mark.parametrize("lie", sorted(LIES))


def followed(world, estimator, steps=3):
    """Yield the beliefs of a run."""
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(steps):
        belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
        yield belief


@EVERY
@pytest.mark.parametrize("often", [0.3, 1.0])
@pytest.mark.parametrize("errors", ["uniform", "extreme"])
def test_a_liar_alone_loses_nobody(lie, often, errors):
    liar = Liar(lie, np.random.default_rng(1), often)
    world = World(np.random.default_rng(2), robots=3, errors=errors)
    for belief in followed(world, SetMembershipFilter(world.team, exact=False, solvers=(liar,))):
        assert escapes(belief, world.positions, world.headings) == []
    assert liar.told > 3


@EVERY
def test_the_next_solver_makes_good_for_a_liar(lie):
    liar = Liar(lie, np.random.default_rng(3))
    one, other = (World(np.random.default_rng(4), robots=3) for _ in range(2))
    lied_to = followed(one, SetMembershipFilter(one.team, exact=False, solvers=(liar, "piqp", "highs")))
    honest = followed(other, SetMembershipFilter(other.team))
    for belief, reference in zip(lied_to, honest, strict=True):
        areas, wanted = ([region.outer.area for region in each.regions] for each in (belief, reference))
        assert areas == pytest.approx(wanted, rel=ALIKE)
        assert escapes(belief, one.positions, one.headings) == []
        assert {event.used for event in belief.events if isinstance(event, Fallback) and event.seen_from is None} <= {"piqp"}
        assert liar.told == 0 or lie in ("a noisy point", "a stale solution") or belief.events


@EVERY
def test_what_is_inconsistent_is_found_in_spite_of_a_liar(lie):
    team = Team(2)
    solvers = Liar(lie, np.random.default_rng(5)), "piqp", "highs"
    estimator = SetMembershipFilter(team, exact=False, solvers=solvers)
    belief = estimator.start(0.0, [Polygon.box([0, 0], [1, 1]), Polygon.box([2, 0], [3, 1])])
    with pytest.raises(Inconsistent) as raised:
        estimator.update(belief, [Range(0, 0, 1, 1.2, 0.1, 0), Range(0, 1, 0, 2.9, 0.1, 0)])
    assert {source.kind for source in raised.value.sources} >= {"range"}


@pytest.mark.parametrize("broken", ["set-up", "both"])
def test_when_every_solver_fails_the_propagated_polygon_is_left(broken):
    def no_workspace(program):
        raise MemoryError

    world = World(np.random.default_rng(6), robots=3)
    liar = Liar("gives up", np.random.default_rng(7))
    estimator = SetMembershipFilter(
        world.team, exact=False, solvers=(no_workspace, liar)[: 1 if broken == "set-up" else 2], cells=0
    )
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    moved = estimator.predict(belief, 0.1, world.move())
    after = estimator.update(moved, world.measure())
    names = ("no_workspace",) if broken == "set-up" else ("no_workspace", "Liar")
    assert after.events == tuple(Fallback(robot, names, None) for robot in (0, 1, 2, None))
    assert str(after.events[0]) == f"the region of robot 0: no good answer of {', '.join(names)}, nobody took over"
    for before, now in zip(moved.regions, after.regions, strict=True):
        assert now.inner is None
        assert now.reason == "solver"
        assert now.outer.area <= before.outer.area * (1 + 1e-9)
    assert escapes(after, world.positions, world.headings) == []


def test_an_honest_run_needs_no_fallback():
    world = World(np.random.default_rng(8), robots=3)
    assert [belief.events for belief in followed(world, SetMembershipFilter(world.team))] == [()] * 3
