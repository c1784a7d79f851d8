"""Numbers at which filters break: far away, tiny, huge, exact, flat, equal, at the turn of an angle."""

from fractions import Fraction

import numpy as np
import pytest
from helpers.programs import on_robot
from helpers.worlds import World, escapes, offset_through, random_program, unit
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy import sparse

from filter import Bearing, Compass, Range
from filter.diagnosis.set_membership_filter import SetMembershipFilter
from filter.geometry.angles import AngularIntervals, wrap
from filter.geometry.polygon import Polygon
from filter.linear.polytope import Polytope
from filter.linear.program import LinearProgram, twice_precise_dot
from filter.linear.solvers import deepest_point, workspace

seeds = st.integers(0, 2**32 - 1)
FAR = np.array([[0.0, 0.0], [4.4e5, 5.3e6], [-1e7, 1e7]])


def placed(kind, rng, size):
    """Return positions and headings of three robots."""
    positions, headings = rng.uniform(0, size, (3, 2)), rng.uniform(-np.pi, np.pi, 3)
    if kind == "on a line":
        positions[:, 1], headings[:] = positions[0, 1], 0.0
    if kind == "in one point":
        positions[:] = positions[0]
    if kind == "seen behind":  # bearings at plus and minus half a turn
        positions[:, 1], headings[:] = positions[0, 1], np.where(np.argsort(positions[:, 0]) == 2, 0.0, np.pi)
    return positions, headings


@settings(max_examples=25)
@given(
    seeds,
    st.sampled_from([1e-3, 1.0, 1e5]),
    st.sampled_from([0, 1, 2]),
    st.sampled_from([0.0, 1e-9, 0.05]),
    st.sampled_from(["anyhow", "on a line", "in one point", "seen behind"]),
)
def test_no_robot_escapes_anywhere(seed, size, far, bound, kind):
    rng = np.random.default_rng(seed)
    world = World(rng, robots=3, landmarks=1, size=size, sight=10 * size, compass=bound, bearing=bound, range=bound)
    positions, world.headings = placed(kind, rng, size)
    world.positions = FAR[far] + positions  # rounded to where floats are
    marks = FAR[far] + rng.uniform(0, size, (1, 2))
    object.__setattr__(world.team, "landmarks", marks)
    reach = size * rng.choice([0.1, 1.0])
    estimator = SetMembershipFilter(world.team)
    boxes = [Polygon.box(place - reach, place + reach) for place in world.positions]
    belief = estimator.start(0.0, boxes, AngularIntervals(world.headings, np.full(3, bound + 1e-9)))
    for _ in range(2):
        belief = estimator.update(belief, [*world.measure()])
        assert escapes(belief, world.positions, world.headings) == []
    moved = estimator.predict(belief, world.time + 0.1, world.move())
    after = estimator.update(moved, world.measure())
    assert escapes(after, world.positions, world.headings) == []


@given(seeds, st.sampled_from([0, 1, 2]), st.sampled_from([0.0, 1e-9, 0.1]), st.booleans())
def test_a_bearing_at_half_a_turn_is_like_any_other(seed, far, bound, above):
    rng = np.random.default_rng(seed)
    world = World(rng, robots=2, landmarks=0, size=3.0)
    world.positions = FAR[far] + np.array([[4.0, 0.0], [0.0, 0.0]])
    team = SetMembershipFilter(world.team)
    belief = team.start(
        0.0, [Polygon.box(p - 0.5, p + 0.5) for p in world.positions], AngularIntervals([0.0, 0.0], [1e-9, 1e-9])
    )
    error = rng.choice([-1, 1]) * bound
    seen = float(wrap((np.pi if above else -np.pi) + error))
    belief = team.update(belief, [Bearing(0, 0, 1, seen, bound + 1e-12), Bearing(0, 0, 1, -np.pi, bound + 1e-12 + abs(error))])
    assert escapes(belief, world.positions, np.zeros(2)) == []


@given(seeds, st.sampled_from([1e-3, 1.0, 1e5]), st.sampled_from([0.0, 5e6, 1e7]))
def test_a_set_missed_by_one_unit_in_the_last_place_is_told_from_one_that_is_not(seed, size, origin):
    """Two rows that touch in a point have it in common; a hair apart they may be proved empty, or not: never the reverse."""
    rng = np.random.default_rng(seed)
    drawn = random_program(rng, size=size, origin=origin)
    normal, point = np.zeros(4), drawn.centre
    normal[:2] = unit(rng.uniform(-np.pi, np.pi))
    one, other = offset_through(normal, point), offset_through(-normal, point)
    A = sparse.csr_array(np.vstack([drawn.A.toarray(), normal, -normal]))
    for ulps in range(3):
        b = np.append(drawn.b, [one, other])
        for _ in range(ulps):
            b[-1] = np.nextafter(b[-1], -np.inf)
        program = LinearProgram(A, b, drawn.lower, drawn.upper)
        empty = Fraction(float(b[-1])) + Fraction(float(b[-2])) < 0
        farkas = np.append(np.zeros(len(drawn.b)), [1.0, 1.0])
        found = deepest_point(program, "piqp")
        for proof in (farkas, *([found.multipliers] if found else [])):
            assert empty or not program.proves_empty(proof)


