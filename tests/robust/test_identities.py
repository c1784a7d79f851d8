"""Robots that wear each other's barcodes: what is not proved to be of one of them is merged as of whoever it can be."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.robust_worlds import started, world_of

from filter.robust.belief import Distrusted, Restarted
from filter.robust.robust_filter import RobustFilter

ROBOTS = 4


def exchanged(records, pair):
    """Return the records with the barcodes of two robots exchanged, without those that name who read them."""
    told = []
    for record in records:
        target = np.select([record.target == pair[0], record.target == pair[1]], [pair[1], pair[0]], record.target)
        kept = target != record.robot
        columns = vars(record) | {"target": target}
        told.append(replace(record, **{name: column[kept] for name, column in columns.items() if name != "time"}))
    return told


def exchanging(world, count, pair, begins=0, known="position"):
    """Yield the belief at each of many steps; two robots wear each other's barcodes from some step on."""
    robust = RobustFilter(world.team)
    belief = started(robust, world, known)
    for step in range(count):
        belief = robust.predict(belief, world.time + 0.4, world.tour(0.4))
        records = world.measure(compasses=False)
        belief = robust.update(belief, exchanged(records, pair) if step >= begins else records)
        yield belief


@pytest.mark.parametrize("known", ["pose", "position", "arena"])
@pytest.mark.parametrize("errors", ["uniform", "extreme"])
@pytest.mark.parametrize("begins", [0, 40])
@pytest.mark.parametrize("pair", [(0, 1), (0, 3)])
def test_exchanged_barcodes_let_nobody_escape_and_are_named(pair, begins, errors, known):
    world, events = world_of(sum(pair), ROBOTS, errors=errors), []
    for belief in exchanging(world, begins + 80, pair, begins, known):
        events += belief.events
        places = [region.outer.contains(place) for region, place in zip(belief.regions, world.positions, strict=True)]
        assert np.all(places)
        assert belief.headings.contains(world.headings).all()
        assert belief.guarantee.in_force.all()
    named = {(event.sensor, event.kind, event.body) for event in events if isinstance(event, Distrusted)}
    assert named
    assert named <= {("identity", "robot", body) for body in pair}  # the other one may not have been read often enough
    assert not [event for event in events if isinstance(event, Restarted)]
    told = next(event for event in events if isinstance(event, Distrusted))
    assert 0.4 * begins < told.since <= told.time
    assert set(told.pairs) <= set(range(ROBOTS)) - {told.body}


@pytest.mark.parametrize("begins", [0, 100])
def test_both_identities_are_named_when_they_have_been_read_for_a_while(begins):
    events = [event for belief in exchanging(world_of(3, ROBOTS), begins + 250, (0, 2), begins) for event in belief.events]
    assert sorted(event.body for event in events if isinstance(event, Distrusted)) == [0, 2]


def test_good_barcodes_are_never_named():
    for seed in range(3):
        world = world_of(seed, ROBOTS, errors="extreme")
        for belief in exchanging(world, 60, (0, 1), 1000):
            assert belief.events == ()
