"""The search: bracketed areas, the paper's counts, and soundness whatever the solver says."""

import numpy as np
import pytest
import shapely
from helpers.programs import searched, support
from helpers.worlds import outside_hull, random_program, unit

from filter.geometry.polygon import Polygon
from filter.linear.program import Candidate
from filter.linear.solvers import workspace
from filter.projection.proved import position
from filter.projection.search import project
from filter.projection.stop import Stop

# Two solvers, or two ways to compute an area, agree to this share.
SAME = 1e-6
CLOSE = Stop(performance_ratio=1 - 1e-9, searches=200)


def matrices(robots, rng):
    return {
        "position": position(0, robots),
        "last": position(robots - 1, robots),
        "relative": position(1, robots) - position(0, robots),
        "mean": sum(position(k, robots) for k in range(robots)) / robots,
        "any": rng.normal(size=(2, 2 * robots)),
    }


@pytest.mark.parametrize("which", ["position", "last", "relative", "mean", "any"])
@pytest.mark.parametrize("seed", range(4))
def test_the_projection_is_between_the_inner_and_the_outer_polygon(seed, which):
    rng = np.random.default_rng(seed)
    program = random_program(rng, robots=3, rows=24)
    D = matrices(3, rng)[which]
    found = searched(program, D, stop=Stop(searches=10))
    for direction in unit(rng.uniform(-np.pi, np.pi, 12)):
        true = support(program, direction @ D)
        assert found.outer.support(direction[None])[0] >= true - 1e-8
        assert (found.inner.vertices @ direction).max() <= true + 1e-8
    assert found.inner.area <= found.outer.area
    assert shapely.Polygon(found.outer.vertices).buffer(1e-8).contains(shapely.Polygon(found.inner.vertices))
    assert found.performance_ratio > 0.5


@pytest.mark.parametrize("solver", ["piqp", "highs"])
@pytest.mark.parametrize("seed", range(6))
def test_the_ratio_is_exactly_a_half_after_four_searches(seed, solver):
    program = random_program(np.random.default_rng(seed), robots=3, rows=24)
    found = searched(program, position(0, 3), solver, Stop(searches=4))
    assert found.searches == 4
    assert found.inner_areas[-1] / found.outer_areas[-1] == pytest.approx(0.5, abs=SAME)
    assert found.performance_ratio >= 0.5 - SAME  # the box may cut the outer polygon further


@pytest.mark.parametrize("seed", range(6))
def test_a_vertex_solver_needs_two_searches_a_vertex_at_most(seed):
    program = random_program(np.random.default_rng(seed), robots=2, rows=16)
    found = searched(program, position(0, 2), "highs", Stop(performance_ratio=1.0, searches=1000))
    corners = len(shapely.Polygon(found.inner.vertices).simplify(1e-7).exterior.coords) - 1
    assert found.searches <= 2 * corners + 4
    assert found.performance_ratio > 1 - SAME


@pytest.mark.parametrize("seed", range(6))
def test_areas_close_in_with_every_search(seed):
    program = random_program(np.random.default_rng(seed), robots=3, rows=24)
    found = searched(program, position(0, 3), stop=CLOSE)
    assert len(found.inner_areas) == len(found.outer_areas) == found.searches
    assert (np.diff(found.inner_areas) >= -1e-9).all()
    assert (np.diff(found.outer_areas[3:]) <= 1e-9).all()
    assert found.inner_areas[-1] == pytest.approx(found.inner.area, rel=1e-5)
    assert found.outer_areas[-1] == pytest.approx(found.outer.area, rel=1e-5)


def test_one_robots_projection_is_its_polygon():
    rng = np.random.default_rng(5)
    program = random_program(rng, robots=1, rows=9)
    found = searched(program, position(0, 1), stop=CLOSE)
    own = Polygon.from_half_planes(program.A.toarray(), program.b, program.lower, program.upper)
    assert found.outer.area == pytest.approx(own.area, rel=SAME)
    assert found.inner.area == pytest.approx(own.area, rel=SAME)


