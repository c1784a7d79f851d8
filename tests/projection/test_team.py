"""Regions of a team: the same as the whole team's program gives, larger in windows, and the same on any number of threads."""

import numpy as np
import pytest
from helpers.programs import (
    EVERYTHING,
    every_pair,
    everybody,
    excess,
    merged_team,
    random_polytope,
    round_set,
    supports,
    with_strangers,
)
from helpers.teams import begun, beliefs
from helpers.worlds import NO_ROWS, World, escapes, unit

from filter import Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.errors import Inconsistent, InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.fallback import Fallback
from filter.projection.stop import Stop
from filter.projection.team import Projector
from filter.projection.window import Window
from filter.team import Team

DIRECTIONS = unit(np.linspace(-np.pi, np.pi, 13))
NAMES = ("normals", "offsets", "vertices", "margin", "first")


def same_bits(one, other):
    """Return whether two outlines are the same to the last bit."""
    pairs = [(getattr(one.outer, name), getattr(other.outer, name)) for name in NAMES]
    pairs += [(getattr(one.weights, name), getattr(other.weights, name)) for name in ("row", "weight", "first")]
    pairs += [(one.inner.corners, other.inner.corners), (one.searches, other.searches)]
    return all(a.tobytes() == b.tobytes() for a, b in pairs) and one.reasons == other.reasons


def together(*parts):
    """Return the polytope of some teams that have nothing to do with one another, one after the other."""
    rows, before = [], 0
    for part in parts:
        few = part.constraints
        rows.append(
            Constraints(np.where(few.i == WORLD, WORLD, few.i + before), few.j + before, few.normal, few.offset, few.source)
        )
        before += len(part.lower)
    box = (np.concatenate([getattr(part, name) for part in parts]) for name in ("lower", "upper"))
    return Polytope(Constraints.concatenate(rows), *box)


def line(robots=1):
    """Return robots on lines, of which no point is proved to be one of them."""
    normal = np.tile([[0.6, -0.8], [-0.6, 0.8]], (robots, 1))
    robot, offset = np.repeat(np.arange(robots), 2), np.tile([0.1, -0.1], robots)
    rows = Constraints(np.full(2 * robots, WORLD), robot, normal, offset, np.zeros(2 * robots, dtype=int))
    return Polytope(rows, np.zeros((robots, 2)), np.ones((robots, 2)))


@pytest.mark.parametrize("seed", range(4))
def test_a_window_of_everybody_gives_what_the_whole_teams_program_says(seed):
    for polytope in (merged_team(seed), random_polytope(np.random.default_rng(seed), 6, 90)):
        found = everybody().robots(polytope)
        assert not found.failures
        for robot, outer in enumerate(found.outlines.outer):
            assert outer.support(DIRECTIONS) == pytest.approx(supports(polytope, DIRECTIONS, robot), rel=0, abs=1e-9)
            true = supports(polytope, outer.normals, robot)
            assert (outer.offsets >= true - 1e-9).all()


@pytest.mark.parametrize("seed", range(2))
def test_a_window_of_everybody_gives_what_the_whole_teams_program_says_of_pairs(seed):
    polytope, (i, j) = merged_team(seed), every_pair(5)
    found = everybody().pairs(polytope, (i, j))
    assert not found.failures
    for k, outer in enumerate(found.outlines.outer):
        true = supports(polytope, DIRECTIONS, j[k], i[k])
        assert outer.support(DIRECTIONS) == pytest.approx(true, rel=0, abs=1e-9)


def test_a_window_as_large_as_the_team_is_that_of_everybody():
    polytope = merged_team(1)
    one, other = everybody().robots(polytope).outlines, Projector(Window(9, 99), EVERYTHING).robots(polytope).outlines
    assert other.outer.offsets.tobytes() == one.outer.offsets.tobytes()
    assert one.inner.known.all()
    assert not other.inner.known.any()


