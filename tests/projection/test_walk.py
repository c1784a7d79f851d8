"""The walk: against HiGHS, against the search, on degenerate teams; and what it proves of empty ones."""

import numpy as np
import pytest
from helpers.programs import (
    EVERYTHING,
    every_pair,
    everybody,
    excess,
    links_of,
    merged_team,
    on_robot,
    random_polytope,
    single,
    supports,
    team_program,
)
from helpers.teams import begun
from helpers.worlds import World, unit

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.sheet import Task, blank
from filter.projection.simplex import FOUND, LOST
from filter.projection.stop import REASONS, Stop
from filter.projection.walk import edges_of, plane_of, project_some, vertices_of, walked

DIRECTIONS = unit(np.linspace(-np.pi, np.pi, 13))
BOTH = ("piqp", "highs")


def regions(polytope, stop=EVERYTHING, solvers=()):
    """Return the outlines of all robots, which no solver had to help with if none is named."""
    found = everybody(stop, solvers=solvers).robots(polytope)
    assert solvers or not found.failures
    return found.outlines


def region(polytope, stop=EVERYTHING, robot=0):
    return regions(polytope, stop).outer[robot]


def task_of(polytope, stop=EVERYTHING):
    box = polytope.lower, polytope.upper
    return Task(99, 99, True, stop.goal, links_of(polytope), polytope.constraints.rows, box)


def around(count, radius=1.0):
    normal = unit(2 * np.pi * np.arange(count) / count)
    return single(normal, np.full(count, radius), [-2, -2], [2, 2])


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("thin", [1.0, 1e-6, 0.0])
def test_the_projection_reaches_as_far_as_highs_says(seed, thin):
    rng = np.random.default_rng(seed)
    robots = int(rng.integers(1, 6))
    polytope = random_polytope(rng, robots, int(rng.integers(0, 60)), thin, at=rng.choice([0.0, 1e3]))
    robot, other = int(rng.integers(0, robots)), int(rng.integers(0, robots))
    team = everybody(solvers=BOTH).robots(polytope)
    if not thin and team.contradiction is not None:  # rows through one point can exclude one another by an ulp
        assert polytope.program().proves_empty(team.contradiction)
        return
    found = [(team.outlines.outer[robot], WORLD, robot)]
    if robot != other:
        i, j = min(robot, other), max(robot, other)
        pair = everybody().pairs(polytope, (np.array([i]), np.array([j])))
        assert not pair.failures or not thin
        found += [(pair.outlines.outer[0], i, j)] if not pair.failures else []
    for outer, i, j in found:
        optimum, reached = supports(polytope, DIRECTIONS, j, i), outer.support(DIRECTIONS)
        assert (optimum - 1e-7 <= reached).all()
        assert (reached <= optimum + 1e-6).all() or not thin


@pytest.mark.parametrize("seed", range(6))
def test_the_walk_itself_finds_it_without_a_search_to_help(seed):
    polytope = random_polytope(np.random.default_rng(seed), 6, 90)
    found = regions(polytope)
    assert found.reasons == ("exact",) * 6
    assert (found.inner.areas / found.outer.areas > 1 - 1e-3).all()  # vertices are spared for a thousandth


@pytest.mark.parametrize("seed", range(6))
def test_a_walk_and_a_search_agree(seed):
    polytope = random_polytope(np.random.default_rng(seed), 3, 40)
    walks = regions(polytope)
    searches = everybody(Stop(1.0, searches=200), exact=False, solvers=("piqp",)).robots(polytope).outlines
    assert walks.outer.areas == pytest.approx(searches.outer.areas, abs=1e-7)
    assert walks.inner.areas == pytest.approx(searches.inner.areas, rel=1e-3)
    for robot, outer in enumerate(walks.outer):
        assert outer.contains(searches.inner[robot].vertices * (1 - 1e-9) + outer.centroid * 1e-9).all()


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("seed", range(2))
def test_every_edge_is_proved_by_its_rows_in_exact_arithmetic(seed, errors):
    polytope, (i, j) = merged_team(seed, errors=errors), every_pair(5)
    for outlines, whose in (
        (regions(polytope, Stop()), (np.full(5, WORLD), np.arange(5))),
        (everybody(Stop()).pairs(polytope, (i, j)).outlines, (i, j)),
    ):
        assert (outlines.weights.counts > 1).any()
        beyond = [float(each) for each in excess(polytope, outlines, *whose)]
        assert min(beyond) > -1e-7
        assert max(beyond) <= 0


