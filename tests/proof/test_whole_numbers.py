"""The checker's whole numbers say what fractions say, of numbers of any size, and err outward where they are rounded."""

from fractions import Fraction

import pytest
from hypothesis import given
from hypothesis import strategies as st

from experiments.proof.cases.polygon import Polygon, three
from experiments.proof.edges import of_two
from experiments.proof.exact import ANGLES, CIRCLE, HALF, PI, Arc, arc_around, direction, length, steps, unit, whole
from experiments.proof.line import greatest
from experiments.proof.motion import Motion

SIZES = [0.0, -0.0, 5e-324, -1e-310, 1e-160, 2.0**-60, 1.0, -1.5, 3e7, 1e160]
sizes = st.one_of(st.sampled_from(SIZES), st.floats(-4, 4), st.floats(-1e200, 1e200))
numbers = sizes.map(Fraction)
planes = st.tuples(numbers, numbers, numbers)
positive = st.one_of(st.sampled_from([5e-324, 2.0**-60, 1.0, 1e160]), st.floats(1e-3, 9)).map(Fraction)
angles = st.floats(-30, 30).map(Fraction)
normals = st.tuples(st.floats(-2, 2), st.floats(-2, 2)).map(lambda two: (Fraction(two[0]), Fraction(two[1])))


def test_half_a_turn_is_known_to_its_last_digit():
    """By Machin: pi is 16 arctan(1/5) - 4 arctan(1/239)."""

    def arctan(n):
        return sum(Fraction((-1) ** k, (2 * k + 1) * n ** (2 * k + 1)) for k in range(130))

    assert (16 * arctan(5) - 4 * arctan(239)) * 2**ANGLES // 1 == HALF


@given(st.lists(numbers, min_size=1, max_size=6))
def test_whole_numbers_are_the_same_numbers(values):
    *found, common = whole(*values)
    assert [Fraction(value, common) for value in found] == values


def cut(corners, lines, normal, offset):
    """Return a polygon behind a line, as lines and corners, in fractions and the obvious way."""
    found = []
    for k, (here, there) in enumerate(zip(corners, [*corners[1:], corners[0]], strict=True)):
        now, then = (normal[0] * x + normal[1] * y - offset for x, y in (here, there))
        if now <= 0:
            found.append((here, lines[k] if then <= 0 or now < 0 else (normal, offset)))
        if now * then < 0:
            share = now / (now - then)
            place = tuple(p + share * (q - p) for p, q in zip(here, there, strict=True))
            found.append((place, lines[k] if then < 0 else (normal, offset)))
    return zip(*found, strict=True) if found else (None, None)


@given(st.tuples(positive, positive), st.lists(planes, max_size=5), planes, positive)
def test_polygons_are_those_of_fractions(far, planes, other, distance):
    (x, y), no, one = far, Fraction(0), Fraction(1)
    polygon, corners = Polygon.box((-x, -y), far), [(-x, -y), (x, -y), (x, y), (-x, y)]
    lines = [((no, -one), y), ((one, no), x), ((no, one), y), ((-one, no), x)]
    for a, b, c in planes:
        polygon, (corners, lines) = polygon.cut(three(a, b, c)), cut(corners, lines, (a, b), c)
        if polygon is None or corners is None:
            assert polygon is corners is None
            return
        assert set(polygon.corners) == set(corners)
    a, b, c = other
    most = max(a * p + b * q for p, q in corners)
    chosen = int(a * 2**60), int(b * 2**60)
    reach = max(chosen[0] * p + chosen[1] * q for p, q in corners) / 2**60
    assert 0 <= Fraction(polygon.reach(chosen), 2**110) - reach < Fraction(1, 2**110)
    assert polygon.is_behind(three(a, b, c)) == (most <= c)
    nearer = all((p - u) ** 2 + (q - v) ** 2 < distance**2 for p, q in corners for u, v in corners)
    assert polygon.is_nearer(polygon, distance) == nearer


@given(planes, planes, st.tuples(numbers, numbers))
def test_what_two_edges_say_is_what_fractions_say(one, other, normal):
    (a, b, p), (c, d, q), (x, y) = one, other, normal
    if (a, b) == (c, d):
        return
    turned, by_one, by_other = a * d - b * c, x * d - y * c, a * y - b * x
    found = of_two({(a, b): p, (c, d): q}, (a, b), (c, d), normal)
    assert found == ((by_one * p + by_other * q) / turned if turned > 0 and min(by_one, by_other) >= 0 else None)


