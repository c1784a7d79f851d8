"""Rows of bearings and ranges never cut off the truth, and the paper's printed signs would."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.worlds import NO_ROWS, exact_slack, unit
from hypothesis import assume, given
from hypothesis import strategies as st

from filter import Bearing, Compass, Range
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import clip
from filter.geometry.sector import far_and_near, sides
from filter.linear.constraints import WORLD, Constraints
from filter.linear.polytope import Polytope
from filter.sensing.headings import heading_arcs_of_bearing, heading_arcs_of_compass
from filter.sensing.rows import (
    WIDENING,
    bearing_rows,
    on_robots,
    range_rows,
    spans_of_targets,
    world_arcs,
)

DRAWS = 20_000
# Rows on pairs are not moved outward before `on_robots`: the rounding of their own check [m].
ROUNDING = 1e-13


def drawn(rng, widest, extreme):
    """Return positions of two robots, the bearing's arc and the range's record of DRAWS measurements within their bounds."""
    i = rng.integers(0, 2, DRAWS)  # who measures: either order of numbers
    positions = rng.uniform(-5, 5, (DRAWS, 2, 2))
    near = rng.random(DRAWS) < 0.1
    positions[near, 1] = positions[near, 0] + rng.uniform(-1, 1, (near.sum(), 2)) * 10.0 ** rng.uniform(-12, 0, (near.sum(), 1))
    positions[:50, 1] = positions[:50, 0]
    each = np.arange(DRAWS)
    difference = positions[each, 1 - i] - positions[each, i]
    error = rng.choice([-1.0, 1.0], (2, DRAWS)) if extreme else rng.uniform(-1, 1, (2, DRAWS))
    bound = np.where(rng.random(DRAWS) < 0.05, 0.0, rng.uniform(0, widest, DRAWS))
    angle = np.arctan2(difference[:, 1], difference[:, 0])
    angle[rng.random(DRAWS) < 0.5] += 2 * np.pi
    distance = np.hypot(*difference.T)
    absolute, relative = 0.3 * rng.random(DRAWS), 0.3 * rng.random(DRAWS)
    measured = distance + error[1] * (absolute + relative * distance)
    low = np.maximum(measured, 0)
    record = Range(0.0, i, 1 - i, low, absolute + np.abs(low - measured) + 1e-12, relative)
    return positions, AngularIntervals(angle + bound * error[0], bound), record


def violation(rows, positions):
    """Return (r,) by how much each row's own pair of positions breaks it [m]."""
    at = positions[rows.source]
    return (rows.normal * (at[:, 1] - at[:, 0])).sum(axis=1) - rows.offset


@pytest.mark.parametrize("extreme", [False, True])
@pytest.mark.parametrize("widest", [np.radians(5), np.pi / 2, np.pi])
def test_bearing_and_range_rows_keep_the_truth_on_their_side(widest, extreme):
    positions, arcs, record = drawn(np.random.default_rng(0), widest, extreme)
    source = np.arange(DRAWS)
    for rows in (bearing_rows(record.robot, record.target, arcs, source), range_rows(record, arcs, source)):
        assert len(rows) > DRAWS // 2
        assert (rows.i < rows.j).all()
        assert violation(rows, positions).max() <= ROUNDING


@pytest.mark.parametrize("part", ["first bearing", "second bearing", "near"])
def test_a_flipped_sign_cuts_off_the_truth(part):
    """As printed in the paper, the first bearing row has a sign flipped, and the near side of a range lacks a minus."""
    positions, arcs, record = drawn(np.random.default_rng(1), 0.1, False)
    source = np.arange(DRAWS)
    bearings, ranges = bearing_rows(record.robot, record.target, arcs, source), range_rows(record, arcs, source)
    if part == "near":
        rows = ranges.select(ranges.offset <= 0)
        rows = Constraints(rows.i, rows.j, -rows.normal, rows.offset, rows.source)
    else:
        rows = bearings.select(np.arange(len(bearings)) % 2 == (part == "second bearing"))
        flipped = rows.normal * (np.array([1, -1]) if part == "first bearing" else -1)
        rows = Constraints(rows.i, rows.j, flipped, rows.offset, rows.source)
    assert (violation(rows, positions) > 1e-6).mean() > 0.4


