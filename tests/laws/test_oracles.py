"""Two ways to compute a thing agree: PIQP with HiGHS, the filter with an LP over everything that was ever measured."""

import numpy as np
import pytest
from helpers.worlds import World, random_program, unit
from scipy.optimize import linprog

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.polygon import Polygon
from filter.linear.solvers import workspace
from filter.projection.proved import position
from filter.projection.stop import Stop
from filter.sets import set_membership

# PIQP's optimum is this close to that of HiGHS, with the box as the unit.
SUPPORT = 1e-7
# Regions of two solvers differ by this [m]: a corner cut off by 1e-9 of a square metre, as `TIGHT` allows, is up to 3e-5 deep.
REGION = 1e-5
TIGHT = Stop(performance_ratio=1 - 1e-9, searches=80)


@pytest.mark.parametrize("origin", [0.0, 5e6])
@pytest.mark.parametrize(("robots", "rows"), [(1, 4), (2, 12), (5, 60), (12, 200)])
def test_piqp_finds_the_supports_of_highs(robots, rows, origin):
    rng = np.random.default_rng(rows)
    for size in (1e-3, 1.0, 1e3):
        program = random_program(rng, robots, rows, size, origin)
        work = workspace(program, "piqp")
        box = np.stack([program.lower - program.centre, program.upper - program.centre], axis=1)
        for angle in rng.uniform(-np.pi, np.pi, 3):
            objective = unit(angle) @ position(int(rng.integers(robots)), robots)
            oracle = -linprog(-objective, program.A.toarray(), program.slack, bounds=box, method="highs").fun
            found = work.maximize(objective)
            bound = program.certified_bounds(objective[None], found.multipliers[None])[0]
            rounding = 1e-12 * origin
            assert objective @ (found.point - program.centre) == pytest.approx(oracle, abs=SUPPORT * size + rounding)
            assert bound - objective @ program.centre == pytest.approx(oracle, abs=SUPPORT * size + rounding)


def supports(polygon: Polygon):
    return polygon.support(unit(np.linspace(-np.pi, np.pi, 60, endpoint=False)))


def searching(world, solver, **options):
    return SetMembershipFilter(world.team, exact=False, solvers=(solver,), stop=TIGHT, **options)


@pytest.mark.parametrize("seed", range(3))
def test_both_solvers_give_the_same_regions(seed):
    """From the same belief each time, since two solvers may keep different rows."""
    world = World(np.random.default_rng(seed), robots=3)
    one, other = (searching(world, solver, rows_per_robot=40, rows_per_pair=40) for solver in ("piqp", "highs"))
    belief = one.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(3):
        predicted = one.predict(belief, motion.time, motion)
        belief, same = one.update(predicted, records), other.update(predicted, records)
        for mine, theirs in zip(belief.regions, same.regions, strict=True):
            assert supports(mine.outer) == pytest.approx(supports(theirs.outer), abs=REGION)
            assert mine.inner.area == pytest.approx(theirs.inner.area, abs=1e-4)


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize("seed", range(3))
def test_a_regions_supports_are_those_of_the_merged_polytope(seed, exact, monkeypatch):
    """The polytope is caught on its way to the projection; HiGHS says how far each robot can be."""
    caught = []
    original = set_membership.refined
    monkeypatch.setattr(
        set_membership,
        "refined",
        lambda belief, *rest, **more: caught.append(belief.polytope) or original(belief, *rest, **more),
    )
    world = World(np.random.default_rng(seed), robots=3)
    estimator = SetMembershipFilter(world.team, stop=TIGHT, cells=0) if exact else searching(world, "piqp", cells=0)
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    (polytope,) = caught
    program = polytope.program()
    box = np.stack([program.lower, program.upper], axis=1)
    for robot, region in enumerate(belief.regions):
        for angle in np.linspace(-np.pi, np.pi, 7):
            objective = unit(angle) @ position(robot, 3)
            oracle = -linprog(-objective, program.A.toarray(), program.b, bounds=box, method="highs").fun
            assert region.outer.support(unit(angle)[None])[0] == pytest.approx(oracle, abs=1e-5)
            assert region.outer.support(unit(angle)[None])[0] >= oracle - 1e-9


def test_pruning_costs_little_against_the_whole_history():
    """Ten steps of a team, with budgets as they are by default and with room for everything."""
    areas = {}
    for budget in (12, 10_000):
        world = World(np.random.default_rng(0), robots=4)
        estimator = SetMembershipFilter(world.team, stop=TIGHT, rows_per_robot=budget, rows_per_pair=budget)
        belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
        for motion, records in world.steps(8):
            belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
        areas[budget] = sum(region.outer.area for region in belief.regions)
    assert areas[10_000] * 0.999 <= areas[12] <= 1.25 * areas[10_000]