@pytest.mark.parametrize("robots", [2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_a_smaller_window_gives_larger_regions(seed, robots):
    polytope = merged_team(seed)
    whole = everybody().robots(polytope).outlines
    areas = []
    for hops in (1, 2):
        outlines = Projector(Window(hops, robots), EVERYTHING).robots(polytope).outlines
        for mine, theirs in zip(outlines.outer, whole.outer, strict=True):
            assert (mine.support(theirs.normals) >= theirs.support(theirs.normals) - 1e-9).all()
        for robot, mine in enumerate(outlines.outer):
            assert mine.contains(whole.inner[robot].vertices).all()
        assert not outlines.inner.known.any()
        areas.append(outlines.outer.areas.sum())
    assert areas[0] > whole.outer.areas.sum() * (1 + 1e-6)


@pytest.mark.parametrize("exact", [True, False])
@pytest.mark.parametrize("window", [Window(1, 3), Window(9, 99)])
def test_in_another_window_nothing_is_known_from_inside(window, exact):
    found = Projector(window, Stop(), exact, ("piqp",)).robots(merged_team(0))
    assert not found.outlines.inner.known.any()
    assert found.failures == ()


@pytest.mark.parametrize("exact", [True, False])
def test_who_has_nothing_to_do_with_a_robot_does_not_matter_to_it(exact):
    one, other = merged_team(0, robots=4), merged_team(1, robots=3)
    projector = everybody(exact=exact, stop=EVERYTHING if exact else Stop(), solvers=("piqp",))
    both = projector.robots(together(one, other)).outlines
    apart = [projector.robots(part).outlines for part in (one, other)]
    areas = np.concatenate([each.outer.areas for each in apart])
    assert both.outer.areas == pytest.approx(areas, rel=1e-9 if exact else 2e-3)
    assert both.inner.areas == pytest.approx(np.concatenate([each.inner.areas for each in apart]), rel=1e-3)
    assert both.reasons == tuple(reason for each in apart for reason in each.reasons)


@pytest.mark.parametrize("seed", range(4))
def test_every_offset_is_proved_by_its_rows_in_exact_arithmetic(seed):
    polytope = merged_team(seed, errors="extreme" if seed % 2 else "uniform")
    rows = polytope.constraints
    found = Projector(Window(1, 4), Stop()).robots(polytope).outlines
    assert (found.weights.counts > 1).sum() >= 5
    beyond = [float(each) for each in excess(polytope, found, np.full(5, WORLD), np.arange(5))]
    assert min(beyond) > -1e-7
    assert max(beyond) <= 0
    for edge, robot in enumerate(found.outer.owner.tolist()):
        line = (*found.outer.normals[edge], found.outer.offsets[edge])
        itself = [row for row in rows.rows_of(WORLD, robot).tolist() if (*rows.normal[row], rows.offset[row]) == line]
        used, weights = found.weights.rests_on(edge)
        assert not itself or (used[0] in itself and weights.tolist() == [1.0])


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("window", [Window(1, 2), Window(1, 12), Window(2, 3)])
def test_no_robot_escapes(errors, window):
    world = World(np.random.default_rng(7), robots=6, errors=errors)
    for belief in beliefs(SetMembershipFilter(world.team, scope=window), world):
        assert {region.reason for region in belief.regions} <= {"exact", "performance ratio"}


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 4)])
def test_far_from_the_origin_no_walk_is_lost(scope):
    world = World(np.random.default_rng(1), robots=6, errors="extreme", origin=np.full(2, 5e6))
    for belief in beliefs(SetMembershipFilter(world.team, scope=scope, cells=0), world, 4):
        assert belief.events == ()


