"""Who can be wrong in a conflict: whoever a part of it rests on, and what was known rests on what was measured before."""

import pytest

from filter import Bearing, Compass, Frame, Position, Source
from filter.diagnosis.suspects import everybody, suspects_of

ROBOTS, MARK = 3, 4  # a landmark's number among all bodies
PAST, NOW = 0.5, 1.0


def who(conflict, before=()):
    """Return who is suspected in a conflict, after an instant at which some records came."""
    frames = [Frame(PAST, None, before), Frame(NOW, None, ())]
    found = suspects_of(conflict, frames, ROBOTS, PAST)
    assert all(suspect.since == PAST for suspect in found)
    assert len({suspect.who for suspect in found}) == len(found)
    return {(suspect.kind, suspect.robot, suspect.target) for suspect in found}


OF_A_MARK = {("sensor", 0, None), ("body", None, MARK), ("sighting", 0, MARK)}


@pytest.mark.parametrize(
    ("source", "suspects"),
    [
        (Source("compass", NOW, 0), {("compass", 0, None)}),
        (Source("position", NOW, 0), {("sensor", 0, None)}),
        (Source("bearing", NOW, 0, MARK), OF_A_MARK),
        (Source("range", NOW, 0, MARK), OF_A_MARK),
        (
            Source("range", NOW, 0, 1),
            {("sensor", 0, None), ("body", None, 1), ("sighting", 0, 1), ("exchange", 1, 2)},
        ),
        (Source("odometry", NOW, 2), {("past", 2, None)}),
        (Source("initial set", PAST, 2), {("past", 2, None)}),
        (Source("pair", PAST, 0, 2), {("past", 0, None), ("past", 2, None)}),
        (Source("arena", NOW, 2), set()),
    ],
    ids=lambda value: value.kind if isinstance(value, Source) else "",
)
def test_each_part_stands_for_whoever_can_be_behind_it(source, suspects):
    assert who([source]) == suspects


def test_behind_what_was_known_is_all_that_was_measured_of_it_and_of_those_it_was_tied_to():
    before = (
        Compass(PAST, [0, 1], [0.0, 0.0], 0.1),
        Bearing(PAST, 0, MARK, 0.0, 0.1),
        Bearing(PAST, 1, 0, 0.0, 0.1),
        Position.fix(PAST, 2, [0.0, 0.0], 1.0),
    )
    found = who([Source("region", PAST, 0)], before)
    tied = {("sensor", 1, None), ("body", None, 0), ("sighting", 1, 0), ("exchange", 0, 2)}
    assert found == {("past", 0, None), ("past", 1, None), ("compass", 0, None), ("compass", 1, None), *OF_A_MARK, *tied}


def test_everybody_is_whoever_is_there_and_whoever_has_said_something_at_the_last_instant_too():
    frames = [Frame(PAST, None, (Compass(PAST, 0, 0.0, 0.1),)), Frame(NOW, None, (Bearing(NOW, 0, MARK, 0.0, 0.1),))]
    found = {(suspect.kind, suspect.robot, suspect.target) for suspect in everybody(frames, {0, 2}, ROBOTS, PAST)}
    assert found == {("past", 0, None), ("past", 2, None), ("compass", 0, None), *OF_A_MARK}
    assert who([Source("region", PAST, 0)]) < {*found, ("past", 0, None), ("past", 1, None)}


def test_without_a_conflict_there_is_nobody():
    assert who([]) == set()