def test_without_its_minus_the_near_side_says_nothing():
    positions, arcs, record = drawn(np.random.default_rng(2), 0.1, False)
    rows = range_rows(record, arcs, np.arange(DRAWS))
    near = rows.select(rows.offset <= 0)
    printed = Constraints(near.i, near.j, near.normal, -near.offset, near.source)
    assert violation(printed, positions).max() < 0
    assert violation(near, positions).max() > -0.5


@given(st.floats(-np.pi, np.pi), st.floats(0, np.pi), st.floats(0.1, 3), st.floats(0, 3), st.floats(0.1, 1.5))
def test_bearings_and_ranges_are_sectors(angle, bound, least, width, spacing):
    """In either order of the robots' numbers, and wider by next to nothing."""
    arcs = AngularIntervals(np.full(2, angle), np.full(2, bound))
    robot, target, source = np.array([1, 0]), np.array([0, 1]), np.array([7, 8])
    record = Range(0.0, robot, target, least + width / 2, width / 2, 0.0)
    nearest, farthest = (each[0] for each in record.interval())
    wide = min(bound + WIDENING, np.pi)
    tangents, reach = far_and_near(angle, wide, nearest * (1 - WIDENING), farthest * (1 + WIDENING), spacing)
    rows = range_rows(record, arcs, source, spacing)
    beside = bearing_rows(robot, target, arcs, source)
    for sign, number in ((-1, 7), (1, 8)):
        mine = rows.select(rows.source == number)
        assert mine.normal == pytest.approx(sign * tangents, abs=1e-12)
        assert mine.offset == pytest.approx(reach, abs=1e-12)
        bearings = beside.select(beside.source == number)
        if bound < np.pi / 2 - 1e-6:
            assert bearings.normal == pytest.approx(sign * sides(angle, wide), abs=1e-12)
            assert (bearings.offset == 0).all()
        elif bound > np.pi / 2:
            assert len(bearings) == 0
    assert set(zip(rows.i.tolist(), rows.j.tolist(), strict=True)) == {(0, 1)}


def region(arc, record, box=20.0):
    """Return the area of where the target can be seen from the robot [m2]."""
    first = np.array([0])
    rows = Constraints.concatenate([bearing_rows(record.robot, record.target, arc, first), range_rows(record, arc, first)])
    return clip(rows.normal, rows.offset, np.full(2, -box), np.full(2, box))[0].area


@given(st.floats(-np.pi, np.pi), st.floats(0.01, np.pi / 12), st.floats(0.5, 3), st.floats(0.1, 3))
def test_the_area_of_a_range_with_a_bearing_is_the_formulas(angle, d, least, width):
    greatest = least + width
    record = Range(0.0, 0, 1, (least + greatest) / 2, width / 2, 0.0)
    sector = (greatest**2 - least**2) * d
    ratio = (greatest**2 * np.tan(d) - least**2 * np.sin(d) * np.cos(d)) / sector
    assert region(AngularIntervals(np.array([angle]), np.array([d])), record) / sector == pytest.approx(ratio, rel=1e-5)


def test_tangents_of_an_unknown_direction_cost_no_more_than_a_fortieth_of_area():
    area = region(AngularIntervals.circles(1), Range(0.0, 0, 1, 2.0, 0.5, 0.0))
    assert 1.0 < area / (np.pi * 2.5**2) < 1.024


@pytest.mark.parametrize("bound", [np.pi / 2, 2.0, np.pi])
def test_arcs_of_half_a_circle_or_more_give_no_bearing_rows_and_no_near_side(bound):
    one = np.array([0])
    arcs = AngularIntervals(np.array([0.3]), np.array([bound]))
    assert len(bearing_rows(one, one + 1, arcs, one)) == 0
    record = Range(0.0, 0, 1, 2.0, 0.1, 0.0)
    assert (range_rows(record, arcs, one).offset > 0).all()


