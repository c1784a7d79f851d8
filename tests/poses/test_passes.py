"""Passes and cells over what was measured at one time: the truth stays, more looking never costs more than its tangents."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.programs import merging, on_robot
from helpers.worlds import World, escapes, unit
from hypothesis import given
from hypothesis import strategies as st

from experiments.following.simulated import from_simulator
from experiments.following.steps import steps
from filter import Bearing, Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.angles import AngularIntervals
from filter.geometry.polygon import Polygon
from filter.linear.polytope import Polytope
from filter.poses.cells import Cases
from filter.records.record import field_names
from filter.sensing.readings import Readings
from filter.sensing.rows import WIDENING
from filter.sets.belief import Belief
from filter.sets.merged import Directions
from filter.sets.passes import boxed_at_a_glance
from filter.sets.worth import are_smaller
from filter.team import Team
from sim.episode import episode

seeds = st.integers(0, 2**32 - 1)
SPACING, FINE = np.radians(30), np.radians(3)


def drawn(seed, errors="uniform", widest=1.5, **how):
    """Return a world, what is known of it before, and what is measured: all kinds, or less."""
    rng = np.random.default_rng(seed)
    world = World(rng, errors=errors, **{"robots": 4, "landmarks": 2, **how})
    sets, headings = world.initial_sets(rng.choice([0.3, 1, 3])), world.initial_headings(rng.choice([0.05, 0.5, widest]))
    records = world.measure(compasses=bool(rng.random() < 0.5))
    if rng.random() < 0.3:
        records = [each for each in records if isinstance(each, Range)]
    return world, SetMembershipFilter(world.team).start(0.0, sets, headings), records


def areas(merged):
    return merged.polytope.of_robots(np.arange(len(merged.headings))).polygons.areas


def in_cells(merged):
    return [case.robot for each in merged.evidence if isinstance(each, Cases) for case in each]


def passes(merged):
    return [each for each in merged.evidence if isinstance(each, Directions)]


def escaped(world, belief, records, merged):
    sources, _ = Readings.of(belief.time, records).numbered(belief.sources, world.team.robots)
    found = Belief(0.0, merged.polytope, merged.headings, sources, belief.guarantee)
    return escapes(found, world.positions, world.headings)


@given(seeds, st.sampled_from(["uniform", "extreme"]), st.sampled_from([0, 4, 64]), st.sampled_from([0.0, 5e6]))
def test_the_truth_is_never_cut_off(seed, errors, cells, origin):
    world, belief, records = drawn(seed, errors, widest=3.0, origin=np.full(2, origin))
    assert escaped(world, belief, records, merging(belief, records, world.team, SPACING, cells).merged()) == []


@given(seeds, st.sampled_from([0, 1, 2, 5]))
def test_whenever_time_is_over_what_is_found_holds(seed, calls):
    world, belief, records = drawn(seed)
    asked = []
    merged = merging(belief, records, world.team, SPACING).merged(lambda: asked.append(0) or len(asked) > calls)
    assert escaped(world, belief, records, merged) == []
    if not calls:
        assert len(merged.evidence) == 1
        once = merging(belief, records, world.team, SPACING, cells=0).merged()
        assert merged.polytope.constraints.offset.tobytes() == once.polytope.constraints.offset.tobytes()


@given(seeds, st.sampled_from([(SPACING, 1.1), (FINE, 1.01)]), st.sampled_from([4, 64]))
def test_more_looking_leaves_no_more_but_for_where_tangents_touch(seed, how, cells):
    """An arc that is narrower has other tangents: some that were at the right place are not there any more."""
    (spacing, most), (world, belief, records) = how, drawn(seed)
    once, more = (merging(belief, records, world.team, spacing, some).merged() for some in (0, cells))
    assert (areas(more) <= most * areas(once) + WIDENING).all()
    assert (more.headings.bound <= once.headings.bound + WIDENING).all()


def test_more_looking_seldom_leaves_more_and_often_much_less():
    shares = []
    for seed in range(60):
        world, belief, records = drawn(seed)
        once, more = (merging(belief, records, world.team, SPACING, some).merged() for some in (0, 64))
        shares += (areas(more) / areas(once)).tolist()
    assert np.mean(np.array(shares) > 1 + 1e-6) < 0.02
    assert np.mean(np.array(shares) < 0.7) > 0.25


@pytest.mark.parametrize("seed", [201, 430])
def test_cells_forget_no_gap_in_what_is_known_of_a_heading(seed):
    world, belief, records = drawn(seed, "extreme", widest=3.0)
    once, more = (merging(belief, records, world.team, SPACING, some).merged() for some in (0, 16))
    assert (more.headings.bound <= once.headings.bound + WIDENING).all()


@pytest.mark.parametrize(("robots", "most"), [(1, 0.01), (4, 0.1)])
def test_the_same_again_says_next_to_nothing_new(robots, most):
    """Where mates were found in cells, too, it says a little more of one another."""
    fell = []
    for seed in range(60):
        world, belief, records = drawn(seed, robots=robots, landmarks=3)
        merged = merging(belief, records, world.team, SPACING).merged()
        known = replace(belief, polytope=merged.polytope, headings=merged.headings)
        again = merging(known, records, world.team, SPACING).merged()
        fell += (1 - areas(again) / areas(merged))[in_cells(merged)].tolist()
    assert len(fell) > 20
    assert np.median(fell) < most


def test_regions_without_an_area_become_no_smaller():
    """Of robots on a line an update came to no end."""
    assert not are_smaller(np.zeros(2), np.zeros(2))
    assert are_smaller(np.array([0.0, 1.0]), np.array([0.0, 2.0]))
    filter_ = SetMembershipFilter(Team(2, arena=[[-9, -9], [9, 9]]))
    belief = filter_.start(0.0, [Polygon.box([0, 0], [0, 0]), Polygon.box([-5, 0], [5, 0])])
    outer = filter_.update(belief, [Range(0.0, 0, 1, 2.0, 0.1, 0.0)]).regions[1].outer
    assert np.ptp(outer.bounds, axis=0)[0] < 4.3


def two_within_reach():
    """Return a robot and another one, both somewhere in the same square and with known headings."""
    team = Team(2, np.zeros((0, 2)), 0.5, 1.0)
    squares = [Polygon.box([-4, -4], [4, 4])] * 2
    return team, SetMembershipFilter(team).start(0.0, squares, AngularIntervals(np.zeros(2), np.full(2, 0.01)))


@pytest.mark.parametrize(("robot", "bearing"), [(0, 0.3), (1, 0.3 - np.pi)])
def test_a_range_uses_the_bearing_of_the_same_sighting_from_either_end(robot, bearing):
    team, belief = two_within_reach()
    seen, far = Bearing(0.0, robot, 1 - robot, bearing, 0.05), Range(0.0, 0, 1, 3.0, 0.1, 0.0)
    alone, both = (merging(belief, some, team, SPACING, cells=0).merged() for some in ([far], [seen, far]))
    assert passes(alone)[0].arcs.full.all()
    assert len(both.evidence) == 1
    assert both.evidence[0].arcs.centre[0] == pytest.approx(0.3)
    assert both.evidence[0].arcs.bound[0] == pytest.approx(0.06, abs=1e-6)
    between = both.polytope.of(np.array([0]), np.array([1])).polygons[0]
    assert (between.vertices @ unit(0.3)).min() == pytest.approx(2.9 * np.cos(0.06), abs=1e-4)


@given(seeds)
def test_order_parts_and_repetition_make_no_difference_to_any_bit(seed):
    rng, (world, belief, records) = np.random.default_rng(seed), drawn(seed)
    single = []
    for record in records:
        for k in rng.permutation(np.repeat(np.arange(len(record.robot)), 2)).tolist():
            single.append(type(record)(0.0, **{name: getattr(record, name)[k] for name in field_names(record)}))
    parts = [single[k] for k in rng.permutation(len(single))]
    one, other = (merging(belief, some, world.team, SPACING, 16).merged() for some in (records, parts))
    for name in ("normal", "offset", "source", "i", "j"):
        values = [getattr(each.polytope.constraints, name).tobytes() for each in (one, other)]
        assert values[0] == values[1]
    assert one.headings.centre.tobytes() == other.headings.centre.tobytes()
    assert one.headings.bound.tobytes() == other.headings.bound.tobytes()


def test_a_box_at_a_glance_is_around_what_a_robots_own_rows_leave_and_an_empty_one_stays():
    normals = np.array([[1.0, 0.0], [-1.0, 0.0], [1.0, 0.0]])
    rows = on_robot(np.array([0, 1, 1]), normals, np.array([0.5, -0.8, 0.2]), np.zeros(3, dtype=int))
    rows = replace(rows, i=np.full(3, -1), j=np.array([0, 1, 1]))
    known = Polytope(rows, np.zeros((3, 2)), np.ones((3, 2)))
    boxed = boxed_at_a_glance(known)
    assert boxed.upper[0] == pytest.approx([0.5, 1.0])
    assert boxed.upper[0, 0] >= 0.5
    assert (boxed.lower[1:] == known.lower[1:]).all()
    assert (boxed.upper[1:] == known.upper[1:]).all()


@given(seeds)
def test_a_box_at_a_glance_grows_nowhere_and_keeps_the_truth(seed):
    world, belief, records = drawn(seed)
    merged = merging(belief, records, world.team, SPACING, cells=0).merged().polytope
    boxed = boxed_at_a_glance(merged)
    assert (boxed.lower >= merged.lower).all()
    assert (boxed.upper <= merged.upper).all()
    assert ((boxed.lower <= world.positions) & (world.positions <= boxed.upper)).all()


@pytest.mark.parametrize("seed", [1, 2])
def test_a_compass_that_says_nothing_new_for_long_is_no_reason_for_cells(seed):
    """With constant errors a heading stays as wide as a bearing's bound, and no wider."""
    run = from_simulator(episode(errors="bias", seed=seed, duration=4.0), 10.0)
    beliefs = [step.belief for step in steps(SetMembershipFilter(run.team), run)]
    in_cells = [any(isinstance(proof, Cases) for proof in belief.proofs) for belief in beliefs]
    assert np.median([belief.headings.bound for belief in beliefs]) > 0.9 * np.radians(3)
    assert sum(in_cells) < len(beliefs) / 4
