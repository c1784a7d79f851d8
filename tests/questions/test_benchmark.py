"""The benchmark: its windows, its clocks, and that it would notice a wrong projection."""

import json
from importlib.util import find_spec
from time import process_time
from types import SimpleNamespace

import numpy as np
import pytest

from experiments.benchmark import main
from experiments.sweep.timing import clocked, medians
from experiments.timed import agreement as benchmark_agreement
from experiments.timed.agreement import Agreement, agreement_of
from experiments.timed.grids import NEIGHBOURS, draw_grid, measured
from experiments.timed.ways import EXACT, POLYTOPE, Problem, by_kernel, ways
from filter.projection.search import project


def spend(seconds):
    begin = process_time()
    while process_time() - begin < seconds:
        pass


@pytest.mark.parametrize("robots", [2, 5, 12])
def test_a_grid_team_knows_where_it_is_and_no_row_excludes_it(robots):
    rng = np.random.default_rng(robots)
    truth = rng.uniform(0, 8, (robots, 2))
    bearings, ranges = measured(truth, rng)
    count = min(NEIGHBOURS, robots - 1)
    assert len(bearings.robot) == len(ranges.robot) == robots * count
    to = truth[bearings.target] - truth[bearings.robot]
    assert (np.abs(np.angle(np.exp(1j * (bearings.bearing - np.arctan2(to[:, 1], to[:, 0]))))) <= bearings.bound).all()
    least, greatest = ranges.interval()
    assert ((least <= np.hypot(*to.T)) & (np.hypot(*to.T) <= greatest)).all()
    polytope = draw_grid(rng, robots)
    assert len(polytope.constraints) == 4 * robots * count
    solver = Problem(polytope, 0).solver("piqp")
    assert polytope.program().holds(solver.maximize(np.zeros(2 * robots)).point[None])[0]


def test_the_same_seed_draws_the_same_grid():
    one, other = (draw_grid(np.random.default_rng(3), 6) for _ in range(2))
    assert (one.constraints.offset == other.constraints.offset).all()
    assert (one.constraints.offset != draw_grid(np.random.default_rng(4), 6).constraints.offset).any()


@pytest.mark.parametrize("seed", range(4))
def test_the_walk_agrees_with_piqp_and_with_a_search(seed):
    rng = np.random.default_rng(seed)
    problem = Problem(draw_grid(rng, 6), int(rng.integers(6)))
    found = agreement_of(problem, 5)
    assert (found.windows, found.fallbacks) == (1, 0)
    assert found.edges <= min(5, found.vertices)
    assert found.vertices >= 3
    assert max(found.apart, found.above) <= 1e-8
    assert found.below <= 1e-7
    searched = project(problem.program, problem.solver("piqp"), problem.plane, problem.program.centre, stop=EXACT)
    walked = by_kernel(problem, problem.task(EXACT))
    assert (walked.vertices[: walked.first[1]] @ searched.outer.normals.T <= searched.outer.offsets + 1e-6).all()


def test_a_walk_that_is_wrong_or_lost_is_noticed(monkeypatch):
    problem = Problem(draw_grid(np.random.default_rng(0), 4), 1)
    right = by_kernel(problem, problem.task(EXACT))
    monkeypatch.setattr(benchmark_agreement, "by_kernel", lambda *_: right._replace(offsets=right.offsets + 1e-6))
    assert agreement_of(problem, 4).apart == pytest.approx(1e-6, rel=0.05)
    assert agreement_of(problem, 4).above == pytest.approx(1e-6, rel=0.05)
    monkeypatch.setattr(benchmark_agreement, "by_kernel", lambda *_: right._replace(offsets=right.offsets - 1e-6))
    assert agreement_of(problem, 4).apart == pytest.approx(1e-6, rel=0.05)
    assert agreement_of(problem, 4).below == pytest.approx(1e-6, rel=0.05)
    monkeypatch.setattr(benchmark_agreement, "by_kernel", lambda *_: right._replace(first=np.zeros(2, dtype=np.int64)))
    assert agreement_of(problem, 4) == Agreement(windows=1, fallbacks=1)


def test_agreements_add_up():
    one, other = Agreement(1, 0, 4, 9, 3e-9, 1e-9, 0.0, 4e-9), Agreement(1, 1, 0, 0, 1e-9, 2e-9, 5e-9, 0.0)
    assert one.joined(other) == other.joined(one) == Agreement(2, 1, 4, 9, 3e-9, 2e-9, 5e-9, 4e-9)


def test_medians_are_of_the_times_spent():
    done = []
    task = {"long": lambda: spend(0.02), "short": lambda: spend(0.002)}
    found = medians([task] * 3, {"short": 2}, lambda: done.append(1))
    assert len(done) == 3
    assert found["long"] >= 0.02
    assert 0.002 <= found["short"] < found["long"]


def test_a_clocked_function_is_itself_again_afterwards():
    module = SimpleNamespace(work=lambda seconds: spend(seconds) or "done")
    before = module.work
    with clocked(module, ["work"]) as spent:
        assert module.work(0.005) == "done"
        with pytest.raises(TypeError):
            module.work(None)
    assert len(spent) == 2
    assert spent[0] >= 0.005
    assert module.work is before


def test_the_share_of_projections_is_a_share():
    for scope in ("team", "window"):
        share = benchmark_agreement.shares_of(0, 0.8, scope)
        assert 0 < share.other < 1
        assert share.step > 0


def test_every_way_answers():
    for task in ways(Problem(draw_grid(np.random.default_rng(1), 3), 2)).values():
        task()


def test_a_run_leaves_a_summary_and_a_figure(tmp_path):
    options = ["--windows", "3", "--timed", "2", "--robots", "4", "--directions", "3", "--duration", "0.8"]
    assert main([*options, "--out", str(tmp_path)]) == 0
    summary = json.loads((tmp_path / "summary.json").read_text())
    assert summary["windows"] == 3
    assert summary["edges_compared"] <= 9
    assert summary["fallbacks"] == 0
    assert (
        (summary["polytope_over_kernel"] is None) == (find_spec(POLYTOPE) is None) == (f"{POLYTOPE}_median_ms" not in summary)
    )
    assert summary["kernel_in_piqp_solves"] == pytest.approx(
        summary["kernel_median_ms"] / summary["piqp_solve_median_ms"], rel=1e-4
    )
    assert {path.name for path in tmp_path.iterdir()} == {"summary.json", "ratios.png"}


@pytest.mark.parametrize("options", [["--windows", "0"], ["--timed", "0"], ["--robots", "1"], ["--duration", "0"]])
def test_what_cannot_be_done_is_refused(options, tmp_path):
    assert main([*options, "--out", str(tmp_path)]) == 2
