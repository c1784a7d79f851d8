"""The linear program over a whole history: it holds the truth, lies in the filter's regions, and is what it says."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from helpers.worlds import World, of_pair, of_robot, unit
from scipy.optimize import linprog

from experiments.optimum.history import History, motion_rows, optimum, without_implied
from experiments.optimum.runs import BUDGETS, DEFAULT
from experiments.tightness import main
from filter import Compass, Frame, Polygon, SetMembershipFilter, Stop, Team, Truth, Window, follow
from filter.linear.constraints import Constraints
from filter.linear.polytope import Polytope
from filter.sensing.motion import Displacements, displacements

FINE = Stop(0.999, 0.0, 48)
ROUND = 512  # half-planes around a displacement set, for laws that are exact but for the slip's roundness


def followed(estimator, world, count, tangents=32, motion=lambda record: record):
    """Return a history, the filter's steps, and the true positions (k, n, 2)."""

    def frames():
        for k in range(count):
            odometry = motion(world.move()) if k else None
            yield Frame(world.time, odometry, tuple(world.measure()), Truth(world.positions, world.headings))

    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    history, steps = History(world.team, tangents=tangents), list(follow(estimator, belief, frames()))
    for step in steps:
        history.add(step)
    return history, steps, np.array([step.frame.truth.positions for step in steps])


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("seed", range(3))
def test_every_row_holds_for_the_true_positions_of_all_steps(seed, errors):
    world = World(np.random.default_rng(seed), robots=4, errors=errors)
    history, steps, truths = followed(SetMembershipFilter(world.team, cells=0), world, 12, tangents=16)
    program = history.polytope(len(steps) - 1).program()
    assert (program.A @ truths.ravel() <= program.b).all()
    assert (program.lower <= truths.ravel()).all()
    assert (truths.ravel() <= program.upper).all()


@pytest.mark.parametrize("options", [{}, {"rows_per_robot": 4, "rows_per_pair": 4}, {"scope": Window(1, 2)}])
@pytest.mark.parametrize("seed", range(2))
def test_the_filters_regions_contain_those_of_the_whole_history(seed, options):
    world = World(np.random.default_rng(seed), robots=3, errors="extreme" if seed else "uniform")
    history, steps, truths = followed(SetMembershipFilter(world.team, cells=0, **options), world, 6, tangents=ROUND)
    for step in (0, 5):
        for robot, best in enumerate(optimum(history, step, FINE)):
            region = steps[step].belief.regions[robot]
            assert (best.inner.vertices @ region.outer.normals.T <= region.outer.offsets + 1e-6).all()
            assert best.outer.contains(truths[step, robot])
            assert best.inner.area >= 0.998 * best.outer.area - 1e-9


def test_before_anything_is_forgotten_the_filter_is_the_optimum():
    world = World(np.random.default_rng(5), robots=4)
    everything = Stop(1 - 1e-9, 0.0, 400)
    estimator = SetMembershipFilter(world.team, stop=everything, rows_per_robot=999, rows_per_pair=999, cells=0)
    history, steps, _ = followed(estimator, world, 1)
    for best, region in zip(optimum(history, 0, FINE), steps[0].belief.regions, strict=True):
        assert region.outer.area == pytest.approx(best.inner.area, rel=2e-3)


def test_a_longer_history_says_more():
    """What is forgotten: the optimum of the last two steps, from where the filter was, is larger than that of all."""
    world = World(np.random.default_rng(2), robots=3)
    history, steps, _ = followed(SetMembershipFilter(world.team, cells=0), world, 8, tangents=ROUND)
    short = History(world.team, tangents=ROUND)
    for step in steps[-2:]:
        short.add(step)
    for best, lesser in zip(optimum(history, 7, FINE), optimum(short, 1, FINE), strict=True):
        assert (best.inner.vertices @ lesser.outer.normals.T <= lesser.outer.offsets + 1e-6).all()
        assert best.inner.area <= lesser.outer.area + 1e-9