@given(
    st.lists(st.tuples(st.floats(0, 9), sizes, st.floats(-1, 1)), max_size=3),
    st.floats(-1, 1),
    st.lists(sizes, min_size=8, max_size=8),
)
def test_a_line_proves_what_it_does_in_fractions(rows, x, ends):
    told = [
        {"i": -1 if k else 0, "j": 1, "multiplier": y.hex(), "offset": b.hex(), "normal": [a.hex(), "1.0"]}
        for k, (y, b, a) in enumerate(rows)
    ]
    lows, highs = ([float(f([a, b])) for a, b in zip(ends[:4], ends[4:], strict=True)] for f in (min, max))
    box = {
        side: {"0": [v.hex() for v in all_[:2]], "1": [v.hex() for v in all_[2:]]}
        for side, all_ in (("lower", lows), ("upper", highs))
    }
    line = {"from": 0, "robot": 1, "normal": [x.hex(), "1.0"], "rows": told, **box}
    rest, total = [-Fraction(x), Fraction(-1), Fraction(x), Fraction(1)], Fraction(0)
    for k, (y, b, a) in enumerate(rows):
        total += Fraction(y) * Fraction(b)
        for c, value in enumerate((Fraction(y) * Fraction(a), Fraction(y))):
            rest[2 + c] -= value
            rest[c] += 0 if k else value
    total += sum(value * Fraction(high if value > 0 else low) for value, low, high in zip(rest, lows, highs, strict=True))
    assert greatest(line) == total


@given(normals, st.tuples(st.floats(-30, 30), st.floats(0, 4)), st.tuples(st.floats(-2, 2), st.floats(0, 2)), st.floats(0, 1))
def test_the_support_of_a_motion_errs_outward_by_a_hair(normal, arc, way, chord):
    (low, width), (least, more), (x, y) = map(Fraction, arc), map(Fraction, way), normal
    slip, hair = abs(least) / 8, Fraction(1, 2**100)
    motion = Motion(Arc.between(low, low + width), least, least + more, Fraction(chord), slip)
    support = motion.support(normal)
    for far in (least, least + more):
        for share in range(5):
            (cosine, _), (sine, _) = unit(low + width * Fraction(share, 4))
            assert support + hair >= far * (x * cosine + y * sine) + slip * length(normal) - hair
    assert support <= length(normal) * (max(abs(least), abs(least + more)) + slip) + hair


@given(angles, angles, st.floats(0, 3).map(Fraction), st.integers(-50, 50))
def test_arcs_err_outward_by_some_steps(low, centre, bound, turns):
    step = Fraction(1, 2**ANGLES)
    arc, third = Arc.between(low / 3, low / 3 + 1), centre / 3
    wider, by = arc.widened(third, bound / 3), 2 * turns * PI
    assert arc.low <= low / 3 <= arc.low + step
    assert arc.high - step <= low / 3 + 1 <= arc.high
    assert wider.low <= low / 3 + third - bound / 3 <= wider.low + 4 * step
    assert wider.high - 4 * step <= low / 3 + 1 + third + bound / 3 <= wider.high
    turned = arc.turned(turns)
    assert turned.low <= arc.low + min(by, by + 2 * turns * step) and arc.high + max(by, by + 2 * turns * step) <= turned.high
    assert arc.opposite.low <= arc.low + PI and arc.high + PI + step <= arc.opposite.high
    assert Arc(arc.first, arc.last).covers(arc.turned(turns)) == (not turns)


def test_an_arc_with_finer_digits_is_refused_and_not_rounded():
    assert arc_around(0.5, 2.0**-100).low == Fraction(0.5) - Fraction(2.0**-100)
    assert arc_around(0.0, 4.0).high == CIRCLE
    with pytest.raises(ValueError, match="finer digits"):
        arc_around(1e-60, 0.5)


@given(sizes)
def test_steps_are_no_smaller(value):
    assert 0 <= Fraction(steps(Fraction(value)), 2**110) - Fraction(value) < Fraction(1, 2**110)


def test_directions_are_those_of_angles_in_steps():
    assert direction(0) == ((2**110 - 1, 2**110 + 2), (-1, 2))
    with pytest.raises(ValueError, match="turns"):
        direction(HALF * 4000)