def test_a_range_that_may_be_0_has_no_near_side():
    arcs = AngularIntervals(np.array([0.3]), np.array([0.1]))
    assert len(range_rows(Range(0.0, 0, 1, 0.1, 0.1, 0.0), arcs, np.array([0]))) == 1


def polytope(lower, upper):
    return Polytope(NO_ROWS, np.asarray(lower, dtype=float), np.asarray(upper, dtype=float))


@pytest.mark.parametrize("far", [0.0, 1e3, 5e6])
def test_rows_on_landmarks_become_rows_on_robots_that_hold_exactly(far):
    rng = np.random.default_rng(3)
    for _ in range(100):
        positions, marks = far + rng.uniform(-3, 3, (2, 2)), far + rng.uniform(-3, 3, (2, 2))
        where = polytope(positions - 0.2, positions + 0.2)
        bodies = np.concatenate([positions, marks])
        robot, target = np.array([0, 1, 1, 0]), np.array([2, 3, 0, 1])
        difference = bodies[target] - bodies[robot]
        arcs = AngularIntervals(np.arctan2(difference[:, 1], difference[:, 0]), np.zeros(4))
        record = Range(0.0, robot, target, np.hypot(*difference.T), 0.0, 0.0)
        source = np.arange(4)
        both = Constraints.concatenate([bearing_rows(robot, target, arcs, source), range_rows(record, arcs, source)])
        rows = on_robots(both, where, marks)
        assert (rows.j < 2).all()
        assert ((rows.i == WORLD) == (rows.source < 2)).all()
        for k in range(len(rows)):
            normal, point = rows.normal[k], positions[rows.j[k]]
            if rows.i[k] != WORLD:
                normal, point = np.append(normal, -normal), np.append(point, positions[rows.i[k]])
            assert exact_slack(normal, rows.offset[k], point) >= 0


@pytest.mark.parametrize("far", [0.0, 1.0, 1e6])
def test_the_allowance_of_a_row_covers_a_normal_that_is_off_by_rounding(far):
    rng = np.random.default_rng(4)
    lower, marks = far * rng.normal(size=(5, 2)), far * rng.normal(size=(2, 2))
    upper = lower + rng.uniform(0, 1, (5, 2))
    i, j = np.sort([rng.permutation(7)[:2] for _ in range(40)]).T
    i, j = i[i < 5], j[i < 5]
    rows = Constraints(i, j, unit(rng.uniform(-np.pi, np.pi, len(j))), rng.normal(size=len(j)), np.arange(len(j)))
    moved = on_robots(rows, polytope(lower, upper), marks)
    which = np.argsort(moved.source)[rows.source]
    off = rows.normal * (1 + np.finfo(float).eps * rng.choice([-1, 1], rows.normal.shape))
    for k in range(len(rows)):
        place = marks[rows.j[k] - 5] if rows.j[k] >= 5 else None
        assert (moved.i[which[k]] == WORLD) == (place is not None)
        others = [place] if place is not None else [lower[rows.j[k]], upper[rows.j[k]]]
        along = [Fraction(n) * Fraction(each) for n, each in zip(rows.normal[k], others[0], strict=True)]
        room = Fraction(moved.offset[which[k]]) - Fraction(rows.offset[k]) + (sum(along) if place is not None else 0)
        for here in (lower[rows.i[k]], upper[rows.i[k]]):
            assert all(abs((off[k] - rows.normal[k]) @ (there - here)) <= room for there in others)


def test_a_row_is_moved_outward_by_no_more_than_a_millionth():
    rows = bearing_rows(np.array([0]), np.array([1]), AngularIntervals(np.array([0.3]), np.array([0.1])), np.array([0]))
    moved = on_robots(rows, polytope(np.zeros((2, 2)), np.ones((2, 2))), np.zeros((0, 2)))
    assert (moved.offset > 0).all()
    assert (moved.offset < 1e-6).all()