def test_the_optimum_is_that_of_an_oracle():
    """HiGHS, with displacements as weighted corners instead of half-planes; without slip, as that is round."""
    world = World(np.random.default_rng(4), robots=2)
    estimator = SetMembershipFilter(world.team, cells=0)
    history, steps, _ = followed(estimator, world, 3, ROUND, lambda record: replace(record, slip_bound=0.0))
    polytope = history.polytope(2)
    rows = polytope.constraints
    measured = rows.select((rows.i < 0) | (rows.i // 2 == rows.j // 2))
    assert len(measured) < len(rows)
    count, moves = 12, []
    for before, after in pairwise(steps):
        gone = displacements(after.frame.odometry, before.belief.headings, world.team, 0.1)
        moves += list(zip(gone.vertices, gone.reach, strict=True))
    variables = count + 8 * len(moves)
    equal, sums, turn = np.zeros((3 * len(moves), variables)), np.zeros(3 * len(moves)), np.linspace(0, 2 * np.pi, ROUND)
    near = []
    for k, (corners, reach) in enumerate(moves):
        weights = slice(count + 8 * k, count + 8 * k + 8)
        for m in range(2):  # x_after - x_before = sum of weights times corners
            equal[3 * k + m, [2 * k + 4 + m, 2 * k + m]] = 1, -1
            equal[3 * k + m, weights] = -corners[:, m]
        equal[3 * k + 2, weights], sums[3 * k + 2] = 1, 1
        disc = np.zeros((ROUND, variables))
        disc[:, weights] = unit(turn) @ corners.T
        near.append((disc, np.full(ROUND, reach)))
    A = np.vstack([np.hstack([measured.matrix(6).toarray(), np.zeros((len(measured), 8 * len(moves)))]), *(a for a, _ in near)])
    b = np.concatenate([measured.offset, *(reach for _, reach in near)])
    box = [*zip(polytope.lower.ravel(), polytope.upper.ravel(), strict=True), *[(0, 1)] * (8 * len(moves))]
    for robot, best in enumerate(optimum(history, 2, FINE)):
        for angle in np.linspace(-3, 3, 5):
            c = np.zeros(variables)
            c[8 + 2 * robot : 10 + 2 * robot] = unit(angle)
            oracle = -linprog(-c, A, b, equal, sums, box, method="highs").fun
            reached = (best.inner.vertices @ unit(angle)).max()
            assert reached <= oracle + 1e-6
            assert best.outer.support(unit(angle)[None])[0] >= oracle - 1e-6


def test_displacement_rows_allow_what_the_filter_allows_and_hardly_more():
    rng = np.random.default_rng(0)
    for _ in range(20):
        corners = rng.normal(size=(8, 2)) * 10.0 ** rng.uniform(-3, 0)
        moves = Displacements(corners[None], np.array([rng.uniform(0.5, 1.2) * np.hypot(*corners.T).max()]), np.array([1e-3]))
        (rows,) = motion_rows(moves, 1, 128)
        directions = unit(rng.uniform(-np.pi, np.pi, 50))
        inside = (corners * np.minimum(1, moves.reach[0] / np.hypot(*corners.T))[:, None]).mean(axis=0)
        assert (rows.normal @ inside < rows.offset).all()
        widest = Polygon.from_half_planes(rows.normal, rows.offset, [-20, -20], [20, 20])
        allowed = moves.support(np.zeros(50, dtype=int), directions)
        assert (widest.support(directions) <= allowed + 1e-3 * moves.reach[0] + 1e-5).all()


def test_a_robot_that_cannot_move_has_one_point_to_go():
    (rows,) = motion_rows(Displacements(np.zeros((1, 8, 2)), np.zeros(1), np.zeros(1)), 1, 8)
    assert (rows.offset < 1e-12).all()
    assert {tuple(normal) for normal in rows.normal.tolist()} >= {(1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0)}


def test_an_anchored_team_stays_where_it_is():
    team = Team(2, speed_limit=0.0)
    estimator, history = SetMembershipFilter(team, cells=0), History(team)
    belief = estimator.start(0.0, [Polygon.box([0, 0], [0, 0]), Polygon.box([1, 0], [2, 0])])
    for step in follow(estimator, belief, [Frame(0.1 * k, None, (Compass(0.1 * k, [0, 1], 0.0, 0.1),)) for k in range(3)]):
        history.add(step)
    point, segment = optimum(history, 2, FINE)
    assert np.abs(point.outer.vertices).max() < 1e-12
    assert segment.outer.bounds[0] == pytest.approx([1, 0], abs=1e-9)
    assert segment.outer.bounds[1] == pytest.approx([2, 0], abs=1e-9)


@pytest.mark.parametrize("seed", range(3))
def test_rows_left_out_are_implied_by_those_that_are_left(seed):
    rng = np.random.default_rng(seed)
    count = 60
    i, j = rng.integers(-1, 2, count), np.full(count, 2)
    offset = np.where(rng.random(count) < 0.3, 0.25, rng.uniform(0.1, 1.0, count))
    rows = Constraints(i, j, unit(rng.choice(np.linspace(-np.pi, np.pi, 17), count)), offset, np.zeros(count, dtype=int))
    lower, upper = np.full((3, 2), -2.0), np.full((3, 2), 2.0)
    kept = without_implied(rows, lower, upper)
    assert len(kept) < count
    for first in (-1, 0, 1):
        whole, part = Polytope(rows, lower, upper), Polytope(kept, lower, upper)
        of = (lambda p, f=first: of_robot(p, 2)[0]) if first < 0 else (lambda p, f=first: of_pair(p, f, 2)[0])
        assert of(part).support(rows.normal) == pytest.approx(of(whole).support(rows.normal), abs=1e-12)


def test_nothing_to_leave_out_of_nothing():
    nothing = Constraints(*(np.zeros(0, dtype=int),) * 2, np.zeros((0, 2)), np.zeros(0), np.zeros(0, dtype=int))
    assert len(without_implied(nothing, np.zeros((1, 2)), np.ones((1, 2)))) == 0


def test_the_default_budget_is_the_filters():
    estimator = SetMembershipFilter(Team(1), cells=0)
    assert BUDGETS[DEFAULT] == (estimator.rows_per_robot, estimator.rows_per_pair)


def test_a_run_leaves_a_summary_and_figures(tmp_path):
    options = ["--robots", "2", "--duration", "0.6", "--every", "3", "--tangents", "8", "--workers", "1"]
    assert main([*options, "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["escapes"] == 0
    assert summary["samples"] == 4
    assert 0.99 < summary["area_ratio_mean_at_least"] <= summary["area_ratio_mean"] <= summary["area_ratio_max"] < 1.5
    assert summary["budget_rows_per_robot"][:5] == [6, 8, 12, 16, 20]
    assert summary["budget_area_ratio_mean"][4] == summary["area_ratio_mean"]
    assert summary["optimum_variables_max"] == 24
    assert {path.name for path in tmp_path.iterdir()} == {"summary.json", "over_time.png", "budgets.png"}


@pytest.mark.parametrize(
    "options", [["--every", "0"], ["--tangents", "3"], ["--duration", "0.5"], ["--performance-ratio", "1"], ["--robots", "0"]]
)
def test_what_cannot_be_done_is_refused(options, tmp_path):
    assert main([*options, "--out", str(tmp_path)]) == 2
