"""Each robot's region: what the team knows of it, and why; its box; and rows made of it."""

import numpy as np
import pytest
from helpers.programs import merged_team, on_robot
from helpers.teams import begun, beliefs
from helpers.worlds import World, escapes, exact_claim

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import SIDES, Polygon
from filter.guarantee import Guarantee
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.program import Candidate
from filter.linear.sources import Source, Sources
from filter.projection.stop import Stop
from filter.projection.team import Projector
from filter.projection.window import Window
from filter.sets.belief import Belief
from filter.sets.refine import edges_as_rows, proved_boxes, refined

WAYS = {
    "walk": Projector(Window.everybody(), Stop()),
    "small windows": Projector(Window(1, 2), Stop()),
    "piqp": Projector(Window.everybody(), Stop(), False, ("piqp",)),
    "highs": Projector(Window.everybody(), Stop(), False, ("highs",)),
}


def two_robots(offset):
    """Return robot 0 in the unit box, robot 1 in [2, 3] x [0, 1], and x_1 - x_0 <= offset along x."""
    rows = Constraints.concatenate(
        [
            on_robot(1, np.array([[-1.0, 0.0]]), np.array([-2.0]), np.array([0])),
            Constraints(np.array([0]), np.array([1]), np.array([[1.0, 0.0]]), np.array([offset]), np.array([1])),
        ]
    )
    sources, _ = Sources().extended("initial set", 0.0, [1])
    sources, _ = sources.extended("range", 1.0, [0], [1])
    polytope = Polytope(rows, np.array([[0.0, 0.0], [0.0, 0.0]]), np.array([[1.0, 1.0], [3.0, 1.0]]))
    return Belief(1.0, polytope, AngularIntervals.circles(2), sources, Guarantee.full(2))


@pytest.mark.parametrize("way", WAYS)
def test_regions_are_what_the_pair_implies_and_their_edges_name_why(way):
    found = refined(two_robots(1.5), WAYS[way])
    left, regions, table = found.polytope, found.regions, found.sources
    assert regions[0].outer.bounds[0] == pytest.approx([0.5, 0], abs=1e-6)
    assert regions[1].outer.bounds[1] == pytest.approx([2.5, 1], abs=1e-6)
    (edge,) = np.flatnonzero(np.abs(regions[0].outer.normals - np.array([-1.0, 0.0])).max(axis=1) < 1e-6)
    assert [table[int(number)].kind for number in regions[0].causes[edge]] == ["initial set", "range"]
    assert left.lower[0] == pytest.approx([0.5, 0], abs=1e-6)
    assert {table[int(number)].kind for number in left.constraints.source} >= {"range", "region"}


@pytest.mark.parametrize("way", WAYS)
def test_what_excludes_one_another_is_named_the_newest_last(way):
    with pytest.raises(
        Inconsistent, match=r"at 1\.0 s: .*initial set of robot 1 at 0\.000 s; range of robot 0 to 1 at 1\.000 s"
    ) as raised:
        refined(two_robots(0.5), WAYS[way])
    assert [source.kind for source in raised.value.sources] == ["initial set", "range"]


@pytest.mark.parametrize("way", WAYS)
def test_regions_that_just_touch_are_not_inconsistent(way):
    regions = refined(two_robots(1.0), WAYS[way]).regions
    assert regions[0].outer.contains([1.0, 0.5])
    assert regions[1].outer.contains([2.0, 0.5])


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
    estimator = SetMembershipFilter(world.team, exact=False, solvers=(work,))
    belief = begun(estimator, world)
    for motion, records in world.steps(4):
        belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []
    if kind == "gives up":
        assert {region.reason for region in belief.regions} == {"solver"}