@pytest.mark.parametrize("at", [1e3, 5e6])
@pytest.mark.parametrize("seed", range(3))
def test_far_from_the_origin_edges_are_proved_and_near(seed, at):
    near, far = (random_polytope(np.random.default_rng(seed), 4, 50, at=where) for where in (0.0, at))
    outlines = regions(far)
    assert max(excess(far, outlines, np.full(4, WORLD), np.arange(4))) <= 0
    assert outlines.outer.areas == pytest.approx(regions(near).outer.areas, rel=1e-6, abs=1e-6)
    assert outlines.inner.known.all()
    for robot in range(4):
        assert outlines.outer[robot].contains(outlines.inner[robot].vertices).all()


@pytest.mark.parametrize("ratio", [0.8, 0.95, 0.999])
def test_a_simplified_polygon_contains_the_exact_one_and_keeps_to_its_ratio(ratio):
    polytope = random_polytope(np.random.default_rng(4), 5, 120)
    exact, simple = region(polytope), region(polytope, Stop(ratio, searches=400))
    assert len(simple.offsets) < len(exact.offsets)
    assert exact.area <= simple.area <= exact.area / ratio
    assert (simple.support(exact.normals) >= exact.support(exact.normals) - 1e-12).all()


def test_a_budget_of_edges_is_kept():
    polytope = random_polytope(np.random.default_rng(4), 5, 120)
    assert regions(polytope, Stop(1.0, searches=5)).searches.max() <= 5
    assert regions(polytope).searches.max() > 5


@pytest.mark.parametrize(
    "upper", [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1e-9]], ids=["point", "segment", "upright", "sliver"]
)
@pytest.mark.parametrize("far", [0.0, 5e6])
def test_sets_without_an_interior(upper, far):
    outer = region(single([], [], [far, far], far + np.array(upper)))
    rounding = 1e-12 + 1e-14 * far
    assert outer.bounds[0] == pytest.approx([far, far], rel=0, abs=rounding)
    assert outer.bounds[1] == pytest.approx(far + np.array(upper), rel=0, abs=rounding)


@pytest.mark.parametrize("far", [0.0, 5e6])
@pytest.mark.parametrize("shape", ["slanted segment", "point by rows", "sliver"])
def test_rows_that_leave_no_area(shape, far):
    rows, b, inside = {
        "slanted segment": ([[1, -1], [-1, 1]], [0, 0], [[0, 0], [0.5, 0.5], [1, 1]]),
        "point by rows": ([[1, 1]], [2 * far], [[0, 0]]),
        "sliver": ([[1, -1], [-1, 1]], [1e-9, 1e-9], [[0, 0], [0.5, 0.5], [1, 1]]),
    }[shape]
    polytope = single(rows, b, [far, far], [far + 1, far + 1])
    outlines = regions(polytope, Stop(), BOTH)
    assert outlines.outer[0].contains(far + np.array(inside)).all()
    assert outlines.outer.areas[0] < 1e-5
    assert max(excess(polytope, outlines, np.array([WORLD]), np.array([0]))) <= 0


def test_rows_that_all_meet_in_one_point_or_come_twice():
    normal = unit(np.linspace(0, np.pi / 2, 40))
    twice = np.concatenate([normal, normal])
    assert region(single(twice, twice @ np.array([0.3, 0.4]), [0, 0], [1, 1])).area == pytest.approx(0.12, abs=1e-8)


