"""Pairs projected: the truth is inside, every edge is proved in exact arithmetic, and what is known of them is used."""

from dataclasses import replace

import numpy as np
import pytest
from filter.sets.pairs import chosen_pairs, with_pairs
from helpers.worlds import World, escapes, exact_claim
from projection.test_exact import EVERYTHING
from projection.test_team import merged

from filter.linear.constraints import WORLD
from filter.projection import team as windows
from filter.projection.fallback import EXACT, project_all
from filter.projection.proved import NOTHING, relative_position
from filter.projection.stop import Stop
from filter.projection.team import project_pairs
from filter.projection.window import Window
from filter.sets.belief import Fallback
from filter.sets.refine import Searched
from filter.sets.set_membership import SetMembershipFilter

EVERYBODY = Window(hops=9, robots=99)


def every_pair(robots):
    return np.triu_indices(robots, 1)


def beliefs(estimator, world, count=6):
    belief = estimator.update(estimator.start(0.0, world.initial_sets(), world.initial_headings()), world.measure())
    yield belief
    for motion, records in world.steps(count):
        predicted = estimator.predict(belief, motion.time, motion)
        assert escapes(predicted, world.positions, world.headings) == []
        belief = estimator.update(predicted, records)
        yield belief


@pytest.mark.parametrize("seed", range(4))
def test_in_a_window_of_everybody_a_pair_is_what_the_whole_team_says_of_it(seed):
    polytope = merged(seed)
    i, j = every_pair(5)
    found = project_pairs(polytope, (i, j), EVERYBODY, EVERYTHING).outlines.outer
    planes = [relative_position(second, first, 5) for first, second in zip(i, j, strict=True)]
    whole = project_all(polytope.program(), planes, [NOTHING] * len(i), [EXACT, "piqp"], EVERYTHING).found
    for mine, theirs in zip(found, whole, strict=True):
        assert mine.area == pytest.approx(theirs.outer.area, rel=1e-6)
        assert (mine.support(theirs.outer.normals) >= theirs.outer.support(theirs.outer.normals) - 1e-8).all()


@pytest.mark.parametrize(("errors", "origin"), [("uniform", 0.0), ("extreme", 0.0), ("uniform", 5e6)])
@pytest.mark.parametrize("scope", ["team", Window(1, 3)])
def test_the_truth_is_inside_and_every_claim_is_proved(errors, origin, scope):
    world = World(np.random.default_rng(3), robots=4, errors=errors, origin=np.full(2, origin))
    for belief in beliefs(SetMembershipFilter(world.team, scope=scope), world):
        assert escapes(belief, world.positions, world.headings) == []
        *_, pairs = belief.proofs
        assert (pairs.i >= 0).all()
        relative = world.positions[pairs.j] - world.positions[pairs.i]
        assert ((pairs.normal * relative).sum(axis=1) <= pairs.offset + 1e-15 * origin).all()
    for claim in range(len(pairs)):
        assert exact_claim(pairs, claim) <= 0


def test_a_pair_of_which_nothing_was_measured_is_projected_too():
    polytope = merged(2)
    rows = polytope.constraints
    without = polytope.with_constraints(rows.select((rows.i != 0) | (rows.j != 3)))
    found = project_pairs(without, (np.array([0]), np.array([3])), EVERYBODY, Stop()).outlines
    assert found.outer.areas[0] < 0.999 * np.prod(np.ptp(without.of(np.array([0]), np.array([3])).polygons.vertices, axis=0))


def test_edges_of_pairs_become_the_rows_on_them_and_their_sources_are_regions():
    world = World(np.random.default_rng(1), robots=3)
    *_, belief = beliefs(SetMembershipFilter(world.team, corner_spacing=None), world)
    rows = belief.constraints
    mutual = np.flatnonzero(rows.i != WORLD)
    assert set(zip(rows.i[mutual].tolist(), rows.j[mutual].tolist(), strict=True)) == {(0, 1), (0, 2), (1, 2)}
    sources = [belief.sources[number] for number in rows.source[mutual].tolist()]
    made = [(source.robot, source.target) for source in sources if source.kind == "region"]
    assert made
    assert set(made) <= {(1, 0), (2, 0), (2, 1)}


