"""When a suspect is acquitted by evidence: often enough, among different bodies, and tested by metres or a second sensor."""

import numpy as np
import pytest

from filter.diagnosis.evidence import AGAIN, INSTANTS, METRES, OFTEN, is_enough
from filter.diagnosis.suspects import suspects_of
from filter.linear.sources import Source
from filter.records.frame import Frame
from filter.records.measurements import Compass, Range
from filter.sets.suspect import Suspect

SENSOR, FAR, NEAR = Suspect("sensor", 0), np.array([METRES, 0.0]), np.array([METRES - 0.01, 99.0])
SEEN = {("sensor", 0, -1): INSTANTS, ("sighting", 0, 5): INSTANTS, ("sighting", 0, 6): OFTEN, ("body", -1, 5): INSTANTS}
WITH_COMPASS = {**SEEN, ("compass", 0, -1): INSTANTS}


@pytest.mark.parametrize(
    ("suspect", "used", "metres", "enough"),
    [
        (SENSOR, SEEN, FAR, True),
        (SENSOR, SEEN, NEAR, False),
        (SENSOR, {**SEEN, ("sighting", 0, 6): OFTEN - 1}, FAR, False),
        (SENSOR, WITH_COMPASS, NEAR, True),
        (SENSOR, {**SEEN, ("compass", 0, -1): INSTANTS - 1}, NEAR, False),
        (SENSOR, {**SEEN, ("body", -1, 0): INSTANTS, ("sighting", 1, 0): INSTANTS}, NEAR, True),
        (SENSOR, {**SEEN, ("sensor", 0, -1): INSTANTS - 1}, FAR, False),
        (SENSOR, {key: count for key, count in SEEN.items() if key != ("sighting", 0, 6)}, FAR, False),
        (Suspect("compass", 0), WITH_COMPASS, NEAR, False),
        (Suspect("compass", 0), WITH_COMPASS, FAR, True),
        (Suspect("past", 0), SEEN, FAR, True),
        (Suspect("past", 1), SEEN, np.array([9.0, 9.0]), False),
        (Suspect("body", None, 5), SEEN, FAR, True),
        (Suspect("body", None, 6), SEEN, FAR, False),
        (Suspect("sighting", 0, 5), SEEN, FAR, True),
        (Suspect("sighting", 0, 6), SEEN, FAR, False),
        (Suspect("exchange", 5, 6), SEEN, FAR, True),
        (Suspect("exchange", 6, 7), SEEN, FAR, False),
    ],
)
def test_what_is_enough(suspect, used, metres, enough):
    assert is_enough(suspect, used, metres) == enough


def test_who_was_guilty_needs_so_many_times_as_much():
    often = {key: AGAIN * count for key, count in SEEN.items()}
    assert is_enough(SENSOR, often, AGAIN * FAR, AGAIN)
    assert not is_enough(SENSOR, SEEN, AGAIN * FAR, AGAIN)
    assert not is_enough(SENSOR, often, FAR, AGAIN)


def who(sources, frames=(), robots=3):
    return {suspect.who for suspect in suspects_of(sources, frames, robots, 1.0)}


def test_each_part_of_a_conflict_stands_for_who_can_be_wrong():
    assert who([Source("compass", 2.0, 1)]) == {("compass", 1, -1)}
    assert who([Source("position", 2.0, 1)]) == {("sensor", 1, -1)}
    assert who([Source("arena", 2.0, 1)]) == set()
    assert who([Source("pair", 2.0, 0, 2)]) == {("past", 0, -1), ("past", 2, -1)}
    for kind in ("region", "heading", "initial set", "odometry", "speed limit", "turn limit"):
        assert who([Source(kind, 2.0, 1)]) == {("past", 1, -1)}
    landmark = {("sensor", 0, -1), ("body", -1, 4), ("sighting", 0, 4)}
    mate = {("sensor", 0, -1), ("body", -1, 1), ("sighting", 0, 1), ("exchange", 1, 2)}
    for kind in ("bearing", "range", "relative heading"):
        assert who([Source(kind, 2.0, 0, 1)]) == mate
    assert who([Source("range", 2.0, 0, 4)]) == landmark
    assert all(suspect.since == 1.0 for suspect in suspects_of([Source("compass", 2.0, 1)], (), 3, 1.0))


def test_what_was_known_of_a_robot_rests_on_what_was_measured_by_it_and_of_it():
    frames = [Frame(1.0, None, [Compass(1.0, [0, 1], 0.0, 0.1), Range(1.0, [0, 1, 2], [4, 4, 0], 1.0, 0.1, 0.0)])]
    last = Frame(2.0, None, [Range(2.0, 1, 5, 1.0, 0.1, 0.0)])
    found = who([Source("region", 2.0, 0)], [*frames, last])
    assert found == {
        *(("past", 0, -1), ("past", 2, -1), ("compass", 0, -1), ("sensor", 0, -1), ("sensor", 2, -1)),
        *(("body", -1, 4), ("body", -1, 0), ("sighting", 0, 4), ("sighting", 2, 0), ("exchange", 0, 1)),
    }
    assert who([Source("region", 2.0, 0)], frames) == {("past", 0, -1)}
    assert who([Source("compass", 2.0, 0)], [*frames, last]) == {("compass", 0, -1)}
