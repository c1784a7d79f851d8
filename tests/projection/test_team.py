"""Regions in windows: sound, near those of the whole team, the same as theirs when a window holds everybody."""

from dataclasses import replace
from fractions import Fraction

import numpy as np
import pytest
from filter.geometry.polygons import Polygons
from helpers.worlds import World, escapes
from projection.test_exact import EVERYTHING, random_program

from filter.errors import Inconsistent, InvalidInput
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.linear.constraints import WORLD
from filter.linear.polytope import Polytope
from filter.measurements import Range
from filter.projection import team as windows
from filter.projection.fallback import EXACT, project_all
from filter.projection.proved import NOTHING, position
from filter.projection.stop import Stop
from filter.projection.team import project_windows
from filter.projection.walk import PROVED
from filter.projection.window import Window, links, members_of
from filter.sets.set_membership import SetMembershipFilter
from filter.team import Team

FULL = Window(hops=9, robots=99)


def merged(seed, robots=5, errors="uniform"):
    """Return the polytope of a team after some steps, as it is before a search."""
    world = World(np.random.default_rng(seed), robots=robots, errors=errors)
    caught = []
    estimator = SetMembershipFilter(world.team)
    with pytest.MonkeyPatch.context() as patch:
        from filter.sets import set_membership

        original = set_membership.searched
        patch.setattr(
            set_membership,
            "searched",
            lambda time, polytope, *a, **k: caught.append(polytope) or original(time, polytope, *a, **k),
        )
        belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
        for motion, records in world.steps(2):
            belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
    return caught[-1]


def team_regions(polytope):
    robots = len(polytope.lower)
    known = [
        (polytope.constraints.normal[k], polytope.constraints.offset[k])
        for k in (polytope.constraints.rows_of(-1, r) for r in range(robots))
    ]
    return project_all(
        polytope.program(), [position(r, robots) for r in range(robots)], known, [EXACT, "piqp"], EVERYTHING
    ).found


@pytest.mark.parametrize("seed", range(4))
def test_a_window_of_everybody_gives_the_regions_of_the_team(seed):
    polytope = merged(seed)
    outlines = project_windows(polytope, FULL, [EXACT], EVERYTHING).outlines
    for mine, theirs in zip(outlines.outer, team_regions(polytope), strict=True):
        assert mine.area == pytest.approx(theirs.outer.area, rel=1e-6)
        assert (mine.support(theirs.outer.normals) >= theirs.outer.support(theirs.outer.normals) - 1e-8).all()


@pytest.mark.parametrize("robots", [2, 3])
@pytest.mark.parametrize("seed", range(3))
def test_a_smaller_window_gives_larger_regions(seed, robots):
    polytope = merged(seed)
    outlines = project_windows(polytope, Window(1, robots), [EXACT], EVERYTHING).outlines
    for mine, theirs in zip(outlines.outer, team_regions(polytope), strict=True):
        assert mine.contains(theirs.inner.vertices).all()
    assert outlines.inner == (None,) * len(polytope.lower)


@pytest.mark.parametrize("seed", range(4))
def test_every_offset_is_proved_by_its_rows_in_exact_arithmetic(seed):
    polytope = merged(seed, errors="extreme" if seed % 2 else "uniform")
    rows = polytope.constraints
    found = project_windows(polytope, Window(1, 4), [EXACT], Stop()).outlines
    assert (found.behind == PROVED).sum() >= len(polytope.lower)
    for edge, robot in enumerate(found.outer.owner.tolist()):
        claims = slice(found.row_first[edge], found.row_first[edge + 1])
        direction = {(robot, m): Fraction(found.outer.normals[edge, m]) for m in range(2)}
        bound = Fraction(0)
        for row, price in zip(found.row[claims].tolist(), map(Fraction, found.multiplier[claims].tolist()), strict=True):
            bound += price * Fraction(rows.offset[row])
            for body, sign in ((int(rows.j[row]), 1), (int(rows.i[row]), -1)):
                for m in range(2) if body >= 0 else ():
                    less = sign * price * Fraction(rows.normal[row, m])
                    direction[body, m] = direction.get((body, m), Fraction(0)) - less
        for (body, m), left in direction.items():
            bound += max(left * Fraction(polytope.lower[body, m]), left * Fraction(polytope.upper[body, m]))
        itself = [
            row
            for row in rows.rows_of(-1, robot).tolist()
            if (*rows.normal[row], rows.offset[row]) == (*found.outer.normals[edge], found.outer.offsets[edge])
        ]
        assert (found.behind[edge] in itself) if itself else found.behind[edge] < 0
        assert bound <= Fraction(found.outer.offsets[edge])
        assert found.outer.offsets[edge] - float(bound) < 1e-7


