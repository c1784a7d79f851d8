"""Pairs projected: the truth is inside, every edge is proved in exact arithmetic, and what is known of them is used."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.programs import every_pair, everybody, merged_team, supports
from helpers.teams import beliefs
from helpers.worlds import World, escapes, exact_claim, unit

from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.projection.fallback import Fallback
from filter.projection.stop import Stop
from filter.projection.team import Projector
from filter.projection.window import Window
from filter.sets.belief import Belief
from filter.sets.refine import NEAR, chosen_pairs, with_pairs

DIRECTIONS = unit(np.linspace(-np.pi, np.pi, 13))


@pytest.mark.parametrize("seed", range(4))
def test_in_a_window_of_everybody_a_pair_is_what_the_whole_team_says_of_it(seed):
    polytope, (i, j) = merged_team(seed), every_pair(5)
    found = everybody().pairs(polytope, (i, j))
    assert found.failures == ()
    for k, mine in enumerate(found.outlines.outer):
        true = supports(polytope, DIRECTIONS, j[k], i[k])
        assert (mine.support(DIRECTIONS) >= true - 1e-8).all()
        assert mine.support(DIRECTIONS) == pytest.approx(true, rel=1e-6, abs=1e-8)


@pytest.mark.parametrize(("errors", "origin"), [("uniform", 0.0), ("extreme", 0.0), ("uniform", 5e6)])
@pytest.mark.parametrize("scope", [Window.everybody(), Window(1, 3)])
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
    polytope = merged_team(2)
    rows = polytope.constraints
    without = polytope.with_constraints(rows.select((rows.i != 0) | (rows.j != 3)))
    found = everybody(Stop()).pairs(without, (np.array([0]), np.array([3]))).outlines
    assert found.outer.areas[0] < 0.999 * np.prod(np.ptp(without.of(np.array([0]), np.array([3])).polygons.vertices, axis=0))


def test_edges_of_pairs_become_the_rows_on_them_and_their_sources_are_regions():
    world = World(np.random.default_rng(1), robots=3)
    *_, belief = beliefs(SetMembershipFilter(world.team), world)
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
    polytope = merged_team(0)
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
    wanted = [known[1], *known[:1:-1], known[0]]
    wanted += [(a, b) for a in range(5) for b in range(a + 1, 5) if (a, b) not in known]
    for most in range(12):
        i, j = chosen_pairs(named, sources, 99.0, most)
        assert list(zip(i.tolist(), j.tolist(), strict=True)) == sorted(wanted[:most])


def round_pair(count=500):
    """Return two robots between which so many rows are that a walk gives up."""
    normal = unit(2 * np.pi * np.arange(count) / count)
    rows = Constraints(
        np.zeros(count, dtype=int), np.ones(count, dtype=int), normal, np.ones(count), np.zeros(count, dtype=int)
    )
    return Polytope(rows, np.full((2, 2), -5.0), np.full((2, 2), 5.0))


def test_a_lost_walk_leaves_a_pair_its_rows_and_is_told():
    world = World(np.random.default_rng(5), robots=2)
    *_, belief = beliefs(SetMembershipFilter(world.team), world, 2)
    polytope = round_pair()
    before = Belief(belief.time, polytope, belief.headings, belief.sources, belief.guarantee)
    found = with_pairs(before, 36, Projector(NEAR, Stop(1.0, searches=400)))
    assert found.events == (Fallback(1, ("walk",), None, 0),)
    assert "region of robot 1 seen from robot 0" in "; ".join(map(str, found.events))
    (proof,) = found.proofs
    assert len(proof) >= 500
    assert all(exact_claim(proof, claim) <= 0 for claim in range(len(proof)))
    pair = np.array([0]), np.array([1])
    assert found.polytope.of(*pair).polygons.areas == pytest.approx(polytope.of(*pair).polygons.areas, rel=1e-9)
    assert found.polytope.constraints.source.tolist() == polytope.constraints.source.tolist()


def test_pairs_that_are_not_chosen_keep_their_rows():
    world = World(np.random.default_rng(3), robots=5)
    *_, belief = beliefs(SetMembershipFilter(world.team, pairs=0), world, 2)
    polytope, sources = belief.polytope, belief.sources
    before = Belief(belief.time, polytope, belief.headings, sources, belief.guarantee)
    found = with_pairs(before, 3, Projector(NEAR, Stop()))
    i, j = chosen_pairs(polytope, sources, belief.time, 3)
    assert set(zip(found.proofs[0].i.tolist(), found.proofs[0].j.tolist(), strict=True)) == set(
        zip(i.tolist(), j.tolist(), strict=True)
    )
    for first, second in zip(*every_pair(5), strict=True):
        old, new = polytope.constraints, found.polytope.constraints
        kept = old.offset[old.rows_of(first, second)].tolist() == new.offset[new.rows_of(first, second)].tolist()
        assert kept == ((first, second) not in zip(i.tolist(), j.tolist(), strict=True))
    assert with_pairs(before, 0, Projector(NEAR, Stop())) is before


def test_when_time_is_up_pairs_keep_their_rows():
    polytope = merged_team(1)
    found = everybody(Stop()).pairs(polytope, every_pair(5), is_over=lambda: True)
    assert found.failures == ()
    assert set(found.outlines.reasons) == {"time"}
    assert found.outlines.outer.areas == pytest.approx(polytope.of(*every_pair(5)).polygons.areas)


@pytest.mark.parametrize("robots", [1, 2])
def test_small_teams(robots):
    world = World(np.random.default_rng(0), robots=robots)
    for belief in beliefs(SetMembershipFilter(world.team), world):
        assert escapes(belief, world.positions, world.headings) == []
        assert len([*belief.proofs_of("regions")]) == len([*belief.proofs_of("boxes")]) >= 1
        assert len([*belief.proofs_of("pairs")]) == (len([*belief.proofs_of("regions")]) if robots == 2 else 0)