@given(st.floats(-20, 20), st.floats(-np.pi, np.pi), st.floats(0, np.pi), st.floats(-1, 1))
def test_a_compass_arc_contains_the_heading(turns, heading, bound, error):
    shown = heading + 2 * np.pi * round(turns) + bound * error
    assume(abs(shown) < 4 * np.pi or not np.pi / 2 - 1e-9 < bound < np.pi)  # others are refused
    arc = heading_arcs_of_compass(Compass(0.0, 0, shown, min(bound + 1e-14, np.pi)))
    assert arc.contains(heading)[0]


@pytest.mark.parametrize("turns", [100, 1_000, 1_000_000])
def test_a_compass_that_counts_turns_still_contains_the_heading(turns):
    """Its bound is its own rounding and no more; what a wrap loses is the float's 2 pi, once for each turn."""
    pi = Fraction("3.14159265358979323846264338327950288419716939937510")
    shown = float(Fraction(1, 2) + 2 * turns * pi)
    bound = np.nextafter(float(abs(Fraction(shown) - Fraction(1, 2) - 2 * turns * pi)), 1.0)
    assert heading_arcs_of_compass(Compass(0.0, 0, shown, bound)).contains(0.5)[0]


@pytest.mark.parametrize("seed", range(5))
def test_headings_and_world_bearings_contain_the_truth(seed):
    rng = np.random.default_rng(seed)
    heading, way = rng.uniform(-np.pi, np.pi, (2, 500))
    bound, known, span = rng.uniform(0, 1, (3, 500)) * np.array([[1.5], [np.pi], [np.pi]])
    shown = way - heading + bound * rng.choice([-1, 1], 500)
    record = Bearing(0.0, np.zeros(500, dtype=int), 1, shown, bound)
    headings = AngularIntervals(heading + known * rng.choice([-1, 1], 500), known + 1e-14)
    spans = AngularIntervals(way + span * rng.choice([-1, 1], 500), span + 1e-14)
    assert world_arcs(record, headings).contains(way).all()
    assert heading_arcs_of_bearing(record, spans).contains(heading).all()


def test_spans_of_targets_contain_every_direction_in_either_order_and_to_landmarks():
    rng = np.random.default_rng(4)
    for _ in range(50):
        lower = rng.uniform(-3, 3, (3, 2))
        where, marks = polytope(lower, lower + rng.uniform(0, 1, (3, 2))), rng.uniform(-3, 3, (1, 2))
        robot, target = np.array([0, 1, 2, 1, 0]), np.array([1, 0, 1, 3, 3])
        spans = spans_of_targets(where, marks, robot, target)
        for _ in range(20):
            at = np.concatenate([rng.uniform(where.lower, where.upper), marks])
            difference = at[target] - at[robot]
            assert spans.contains(np.arctan2(difference[:, 1], difference[:, 0])).all()
        swapped = wrap(spans.centre[0] + np.pi - spans.centre[1])
        assert spans.full[0] or abs(swapped) < 1e-9


def test_a_direction_is_unknown_where_bodies_may_coincide():
    where = polytope(np.zeros((2, 2)), np.ones((2, 2)))
    assert spans_of_targets(where, np.array([[0.5, 0.5]]), np.array([0, 0]), np.array([1, 2])).full.all()
    assert len(spans_of_targets(where, np.zeros((0, 2)), np.zeros(0, dtype=int), np.zeros(0, dtype=int))) == 0


def test_the_span_of_two_known_points_is_a_direction():
    where = polytope([[0, 0], [3, 3]], [[0, 0], [3, 3]])
    spans = spans_of_targets(where, np.zeros((0, 2)), np.array([0, 1]), np.array([1, 0]))
    assert unit(spans.centre) == pytest.approx(unit(np.array([np.pi / 4, -3 * np.pi / 4])))
    assert (spans.bound < 1e-12).all()
