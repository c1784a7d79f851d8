"""Rows that the checker takes from what mounted sensors measure: none that a place which they allow would break."""

from fractions import Fraction
from types import SimpleNamespace

import numpy as np
import pytest
from helpers.sensing.mounted import turned
from helpers.worlds import unit
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.proof.edges import plane
from experiments.proof.exact import arc_around
from experiments.proof.given.frame import Frame, Reading
from experiments.proof.given.sensors import CENTRE, Mounts
from experiments.proof.measured import BEARING, DIRECTION, FAR, NEAR, Instant, of_measurement
from experiments.proof.reading import MISSHAPEN, Broken
from experiments.proof.sides import Sides

SENSORS = {"camera": {"position": [0.4, -0.3], "position_bound": 0.02}, "tag": {"position": [-0.2, 0.1]}}
CAMERA, TAG = Mounts(SENSORS).pair([0, 1])
LOG = SimpleNamespace(robots=2, landmarks=[])
seeds = st.integers(0, 2**32 - 1)


def exactly(*values):
    return [Fraction(float(value)) for value in values]


def instant(headings, bound, **readings):
    """Return what robot 0, which sees robot 1, measures: readings by their kinds, with headings known to a bound."""
    frame = Frame(0.0, {(kind, 0, 1): [one] for kind, one in readings.items()})
    return Instant(LOG, frame, [arc_around(float(one), float(bound)) for one in headings], Sides(2, []))


def link_of(then, kind, normal, offset):
    source = {"kind": kind, "robot": 0, "target": 1}
    return of_measurement(then, (0, 1), source, plane(np.asarray(normal, dtype=float).tolist()), Fraction(float(offset)))


def places_allowed(rng, then, bearing, distances):
    """Return places (k, 2) of robot 1, as seen from robot 0, that a bearing and a range between their sensors allow."""
    count, ends = 400, np.array([-1.0, 1.0, 0.0])
    arcs = [[float(arc.low + arc.high) / 2, float(arc.high - arc.low) / 2] for arc in then.headings]
    own, other = (middle + half * np.append(ends, rng.uniform(-1, 1, count - 3)) for middle, half in arcs)
    rng.shuffle(other)
    camera = SENSORS["camera"]["position"] + 0.02 * unit(rng.uniform(-np.pi, np.pi, count))
    tag = np.tile(SENSORS["tag"]["position"], (count, 1))
    way = own + bearing[0] + bearing[1] * rng.choice([-1, 1, 0.3], count)
    return turned(own, camera) + rng.choice(distances, count)[:, None] * unit(way) - turned(other, tag)


@settings(max_examples=80, deadline=None)
@given(seeds)
def test_no_row_is_taken_that_cuts_off_a_place_that_is_allowed(seed):
    rng = np.random.default_rng(seed)
    bearing, distances = (rng.uniform(-np.pi, np.pi), rng.choice([0.0, 0.05, 0.6])), rng.uniform(0, 3) + np.array([0.0, 0.2])
    seen = Reading(*exactly(*bearing), Fraction(0), CAMERA, TAG)
    far = Reading(*exactly(distances.mean(), np.ptp(distances) / 2), Fraction(0), CAMERA, TAG)
    headings, known = rng.uniform(-np.pi, np.pi, 2), rng.choice([0.0, 0.02, 0.5])
    then = instant(headings, known, bearing=seen, range=far)
    middle, half = headings[0] + bearing[0], known + bearing[1]
    for kind, normal in (
        ("bearing", unit(middle + half + 1e-9 + np.pi / 2)),
        ("bearing", -unit(middle - half - 1e-9 + np.pi / 2)),
        ("range", -unit(middle)),
        ("range", unit(rng.uniform(-np.pi, np.pi))),
    ):
        some = [0.0, 1.0, 1e3] if kind == "bearing" else distances
        most = (places_allowed(rng, then, bearing, some) @ normal).max()
        assert link_of(then, kind, normal, most - 1e-6) is None
        enough = max(most, distances.max() if kind == "range" else 0.0) + 1.0
        assert link_of(then, kind, normal, enough) in (BEARING, DIRECTION, FAR, NEAR)


def test_a_bearing_tells_the_direction_of_a_range_between_the_same_two_places_alone():
    arm, ahead = Fraction(1, 2), np.array([-1.0, 0.0])
    for own, other in ((CAMERA, TAG), (CAMERA, CENTRE), (CENTRE, TAG)):
        far = Reading(Fraction(5), Fraction(0), Fraction(0), own, other)
        for seer, seen in ((CAMERA, TAG), (CAMERA, CENTRE), (CENTRE, TAG)):
            then = instant([0.0, 0.0], 0.0, range=far, bearing=Reading(Fraction(0), Fraction(0), Fraction(0), seer, seen))
            near = link_of(then, "range", ahead, -4.99 + float(3 * arm))
            assert near == (NEAR if (own, other) == (seer, seen) else None)


def side(offset, sensors):
    """Return a line that puts robot 0 behind x = offset, as a side of a landmark; its sensors are meant."""
    normal = [(1.0).hex(), (0.0).hex()]
    return {"from": -1, "robot": 0, "side": 1, "normal": normal, "offset": float(offset).hex(), "sensors": sensors}


def test_a_side_is_one_of_its_two_places_alone_and_leaves_room_for_them():
    sides, looks = Sides(1, [(Fraction(5), Fraction(0))], Mounts(SENSORS)), [arc_around(0.0, 0.1)]
    sides.add(side(4.5, [0, -1]), Fraction(9, 2), looks)
    assert sides.arc(0, 1, (CAMERA, CENTRE)) is not None
    assert sides.arc(0, 1, (TAG, CENTRE)) is sides.arc(0, 1) is None
    for room in (0.4, 0.44):  # it is 0.4 m ahead, farther if the robot looks to the left, and 0.02 m more
        with pytest.raises(Broken, match="a side that the target may be"):
            sides.add(side(5 - room, [0, -1]), Fraction(5) - Fraction(room), looks)
    for wrong in ([0], [0, 2], None, [True, -1], [0, 0]):
        with pytest.raises((Broken, *MISSHAPEN)):
            sides.add(side(4.5, wrong), Fraction(9, 2), looks)
