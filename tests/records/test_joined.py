"""Odometry that is joined contains all that its pieces can have been, one after the other, whatever they say."""

import numpy as np
import pytest

from filter import AngularIntervals, Motions, Odometry, Team
from filter.sensing.motion import displacements, turned_headings

WAYS = np.linspace(-np.pi, np.pi, 25)
SOME = 400  # drives that are drawn of each


def pieces_of(rng, count):
    """Return a record for each of some times, wild ones among them, as a law has no favourites."""
    wild = rng.choice([0.1, 1.0, 3.0])
    return [
        Odometry(
            float(k),
            float(k + 1),
            0,
            distance=rng.uniform(-1, 1) * rng.integers(0, 2),
            distance_bound=rng.uniform(0, 0.3),
            turn=wild * rng.uniform(-1, 1),
            turn_bound=wild * rng.uniform(0, 1) * rng.integers(0, 2),
            direction_bound=rng.uniform(0, 1.5) * rng.integers(0, 2),
            slip_bound=rng.uniform(0, 0.1),
            aside=rng.choice([0.0, np.pi / 2, rng.uniform(-6, 6)]),
        )
        for k in range(count)
    ]


def drives(rng, records, heading):
    """Return places and headings after drives within records: at bounds, mostly, as it is there that one gets farthest."""
    place, look = np.zeros((SOME, 2)), np.full(SOME, heading)
    for record in records:

        def off(bound, ends=(-1.0, 1.0)):
            return bound * np.where(rng.random(SOME) < 0.7, rng.choice(ends, SOME), rng.uniform(*ends, SOME))

        turn, far = record.turn + off(record.turn_bound), record.distance + off(record.distance_bound)
        way, slid = look + turn / 2 + record.aside + off(record.direction_bound), rng.uniform(-np.pi, np.pi, SOME)
        place = place + far[:, None] * np.stack([np.cos(way), np.sin(way)], axis=1)
        place = place + off(record.slip_bound)[:, None] * np.stack([np.cos(slid), np.sin(slid)], axis=1)
        look = look + turn
    return place, look


@pytest.mark.parametrize("count", [1, 2, 5])
@pytest.mark.parametrize("seed", range(40))
def test_no_drive_within_the_pieces_gets_out(seed, count):
    rng = np.random.default_rng([seed, count])
    team, records, heading = Team(1, speed_limit=9.0, turn_rate_limit=9.0), pieces_of(rng, count), rng.uniform(-np.pi, np.pi)
    motions = Motions(team)
    for record in records:
        motions = motions.merged(record)
    whole, before = motions.between(0.0, float(count)), AngularIntervals([heading], [0.0])
    place, look = drives(rng, records, heading)
    moves, after = displacements(whole, before, team, count), turned_headings(whole, before, team, count)
    for way in WAYS:
        direction = np.array([[np.cos(way), np.sin(way)]])
        assert (place @ direction[0]).max() <= moves.support(np.array([0]), direction)[0] + 1e-12
    beyond = np.abs((look - after.centre[0] + np.pi) % (2 * np.pi) - np.pi)
    assert (beyond <= after.bound[0] + 1e-12).all()


@pytest.mark.parametrize("span", [(0.0, 1.0), (1.0, 2.0), (0.2, 0.7), (1.0, 1.5), (0.5, 2.0)])
def test_what_was_driven_before_and_after_says_nothing(span):
    """To the last bit, also where it ends or begins just then; of another robot, too."""
    records = pieces_of(np.random.default_rng(7), 3)
    alone, among = Motions(Team(2)), Motions(Team(2)).merged(Odometry(0.0, 3.0, 1, 1.0, 0.1, 0.0, 0.1, 0.1, 0.1))
    for record in records:
        among = among.merged(record)
        if record.start < span[1] and record.time > span[0]:
            alone = alone.merged(record)
    expected, found = alone.between(*span), among.between(*span)
    assert found.robot.tolist() == [0, 1]
    for name in ("distance", "distance_bound", "turn", "turn_bound", "direction_bound", "slip_bound", "aside"):
        assert getattr(found, name)[0] == getattr(expected, name)[0]