def test_reasons_to_stop():
    program = random_program(np.random.default_rng(6), robots=3, rows=24)
    D = position(0, 3)
    assert searched(program, D, stop=Stop(searches=5)).reason == "searches"
    assert searched(program, D, stop=Stop(performance_ratio=0.4)).reason == "performance ratio"
    assert searched(program, D, stop=Stop(performance_ratio=1.0, area_gap=100.0)).reason == "area gap"
    stopped = searched(program, D, stop=Stop(performance_ratio=0.9))
    assert stopped.reason == "performance ratio"
    assert stopped.performance_ratio >= 0.9 - SAME
    exact = searched(program, D, "highs", Stop(performance_ratio=1.0, searches=1000))
    assert exact.reason in ("exact", "performance ratio")


class Fake:
    """A solver that does whatever it likes."""

    def __init__(self, answer):
        self.answer, self.calls = answer, 0

    def maximize(self, objective):
        self.calls += 1
        return self.answer(self.calls, objective)


def fakes(program, rng):
    rows, variables = len(program.b), len(program.centre)
    true = workspace(program, "piqp")

    def after(count, otherwise):
        return lambda call, c: true.maximize(c) if call <= count else otherwise(call, c)

    def nothing(*_):
        return None

    def noise(*_):
        return Candidate(program.centre + rng.normal(size=variables), rng.exponential(1, rows) * 10.0 ** rng.uniform(-6, 6))

    def numberless(*_):
        return Candidate(np.full(variables, np.nan), np.full(rows, np.nan))

    return {
        "gives up": nothing,
        "gives up after 1": after(1, nothing),
        "gives up after 3": after(3, nothing),
        "gives up after 6": after(6, nothing),
        "noise": noise,
        "noise after 5": after(5, noise),
        "no number": numberless,
        "no number after 6": after(6, numberless),
        "one point": lambda *_: Candidate(program.centre, np.zeros(rows)),
        "far away": lambda *_: Candidate(program.centre + 1e9 * rng.normal(size=variables), np.zeros(rows)),
        "negative": lambda *_: Candidate(program.lower, np.full(rows, -1.0)),
        "huge": lambda *_: Candidate(program.upper, np.full(rows, 1e30)),
        "no number in multipliers": after(4, lambda _, c: Candidate(true.maximize(c).point, np.full(rows, np.nan))),
    }


NAMES = list(fakes(random_program(np.random.default_rng(0)), np.random.default_rng(0)))


@pytest.mark.parametrize("name", NAMES)
def test_whatever_a_solver_says_the_outer_polygon_stays_sound(name):
    for seed in range(4):
        rng = np.random.default_rng(seed)
        program = random_program(rng, robots=2, rows=12)
        found = project(program, Fake(fakes(program, rng)[name]), position(0, 2), program.centre, stop=Stop())
        points = program.centre + rng.uniform(-1, 1, (4000, 4))
        allowed = points[program.holds(points)][:, :2]
        assert len(allowed)
        assert found.outer.contains(allowed).all()
        assert not any(outside_hull(found.outer, point) for point in allowed[:50])
        if found.inner is not None:
            assert shapely.Polygon(found.outer.vertices).buffer(1e-9).contains(shapely.MultiPoint(found.inner.vertices))
        assert found.searches <= 16


def test_a_solver_that_gives_up_is_the_reason():
    program = random_program(np.random.default_rng(0))
    found = project(program, Fake(lambda *_: None), position(0, 2), program.centre, stop=Stop())
    assert found.reason == "solver"
    assert found.outer.area == pytest.approx(4.0)
    assert found.inner is None


def test_what_a_solver_proved_before_it_lost_its_numbers_is_kept():
    rng = np.random.default_rng(1)
    program = random_program(rng, robots=2, rows=12)
    before = project(program, Fake(fakes(program, rng)["gives up after 6"]), position(0, 2), program.centre, stop=Stop())
    after = project(program, Fake(fakes(program, rng)["no number after 6"]), position(0, 2), program.centre, stop=Stop())
    assert after.outer.area == pytest.approx(before.outer.area)
