"""Who can be wrong in a conflict: everybody, as what was known rests on everybody; and whom its parts stand for."""

import pytest

from filter import Bearing, Compass, Frame, Position, Source
from filter.diagnosis.suspects import everybody, named_by

ROBOTS, MARK = 3, 4  # a landmark's number among all bodies
PAST, NOW = 0.5, 1.0


def who(found):
    """Return who is suspected, each once."""
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
    assert who(named_by([source], ROBOTS, PAST)) == suspects


def test_everybody_is_whoever_is_there_and_whoever_has_said_something():
    before = (
        Compass(PAST, [0, 1], [0.0, 0.0], 0.1),
        Bearing(PAST, 1, 0, 0.0, 0.1),
        Position.fix(PAST, 2, [0.0, 0.0], 1.0),
    )
    frames = [Frame(PAST, None, before), Frame(NOW, None, (Bearing(NOW, 0, MARK, 0.0, 0.1),))]
    of_a_mate = {("sensor", 1, None), ("body", None, 0), ("sighting", 1, 0), ("exchange", 0, 2)}
    others = {("past", 0, None), ("past", 2, None), ("compass", 0, None), ("compass", 1, None), ("sensor", 2, None)}
    assert who(everybody(frames, {0, 2}, ROBOTS, PAST)) == {*OF_A_MARK, *of_a_mate, *others}


def test_whomever_a_conflict_names_is_among_everybody():
    frames = [Frame(PAST, None, (Bearing(PAST, 0, 1, 0.0, 0.1), Compass(PAST, 2, 0.0, 0.1)))]
    named = [Source("bearing", PAST, 0, 1), Source("compass", PAST, 2), Source("pair", PAST, 0, 2)]
    assert who(named_by(named, ROBOTS, PAST)) < who(everybody(frames, range(ROBOTS), ROBOTS, PAST))


def test_without_a_conflict_nobody_is_named():
    assert who(named_by([], ROBOTS, PAST)) == set()
