"""When a suspect is acquitted by evidence: often enough, among different bodies, and tested by metres or a second sensor."""

from dataclasses import replace

import numpy as np
import pytest
from helpers.drawn.broken import drawn, followed

from filter import AngularIntervals, Bearing, Compass
from filter.cameras.offsets import Offsets
from filter.diagnosis.evidence import (
    AGAIN,
    HEADING,
    INSTANTS,
    METRES,
    OFTEN,
    PLACE,
    TEST,
    counted,
    is_enough,
    put_to_test,
    vouched_for,
)
from filter.diagnosis.told import said
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


def test_an_instant_may_count_for_several():
    assert is_enough(SENSOR, {who: count / 5 for who, count in SEEN.items()}, FAR, weight=5)
    assert not is_enough(SENSOR, {who: count / 5 for who, count in SEEN.items()}, FAR, weight=4)


def test_it_is_a_test_if_the_pose_of_whoever_measures_is_known_and_the_place_of_a_mate():
    belief = followed(drawn(None, 1), count=1)[0].alone
    middle, half = np.zeros((3, 2)), np.array([[0.5], [0.5], [0.51]]) * PLACE  # nobody knows well where robot 2 is
    polytope = replace(belief.polytope, lower=middle - half, upper=middle + half)
    headings = AngularIntervals(np.zeros(3), np.array([HEADING, HEADING + 0.01, 0.1]))  # nor how robot 1 looks
    known = replace(belief, polytope=polytope, headings=headings)
    records = (Compass(0.0, [0, 1, 2], 0.0, 0.1), Bearing(0.0, [0, 0, 0, 1, 2], [1, 2, 4, 4, 4], 0.1, 0.1))
    tests = said(put_to_test(records, known))
    assert {who for who in tests if who[0] in ("compass", "sighting")} == {
        ("compass", 0, -1),
        ("sighting", 0, 1),
        ("sighting", 0, 4),
    }
    used = counted({("compass", 1, -1): 2}, records, put_to_test(records, known))
    assert [used[who] for who in (("compass", 1, -1), ("sighting", 0, 4), ("sighting", 0, 2))] == [3, TEST, 1]


def test_a_camera_that_is_vouched_for_need_not_have_driven():
    metres, cameras = np.array([0.0, 0.0, 9.0]), replace(Offsets.none(3, 0.0), vouched=np.array([True, False, True]))
    assert vouched_for(metres, cameras).tolist() == [METRES, 0.0, 9.0]
    assert vouched_for(metres, None) is metres