def test_robots_that_are_tied_together_are_where_the_others_are():
    """The offset of each pair is given: nothing but the sum of all is free."""
    i, way = np.repeat(np.arange(3), 4), np.tile(unit(np.arange(4) * np.pi / 2), (3, 1))
    tied = Constraints(i, i + 1, way, way @ np.array([1.0, 0.5]), np.zeros(12, dtype=int))
    lower = np.zeros((4, 2))
    upper = np.array([[2.0, 2.0], [9.0, 9.0], [9.0, 9.0], [4.0, 9.0]])
    polytope = Polytope(tied, lower, upper)
    outlines = regions(polytope, EVERYTHING, BOTH)
    for k, outer in enumerate(outlines.outer):
        assert outer.bounds[0] == pytest.approx([k, 0.5 * k], abs=1e-6)
        assert outer.bounds[1] == pytest.approx([1 + k, 2 + 0.5 * k], abs=1e-6)
    assert max(excess(polytope, outlines, np.full(4, WORLD), np.arange(4))) <= 0


@pytest.mark.parametrize("spoil", ["zero", "negative", "no number", "reversed"])
@pytest.mark.parametrize("i", [WORLD, 1])
def test_a_spoilt_proof_costs_tightness_and_nothing_else(spoil, i):
    """The walk's candidates, spoilt: the edges lie farther out, and of a region that is noticed."""
    polytope = random_polytope(np.random.default_rng(1), 3, 40)
    members = [0] if i == WORLD else [0, i]
    program = team_program(polytope, members + [k for k in range(3) if k not in members])
    plane = plane_of(program, i != WORLD)
    how, trace, _, _ = walked(program, plane)
    assert how == FOUND
    place = np.full(3, -1)
    place[members + [k for k in range(3) if k not in members]] = np.arange(3)
    seen, where, task = vertices_of(trace, plane), (place, program.centre, program.radius), task_of(polytope)
    how, edges = edges_of(i, 0, program, plane, trace, seen, where, task)
    normals, exact = edges.normals.copy(), edges.offsets.copy()
    true = supports(polytope, normals, 0) if i == WORLD else supports(polytope, -normals, i, 0)
    assert how == FOUND
    assert exact == pytest.approx(true, abs=1e-8)
    count = int(trace.filled[0])
    prices = trace.prices[:count].copy()
    wrong = {"zero": 0 * prices, "negative": -prices, "no number": np.nan * prices, "reversed": prices[::-1]}
    trace.prices[:count] = wrong[spoil]
    how, edges = edges_of(i, 0, program, plane, trace, seen, where, task)
    assert how == (LOST if i == WORLD else FOUND)
    assert edges.normals.tolist() == normals.tolist()
    assert (edges.offsets >= true - 1e-9).all()
    assert (edges.offsets > true + 1e-4).any()


@pytest.mark.parametrize("exact", [True, False])
def test_a_row_that_anchored_coordinates_break_is_a_contradiction(exact):
    polytope = single([[1.0, 0.0]], [0.5], [1, 0], [1, 1])
    found = everybody(exact=exact, solvers=("piqp",) if not exact else ()).robots(polytope)
    assert polytope.program().proves_empty(found.contradiction)
    assert len(found.outlines.outer) == 0


def cut(polytope, coordinate, gap):
    """Return a polytope with two more rows, that exclude one another by a gap."""
    robot, axis = divmod(coordinate, 2)
    middle = polytope.program().centre[coordinate]
    normal = np.stack([np.eye(2)[axis], -np.eye(2)[axis]])
    apart = on_robot(robot, normal, np.array([middle, -middle - gap]), np.zeros(2, dtype=int))
    return polytope.with_constraints(Constraints.concatenate([polytope.constraints, apart]))