@pytest.mark.parametrize("window", [Window.everybody(), Window(1, 3)])
def test_a_lost_walk_among_others_is_searched_and_put_in_its_place(window):
    """The searched region is what it is, to the search's goal, and stands where it belongs."""
    polytope = merged_team(2)
    whole = Projector(window, Stop(), solvers=()).robots(polytope).outlines
    lost = Projector(window, Stop(), solvers=("piqp", "highs")).robots(with_strangers(polytope, [1, 3]))
    assert lost.failures == (Fallback(1, ("walk",), "piqp"), Fallback(3, ("walk",), "piqp"))
    others = np.array([0, 2, 4, 5, 6])
    assert lost.outlines.outer.areas[others] == pytest.approx(whole.outer.areas, rel=1e-9)
    assert lost.outlines.select(others).weights.counts.tolist() == whole.weights.counts.tolist()
    exact = round_set().area
    assert (exact <= lost.outlines.outer.areas[[1, 3]]).all()
    assert (lost.outlines.outer.areas[[1, 3]] <= exact * 1.002).all()
    assert lost.outlines.inner.known.tolist() == [window.leaves_nobody_out] * 7
    everyone = np.full(7, WORLD), np.arange(7)
    assert max(excess(with_strangers(polytope, [1, 3]), lost.outlines, *everyone)) <= 0


@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 3)])
def test_a_lost_walk_is_searched_and_the_event_says_so(scope):
    world = World(np.random.default_rng(1), robots=3)
    sets = [round_set(position) for position in world.positions]
    estimator = SetMembershipFilter.light(world.team, scope=scope, rows_per_robot=600)
    belief = estimator.update(estimator.start(0.0, sets, world.initial_headings()))
    assert [(event.robot, event.failed, event.used) for event in belief.events] == [(k, ("walk",), "piqp") for k in range(3)]
    assert escapes(belief, world.positions, world.headings) == []
    assert belief.regions.outer.areas == pytest.approx([sets[0].area] * 3, rel=2e-3)
    assert escapes(estimator.update(belief, world.measure()), world.positions, world.headings) == []


def test_without_anybody_to_search_what_is_known_is_left():
    world = World(np.random.default_rng(1), robots=3)
    sets = [round_set(position) for position in world.positions]
    estimator = SetMembershipFilter.light(world.team, scope=Window(1, 3), solvers=(), rows_per_robot=600)
    belief = estimator.update(estimator.start(0.0, sets, world.initial_headings()))
    assert [(event.robot, event.failed, event.used) for event in belief.events] == [(k, ("walk",), None) for k in range(3)]
    assert escapes(belief, world.positions, world.headings) == []
    assert {region.reason for region in belief.regions} == {"solver"}
    assert belief.regions.outer.areas == pytest.approx([sets[0].area] * 3, rel=1e-9)


def test_inner_polygons_are_known_only_when_every_part_has_a_proved_point():
    good = merged_team(0, robots=3)
    for part, known in ((merged_team(1, robots=2), True), (line(), False), (line(2), False)):
        for polytope in (together(good, part), together(part, good)):
            found = everybody(solvers=("piqp", "highs")).robots(polytope)
            assert found.contradiction is None
            assert found.outlines.inner.known.tolist() == [known] * len(polytope.lower)
    assert everybody().robots(good).outlines.inner.known.all()


def test_a_part_that_is_empty_by_less_than_a_walk_sees_is_proved_empty_by_solvers():
    good, part = merged_team(0, robots=3), line()
    rows = part.constraints
    for gap in (5e-9, 1e-11):
        apart = Constraints(rows.i, rows.j, rows.normal, rows.offset - np.array([0.0, gap]), rows.source)
        polytope = together(good, part.with_constraints(apart))
        found = everybody(solvers=("piqp", "highs")).robots(polytope)
        assert polytope.program().proves_empty(found.contradiction)
        nobody = everybody().robots(polytope)
        assert nobody.contradiction is not None or not nobody.outlines.inner.known.any()


@pytest.mark.parametrize("window", [Window.everybody(), Window()])
def test_where_time_ran_out_nothing_is_known_from_inside(window):
    polytope = merged_team(0)
    found = Projector(window, Stop()).robots(polytope, is_over=lambda: True)
    assert found.outlines.reasons == ("time",) * 5
    assert not found.outlines.inner.known.any()
    assert found.outlines.outer.areas.tolist() == polytope.of_robots(np.arange(5)).polygons.areas.tolist()