@pytest.mark.parametrize("seed", range(3))
def test_who_projects_pairs_has_regions_no_larger(seed):
    def last(pairs):
        world = World(np.random.default_rng(seed), robots=4, errors="extreme" if seed else "uniform")
        *_, belief = beliefs(SetMembershipFilter(world.team, pairs=pairs), world, 12)
        return belief.regions.outer.areas

    more, less = last(36), last(0)
    assert (more <= less * 1.003 + 1e-12).all()
    assert more.sum() < less.sum()


def test_those_just_measured_come_first_then_those_longest_ago_then_strangers():
    polytope = merged(0)
    rows = polytope.constraints
    time = np.zeros(rows.source.max() + 1)
    known = sorted(set(zip(rows.i[rows.i >= 0].tolist(), rows.j[rows.i >= 0].tolist(), strict=True)))
    assert len(known) > 3
    number = {pair: k for k, pair in enumerate(known)}
    source = np.array([number.get(pair, len(known)) for pair in zip(rows.i.tolist(), rows.j.tolist(), strict=True)])
    named = polytope.with_constraints(replace(rows, source=source))
    time = np.append(np.arange(len(known), 0, -1.0), 0.0)  # the last pair was measured longest ago
    time[1] = 99.0
    sources = type("Table", (), {"time": time})
    i, j = chosen_pairs(named, sources, 99.0, 36)
    found = list(zip(i.tolist(), j.tolist(), strict=True))
    assert found[: len(known)] == [known[1], *known[:1:-1], known[0]]
    assert sorted(found) == [(a, b) for a in range(5) for b in range(a + 1, 5)]
    assert [len(part) for part in chosen_pairs(named, sources, 99.0, 2)] == [2, 2]
    assert [len(part) for part in chosen_pairs(named, sources, 99.0, 0)] == [0, 0]


def test_a_lost_walk_leaves_a_pair_its_rows_and_is_told(monkeypatch):
    world = World(np.random.default_rng(5), robots=3)
    *_, belief = beliefs(SetMembershipFilter(world.team), world, 2)
    polytope, pairs = belief.polytope, every_pair(3)
    sheet = windows.project_some

    def losing(i, j, task):
        found = sheet(i, j, task)
        return (
            found
            if not len(j)
            else sheet(i[:0], j[:0], task)._replace(
                margin=np.zeros(len(j)),
                first=np.zeros(len(j) + 1, dtype=np.int64),
                searches=np.zeros(len(j), dtype=np.int64),
                why=np.zeros(len(j), dtype=np.int64),
            )
        )

    before = Searched(belief.polytope, belief.regions, belief.sources, (), ())
    monkeypatch.setattr(windows, "project_some", losing)
    found = with_pairs(belief.time, before, 36, stop=Stop())
    assert set(found.events) == {Fallback(int(j), (EXACT,), None, int(i)) for i, j in zip(*pairs, strict=True)}
    assert "region of robot 1 seen from robot 0" in "; ".join(map(str, found.events))
    (proof,) = found.proofs
    assert all(exact_claim(proof, claim) <= 0 for claim in range(len(proof)))
    theirs = polytope.of(*pairs).polygons
    for mine, own in zip(found.polytope.of(*pairs).polygons, theirs, strict=True):
        assert mine.area == pytest.approx(own.area, rel=1e-9)


def test_when_time_is_up_pairs_keep_their_rows():
    polytope = merged(1)
    found = project_pairs(polytope, every_pair(5), EVERYBODY, Stop(), is_over=lambda: True)
    assert found.failures == ()
    assert set(found.outlines.reasons) == {"time"}
    assert found.outlines.outer.areas == pytest.approx(polytope.of(*every_pair(5)).polygons.areas)


@pytest.mark.parametrize("robots", [1, 2])
def test_small_teams(robots):
    world = World(np.random.default_rng(0), robots=robots)
    for belief in beliefs(SetMembershipFilter(world.team), world):
        assert escapes(belief, world.positions, world.headings) == []
        assert len(belief.proofs) == (3 if robots == 2 else 2)