def test_a_gap_of_a_few_units_in_the_last_place_is_proved_at_any_distance():
    """The slack is computed in twice the precision, so that large coordinates hide nothing."""
    for origin in (0.0, 1e7, 1e9):
        normal = unit(0.7)
        offset = offset_through(normal, np.full(2, origin))
        gap = 4 * np.spacing(max(offset, 1e-12))
        A = sparse.csr_array([normal, -normal])
        apart = LinearProgram(A, np.array([offset, -offset - gap]), np.full(2, origin - 1e-3), np.full(2, origin + 1e-3))
        assert apart.proves_empty(np.ones(2)) == (gap > 1e-13)


@settings(max_examples=10)
@given(seeds, st.sampled_from([0.0, 1e7]))
def test_a_thousand_redundant_rows_change_nothing_but_time(seed, origin):
    rng = np.random.default_rng(seed)
    square = Polygon.box([origin - 1, origin - 1], [origin + 1, origin + 1])
    directions = unit(rng.uniform(-np.pi, np.pi, 1000))
    twice = np.concatenate([square.normals, square.normals, directions, directions])
    offsets = np.concatenate([square.offsets, square.offsets, np.tile(square.support(directions) + 1e-3, 2)])
    rows = on_robot(0, twice, offsets, np.zeros(len(offsets), dtype=int))
    program = Polytope(rows, np.full((1, 2), origin - 5), np.full((1, 2), origin + 5)).program()
    for solver in ("piqp", "highs"):
        found = workspace(program, solver).maximize(np.array([1.0, 0.0]))
        bound = float(program.certified_bounds(np.array([[1.0, 0.0]]), found.multipliers[None])[0])
        assert origin + 1 <= bound <= origin + 1 + 1e-6
    assert not program.proves_empty(deepest_point(program, "piqp").multipliers)


@pytest.mark.parametrize("bound", [0.0, 1e-9])
def test_measured_twice_is_measured_once(bound):
    world = World(np.random.default_rng(3), robots=3, sight=99.0, bearing=bound, range=bound, compass=bound)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    records = world.measure()
    belief = estimator.update(belief, [*records, *records, *records])
    assert escapes(belief, world.positions, world.headings) == []
    assert all(region.outer.area < 1e-6 for region in belief.regions)


def test_values_and_bounds_at_the_edge_of_what_is_accepted():
    world = World(np.random.default_rng(4), robots=2, landmarks=0)
    estimator = SetMembershipFilter(world.team)
    belief = estimator.start(0.0, world.initial_sets(), world.initial_headings())
    nothing = [
        Compass(0, [0, 1], [0.0, 100.0], np.pi),
        Range(0, 0, 1, 0.0, 1e6, 0.999),
        Range(0, 1, 0, 1e6, 1e6, 0.0),
        Bearing(0, 0, 1, world.headings[0] * 0, np.nextafter(np.pi / 2, 0)),
    ]
    after = estimator.update(belief, nothing[:3])
    assert escapes(after, world.positions, world.headings) == []
    assert [region.outer.area for region in after.regions] == pytest.approx([r.outer.area for r in belief.regions], rel=1e-6)


@given(seeds, st.integers(1, 40))
def test_a_dot_product_in_twice_the_precision_is_off_by_as_little_as_it_says(seed, count):
    rng = np.random.default_rng(seed)
    a, b = (rng.normal(size=(3, count)) * 10.0 ** rng.uniform(-8, 8, (3, count)) for _ in range(2))
    a[:, count // 2 :], b[:, count // 2 :] = a[:, : count - count // 2], -b[:, : count - count // 2]  # most of it cancels
    high, low = twice_precise_dot(a, b)
    for k in range(3):
        products = [Fraction(float(x)) * Fraction(float(y)) for x, y in zip(a[k], b[k], strict=True)]
        error = abs(Fraction(float(high[k])) + Fraction(float(low[k])) - sum(products))
        assert error <= Fraction((count * np.finfo(float).eps) ** 2 / 2) * sum(map(abs, products))
