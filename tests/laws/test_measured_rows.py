"""Rows that the checker takes from a measurement: none that a place it allows would break, and all that the filter makes."""

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
from helpers.worlds import unit
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.proof.edges import plane
from experiments.proof.exact import Arc
from experiments.proof.given.frame import Frame, Reading
from experiments.proof.measured import BEARING, DIRECTION, FAR, NEAR, NEAR_OF_SIDES, Instant, of_measurement
from experiments.proof.sides import Sides

SIGHT = {"robot": 0, "target": 1}
seeds = st.integers(0, 2**32 - 1)


def instant(rng, kinds, sides):
    """Return what robot 0, which sees robot 1, knows and measures, and what that allows: directions and distances."""
    heading, bound = rng.uniform(-np.pi, np.pi), rng.choice([0.01, 0.3, 1.4])
    bearing = {"bearing": rng.uniform(-np.pi, np.pi), "bound": rng.choice([0.0, 0.05, 0.6])}
    given = {"range": rng.uniform(0, 4), "bound": rng.choice([0.0, 0.1]), "relative_bound": rng.choice([0.0, 0.05])}
    of_bearing, of_range = (Reading(*map(Fraction, map(float, each.values()))) for each in (bearing, given))
    readings = {(kind, 0, 1): [{"bearing": of_bearing, "range": of_range}[kind]] for kind in kinds}
    middle, reach = heading + bearing["bearing"], bound + bearing["bound"]
    known, low, high = Sides(2, []), middle - reach, middle + reach
    if "bearing" not in kinds:
        low, high = middle - np.pi, middle + np.pi
    if sides:
        low, high = middle - 0.4 * reach, middle + 0.3 * reach
        for normal in (-unit(low + np.pi / 2), unit(high + np.pi / 2)):
            line = {"from": 0, "robot": 1, "side": 0, "normal": [float.hex(float(x)) for x in normal], "offset": "0x0p+0"}
            known.add(line, Fraction(-1))
    near = max(0.0, (given["range"] - given["bound"]) / (1 + given["relative_bound"]))
    far = (given["range"] + given["bound"]) / (1 - given["relative_bound"])
    arc = Arc.between(Fraction(heading) - Fraction(bound), Fraction(heading) + Fraction(bound))
    log = SimpleNamespace(robots=2, landmarks=[])
    return Instant(log, Frame(0.0, readings), [arc, arc], known), (low, high), (near, far)


def row_near(rng, arc, distances, kind):
    """Return a normal and an offset that are almost those of a row of some kind, a little too little or too much."""
    low, high = arc
    if rng.uniform() < 0.2:  # both ends of a wide arc are behind what is in its middle
        return unit((low + high) / 2), 0.0
    middle, slack = (low + high) / 2, rng.choice([0.0, 1e-9, 0.1]) * rng.choice([-1, 1])
    if kind == "bearing":
        side = rng.choice([-1, 1])
        return side * unit((low if side < 0 else high) + side * slack + np.pi / 2), rng.choice([0.0, -1e-6, 0.1])
    if rng.uniform() < 0.5:
        return unit(rng.uniform(-np.pi, np.pi)), distances[1] + slack
    return -unit(middle + rng.choice([0.0, 0.2])), -distances[0] * np.cos((high - low) / 2) + slack


@settings(max_examples=200)
@given(seeds)
def test_no_row_is_taken_that_cuts_off_a_place_that_is_allowed(seed):
    rng = np.random.default_rng(seed)
    kind = rng.choice(["bearing", "range"])
    kinds = {"bearing", kind} if rng.uniform() < 0.7 else {kind}
    then, arc, distances = instant(rng, kinds, sides=kind == "range" and rng.uniform() < 0.4)
    normal, offset = row_near(rng, arc, distances, kind)
    link = of_measurement(then, (0, 1), {"kind": kind, **SIGHT}, plane(normal.tolist()), Fraction(float(offset)))
    assert of_measurement(then, (0, 2), {"kind": kind, **SIGHT}, plane(normal.tolist()), Fraction(float(offset))) is None
    if link is None:
        return
    assert link in ((BEARING,) if kind == "bearing" else (FAR, NEAR, NEAR_OF_SIDES, DIRECTION))
    for way in np.linspace(*arc, 41):
        for far in distances if kind == "range" else (0.0, 1.0, 1e3):
            assert far * normal @ unit(way) <= offset + 1e-12 * (1 + far)


@given(seeds)
def test_the_rows_themselves_are_taken(seed):
    rng = np.random.default_rng(seed)
    then, (low, high), (near, far) = instant(rng, {"bearing", "range"}, sides=False)
    wide = 1e-9
    if high - low < 3:
        for side, end in ((-1, low), (1, high)):
            normal = plane((side * unit(end + side * wide + np.pi / 2)).tolist())
            assert of_measurement(then, (0, 1), {"kind": "bearing", **SIGHT}, normal, Fraction(0)) == BEARING
        normal, offset = plane((-unit((low + high) / 2)).tolist()), -near * np.cos((high - low) / 2) + wide
        assert of_measurement(then, (0, 1), {"kind": "range", **SIGHT}, normal, Fraction(float(offset))) in (NEAR, FAR)
    normal = plane(unit(rng.uniform(-np.pi, np.pi)).tolist())
    assert of_measurement(then, (0, 1), {"kind": "range", **SIGHT}, normal, Fraction(float(far + wide))) == FAR