@pytest.mark.parametrize("seed", range(8))
def test_an_empty_team_is_never_projected(seed):
    rng = np.random.default_rng(seed)
    polytope = random_polytope(rng, 3, 40)
    empty = cut(polytope, int(rng.integers(0, 6)), 10.0 ** -rng.integers(1, 10))
    found = everybody(solvers=BOTH).robots(empty)
    assert empty.program().proves_empty(found.contradiction)


def test_a_walk_proves_that_a_team_is_empty_without_help():
    for seed in range(4):
        empty = cut(random_polytope(np.random.default_rng(seed), 3, 40), seed, 1e-3)
        found = everybody().robots(empty)
        assert empty.program().proves_empty(found.contradiction)
        assert (found.contradiction > 0).sum() >= 2


def test_a_set_that_is_empty_by_less_than_a_walk_sees_is_proved_empty_by_others():
    for gap in (1e-5, 5e-9, 1e-11):
        polytope = single([[1.0, 0.0], [-1.0, 0.0]], [50.0, -50.0 - gap], [0, 0], [100, 100])
        found = everybody(solvers=BOTH).robots(polytope)
        assert polytope.program().proves_empty(found.contradiction)
        # with nobody to prove it, what was known is left, and not the box
        normal, none = np.array([[1.0, 0.0], [-1.0, 0.0]]), np.zeros(2, dtype=int)
        rows = Constraints(np.array([WORLD, 0]), np.array([1, 1]), normal, np.array([50.0, -50.0 - gap]), none)
        pair = Polytope(rows, np.zeros((2, 2)), np.array([[0.0, 0.0], [100.0, 100.0]]))
        left = everybody().robots(pair)
        if left.contradiction is None:
            assert left.outlines.outer[1].bounds[1][0] < 50.1
            assert not left.outlines.inner.known.any()
        found = everybody(solvers=BOTH).robots(pair)
        assert pair.program().proves_empty(found.contradiction)


def test_edges_rest_on_rows_that_matter():
    world = World(np.random.default_rng(5), robots=4)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.update(begun(estimator, world), world.measure())
    assert min(proof.weights.weight.min() for proof in belief.proofs_of("regions")) > 1e-10


def test_the_reason_says_what_decided():
    decided = {
        "searches": Stop(0.9999, searches=4),
        "performance ratio": Stop(0.9, searches=60),
        "area gap": Stop(1.0, area_gap=0.3, searches=60),
        "exact": Stop(1.0, searches=100),
    }
    for reason, stop in decided.items():
        assert regions(around(60), stop).reasons == (reason,)


def found_in(polytope, i, j, task):
    """Return the proof of emptiness, and the sheet with one window."""
    i, j = np.array([i]), np.array([j])
    begin, end = polytope.constraints.groups(i, j)
    sheet = blank(end - begin, task)
    return project_some((i, j), (begin, end), polytope.around(i, j), task, sheet), sheet


def test_a_shadow_of_too_many_edges_is_lost():
    for count, edges in ((300, 300), (500, 0)):
        polytope = around(count)
        proof, sheet = found_in(polytope, WORLD, 0, task_of(polytope))
        assert (proof, sheet.first.tolist()) == (0, [0, edges])


def test_a_window_says_what_it_found():
    polytope = merged_team(4)
    for i, j in ((WORLD, 0), (WORLD, 4), (0, 3)):
        proof, sheet = found_in(polytope, i, j, task_of(polytope, Stop())._replace(inside=i == WORLD))
        edges = sheet.first[1]
        assert proof == 0 < edges
        assert REASONS[sheet.why[0]] in ("exact", "performance ratio")
        assert 0 < sheet.searches[0] <= edges <= sheet.row_first[edges]
        assert (sheet.corner_first[1] > 0) == (i == WORLD)
    empty = cut(polytope, 4, 0.1)
    proof, sheet = found_in(empty, WORLD, 2, task_of(empty))
    assert (proof > 0, sheet.first.tolist(), sheet.corner_first.tolist()) == (True, [0, 0], [0, 0])
