"""The exact projection: against HiGHS, against the search, on degenerate programs; and what it proves of empty ones."""

from dataclasses import replace

import numpy as np
import pytest
from filter.projection.exact import Walker, project_exactly
from helpers.worlds import World
from scipy import sparse
from scipy.optimize import linprog

from filter.errors import Inconsistent
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.linear.program import LinearProgram
from filter.measurements import Range
from filter.projection import projector
from filter.projection.fallback import EXACT, project_all
from filter.projection.proved import NOTHING, position, relative_position
from filter.projection.stop import Stop
from filter.sets.set_membership import SetMembershipFilter
from filter.team import Team

EVERYTHING = Stop(1.0, searches=400)
STRICT = {"primal_feasibility_tolerance": 1e-10, "dual_feasibility_tolerance": 1e-10}
ANGLES = np.linspace(-np.pi, np.pi, 13)


def random_program(rng, robots, rows, thin=1.0, at=0.0):
    """A team with random rows on robots and pairs around a random configuration; `thin` scales their slack."""
    inside = rng.uniform(-2, 2, (robots, 2)) + at
    j = rng.integers(0, robots, rows)
    i = np.where(rng.random(rows) < 0.4, WORLD, rng.integers(0, robots, rows))
    i = np.where(i == j, WORLD, i)
    angle = rng.uniform(-np.pi, np.pi, rows)
    normal = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    from_where = np.where((i == WORLD)[:, None], 0.0, inside[i])
    offset = (normal * (inside[j] - from_where)).sum(axis=1) + thin * rng.uniform(0.0, 0.3, rows)
    constraints = Constraints.between(i, j, normal, offset, np.zeros(rows, dtype=int))
    return Polytope(constraints, inside - rng.uniform(0.1, 1, (robots, 2)), inside + rng.uniform(0.1, 1, (robots, 2))).program()


def support(program, objective):
    box = np.stack([program.lower, program.upper], axis=1)
    return -linprog(-objective, program.A.toarray(), program.b, bounds=box, method="highs", options=STRICT).fun


def unit(angle):
    return np.array([np.cos(angle), np.sin(angle)])


def projected(program, D, stop=EVERYTHING):
    (found,) = project_all(program, [D], [NOTHING], [EXACT, "piqp"], stop).found
    return found


@pytest.mark.parametrize("seed", range(12))
@pytest.mark.parametrize("thin", [1.0, 1e-6, 0.0])
def test_the_projection_reaches_as_far_as_highs_says(seed, thin):
    rng = np.random.default_rng(seed)
    robots = int(rng.integers(1, 6))
    program = random_program(rng, robots, int(rng.integers(0, 60)), thin, at=rng.choice([0.0, 1e3]))
    robot, other = rng.integers(0, robots, 2)
    planes = [position(robot, robots), relative_position(robot, other, robots) if robot != other else position(0, robots)]
    for D in planes:
        outer = projected(program, D).outer
        for angle in ANGLES:
            optimum = support(program, unit(angle) @ D)
            reached = float(outer.support(unit(angle)[None])[0])
            assert optimum - 1e-7 <= reached
            assert reached <= optimum + 1e-6 or not thin  # rows through one point can exclude one another by an ulp


@pytest.mark.parametrize("seed", range(6))
def test_the_walk_itself_finds_it_without_a_search_to_help(seed, monkeypatch):
    monkeypatch.setattr(projector, "_searched", lambda *_: pytest.fail("the walk was lost"))
    program = random_program(np.random.default_rng(seed), 6, 90)
    planes = [position(robot, 6) for robot in range(6)]
    found = project_all(program, planes, [NOTHING] * 6, [EXACT], EVERYTHING).found
    assert all(each.reason == "exact" and each.performance_ratio > 1 - 1e-6 for each in found)


@pytest.mark.parametrize("seed", range(6))
def test_a_walk_and_a_search_agree(seed):
    program, D = random_program(np.random.default_rng(seed), 3, 40), position(1, 3)
    (searched,) = project_all(program, [D], [NOTHING], ["piqp"], Stop(1.0, searches=200)).found
    walked = projected(program, D)
    assert walked.outer.area == pytest.approx(searched.outer.area, abs=1e-7)
    assert walked.inner.area == pytest.approx(searched.inner.area, abs=1e-5)


