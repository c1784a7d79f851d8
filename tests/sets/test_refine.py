"""Each robot's region: what the team knows of it, and why."""

import numpy as np
import pytest
from helpers.worlds import World, escapes

from filter.errors import Inconsistent
from filter.geometry.polygon import Polygon
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.linear.solvers import Candidate
from filter.projection.stop import Stop
from filter.sets.belief import Sources
from filter.sets.refine import regions_at_a_glance, searched
from filter.sets.set_membership import SetMembershipFilter


def two_robots(offset):
    """Return robot 0 in the unit box, robot 1 in [2, 3] x [0, 1], and x_1 - x_0 <= offset along x."""
    rows = Constraints.concatenate(
        [
            Constraints.on_robot(1, np.array([[-1.0, 0.0]]), np.array([-2.0]), np.array([0])),
            Constraints(np.array([0]), np.array([1]), np.array([[1.0, 0.0]]), np.array([offset]), np.array([1])),
        ]
    )
    sources, _ = Sources().extended("initial set", 0.0, [1])
    sources, _ = sources.extended("range", 1.0, [0], [1])
    return Polytope(rows, np.array([[0.0, 0.0], [0.0, 0.0]]), np.array([[1.0, 1.0], [3.0, 1.0]])), sources


@pytest.mark.parametrize("solver", ["piqp", "highs"])
def test_regions_are_what_the_pair_implies_and_their_edges_name_why(solver):
    polytope, sources = two_robots(1.5)
    found = searched(1.0, polytope, sources, [solver], stop=Stop())
    left, regions, table = found.polytope, found.regions, found.sources
    assert regions[0].outer.bounds[0] == pytest.approx([0.5, 0], abs=1e-6)
    assert regions[1].outer.bounds[1] == pytest.approx([2.5, 1], abs=1e-6)
    (edge,) = np.flatnonzero(np.abs(regions[0].outer.normals - np.array([-1.0, 0.0])).max(axis=1) < 1e-6)
    assert [table[int(number)].kind for number in regions[0].causes[edge]] == ["initial set", "range"]
    assert left.lower[0] == pytest.approx([0.5, 0], abs=1e-6)
    assert {table[int(number)].kind for number in left.constraints.source} >= {"range", "region"}


@pytest.mark.parametrize("solver", ["piqp", "highs"])
def test_what_excludes_one_another_is_named_the_newest_last(solver):
    polytope, sources = two_robots(0.5)
    with pytest.raises(
        Inconsistent, match=r"at 1\.0 s: .*initial set of robot 1 at 0\.000 s; range of robot 0 to 1 at 1\.000 s"
    ) as raised:
        searched(1.0, polytope, sources, [solver], stop=Stop())
    assert [source.kind for source in raised.value.sources] == ["initial set", "range"]


def test_regions_that_just_touch_are_not_inconsistent():
    polytope, sources = two_robots(1.0)
    regions = searched(1.0, polytope, sources, ["piqp"], stop=Stop()).regions
    assert regions[0].outer.contains([1.0, 0.5])
    assert regions[1].outer.contains([2.0, 0.5])


def test_at_a_glance_nothing_is_searched():
    polytope, _ = two_robots(1.5)
    regions = regions_at_a_glance(polytope)
    assert [region.outer.area for region in regions] == pytest.approx([1.0, 1.0])
    assert all(region.searches == 0 and region.reason is None and region.inner is None for region in regions)


class Silent:
    """A solver that gives up each time, or says what is no help."""

    def __init__(self, answer=None):
        self.answer = answer

    def maximize(self, objective):
        return self.answer


@pytest.mark.parametrize("kind", ["gives up", "noise", "zero"])
def test_a_filter_whose_solver_fails_still_contains_the_truth(kind):
    rng = np.random.default_rng(0)

    def work(program):
        rows, variables = len(program.b), len(program.lower)
        noise = Candidate(program.centre + rng.normal(size=variables), rng.exponential(3, rows))
        return Silent({"gives up": None, "noise": noise, "zero": Candidate(program.centre, np.zeros(rows))}[kind])

    world = World(rng, robots=3)
    estimator = SetMembershipFilter(world.team, work, fallbacks=())
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(4):
        belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []
    if kind == "gives up":
        assert {region.reason for region in belief.regions} == {"solver"}


def test_a_region_is_within_what_was_known_of_the_robot_before():
    world = World(np.random.default_rng(2), robots=3)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    after = estimator.update(belief, world.measure())
    for robot in range(3):
        before, now = belief.regions[robot].outer, after.regions[robot].outer
        assert isinstance(now, Polygon)
        assert (now.bounds[0] >= before.bounds[0] - 1e-9).all()
        assert now.area <= before.area + 1e-9