@pytest.mark.parametrize("scope", [Window.everybody(), Window()])
def test_a_contradiction_names_its_measurements(scope):
    estimator = SetMembershipFilter(Team(1, landmarks=[[0.0, 0.0], [4.0, 0.0]]), scope=scope)
    belief = estimator.start(0.0, [Polygon.box([-5, -5], [5, 5])], AngularIntervals.circles(1))
    with pytest.raises(Inconsistent) as caught:
        estimator.update(belief, [Range(0.0, [0, 0], [1, 2], [1.0, 1.0], 0.1, 0.0)])
    assert {source.target for source in caught.value.sources} == {1, 2}


@pytest.mark.parametrize("window", [Window.everybody(), Window()])
def test_sets_without_an_interior(window):
    polytope = Polytope(NO_ROWS, np.zeros((2, 2)), np.array([[0.0, 0.0], [1.0, 0.0]]))
    point, segment = Projector(window, Stop()).robots(polytope).outlines.outer
    assert point.area == 0
    assert segment.bounds[1] == pytest.approx([1.0, 0.0])


@pytest.mark.parametrize("scope", [Window.everybody(), Window()])
def test_anchored_robots_are_no_trouble(scope):
    estimator = SetMembershipFilter(Team(2), scope=scope)
    belief = estimator.start(0.0, [Polygon.box([0, 0], [0, 0]), Polygon.box([1, 0], [1, 0])])
    after = estimator.update(belief, [Range(0.0, 0, 1, 1.0, 0.1, 0.0)])
    assert [region.outer.area for region in after.regions] == pytest.approx([0, 0], abs=1e-12)
    with pytest.raises(Inconsistent):
        estimator.update(belief, [Range(0.0, 0, 1, 5.0, 0.1, 0.0)])


def test_a_scope_that_is_none_is_refused():
    with pytest.raises(InvalidInput, match="scope: a Window"):
        SetMembershipFilter(Team(1), scope="team")


@pytest.mark.parametrize("window", [Window.everybody(), Window(1, 4)])
@pytest.mark.parametrize("threads", [2, 5])
def test_the_number_of_threads_makes_no_difference_to_the_last_bit(threads, window, monkeypatch):
    monkeypatch.setattr("filter.projection.team.TOGETHER", 3)
    polytope, pairs = merged_team(5, robots=8), every_pair(8)
    one, other = (Projector(window, Stop(), threads=each) for each in (1, threads))
    assert same_bits(one.robots(polytope).outlines, other.robots(polytope).outlines)
    assert same_bits(one.pairs(polytope, pairs).outlines, other.pairs(polytope, pairs).outlines)


def test_how_many_are_projected_together_makes_no_difference_to_the_last_bit(monkeypatch):
    polytope = merged_team(5, robots=7)
    one = everybody(Stop()).robots(polytope).outlines
    monkeypatch.setattr("filter.projection.team.TOGETHER", 2)
    assert same_bits(one, everybody(Stop()).robots(polytope).outlines)


@pytest.mark.parametrize("window", [Window.everybody(), Window(1, 4)])
def test_the_order_that_robots_are_asked_in_makes_no_difference(window, monkeypatch):
    monkeypatch.setattr("filter.projection.team.TOGETHER", 2)
    polytope, projector = merged_team(5, robots=7), Projector(window, Stop())
    order = np.random.default_rng(0).permutation(7)
    assert same_bits(projector.robots(polytope).outlines, projector.robots(polytope, order=order).outlines)


def test_the_same_beliefs_give_the_same_bits():
    world = World(np.random.default_rng(5), robots=4)
    estimator = SetMembershipFilter(world.team)
    belief, records = begun(estimator, world), world.measure()
    one, other = estimator.update(belief, records), estimator.update(belief, records)
    for mine, theirs in zip(one.regions, other.regions, strict=True):
        assert mine.outer.offsets.tobytes() == theirs.outer.offsets.tobytes()
        assert mine.inner.vertices.tobytes() == theirs.inner.vertices.tobytes()


@pytest.mark.parametrize("threads", [0, 1.5])
def test_a_number_of_threads_that_is_none_is_refused(threads):
    with pytest.raises(InvalidInput, match="threads"):
        SetMembershipFilter(Team(1), threads=threads)