@pytest.mark.parametrize("seed", range(10))
def test_the_inner_polygon_is_inside_the_outer_one(seed):
    found = projected(random_program(np.random.default_rng(seed), 4, 50), position(2, 4))
    assert found.outer.contains(found.inner.vertices).all()


@pytest.mark.parametrize("ratio", [0.8, 0.95, 0.999])
def test_a_simplified_polygon_contains_the_exact_one_and_keeps_to_its_ratio(ratio):
    program, D = random_program(np.random.default_rng(4), 5, 120), position(0, 5)
    exact, simple = projected(program, D), projected(program, D, Stop(ratio, searches=400))
    assert len(simple.outer.offsets) < len(exact.outer.offsets)
    assert exact.outer.area <= simple.outer.area <= exact.outer.area / ratio
    assert (simple.outer.support(exact.outer.normals) >= exact.outer.support(exact.outer.normals) - 1e-12).all()


def test_a_budget_of_edges_is_kept():
    program, D = random_program(np.random.default_rng(4), 5, 120), position(0, 5)
    assert projected(program, D, Stop(1.0, searches=5)).searches <= 5


@pytest.mark.parametrize(
    "upper", [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1e-9]], ids=["point", "segment", "upright", "sliver"]
)
def test_sets_without_an_interior(upper):
    program = LinearProgram(sparse.csr_array((0, 2)), np.zeros(0), np.zeros(2), np.array(upper))
    outer = projected(program, np.eye(2)).outer
    assert outer.bounds[0] == pytest.approx([0, 0], abs=1e-12)
    assert outer.bounds[1] == pytest.approx(upper, abs=1e-12)


def test_rows_that_all_meet_in_one_point_or_come_twice():
    angles = np.linspace(0, np.pi / 2, 40)
    normal = np.stack([np.cos(angles), np.sin(angles)], axis=1)
    A = sparse.csr_array(np.concatenate([normal, normal]))
    program = LinearProgram(A, A @ np.array([0.3, 0.4]), np.zeros(2), np.ones(2))
    assert projected(program, np.eye(2)).outer.area == pytest.approx(0.12, abs=1e-8)


def test_a_dropped_proof_costs_tightness_and_nothing_else():
    """The walker's candidates, spoilt: the region is larger, and a spoilt shadow is noticed."""
    program, D = random_program(np.random.default_rng(1), 3, 40), position(0, 3)
    shadow = Walker(program).shadow(D, EVERYTHING)
    exact = project_exactly(program, shadow, D, None).outer
    for spoilt in (
        np.zeros_like(shadow.multipliers),
        -shadow.multipliers,
        shadow.multipliers * np.nan,
        shadow.multipliers[::-1],
    ):
        wrong = replace(shadow, multipliers=spoilt, reached=np.full(len(shadow.reached), np.inf))
        outer = project_exactly(program, wrong, D, None).outer
        assert outer.contains(exact.vertices * (1 - 1e-9) + exact.centroid * 1e-9).all()
        unnoticed = replace(shadow, multipliers=spoilt)
        assert project_exactly(program, unnoticed, D, None) is None


def test_an_empty_program_is_proved_to_be_empty_and_names_its_rows():
    team = Team(1, landmarks=[[0.0, 0.0], [4.0, 0.0]])
    estimator = SetMembershipFilter(team)
    belief = estimator.start(0.0, [Polygon.box([-5, -5], [5, 5])], AngularIntervals.circles(1))
    with pytest.raises(Inconsistent) as caught:
        estimator.update(belief, [Range(0.0, [0, 0], [1, 2], [1.0, 1.0], 0.1, 0.0)])
    assert {source.target for source in caught.value.sources} == {1, 2}


def test_a_row_that_anchored_coordinates_break_is_a_contradiction():
    program = LinearProgram(sparse.csr_array([[1.0, 0.0]]), np.array([0.5]), np.array([1.0, 0.0]), np.array([1.0, 1.0]))
    for solver in (EXACT, "piqp"):
        found = project_all(program, [np.eye(2)], [NOTHING], [solver], EVERYTHING)
        assert program.proves_empty(found.contradiction)