@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("window", [Window(1, 2), Window(1, 12), Window(2, 3)])
def test_no_robot_escapes(errors, window):
    world = World(np.random.default_rng(7), robots=6, errors=errors)
    estimator = SetMembershipFilter(world.team, scope=window)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    for motion, records in world.steps(6):
        belief = estimator.update(estimator.predict(belief, motion.time, motion), records)
        assert escapes(belief, world.positions, world.headings) == []
        assert {region.reason for region in belief.regions} <= {"exact", "performance ratio"}


def test_the_members_are_the_nearest_and_no_more_than_there_is_room_for():
    world = World(np.random.default_rng(3), robots=6)
    rows = merged(3, robots=6).constraints
    who = links(rows, 6)
    for robot in range(6):
        near = {int(j) if i == robot else int(i) for i, j in zip(rows.i, rows.j, strict=True) if robot in (i, j) and i >= 0}
        place = np.full(6, -1)
        members = members_of(WORLD, robot, 1, 99, who.near, who.near_first, place)
        assert members[0] == robot
        assert set(members.tolist()) == {robot, *near}
        assert (place[members] == np.arange(len(members))).all()
        assert len(members_of(WORLD, robot, 1, 2, who.near, who.near_first, np.full(6, -1))) == min(2, 1 + len(near))
    assert world is not None


def lose(monkeypatch, robots):
    """Let the walks of some robots come to nothing."""
    original = windows._outlines

    def outlines(sheets):
        found = original(sheets)
        gone = np.isin(np.arange(len(found.outer)), robots)
        counts = np.where(gone, 0, np.diff(found.outer.first))
        left = found.select(np.flatnonzero(~gone))
        outer = Polygons(
            left.outer.normals, left.outer.offsets, left.outer.vertices, found.outer.margin, np.cumsum([0, *counts])
        )
        return replace(left, outer=outer, inner=found.inner, searches=found.searches, reasons=found.reasons)

    monkeypatch.setattr(windows, "_outlines", outlines)


def test_a_window_that_is_lost_is_searched_and_the_event_says_so(monkeypatch):
    lose(monkeypatch, [0, 1, 2])
    world = World(np.random.default_rng(1), robots=3)
    estimator = SetMembershipFilter.light(world.team, scope=Window(1, 3))
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    assert escapes(belief, world.positions, world.headings) == []
    assert [(event.robot, event.failed, event.used) for event in belief.events] == [(k, ("exact",), "piqp") for k in range(3)]


def test_one_lost_window_among_others_is_put_in_its_place(monkeypatch):
    """The searched region is the walked one, to the search's goal, and stands where it belongs."""
    polytope = merged(2)
    whole = project_windows(polytope, Window(1, 3), [EXACT, "piqp"], Stop()).outlines
    lose(monkeypatch, [1, 3])
    found = project_windows(polytope, Window(1, 3), [EXACT, "piqp"], Stop())
    assert [failure.plane for failure in found.failures] == [1, 3]
    assert found.outlines.outer.areas == pytest.approx(whole.outer.areas, rel=2e-3)
    for robot in (0, 2, 4):
        assert found.outlines.outer[robot].vertices.tolist() == whole.outer[robot].vertices.tolist()
        edge, same = found.outlines.outer.first[robot], whole.outer.first[robot]
        assert found.outlines.row_first[edge + 1] - found.outlines.row_first[edge] == np.diff(whole.row_first)[same]