@pytest.mark.parametrize("seed", [2, 3, 4])
def test_a_region_is_within_what_was_known_of_the_robot_before(seed):
    world = World(np.random.default_rng(seed), robots=3)
    estimator = SetMembershipFilter(world.team)
    belief = begun(estimator, world)
    after = estimator.update(belief, world.measure())
    for robot in range(3):
        before, now = belief.regions[robot].outer, after.regions[robot].outer
        assert isinstance(now, Polygon)
        assert (now.bounds[0] >= before.bounds[0] - 1e-9).all()
        assert now.area <= before.area + 1e-9


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 3)])
@pytest.mark.parametrize(("errors", "origin"), [("uniform", 0.0), ("extreme", 0.0), ("uniform", 5e6)])
def test_every_side_of_a_box_is_proved_and_touches_the_polygon(scope, errors, origin):
    world = World(np.random.default_rng(8), robots=4, errors=errors, origin=np.full(2, origin))
    *_, belief = beliefs(SetMembershipFilter(world.team, scope=scope), world, 2)
    *_, boxes = belief.proofs_of("boxes")
    assert boxes.j.tolist() == np.repeat(range(4), 4).tolist()
    assert boxes.normal.tolist() == np.tile(SIDES, (4, 1)).tolist()
    for claim in range(len(boxes)):
        assert exact_claim(boxes, claim) <= 0
        outer = belief.regions[boxes.j[claim]].outer
        extent = (boxes.normal[claim] * outer.vertices).sum(axis=1).max()
        assert boxes.offset[claim] == pytest.approx(extent, abs=1e-9 + 1e-14 * origin)
    found = boxes.offset.reshape(4, 4)
    assert (belief.polytope.upper <= found[:, :2]).all()
    assert (belief.polytope.lower >= -found[:, 2:]).all()


def outlines_of(polytope, way="walk"):
    return WAYS[way].robots(polytope).outlines


def test_only_the_boxes_that_are_asked_for_are_made_smaller():
    polytope = merged_team(0)
    outlines, whose = outlines_of(polytope), (np.full(5, WORLD), np.arange(5))
    edges = edges_as_rows(polytope, outlines, whose, np.zeros(5, dtype=int))
    lower, upper, proof = proved_boxes(polytope, Sources(), outlines, edges, np.array([1, 3]))
    assert proof.j.tolist() == [1] * 4 + [3] * 4
    for robot in range(5):
        smaller = (lower[robot] > polytope.lower[robot]).any() or (upper[robot] < polytope.upper[robot]).any()
        assert smaller == (robot in (1, 3))
        assert (lower[robot] <= outlines.outer[robot].vertices.min(axis=0) + 1e-9).all()


def test_edges_become_rows_known_ones_with_their_sources_new_ones_with_the_regions():
    polytope = merged_team(2)
    outlines, whose, rows = outlines_of(polytope), (np.full(5, WORLD), np.arange(5)), polytope.constraints
    numbers = 1000 + np.arange(5)
    own, row = edges_as_rows(polytope, outlines, whose, numbers)
    assert (row < len(own)).any()
    sides = 0
    for edge, robot in enumerate(outlines.outer.owner.tolist()):
        used, _ = outlines.weights.rests_on(edge)
        if row[edge] == len(own):
            assert len(used) == 0  # a side of the box is no row
            sides += 1
            continue
        at = row[edge]
        assert (own.i[at], own.j[at]) == (WORLD, robot)
        assert own.normal[at].tolist() == outlines.outer.normals[edge].tolist()
        assert own.offset[at] == outlines.outer.offsets[edge]
        known = len(used) == 1 and (rows.i[used[0]], rows.j[used[0]]) == (WORLD, robot)
        assert own.source[at] == (rows.source[used[0]] if known else numbers[robot])
    assert len(own) == len(row) - sides
    assert set(own.source.tolist()) & set(numbers.tolist())
    assert set(own.source.tolist()) - set(numbers.tolist())


def test_after_a_projection_only_edges_are_left_of_rows_on_single_robots():
    polytope = merged_team(1)
    sources, _ = Sources().extended("range", 0.0, np.zeros(999, dtype=int))
    found = refined(Belief(2.0, polytope, AngularIntervals.circles(5), sources, Guarantee.full(5)), WAYS["walk"])
    rows = found.polytope.constraints
    pairs = polytope.constraints.i != WORLD
    assert rows.offset[rows.i != WORLD].tolist() == polytope.constraints.offset[pairs].tolist()
    assert sorted(rows.offset[rows.i == WORLD].tolist()) == sorted(
        found.regions.outer.offsets[found.proofs[0].weights.counts > 0].tolist()
    )
    assert [found.sources[k] for k in found.polytope.origin.tolist()] == [Source("region", 2.0, k) for k in range(5)]
