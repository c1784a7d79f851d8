"""How the checker cuts and joins odometry: what a robot did is within it, and the filter claims no less."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from helpers.drives import TICK, Drive
from hypothesis import given, settings
from hypothesis import strategies as st

from experiments.proof.edges import plane
from experiments.proof.exact import Arc, arc_around
from experiments.proof.given.driven import Driven, Limits, Part
from experiments.proof.motion import Displaced, Piece, turned
from experiments.proof.reading import Broken
from filter import AngularIntervals, InvalidInput, Motions, Odometry, Team, Twist
from filter.motions import NAMES
from filter.sensing.motion import displacements, turned_headings

KINDS = ["driving", "standing", "on the spot", "sideways"]
DIRECTIONS = [np.array([np.cos(way), np.sin(way)]) for way in np.linspace(-np.pi, np.pi, 17)]
ROUNDING = 1e-12  # of the true motion, which is added up in floats
RATES = ("speed", "speed_bound", "turn_rate", "turn_rate_bound", "direction_bound", "slip_rate", "aside")
seeds = st.integers(0, 2**32 - 1)


def limits_of(limits):
    values = [limits[name] for name in ("speed_limit", "turn_rate_limit", "acceleration_limit", "turn_acceleration_limit")]
    return Limits(*(None if np.isinf(value) else Fraction(value) for value in values))


def part_of(record):
    """Return what a record of one robot tells."""
    if isinstance(record, Odometry):
        return Part(record.start, record.time, Piece(*(Fraction(getattr(record, name)[0]) for name in NAMES)), steady=False)
    end = record.time + record.hold[0].item()
    values = {name: Fraction(getattr(record, name)[0]) for name in RATES}
    lasting = Fraction(end) - Fraction(record.time)
    grown = [value * (1 if name in ("direction_bound", "aside") else lasting) for name, value in values.items()]
    return Part(record.time, end, Piece(*grown), steady=True)


def compared(rng, told, team, span):
    """Check that the filter claims no less of a span; return what is known of place and heading."""
    (motions, driven), (begin, end) = told, span
    heading = rng.uniform(-np.pi, np.pi), rng.choice([0.0, 0.1, 1.0, np.pi])
    odometry, pieces, arc = motions.between(begin, end), driven.pieces(begin, end), arc_around(*heading)
    displaced, looks, before = Displaced.of(pieces, arc), turned(pieces, arc), AngularIntervals(*heading)
    after = turned_headings(odometry, before, team, end - begin)
    assert arc_around(after.centre[0].item(), after.bound[0].item()).covers(looks)
    moves = displacements(odometry, before, team, end - begin)
    for way in DIRECTIONS:
        claimed = moves.support(np.array([0]), way[None])[0].item()
        assert displaced.support(plane(way.tolist())) <= Fraction(claimed)
    return heading[0], displaced, looks


@pytest.mark.parametrize("kind", KINDS)
@settings(max_examples=6, deadline=None)
@given(seeds)
def test_what_was_done_in_any_span_is_within_what_is_said_of_it(kind, seed):
    rng = np.random.default_rng(seed)
    drive = Drive(rng, kind)
    team = Team(1, **drive.limits)
    motions, driven, stamps = Motions(team), Driven(limits_of(drive.limits)), np.unique(rng.integers(0, len(drive.path), 12))
    spans = [span for span in pairwise(stamps) if span[1] - span[0] < 150 and rng.random() < 0.9]
    for begin, end in rng.permutation(np.array(spans, dtype=int).reshape(-1, 2)).tolist():
        record = drive.record(begin, end)
        motions = motions.merged(record)
        driven.add(part_of(record))
    for _ in range(8):
        begin, end = np.sort(rng.integers(0, len(drive.path), 2)).tolist()
        if begin < end:
            first, displaced, looks = compared(rng, (motions, driven), team, (begin * TICK, end * TICK))
            holds(drive, (begin, end), first, displaced, looks)


def holds(drive, span, first, displaced, looks):
    """Check that a drive from one tick to another, from a heading on, is within what is known of it."""
    begin, end = span
    now = first + drive.heading[end] - drive.heading[begin]
    assert looks.covers(Arc.between(Fraction(now), Fraction(now)))
    c, s = np.cos(first - drive.heading[begin]), np.sin(first - drive.heading[begin])
    moved = np.array([[c, -s], [s, c]]) @ (drive.place[end] - drive.place[begin])
    assert all(way @ moved <= displaced.support(plane(way.tolist())) + ROUNDING for way in DIRECTIONS)


def record_at(rng, time):
    """Return a record that begins at a time, whatever it says."""
    kind = rng.integers(6)
    distance, turn = (0.0 if rng.uniform() < 0.2 else rng.choice([-1, 1]) * 10 ** rng.uniform(-5, 0) for _ in range(2))
    bounds = [0.0 if rng.uniform() < 0.2 else 10 ** rng.uniform(-6, -0.5) for _ in range(4)]
    aside = rng.choice([0.0, np.pi / 2, rng.uniform(-6, 6)])
    if kind < 2:
        return Twist(time, 0, distance, bounds[0], turn, *bounds[1:], rng.choice([0.1, 1.0]), aside)
    return Odometry(
        time, time + rng.uniform(0.01, 0.3), 0, distance, bounds[0], turn * (4 if kind == 5 else 1), *bounds[1:], aside
    )


@settings(max_examples=150, deadline=None)
@given(seeds)
def test_the_filter_claims_no_less_whatever_the_records_say(seed):
    rng = np.random.default_rng(seed)
    limits = {"speed_limit": rng.choice([0.0, 1.0]), "turn_rate_limit": rng.choice([0.0, 0.5, 6.0])}
    limits |= {name: rng.choice([0.0, 1.0, np.inf]) for name in ("acceleration_limit", "turn_acceleration_limit")}
    team, start = Team(1, **limits), rng.choice([0.0, 1.7e9])
    motions, driven, time = Motions(team), Driven(limits_of(limits)), float(start)
    for _ in range(6):
        record = record_at(rng, time)
        motions = motions.merged(record)
        driven.add(part_of(record))
        time = record.time + (0.1 if isinstance(record, Twist) else rng.choice([0.0, 0.0, 0.2]).item())
    for _ in range(4):
        begin, end = np.sort(start + rng.uniform(-0.1, time - start + 0.2, 2)).tolist()
        compared(rng, (motions, driven), team, (begin, end))


def test_what_overlaps_or_takes_no_time_is_refused():
    told, team = Driven(Limits(Fraction(1), Fraction(1))), Team(1)
    motions = Motions(team)
    for begin, end in ((0.0, 1.0), (1.0, 1.5)):
        record = Odometry(begin, end, 0, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0)
        motions = motions.merged(record)
        told.add(part_of(record))
    for begin, end in ((0.5, 0.7), (1.4, 2.0), (2.0, 2.0), (-1.0, 0.1)):
        record = Odometry(begin, end, 0, 0.1, 0.1, 0.0, 0.0, 0.0, 0.0)
        with pytest.raises(InvalidInput):
            motions.merged(record)
        with pytest.raises(Broken):
            told.add(part_of(record))


def test_odometry_that_ends_a_twist_which_was_relied_on_is_refused():
    """Two seconds of the twist were taken to hold when nobody knew that the robot had long done something else."""
    still = Piece(*map(Fraction, (1, 0, 0, 0, 0, 0, 0)))
    for late in (False, True):
        told = Driven(Limits(Fraction(1), Fraction(1)))
        told.add(Part(0.0, 5.0, still, steady=True))
        if late:
            told.forget(2.0)
            with pytest.raises(Broken, match=r"from 1\.0 s on, where a twist was taken to hold until 2\.0 s"):
                told.add(Part(1.0, 3.0, still, steady=False))
        else:
            told.add(Part(1.0, 3.0, still, steady=False))
            assert [piece.distance for piece in told.pieces(0.0, 3.0)] == [Fraction(1, 5), 1]


def test_a_cut_without_a_limit_of_acceleration_is_as_wide_as_the_speed_allows():
    limits = Limits(Fraction(2), Fraction(1))
    told, free = Driven(limits), Driven(Limits(Fraction(2), Fraction(1), Fraction(1)))
    for each in (told, free):
        each.add(Part(0.0, 1.0, Piece(*map(Fraction, (1, 0, 0, 0, 0, 0, 0))), steady=False))
    (piece,), (less,) = told.pieces(0.0, 0.25), free.pieces(0.0, 0.25)
    assert (piece.distance - piece.distance_bound, piece.distance + piece.distance_bound) == (-0.5, 0.5)
    assert (less.distance, less.distance_bound) == (Fraction(1, 4), Fraction(3, 32))