@pytest.mark.parametrize("seed", range(8))
def test_an_empty_program_is_never_projected(seed):
    rng = np.random.default_rng(seed)
    program = random_program(rng, 3, 40)
    j = int(rng.integers(0, 6))
    cut = sparse.csr_array(([1.0, -1.0], ([0, 1], [j, j])), shape=(2, 6))
    gap = 10.0 ** -rng.integers(1, 10)
    middle = program.centre[j]
    empty = LinearProgram(
        sparse.csr_array(sparse.vstack([program.A, cut])),
        np.append(program.b, [middle, -middle - gap]),
        program.lower,
        program.upper,
    )
    found = project_all(empty, [position(0, 3)], [NOTHING], [EXACT, "piqp", "highs"], EVERYTHING)
    assert found.contradiction is not None
    assert empty.proves_empty(found.contradiction)


def test_a_set_that_is_empty_by_less_than_a_walk_sees_is_proved_empty_by_others():
    A = sparse.csr_array([[1.0, 0.0], [-1.0, 0.0]])
    for gap in (1e-5, 5e-9, 1e-11):
        program = LinearProgram(A, np.array([50.0, -50.0 - gap]), np.zeros(2), np.full(2, 100.0))
        found = project_all(program, [np.eye(2)], [NOTHING], [EXACT, "piqp", "highs"], EVERYTHING)
        assert program.proves_empty(found.contradiction)
        # with nobody to prove it, what was known is left, and not the box
        known = np.array([[1.0, 0.0]]), np.array([50.0])
        (left,) = project_all(program, [np.eye(2)], [known], [EXACT], EVERYTHING).found or (None,)
        assert left is None or left.outer.bounds[1][0] < 50.1


def test_edges_rest_on_rows_that_matter():
    world = World(np.random.default_rng(5), robots=4)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    assert min(proof.multiplier.min() for proof in belief.proofs) > 1e-10


def test_a_row_of_more_than_four_entries_is_left_to_a_search():
    program = LinearProgram(sparse.csr_array(np.ones((1, 6))), np.zeros(1), -np.ones(6), np.ones(6))
    (found,) = project_all(program, [position(0, 3)], [NOTHING], [EXACT, "piqp"], EVERYTHING).found
    assert found.outer.area == pytest.approx(4.0)


def test_a_team_of_anchored_robots_is_no_trouble():
    estimator = SetMembershipFilter(Team(2))
    belief = estimator.start(0.0, [Polygon.box([0, 0], [0, 0]), Polygon.box([1, 0], [1, 0])])
    after = estimator.update(belief, [Range(0.0, 0, 1, 1.0, 0.1, 0.0)])
    assert [region.outer.area for region in after.regions] == pytest.approx([0, 0], abs=1e-12)
    with pytest.raises(Inconsistent):
        estimator.update(belief, [Range(0.0, 0, 1, 5.0, 0.1, 0.0)])


def test_the_reason_says_what_decided():
    angles = np.linspace(0, 2 * np.pi, 60, endpoint=False)
    A = sparse.csr_array(np.stack([np.cos(angles), np.sin(angles)], axis=1))
    program = LinearProgram(A, np.ones(60), -2 * np.ones(2), 2 * np.ones(2))
    decided = {
        "searches": Stop(0.9999, searches=4),
        "performance ratio": Stop(0.9, searches=60),
        "area gap": Stop(1.0, area_gap=0.3, searches=60),
        "exact": Stop(1.0, searches=100),
    }
    for reason, stop in decided.items():
        assert projected(program, np.eye(2), stop).reason == reason


def test_a_walk_that_is_lost_is_replaced_by_a_search(monkeypatch):
    monkeypatch.setattr(Walker, "shadow", lambda *_: None)
    program, D = random_program(np.random.default_rng(1), 3, 40), position(0, 3)
    assert projected(program, D, Stop(0.99, searches=60)).reason in ("performance ratio", "searches")


def test_the_same_program_gives_the_same_bits():
    world = World(np.random.default_rng(5), robots=4)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    records = world.measure()
    one, other = estimator.update(belief, records), estimator.update(belief, records)
    for mine, theirs in zip(one.regions, other.regions, strict=True):
        assert mine.outer.offsets.tobytes() == theirs.outer.offsets.tobytes()
        assert mine.inner.vertices.tobytes() == theirs.inner.vertices.tobytes()