def test_without_anybody_to_search_what_is_known_is_left(monkeypatch):
    lose(monkeypatch, [0, 1, 2])
    world = World(np.random.default_rng(1), robots=3)
    estimator = SetMembershipFilter(world.team, scope=Window(1, 3), fallbacks=())
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    assert escapes(belief, world.positions, world.headings) == []
    assert {region.reason for region in belief.regions} == {"solver"}


def test_a_contradiction_within_a_window_names_its_measurements():
    estimator = SetMembershipFilter(Team(1, landmarks=[[0.0, 0.0], [4.0, 0.0]]), scope=Window())
    belief = estimator.start(0.0, [Polygon.box([-5, -5], [5, 5])], AngularIntervals.circles(1))
    with pytest.raises(Inconsistent) as caught:
        estimator.update(belief, [Range(0.0, [0, 0], [1, 2], [1.0, 1.0], 0.1, 0.0)])
    assert {source.target for source in caught.value.sources} == {1, 2}


def test_sets_without_an_interior():
    polytope = Polytope(
        merged(0, robots=2).constraints.select(np.zeros(0, dtype=int)), np.zeros((2, 2)), np.array([[0.0, 0.0], [1.0, 0.0]])
    )
    point, segment = project_windows(polytope, Window(), [EXACT], Stop()).outlines.outer
    assert point.area == 0
    assert segment.bounds[1] == pytest.approx([1.0, 0.0])


def test_anchored_robots_in_windows_are_no_trouble():
    estimator = SetMembershipFilter(Team(2), scope=Window())
    belief = estimator.start(0.0, [Polygon.box([0, 0], [0, 0]), Polygon.box([1, 0], [1, 0])])
    after = estimator.update(belief, [Range(0.0, 0, 1, 1.0, 0.1, 0.0)])
    assert [region.outer.area for region in after.regions] == pytest.approx([0, 0], abs=1e-12)
    with pytest.raises(Inconsistent):
        estimator.update(belief, [Range(0.0, 0, 1, 5.0, 0.1, 0.0)])


@pytest.mark.parametrize("values", [{"hops": 0}, {"robots": 1}])
def test_a_window_too_small_is_refused(values):
    with pytest.raises(InvalidInput, match="of a window"):
        Window(**values)


def test_a_scope_that_is_none_is_refused():
    with pytest.raises(InvalidInput, match="a scope"):
        SetMembershipFilter(Team(1), scope="neighbours")


def test_programs_of_other_kinds_are_left_to_the_search():
    program = random_program(np.random.default_rng(0), 3, 20)
    assert project_all(program, [position(0, 3)], [NOTHING], [EXACT], Stop()).found[0].reason == "exact"


@pytest.mark.parametrize("threads", [2, 5])
def test_the_number_of_threads_makes_no_difference_to_the_last_bit(threads, monkeypatch):
    monkeypatch.setattr(windows, "TOGETHER", 3)
    polytope = merged(5, robots=8)
    one, other = (project_windows(polytope, Window(1, 4), [EXACT], Stop(), threads=t).outlines for t in (1, threads))
    assert one.outer.offsets.tolist() == other.outer.offsets.tolist()
    assert one.outer.vertices.tolist() == other.outer.vertices.tolist()
    assert one.multiplier.tolist() == other.multiplier.tolist()
    assert one.behind.tolist() == other.behind.tolist()


def test_the_order_that_robots_are_asked_in_makes_no_difference(monkeypatch):
    monkeypatch.setattr(windows, "TOGETHER", 2)
    polytope = merged(5, robots=7)
    order = np.random.default_rng(0).permutation(7)
    one = project_windows(polytope, Window(1, 4), [EXACT], Stop()).outlines
    other = project_windows(polytope, Window(1, 4), [EXACT], Stop(), order=order).outlines
    for name in ("behind", "row", "multiplier", "row_first", "searches", "reasons"):
        assert list(getattr(one, name)) == list(getattr(other, name))
    assert one.outer.vertices.tolist() == other.outer.vertices.tolist()


@pytest.mark.parametrize("threads", [0, 1.5])
def test_a_number_of_threads_that_is_none_is_refused(threads):
    with pytest.raises(InvalidInput, match="threads"):
        SetMembershipFilter(Team(1), threads=threads)
